//! `cellctl ik`: inverse kinematics, every branch.

use api::{BranchBody, InverseBody, InverseResult};
use clap::Args;

use crate::context::Context;
use crate::failure::Failure;
use crate::numbers::{PoseArgs, finite, six};
use crate::report::{Exit, Report};
use crate::text::{Table, thousandths};

/// Calculate all joint values that reach a pose, and which of them the controller takes. Nothing moves.
///
/// The pose is the tool center point in the robot's user frame.
///
/// Examples:
///   cellctl ik 600 200 600 -180 30 0
///   cellctl ik 600 200 600 -180 30 0 --near 0 0 0 0 -90 0
#[derive(Args, Debug)]
#[command(verbatim_doc_comment)]
pub(crate) struct IkArgs {
    #[command(flatten)]
    pose: PoseArgs,
    /// The present joints in degrees: the nearest branch is counted from them. The home joints if absent.
    #[arg(long, num_args = 6, allow_hyphen_values = true, value_parser = finite,
        value_names = ["J1", "J2", "J3", "J4", "J5", "J6"])]
    near: Option<Vec<f64>>,
}

pub(crate) async fn run(args: IkArgs, context: &Context) -> Result<Report, Failure> {
    let body = InverseBody {
        pose: args.pose.into(),
        near: args.near.as_deref().and_then(six),
    };
    let result = context.robot().await?.inverse(&body).await?;
    Ok(context.report(Exit::Done, &result, table))
}

fn table(result: &InverseResult) -> String {
    let mut table = Table::new(&[
        ">#",
        "configuration",
        ">J1",
        ">J2",
        ">J3",
        ">J4",
        ">J5",
        ">J6",
        ">margin",
        "at",
        ">distance",
        "",
    ]);
    for (index, branch) in result.branches.iter().enumerate() {
        let [j1, j2, j3, j4, j5, j6] = <[f64; 6]>::from(branch.joints).map(thousandths);
        let (margin, at) = tightest(branch);
        table.row([
            (index + 1).to_string(),
            branch.configuration.clone(),
            j1,
            j2,
            j3,
            j4,
            j5,
            j6,
            margin,
            at,
            thousandths(branch.distance_deg),
            remarks(result, index, branch),
        ]);
    }
    let controller = match result.controller {
        Some(index) => format!("The controller takes branch {}.", index + 1),
        None => "The controller refuses this pose: the branch of the configuration it keeps is \
                 not inside the limits."
            .to_owned(),
    };
    let reached = match result.branches.len() {
        1 => "1 branch reaches the pose".to_owned(),
        count => format!("{count} branches reach the pose"),
    };
    format!("{reached}; joints, margins and distances in degrees. {controller}\n\n{table}")
}

/// The joint with the least margin, which alone decides.
fn tightest(branch: &BranchBody) -> (String, String) {
    branch
        .margins
        .iter()
        .min_by(|a, b| a.margin_deg.total_cmp(&b.margin_deg))
        .map_or_else(Default::default, |joint| {
            (thousandths(joint.margin_deg), joint.joint.clone())
        })
}

fn remarks(result: &InverseResult, index: usize, branch: &BranchBody) -> String {
    let mut remarks = Vec::new();
    if result.controller == Some(index) {
        remarks.push("controller");
    }
    if result.nearest == index {
        remarks.push("nearest");
    }
    if !branch.within_limits {
        remarks.push("outside the limits");
    }
    if branch.singularity.singular {
        remarks.push("singular");
    }
    remarks.join(", ")
}
