//! `cellctl arm calibrate`: a tool out of taught points.

use api::arms::{ArmCalibrationBody, ArmCalibrationPoint, ArmCalibrationResult, ArmFrames};
use clap::Args;
use plots::answers::{self, Taught, TaughtBy};

use super::desk::Desk;
use super::input::{FileArgs, Numbers};
use super::show::{PlotArgs, finish, point};
use crate::context::Context;
use crate::failure::Failure;
use crate::report::{Exit, Report};
use crate::text::{self, thousandths, word};

/// Calculate a tool out of taught postures: its tip at one place (three points), and its directions (six points);
/// --plot draws the postures with that tool.
///
/// Example:
///   cellctl arm calibrate fanuc-m20ia --tip 0,20,-20,0,-70,0 --tip 10,22,-21,30,-60,5 --tip -10,25,-18,-30,-65,-5
#[derive(Args, Debug)]
#[command(verbatim_doc_comment)]
pub(super) struct CalibrateArgs {
    /// The model.
    model: String,
    /// A posture with the tip at the place; three or more, the flange turned between them.
    #[arg(
        long,
        value_name = "J1,J2,..",
        allow_hyphen_values = true,
        required_unless_present = "file",
        conflicts_with = "file"
    )]
    tip: Vec<Numbers>,
    /// The tip at the orient origin, of the six-point method.
    #[arg(long, value_name = "J1,J2,..", allow_hyphen_values = true, requires_all = ["along_x", "along_z"])]
    orient_origin: Option<Numbers>,
    /// From there along the tool's X.
    #[arg(
        long,
        value_name = "J1,J2,..",
        allow_hyphen_values = true,
        requires = "orient_origin"
    )]
    along_x: Option<Numbers>,
    /// From there along the tool's Z.
    #[arg(
        long,
        value_name = "J1,J2,..",
        allow_hyphen_values = true,
        requires = "orient_origin"
    )]
    along_z: Option<Numbers>,
    #[command(flatten)]
    file: FileArgs,
    #[command(flatten)]
    plot: PlotArgs,
}

pub(super) async fn run(args: CalibrateArgs, context: &Context) -> Result<Report, Failure> {
    let taught = |Numbers(joints): Numbers| ArmCalibrationPoint {
        joints_deg_mm: Some(joints),
        flange: None,
    };
    let body = args.file.question(|| {
        Ok(ArmCalibrationBody {
            tip: args.tip.into_iter().map(taught).collect(),
            orient_origin: args.orient_origin.map(taught),
            along_x: args.along_x.map(taught),
            along_z: args.along_z.map(taught),
        })
    })?;
    let desk = Desk::of(context);
    let answer = desk.calibrate(&args.model, &body).await?;
    let drawing = match &args.plot.plot {
        None => None,
        Some(picture) => {
            let held = held(&desk, &args.model, &body, &answer).await?;
            Some((picture, answers::calibration(&args.model, &answer, &held)?))
        }
    };
    finish(context, Exit::Done, &answer, drawing, fitted)
}

/// The taught postures with the tool that was found.
async fn held(
    desk: &Desk,
    model: &str,
    body: &ArmCalibrationBody,
    answer: &ArmCalibrationResult,
) -> Result<Vec<Taught>, Failure> {
    let frames = ArmFrames {
        tool: Some(answer.tool),
        user_frame: None,
    };
    let directions = [
        ("orient origin", &body.orient_origin),
        ("along X", &body.along_x),
        ("along Z", &body.along_z),
    ];
    let named = (1..).zip(&body.tip);
    let tips = named.map(|(number, point)| (format!("tip {number}"), point));
    let directions = directions
        .into_iter()
        .filter_map(|(name, point)| Some((name.to_owned(), point.as_ref()?)));
    let mut held = Vec::new();
    for (name, point) in tips.chain(directions) {
        let by = match (&point.joints_deg_mm, point.flange) {
            (Some(joints), _) => TaughtBy::Joints(desk.at(model, joints, &frames).await?),
            (None, Some(flange)) => TaughtBy::Flange(flange),
            (None, None) => continue,
        };
        held.push(Taught { name, by });
    }
    Ok(held)
}

fn fitted(answer: &ArmCalibrationResult) -> String {
    text::facts(&[
        ("by", word(answer.method)),
        ("tool", text::pose(&answer.tool)),
        ("place", point(answer.place_mm)),
        (
            "worst",
            format!("{} mm from the place", thousandths(answer.worst_mm)),
        ),
        ("mean", format!("{} mm", thousandths(answer.mean_mm))),
    ])
}
