//! `cellctl delta`: a move relative to the last accepted target.

use api::{MotionType, PoseBody, TargetBody};
use clap::Args;

use crate::context::Context;
use crate::failure::Failure;
use crate::move_to::{self, MotionArgs};
use crate::numbers::PoseArgs;
use crate::report::Report;

/// Move the robot by a change to the last accepted target, added number by number.
///
/// The last accepted target is what the server last sent with success: not where the arm is if it was moved by hand
/// since. It is read first and the sum is sent as an absolute target, so of two clients at work at the same moment
/// one may count from the older target; the answer shows the target that was sent.
///
/// Example, 10 mm down:
///   cellctl delta 0 0 -10 0 0 0 --speed 50
#[derive(Args, Debug)]
#[command(verbatim_doc_comment)]
pub(crate) struct DeltaArgs {
    #[command(flatten)]
    change: PoseArgs,
    #[command(flatten)]
    motion: MotionArgs,
}

pub(crate) async fn run(args: DeltaArgs, context: &Context) -> Result<Report, Failure> {
    let state = context.robot().await?.state().await?;
    let Some(from) = state.pose else {
        return Err(Failure::NoAcceptedTarget);
    };
    let by = PoseBody::from(args.change);
    let to = PoseBody {
        x_mm: from.x_mm + by.x_mm,
        y_mm: from.y_mm + by.y_mm,
        z_mm: from.z_mm + by.z_mm,
        w_deg: from.w_deg + by.w_deg,
        p_deg: from.p_deg + by.p_deg,
        r_deg: from.r_deg + by.r_deg,
    };
    let target = Some(TargetBody::Pose(to));
    move_to::send(args.motion, MotionType::Joint, target, context).await
}
