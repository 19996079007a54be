//! Whether a motion may be sent now, judged by the controller's last status line (C2 to C9).

use protocol::v2::{OperatingMode, StatusLine};
use thiserror::Error;

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
