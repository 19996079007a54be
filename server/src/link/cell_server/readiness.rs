//! Whether a motion may be sent now, judged by the controller's last status line (C2 to C9).

use kinematics::{Axis, PendantJoints, Pose, Xyzwpr};
use protocol::v2::{OperatingMode, StatusLine};
use thiserror::Error;

use super::plan::Arm;
use crate::config::FrameNumbers;

/// Why no motion is sent now.
#[derive(Clone, Copy, Debug, Eq, Error, PartialEq)]
pub(crate) enum NotReady {
    #[error("the controller's status port is not connected")]
    Disconnected,
    #[error("the controller has not been fenced with an epoch of this server")]
    NotFenced,
    #[error(
        "another server has taken the controller with epoch {epoch_max}, above this server's {ours}"
    )]
    Superseded { epoch_max: u32, ours: u32 },
    #[error(
        "this start of the server has used up its {limit} link generations; a restart begins a new epoch"
    )]
    GenerationsUsedUp { limit: u32 },
    #[error(
        "another controller answers at this address, or this one has lost its memory: boot {} after {}, highest \
         epoch {} after {}; a restart of the server takes it as it is",
        is.boot, was.boot, is.epoch_max, was.epoch_max
    )]
    OtherController { is: Identity, was: Identity },
    #[error(
        "{axis} is said to be at {} degrees, beyond its limits: is the robot mastered?",
        f64::from(*mdeg) / 1000.0
    )]
    ImplausibleJoint { axis: Axis, mdeg: i32 },
    #[error(
        "the pose the controller reports is {} mm and {} degrees from where its joints put the tool: the tool, the user \
         frame or the arm model is another one than configured, or the robot is not mastered",
        f64::from(*apart_um) / 1000.0,
        f64::from(*turned_mdeg) / 1000.0
    )]
    ImplausiblePose { apart_um: u32, turned_mdeg: u32 },
    #[error("the teach pendant is enabled")]
    Pendant,
    #[error("the mode is {}, not AUTO", mode_name(*.0))]
    Mode(OperatingMode),
    #[error("the controller has alarm {}", alarm_name(*.0))]
    Alarm(u32),
    #[error("the controller is on hold")]
    Held,
    #[error("the speed override is 0 %")]
    OverrideZero,
    #[error("the dead-man is latched until the controller is fenced anew")]
    DeadMan,
    #[error("user frame {active} is active on the controller, not {expected}")]
    UserFrame { active: u8, expected: u8 },
    #[error("tool {active} is active on the controller, not {expected}")]
    Tool { active: u8, expected: u8 },
    #[error("the arm moves, and not by a motion of this server")]
    MovedByOthers,
}

/// What tells one controller from another, and one that has its memory from one that has lost it: both only rise.
#[derive(Clone, Copy, Debug, Eq, PartialEq)]
pub(crate) struct Identity {
    pub(crate) boot: u32,
    /// The highest epoch it was fenced with.
    pub(crate) epoch_max: u32,
}

impl Identity {
    pub(super) fn of(status: &StatusLine) -> Self {
        Self {
            boot: status.boot,
            epoch_max: status.epoch_max,
        }
    }

    /// Whether a controller that says `is` can be the one that was `self` before.
    pub(super) fn check(self, is: Self) -> Result<(), NotReady> {
        if is.boot < self.boot || is.epoch_max < self.epoch_max {
            return Err(NotReady::OtherController { is, was: self });
        }
        Ok(())
    }
}

/// How far a joint may be beyond its limit: pendants show it, and a brake lets an arm sink a little.
const BEYOND_LIMIT_DEG: f64 = 1.0;
/// How far the reported pose may be from that of the reported joints. A calibrated arm differs from its drawing by a
/// few millimeters.
const APART_MM: f64 = 10.0;
const TURNED_DEG: f64 = 1.0;

/// Whether what the controller says of the arm can be true (C13): joints within the model's limits, and the pose that
/// follows from them.
pub(super) fn implausible(status: &StatusLine, arm: &Arm) -> Option<NotReady> {
    // While it moves, joints and pose may have been read one after the other.
    if status.moving {
        return None;
    }
    let joints = PendantJoints::from_degrees(status.joints.degrees().map(|joint| joint.0));
    for axis in Axis::ALL {
        let value = joints.of(axis);
        let margin = arm.model.limits(axis).margin(value);
        // Written so that what cannot be compared is implausible.
        let within = margin.0 >= -BEYOND_LIMIT_DEG;
        if !within {
            return Some(NotReady::ImplausibleJoint {
                axis,
                mdeg: thousandths(value.0),
            });
        }
    }
    let ([x, y, z], [w, p, r]) = (status.pose.position(), status.pose.rotation());
    let reported = Pose::try_from_xyzwpr(&Xyzwpr { x, y, z, w, p, r }).ok()?;
    let follows = arm.frames.tcp_in_user_frame(&arm.model.forward(&joints));
    let (apart, turned) = reported.distance_to(&follows);
    let turned: units::Degrees = turned.into();
    let near = apart.0 <= APART_MM && turned.0 <= TURNED_DEG;
    (!near).then(|| NotReady::ImplausiblePose {
        apart_um: thousandths(apart.0).unsigned_abs(),
        turned_mdeg: thousandths(turned.0).unsigned_abs(),
    })
}

fn thousandths(value: f64) -> i32 {
    #[expect(
        clippy::cast_possible_truncation,
        reason = "only shown; a number beyond the range is shown as its end"
    )]
    let rounded = (value * 1000.0).round() as i32;
    rounded
}

/// `SRVO-050` is `11-050`: the wire has the facility's number, not its letters.
pub(super) fn alarm_name(alarm: u32) -> String {
    format!("{}-{:03}", alarm / 1000, alarm % 1000)
}

fn mode_name(mode: OperatingMode) -> &'static str {
    match mode {
        OperatingMode::T1 => "T1",
        OperatingMode::T2 => "T2",
        OperatingMode::Auto => "AUTO",
    }
}

/// The first reason against a motion, those that take a person at the controller first.
pub(super) fn check(
    status: &StatusLine,
    wire_epoch: u32,
    frames: FrameNumbers,
    in_flight: bool,
) -> Option<NotReady> {
    if status.epoch_max > wire_epoch {
        return Some(NotReady::Superseded {
            epoch_max: status.epoch_max,
            ours: wire_epoch,
        });
    }
    if status.epoch_max < wire_epoch {
        return Some(NotReady::NotFenced);
    }
    if status.pendant {
        return Some(NotReady::Pendant);
    }
    if status.mode != OperatingMode::Auto {
        return Some(NotReady::Mode(status.mode));
    }
    if status.alarm != 0 {
        return Some(NotReady::Alarm(status.alarm));
    }
    if status.held {
        return Some(NotReady::Held);
    }
    if status.speed_override == 0 {
        return Some(NotReady::OverrideZero);
    }
    if status.dead_man {
        return Some(NotReady::DeadMan);
    }
    if let Some(expected) = frames.user_frame
        && expected != status.user_frame
    {
        return Some(NotReady::UserFrame {
            active: status.user_frame,
            expected,
        });
    }
    if let Some(expected) = frames.tool
        && expected != status.tool
    {
        return Some(NotReady::Tool {
            active: status.tool,
            expected,
        });
    }
    (status.moving && !in_flight).then_some(NotReady::MovedByOthers)
}
