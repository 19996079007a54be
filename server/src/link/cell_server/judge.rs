//! What became of a command, by what the controller says of itself. The decision table; no clock, no I/O.
//!
//! With `n` the command's number, `acc` and `fin` the controller's, behind a fence where one is said:
//!
//! | status line | verdict |
//! |---|---|
//! | `acc < n`, not fenced | wait: it may still be read |
//! | `acc < n`, fenced | not taken, if that stays so |
//! | `acc < n`, once seen accepted | in doubt, if that stays so |
//! | `acc = fin = n`, moving | wait for the standstill |
//! | `acc = fin = n`, status 0 | arrived, if the pose is the target's; else in doubt, if that stays so |
//! | `acc = fin = n`, other status | interrupted |
//! | `acc = n`, `fin < n`, other boot | in doubt |
//! | `acc = n`, `fin < n`, moving, held or override 0 | wait |
//! | `acc = n`, `fin < n`, standing | in doubt, if that stays so |
//! | `acc > n` | in doubt |

use kinematics::{Pose, Xyzwpr};
use protocol::v2::{Command, FinishStatus, MotionNumber, Move, StatusLine, WireJoints, WirePose};
use units::{Degrees, Millimeters};

use super::error::LinkError;
use super::order::Instruction;
use crate::config::Tolerance;

/// A command whose end is open.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Open {
    pub(crate) number: MotionNumber,
    /// The controller's boot counter when it was sent, where it is known.
    pub(crate) boot: Option<u32>,
    /// Whether the controller was seen to have accepted it.
    pub(crate) accepted: bool,
    pub(crate) command: Instruction,
}

/// What a status line says of an open command.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Verdict {
    /// A later status line will tell.
    Wait,
    /// Finished at its target, standing still.
    Arrived,
    /// Finished elsewhere.
    Interrupted(FinishStatus),
    /// True unless a later status line says otherwise; to be believed once it has stayed so for a while.
    Unless(Finding),
    /// No later status line can tell.
    Lost(Finding),
}

/// What was found.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Finding {
    NotTaken {
        accepted: MotionNumber,
    },
    Forgotten {
        accepted: MotionNumber,
    },
    Unfinished,
    PoseMismatch {
        apart_mm: f64,
        apart_deg: f64,
    },
    OutputMismatch {
        output: u8,
    },
    Restarted {
        was: u32,
        is: u32,
    },
    Overtaken {
        accepted: MotionNumber,
    },
    /// Of the seed's pose server, see [`super::seed_judge`].
    Reached,
    Halted,
    Alarmed,
    NotBegun,
    Unanswered {
        fenced: bool,
        at_start: Option<bool>,
    },
}

/// What a finding that is believed comes to.
pub(super) enum Conclusion {
    Ended(FinishStatus),
    Doubt(LinkError),
}

impl Finding {
    /// Whether two findings are the same, whatever their numbers.
    pub(super) fn same_kind(self, other: Self) -> bool {
        std::mem::discriminant(&self) == std::mem::discriminant(&other)
    }

    pub(super) fn conclusion(self, number: MotionNumber) -> Conclusion {
        Conclusion::Doubt(match self {
            Self::Reached => return Conclusion::Ended(FinishStatus::Arrived),
            Self::Halted => return Conclusion::Ended(FinishStatus::Stopped),
            Self::Alarmed => return Conclusion::Ended(FinishStatus::Alarm),
            Self::NotBegun => LinkError::NotBegun,
            Self::Unanswered { fenced, at_start } => LinkError::Unanswered { fenced, at_start },
            Self::NotTaken { accepted } => LinkError::NotTaken { accepted },
            Self::Forgotten { accepted } => LinkError::Forgotten { number, accepted },
            Self::Unfinished => LinkError::Unfinished,
            Self::PoseMismatch {
                apart_mm,
                apart_deg,
            } => LinkError::PoseMismatch {
                apart_mm,
                apart_deg,
            },
            Self::OutputMismatch { output } => LinkError::OutputMismatch { output },
            Self::Restarted { was, is } => LinkError::Restarted { was, is },
            Self::Overtaken { accepted } => LinkError::Overtaken { number, accepted },
        })
    }
}

/// Judges an open command by one status line.
pub(super) fn judge(status: &StatusLine, open: &Open, tolerance: Tolerance) -> Verdict {
    let Open {
        number, accepted, ..
    } = *open;
    if status.accepted > number || status.finished > number {
        return Verdict::Lost(Finding::Overtaken {
            accepted: status.accepted.max(status.finished),
        });
    }
    if status.accepted < number {
        if accepted {
            // An older line that came late; or what it had stored is gone, its memory lost or restored.
            return Verdict::Unless(Finding::Forgotten {
                accepted: status.accepted,
            });
        }
        return if status.epoch_max > number.epoch {
            Verdict::Unless(Finding::NotTaken {
                accepted: status.accepted,
            })
        } else {
            Verdict::Wait
        };
    }
    if status.finished == number {
        return match status.finish {
            _ if status.moving => Verdict::Wait,
            FinishStatus::Arrived => match mismatch(status, &open.command, tolerance) {
                None => Verdict::Arrived,
                Some(finding) => Verdict::Unless(finding),
            },
            other @ (FinishStatus::Alarm | FinishStatus::Stopped | FinishStatus::DeadMan) => {
                Verdict::Interrupted(other)
            }
        };
    }
    match open.boot {
        Some(boot) if boot != status.boot => Verdict::Lost(Finding::Restarted {
            was: boot,
            is: status.boot,
        }),
        // On hold, or slowed to nothing, it goes on when somebody lets it: never judged before that.
        _ if status.moving || status.held || status.speed_override == 0 => Verdict::Wait,
        _ => Verdict::Unless(Finding::Unfinished),
    }
}

/// What the thousandths of the wire leave in a difference of two of them.
const ROUNDING: f64 = 1e-6;

fn mismatch(
    status: &StatusLine,
    instruction: &Instruction,
    tolerance: Tolerance,
) -> Option<Finding> {
    let (apart_mm, apart_deg) = match instruction {
        Instruction::Seed(target) => poses_apart(&status.pose, &WirePose::from(*target)),
        Instruction::Numbered(Command::Output(output)) => {
            let number = output.output.get();
            return (status.output(number) != output.on)
                .then_some(Finding::OutputMismatch { output: number });
        }
        Instruction::Numbered(Command::Move(
            Move::Joint { pose, .. } | Move::Linear { pose, .. },
        )) => poses_apart(&status.pose, pose),
        Instruction::Numbered(Command::Move(Move::Joints { joints, .. })) => {
            (Millimeters(0.0), joints_apart(&status.joints, joints))
        }
    };
    let near = is_near((apart_mm, apart_deg), tolerance);
    (!near).then_some(Finding::PoseMismatch {
        apart_mm: apart_mm.0,
        apart_deg: apart_deg.0,
    })
}

/// Whether what is so far apart counts as the same.
pub(super) fn is_near((apart, turned): (Millimeters, Degrees), tolerance: Tolerance) -> bool {
    // Written so that what cannot be compared is not near.
    apart <= tolerance.position + Millimeters(ROUNDING)
        && turned <= tolerance.rotation + Degrees(ROUNDING)
}

/// How far two poses are apart and turned against each other; infinitely, where one of them is none.
pub(super) fn poses_apart(one: &WirePose, other: &WirePose) -> (Millimeters, Degrees) {
    match (pose_of(one), pose_of(other)) {
        (Some(one), Some(other)) => {
            let (apart, turned) = one.distance_to(&other);
            (apart, turned.into())
        }
        _ => (Millimeters(f64::INFINITY), Degrees(f64::INFINITY)),
    }
}

/// The largest difference of two joints.
pub(super) fn joints_apart(one: &WireJoints, other: &WireJoints) -> Degrees {
    let apart = one.degrees().into_iter().zip(other.degrees());
    Degrees(apart.fold(0.0, |most, (one, other)| most.max((one - other).abs().0)))
}

fn pose_of(wire: &WirePose) -> Option<Pose> {
    let ([x, y, z], [w, p, r]) = (wire.position(), wire.rotation());
    Pose::try_from_xyzwpr(&Xyzwpr { x, y, z, w, p, r }).ok()
}
