//! `cellctl arm transfer`: an arm among obstacles.

use api::arms::{ArmDescription, ArmObstacle, ArmTransferBody, ArmTransferResult};
use clap::Args;
use plots::answers;

use super::desk::Desk;
use super::input::{AskArgs, Numbers, Row, needed};
use super::show::{finish, unit};
use crate::context::Context;
use crate::failure::Failure;
use crate::numbers::finite;
use crate::report::{Exit, Report};
use crate::text::{Table, thousandths};

/// Find a way from one joint set to another, or to a pose, that touches nothing, by a probabilistic roadmap.
///
/// Example:
///   cellctl arm transfer fanuc-m20ia --from 45,20,-20,0,-70,0 --to -45,20,-20,0,-70,0 --keep-out 700,-100,-500,1000,100,500
#[derive(Args, Debug)]
#[command(verbatim_doc_comment)]
pub(super) struct TransferArgs {
    /// The model.
    model: String,
    /// The joints at the start, base first.
    #[arg(
        long,
        value_name = "J1,J2,..",
        allow_hyphen_values = true,
        conflicts_with = "file"
    )]
    from: Option<Numbers>,
    /// The joints at the goal.
    #[arg(long, value_name = "J1,J2,..", allow_hyphen_values = true)]
    to: Option<Numbers>,
    /// Or where the tool is to be: the way ends at the nearest of the joint sets that reach it and are free.
    #[arg(
        long,
        value_name = "X,Y,Z,W,P,R",
        allow_hyphen_values = true,
        conflicts_with = "to"
    )]
    to_pose: Option<Row<6>>,
    /// A box that the arm must not be in: two corners in the arm's world, in mm. As often as there are such.
    #[arg(long, value_name = "X,Y,Z,X,Y,Z", allow_hyphen_values = true)]
    keep_out: Vec<Row<6>>,
    /// An upright cylinder: the middle of its floor, radius and height, in mm.
    #[arg(long, value_name = "X,Y,Z,R,H", allow_hyphen_values = true)]
    cylinder: Vec<Row<5>>,
    /// How far from obstacles the arm stays, in mm; 20 if absent.
    #[arg(long, value_name = "MM", value_parser = finite, allow_hyphen_values = true)]
    margin: Option<f64>,
    /// The same seed gives the same way.
    #[arg(long)]
    seed: Option<u64>,
    /// After so many samples the search is given up; 5000 if absent.
    #[arg(long, value_name = "COUNT")]
    samples: Option<u32>,
    #[command(flatten)]
    ask: AskArgs,
}

pub(super) async fn run(args: TransferArgs, context: &Context) -> Result<Report, Failure> {
    let model = args.model.clone();
    let (file, plot) = (args.ask.file.clone(), args.ask.plot.clone());
    let body = file.question(|| of_options(args))?;
    let desk = Desk::of(context);
    let arm = desk.describe(&model).await?;
    let answer = desk.transfer(&model, &body).await?;
    let drawing = match &plot.plot {
        None => None,
        Some(picture) => {
            let drawing = answers::transfer(&model, &body.obstacles, &answer)?;
            Some((picture, drawing))
        }
    };
    finish(context, Exit::Done, &answer, drawing, |answer| {
        way(&arm, answer)
    })
}

fn of_options(args: TransferArgs) -> Result<ArmTransferBody, Failure> {
    let boxes = args
        .keep_out
        .iter()
        .map(|Row([x0, y0, z0, x1, y1, z1])| ArmObstacle::KeepOut {
            min_mm: [*x0, *y0, *z0],
            max_mm: [*x1, *y1, *z1],
        });
    let cylinders =
        args.cylinder
            .iter()
            .map(|Row([x, y, z, radius, height])| ArmObstacle::Cylinder {
                pose: [*x, *y, z + height / 2.0, 0.0, 0.0, 0.0].into(),
                radius_mm: *radius,
                height_mm: *height,
            });
    let goal_pose = args.to_pose.map(|Row(pose)| pose.into());
    Ok(ArmTransferBody {
        start_deg_mm: needed(args.from, "--from")?.0,
        goal_deg_mm: match (args.to, goal_pose) {
            (None, Some(_)) => Vec::new(),
            (joints, _) => needed(joints, "--to or --to-pose")?.0,
        },
        goal_pose,
        frames: args.ask.frames.into(),
        obstacles: boxes.chain(cylinders).collect(),
        capsules: None,
        tool_capsules: Vec::new(),
        margin_mm: args.margin,
        seed: args.seed,
        samples: args.samples,
    })
}

fn way(arm: &ArmDescription, answer: &ArmTransferResult) -> String {
    let joints = arm.joints.iter();
    let names = joints.map(|joint| format!(">{} {}", joint.name, unit(joint.kind)));
    let mut table = Table::with_headings([">#".to_owned()].into_iter().chain(names));
    for (index, joints) in answer.points_deg_mm.iter().enumerate() {
        let values = joints.iter().map(|value| thousandths(*value));
        table.row([(index + 1).to_string()].into_iter().chain(values));
    }
    let pieces = answer.points_deg_mm.len().saturating_sub(1);
    let straight = if pieces == 1 { "piece" } else { "pieces" };
    let slid = answer.length_mm.map(thousandths);
    let slid = slid.map_or_else(String::new, |slid| format!(" and {slid} mm"));
    format!(
        "{pieces} straight {straight} of joint space, {} deg{slid} together\n\n{table}",
        thousandths(answer.length_deg)
    )
}
