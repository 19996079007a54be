//! `cellctl arm calibrate`: a tool out of taught points.

use api::arms::{ArmCalibrationBody, ArmCalibrationPoint, ArmCalibrationResult};
use clap::Args;

use super::desk::Desk;
use super::input::{FileArgs, Numbers, read};
use super::show::point;
use crate::context::Context;
use crate::failure::Failure;
use crate::report::{Exit, Report};
use crate::text::{self, thousandths, word};

/// Calculate a tool out of taught postures: its tip at one place (three points), and its directions (six points).
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
}

pub(super) async fn run(args: CalibrateArgs, context: &Context) -> Result<Report, Failure> {
    let taught = |Numbers(joints): Numbers| ArmCalibrationPoint {
        joints_deg_mm: Some(joints),
        flange: None,
    };
    let body = match &args.file.file {
        Some(file) => read(file)?,
        None => ArmCalibrationBody {
            tip: args.tip.into_iter().map(taught).collect(),
            orient_origin: args.orient_origin.map(taught),
            along_x: args.along_x.map(taught),
            along_z: args.along_z.map(taught),
        },
    };
    let answer = Desk::of(context).calibrate(&args.model, &body).await?;
    Ok(context.report(Exit::Done, &answer, fitted))
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
