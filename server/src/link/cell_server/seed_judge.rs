//! What became of a motion of the seed's pose server, by where the arm is. The decision table; no clock, no I/O.
//!
//! The wire has no number, so nothing ties a status line to a motion but the target. Only lines that were asked for
//! after the last thing known on the command port are judged: the answer, or the end of waiting for one.
//!
//! | the arm | verdict |
//! |---|---|
//! | other boot of the status program | in doubt |
//! | moves | wait |
//! | stands at the target | arrived, if that stays so, whatever was answered |
//! | stands elsewhere, on hold or override 0 | wait: it goes on when somebody lets it |
//! | stands elsewhere, stopped | interrupted, if that stays so |
//! | stands elsewhere, alarm | interrupted, if that stays so, and the controller has dropped the rest |
//! | stands elsewhere, taken, was seen moving | in doubt: stopped between, if that stays so |
//! | stands elsewhere, taken, was never seen moving | in doubt: not begun, if that stays so |
//! | stands elsewhere, no answer | in doubt, if that stays so; whether it stands at the start is evidence, not proof |

use protocol::WireMove;
use protocol::v2::{StatusLine, WirePose};

use super::judge::{Finding, Open, Verdict, is_near, poses_apart};
use crate::config::Tolerance;

/// What is known of a motion on the command port.
#[derive(Clone, Copy, Debug, Eq, PartialEq)]
pub(super) enum Answered {
    /// An answer may still come.
    NotYet,
    /// The controller says that it moves.
    Taken,
    /// None came that tells. `fenced`: the controller has read all that was sent.
    Never { fenced: bool },
}

/// What is known beside the status line.
#[derive(Clone, Copy, Debug)]
pub(super) struct Known {
    pub(super) answered: Answered,
    /// Where the arm stood when the motion was sent.
    pub(super) start: Option<WirePose>,
    /// The arm was seen moving since.
    pub(super) moved: bool,
    /// A stop was confirmed since.
    pub(super) stopped: bool,
}

/// Judges an open motion by one status line.
pub(super) fn judge(
    status: &StatusLine,
    open: &Open,
    target: &WireMove,
    known: Known,
    tolerance: Tolerance,
) -> Verdict {
    if let Some(was) = open.boot
        && was != status.boot
    {
        return Verdict::Lost(Finding::Restarted {
            was,
            is: status.boot,
        });
    }
    let at = |pose: &WirePose| is_near(poses_apart(&status.pose, pose), tolerance);
    let fenced = match known.answered {
        Answered::NotYet => return Verdict::Wait,
        Answered::Taken => true,
        Answered::Never { fenced } => fenced,
    };
    if status.moving {
        return Verdict::Wait;
    }
    if at(&WirePose::from(*target)) {
        return Verdict::Unless(Finding::Reached);
    }
    if known.stopped && fenced {
        return Verdict::Unless(Finding::Halted);
    }
    if status.held || status.speed_override == 0 {
        return Verdict::Wait;
    }
    let taken = known.moved || known.answered == Answered::Taken;
    Verdict::Unless(match taken {
        true if status.alarm != 0 => Finding::Alarmed,
        true if known.moved => Finding::Unfinished,
        true => Finding::NotBegun,
        false => Finding::Unanswered {
            fenced,
            at_start: known.start.as_ref().map(at),
        },
    })
}
