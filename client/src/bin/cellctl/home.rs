//! `cellctl home`.

use api::MotionType;
use clap::Args;

use crate::context::Context;
use crate::failure::Failure;
use crate::move_to::{self, MotionArgs};
use crate::report::Report;

/// Move the robot to the home joints of its arm model.
#[derive(Args, Debug)]
pub(crate) struct HomeArgs {
    #[command(flatten)]
    motion: MotionArgs,
}

pub(crate) async fn run(args: HomeArgs, context: &Context) -> Result<Report, Failure> {
    move_to::send(args.motion, MotionType::Home, None, context).await
}
