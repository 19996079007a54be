//! `cellctl arm`, `plan` and `route`: questions about arm models, trajectories and routes. Nothing moves.
//!
//! They are answered by this program, or by a server that is named, with the same bodies; the drawings are made here
//! from the answers, so they are the same either way.

mod arm;
mod calibrate;
mod describe;
mod desk;
mod drive;
mod input;
mod pose;
mod route;
mod show;
mod space;
mod tool_path;
mod torques;
mod trajectory;
mod transfer;
mod velocity;

use clap::{Args, Subcommand};

use crate::context::Context;
use crate::failure::Failure;
use crate::report::Report;

pub(crate) use arm::{ArmArgs, run as arm};
pub(crate) use route::{RouteArgs, run as route};

/// Plan how an arm moves: joints in time, or the tool along a path. Nothing moves.
///
/// Joint values are lists, base first: degrees of a joint that turns, millimeters of one that slides.
#[derive(Args, Debug)]
pub(crate) struct PlanArgs {
    #[command(subcommand)]
    command: PlanCommand,
}

#[derive(Debug, Subcommand)]
enum PlanCommand {
    Trajectory(trajectory::TrajectoryArgs),
    ToolPath(tool_path::ToolPathArgs),
}

pub(crate) async fn plan(args: PlanArgs, context: &Context) -> Result<Report, Failure> {
    match args.command {
        PlanCommand::Trajectory(args) => trajectory::run(args, context).await,
        PlanCommand::ToolPath(args) => tool_path::run(args, context).await,
    }
}
