//! `cellctl teach`: a taught pose, from where the arm is.

use api::setup::{ExplicitPose, PlanarPoseBody, PoseFrame, TeachBody, TeachResult};
use clap::{Args, ValueEnum};

use crate::context::Context;
use crate::failure::Failure;
use crate::numbers::{finite, six};
use crate::report::{Exit, Report};
use crate::text::{facts, pose, thousandths};

/// Teach how the robot grips at a place: its actual pose, or the one given.
///
/// A controller that reports no position (tier 0) needs --joints, or --pose with --configuration, from the pendant.
///
/// Examples:
///   cellctl teach rack/a
///   cellctl teach rack/a --approach-mm 150 --joints 63.4 21 -8 0 -82 0
///   cellctl teach front/left --dock 1102 -3 90.5
#[derive(Args, Debug)]
#[command(verbatim_doc_comment)]
pub(crate) struct TeachArgs {
    /// The place's id.
    place: String,
    /// How far before the pose the approach begins, in millimeters.
    #[arg(long, value_name = "MM", value_parser = finite)]
    approach_mm: Option<f64>,
    /// How far a gripped load is lifted, in millimeters.
    #[arg(long, value_name = "MM", value_parser = finite)]
    lift_mm: Option<f64>,
    /// Joint values as on the pendant, in degrees.
    #[arg(long, num_args = 6, allow_hyphen_values = true, value_parser = finite, conflicts_with = "pose",
        value_names = ["J1", "J2", "J3", "J4", "J5", "J6"])]
    joints: Option<Vec<f64>>,
    /// The tool center point, in the frame of --frame.
    #[arg(long, num_args = 6, allow_hyphen_values = true, value_parser = finite, requires = "configuration",
        value_names = ["X", "Y", "Z", "W", "P", "R"])]
    pose: Option<Vec<f64>>,
    /// The configuration that goes with --pose, e.g. "N U T, 0, 0, 0".
    #[arg(long, requires = "pose", value_name = "TEXT")]
    configuration: Option<String>,
    /// The frame the pose is given and kept in.
    #[arg(long, value_enum, default_value = "cell", value_name = "FRAME")]
    frame: FrameWord,
    /// Where the mobile robot is docked meanwhile, in the cell frame: millimeters and degrees.
    #[arg(long, num_args = 3, allow_hyphen_values = true, value_parser = finite,
        value_names = ["X", "Y", "HEADING"])]
    dock: Option<Vec<f64>>,
}

#[derive(Clone, Copy, Debug, ValueEnum)]
enum FrameWord {
    /// The cell frame.
    Cell,
    /// The arm's own world frame.
    Arm,
}

pub(crate) async fn run(args: TeachArgs, context: &Context) -> Result<Report, Failure> {
    let robot = context.robot().await?;
    let setup = context.client.setup(robot.cell());
    let at = match (
        args.joints.as_deref().and_then(six),
        args.pose.as_deref().and_then(six),
    ) {
        (None, None) => None,
        (joints, numbers) => Some(ExplicitPose {
            joints,
            pose: numbers.map(|numbers| <[f64; 6]>::from(numbers).into()),
            configuration: args.configuration,
        }),
    };
    let measured_dock = match args.dock.as_deref() {
        Some([x_mm, y_mm, heading_deg]) => Some(PlanarPoseBody {
            x_mm: *x_mm,
            y_mm: *y_mm,
            heading_deg: *heading_deg,
        }),
        Some(_) | None => None,
    };
    let body = TeachBody {
        approach_mm: args.approach_mm,
        lift_mm: args.lift_mm,
        frame: match args.frame {
            FrameWord::Cell => PoseFrame::Cell,
            FrameWord::Arm => PoseFrame::Arm,
        },
        measured_dock,
        at,
    };
    let etag = setup.get().await?.etag;
    let taught = setup.teach(robot.id(), &args.place, &body, &etag).await?;
    Ok(context.report(Exit::Done, &taught, sentences))
}

fn sentences(result: &TeachResult) -> String {
    let taught = &result.taught;
    let frame = match taught.frame {
        PoseFrame::Cell => "cell frame",
        PoseFrame::Arm => "the arm's world frame",
    };
    let facts = facts(&[
        ("pose", format!("{} ({frame})", pose(&taught.pose))),
        ("configuration", taught.configuration.clone()),
        (
            "approach",
            format!("{} mm", thousandths(taught.approach_mm)),
        ),
        ("revision", result.revision.to_string()),
    ]);
    format!("Taught {} for {}.\n{facts}", taught.place, taught.arm)
}
