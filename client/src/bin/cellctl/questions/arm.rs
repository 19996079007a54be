//! `cellctl arm`: which arms there are, and what they can do.

use clap::{Args, Subcommand};

use super::{calibrate, describe, pose, space, torques, transfer, velocity};
use crate::context::Context;
use crate::failure::Failure;
use crate::report::Report;

/// Ask about an arm model: forward and inverse kinematics, Jacobians, torques, reach, ways among obstacles. Nothing moves.
///
/// Answered by this program, or by the server that --server names. Joint values are lists, base first: degrees of a
/// joint that turns, millimeters of one that slides. Poses are the tool's in the user frame; without --tool and
/// --user-frame that is the flange in the arm's world.
#[derive(Args, Debug)]
pub(crate) struct ArmArgs {
    #[command(subcommand)]
    command: ArmCommand,
}

#[derive(Debug, Subcommand)]
enum ArmCommand {
    /// List the models.
    List,
    Describe(describe::DescribeArgs),
    Fk(pose::FkArgs),
    Ik(pose::IkArgs),
    Jacobian(velocity::JacobianArgs),
    Rates(velocity::RatesArgs),
    MoveVelocity(velocity::MotionArgs),
    Torques(torques::TorquesArgs),
    Calibrate(calibrate::CalibrateArgs),
    Reach(space::ReachArgs),
    Transfer(transfer::TransferArgs),
}

pub(crate) async fn run(args: ArmArgs, context: &Context) -> Result<Report, Failure> {
    match args.command {
        ArmCommand::List => describe::list(context).await,
        ArmCommand::Describe(args) => describe::run(args, context).await,
        ArmCommand::Fk(args) => pose::forward(args, context).await,
        ArmCommand::Ik(args) => pose::inverse(args, context).await,
        ArmCommand::Jacobian(args) => velocity::jacobian(args, context).await,
        ArmCommand::Rates(args) => velocity::rates(args, context).await,
        ArmCommand::MoveVelocity(args) => velocity::motion(args, context).await,
        ArmCommand::Torques(args) => torques::run(args, context).await,
        ArmCommand::Calibrate(args) => calibrate::run(args, context).await,
        ArmCommand::Reach(args) => space::run(args, context).await,
        ArmCommand::Transfer(args) => transfer::run(args, context).await,
    }
}
