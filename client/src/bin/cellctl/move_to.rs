//! `cellctl move`: to a pose, or to joint values.

use std::time::Duration;

use api::{
    Completion, ControlToken, Motion, MotionBody, MotionState, MotionType, PoseBody, TargetBody,
};
use clap::builder::NonEmptyStringValueParser;
use clap::{ArgGroup, Args};
use client::Ask;

use crate::context::Context;
use crate::failure::Failure;
use crate::numbers::{finite, six};
use crate::report::{Exit, Report};
use crate::text;

/// Move the robot to a pose, or to joint values, all joints starting and stopping together.
///
/// The pose is the tool center point in the robot's user frame. The answer says whether the controller took the
/// command; the arm may still be on its way.
///
/// Examples:
///   cellctl move 600 200 600 -180 30 0
///   cellctl move --x 600 --y 200 --z 600 --w -180 --p 30 --r 0 --speed 100
///   cellctl move --joints 0 0 0 0 -90 0
#[derive(Args, Debug)]
#[command(
    verbatim_doc_comment,
    group(ArgGroup::new("target").required(true).args(["X", "x", "joints"])),
    override_usage = "cellctl move <X> <Y> <Z> <W> <P> <R> [OPTIONS]\n       \
                      cellctl move --x <MM> --y <MM> --z <MM> --w <DEG> --p <DEG> --r <DEG> [OPTIONS]\n       \
                      cellctl move --joints <J1> <J2> <J3> <J4> <J5> <J6> [OPTIONS]"
)]
pub(crate) struct MoveArgs {
    #[command(flatten)]
    in_a_row: InARow,
    #[command(flatten)]
    by_name: ByName,
    /// Joint values in degrees, as on the pendant, instead of a pose.
    #[arg(long, num_args = 6, allow_hyphen_values = true, value_parser = finite,
        value_names = ["J1", "J2", "J3", "J4", "J5", "J6"])]
    joints: Option<Vec<f64>>,
    #[command(flatten)]
    pub(crate) motion: MotionArgs,
}

/// What every motion takes.
#[derive(Args, Debug)]
pub(crate) struct MotionArgs {
    /// Programmed speed in mm/s, a whole number from 1 to 1999.
    #[arg(long, value_name = "MM_S", default_value_t = 200.0, allow_hyphen_values = true, value_parser = finite)]
    speed: f64,
    /// Speed of the joints in percent of their fastest instead, for a controller that takes percent.
    #[arg(long, value_name = "PERCENT", conflicts_with = "speed", value_parser = clap::value_parser!(u8).range(1..=100))]
    percent: Option<u8>,
    /// Wait for the end of the motion, at most this many seconds (60 at most). The server's own measure where absent.
    #[arg(long, value_name = "S", value_parser = clap::value_parser!(u64).range(0..=60))]
    wait: Option<u64>,
    /// The key that names this motion: the same motion with the same key again is not sent again. A new one where
    /// absent.
    #[arg(long, value_name = "KEY", value_parser = NonEmptyStringValueParser::new())]
    key: Option<String>,
    /// Give up if the controller has not answered after this many milliseconds.
    #[arg(long, value_name = "MS")]
    deadline_ms: Option<u64>,
    /// Why, for the record.
    #[arg(long, value_name = "TEXT")]
    reason: Option<String>,
    /// Control that was taken with `cellctl control take`. Where absent it is taken for this motion.
    #[arg(long, value_name = "TOKEN", env = "ROBOCELL_CONTROL")]
    control: Option<ControlToken>,
}

#[derive(Args, Debug)]
struct InARow {
    /// X in millimeters.
    #[arg(id = "X", allow_hyphen_values = true, value_parser = finite,
        requires_all = ["Y", "Z", "W", "P", "R"])]
    x: Option<f64>,
    /// Y in millimeters.
    #[arg(id = "Y", allow_hyphen_values = true, value_parser = finite)]
    y: Option<f64>,
    /// Z in millimeters.
    #[arg(id = "Z", allow_hyphen_values = true, value_parser = finite)]
    z: Option<f64>,
    /// W, about the fixed X axis, in degrees.
    #[arg(id = "W", allow_hyphen_values = true, value_parser = finite)]
    w: Option<f64>,
    /// P, about the fixed Y axis, in degrees.
    #[arg(id = "P", allow_hyphen_values = true, value_parser = finite)]
    p: Option<f64>,
    /// R, about the fixed Z axis, in degrees.
    #[arg(id = "R", allow_hyphen_values = true, value_parser = finite)]
    r: Option<f64>,
}

#[derive(Args, Debug)]
struct ByName {
    /// X in millimeters.
    #[arg(long, value_name = "MM", allow_hyphen_values = true, value_parser = finite,
        requires_all = ["y", "z", "w", "p", "r"])]
    x: Option<f64>,
    /// Y in millimeters.
    #[arg(long, value_name = "MM", allow_hyphen_values = true, value_parser = finite,
        requires = "x", conflicts_with_all = ["X", "joints"])]
    y: Option<f64>,
    /// Z in millimeters.
    #[arg(long, value_name = "MM", allow_hyphen_values = true, value_parser = finite,
        requires = "x", conflicts_with_all = ["X", "joints"])]
    z: Option<f64>,
    /// W, about the fixed X axis, in degrees.
    #[arg(long, value_name = "DEG", allow_hyphen_values = true, value_parser = finite,
        requires = "x", conflicts_with_all = ["X", "joints"])]
    w: Option<f64>,
    /// P, about the fixed Y axis, in degrees.
    #[arg(long, value_name = "DEG", allow_hyphen_values = true, value_parser = finite,
        requires = "x", conflicts_with_all = ["X", "joints"])]
    p: Option<f64>,
    /// R, about the fixed Z axis, in degrees.
    #[arg(long, value_name = "DEG", allow_hyphen_values = true, value_parser = finite,
        requires = "x", conflicts_with_all = ["X", "joints"])]
    r: Option<f64>,
}

impl MoveArgs {
    fn target(&self) -> Option<TargetBody> {
        let InARow { x, y, z, w, p, r } = self.in_a_row;
        let named = &self.by_name;
        let joints = || self.joints.as_deref().and_then(six).map(TargetBody::Joints);
        whole_pose([x, y, z, w, p, r])
            .or_else(|| whole_pose([named.x, named.y, named.z, named.w, named.p, named.r]))
            .map(TargetBody::Pose)
            .or_else(joints)
    }
}

fn whole_pose([x, y, z, w, p, r]: [Option<f64>; 6]) -> Option<PoseBody> {
    Some([x?, y?, z?, w?, p?, r?].into())
}

pub(crate) async fn run(args: MoveArgs, context: &Context) -> Result<Report, Failure> {
    let Some(target) = args.target() else {
        return Err(Failure::Usage("the target is incomplete".to_owned()));
    };
    send(args.motion, MotionType::Joint, Some(target), context).await
}

/// Sends one motion to the robot that is meant, and reports what became of it.
pub(crate) async fn send(
    args: MotionArgs,
    motion_type: MotionType,
    target: Option<TargetBody>,
    context: &Context,
) -> Result<Report, Failure> {
    let robot = context.robot().await?;
    let why = args.reason.as_deref().unwrap_or("a motion by cellctl");
    let (robot, held) = context.control_of(&robot, args.control, why).await?;
    let body = MotionBody {
        target,
        speed_mm_s: args.percent.is_none().then_some(args.speed),
        speed_percent: args.percent.map(f64::from),
        deadline_ms: args.deadline_ms,
        reason: args.reason,
        ..MotionBody::new(motion_type)
    };
    let ask = Ask {
        key: args.key,
        wait: args.wait.map(Duration::from_secs),
    };
    let sent = robot.ask_for_motion(&body, &ask).await;
    if let Some(held) = held {
        // It ends by itself soon, if it cannot be given back; what became of the motion is what matters.
        let _given_back = held.release().await;
    }
    let motion = sent?;
    Ok(context.report(exit_of(motion.state), &motion, sentence))
}

fn exit_of(state: MotionState) -> Exit {
    match state {
        MotionState::Queued
        | MotionState::Dispatched
        | MotionState::Accepted
        | MotionState::Executing
        | MotionState::Paused
        | MotionState::Settling
        | MotionState::Succeeded => Exit::Done,
        MotionState::Rejected
        | MotionState::NotExecuted
        | MotionState::Expired
        | MotionState::Canceled
        | MotionState::Failed => Exit::Refused,
        MotionState::InDoubt => Exit::Link,
    }
}

fn sentence(motion: &Motion) -> String {
    let what = match motion.state {
        MotionState::Queued => "The motion waits for the link",
        MotionState::Dispatched => "The motion is on its way to the controller",
        MotionState::Accepted => match motion.completion {
            Completion::NotObservable => {
                "The controller took the motion. Its end is not reported by this controller"
            }
            Completion::Observable => "The controller took the motion",
        },
        MotionState::Executing => "The arm moves",
        MotionState::Paused => "The motion is held",
        MotionState::Settling => "The arm is there, and is being checked to stand still",
        MotionState::Succeeded => "The arm is at the target, standing still",
        MotionState::Failed => "The motion began and did not get to its target",
        MotionState::Canceled => "The motion was canceled",
        MotionState::Expired => "The motion could not begin in time and was not sent",
        MotionState::Rejected => "The controller refused the motion: not executed",
        MotionState::NotExecuted => "The motion was not sent",
        MotionState::InDoubt => {
            "The outcome of the motion is UNKNOWN: the robot may have moved. \
             Look at it before sending anything else"
        }
    };
    let facts = [
        ("robot", format!("{} in {}", motion.robot, motion.cell)),
        ("target", text::pose(&motion.target)),
        ("joints", text::joints(motion.expected_joints)),
        ("speed", text::speed(motion)),
        ("state", text::word(motion.state)),
        ("motion", motion.id.to_string()),
    ];
    format!("{what}.\n{}", text::facts(&facts))
}
