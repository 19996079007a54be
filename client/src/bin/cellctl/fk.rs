//! `cellctl fk`: forward kinematics.

use api::{ForwardBody, ForwardResult};
use clap::Args;

use crate::context::Context;
use crate::failure::Failure;
use crate::numbers::JointArgs;
use crate::report::{Exit, Report};
use crate::text;

/// Calculate the pose at given joint values. Nothing moves.
///
/// Example:
///   cellctl fk 0 0 0 0 -90 0
#[derive(Args, Debug)]
#[command(verbatim_doc_comment)]
pub(crate) struct FkArgs {
    #[command(flatten)]
    joints: JointArgs,
}

pub(crate) async fn run(args: FkArgs, context: &Context) -> Result<Report, Failure> {
    let body = ForwardBody {
        joints: args.joints.into(),
    };
    let result = context.robot().await?.forward(&body).await?;
    Ok(context.report(Exit::Done, &result, sentence))
}

fn sentence(result: &ForwardResult) -> String {
    let limits = if result.within_limits {
        "Every joint is inside its limits."
    } else {
        "At least one joint is outside its limits: the controller would refuse."
    };
    let singular = if result.singularity.singular {
        "\nThe arm is singular there."
    } else {
        ""
    };
    format!(
        "{}\nConfiguration {}. {limits}{singular}\n\n{}",
        text::pose(&result.pose),
        result.configuration,
        text::margins(&result.margins),
    )
}
