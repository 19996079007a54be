//! What became of a motion: the decision from evidence, for every restart and every lost answer.
//!
//! The rule is that of a controller that keeps the highest epoch it was fenced with, and the numbers of the last motion
//! it accepted and the last it finished (tier 2). It is pure, so that the server and the model share it.

use serde::{Deserialize, Serialize};

/// The number of a motion: epoch first, then sequence.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize, Deserialize)]
pub struct MotionNumber {
    /// Grows with every start of the server.
    pub epoch: u32,
    /// Grows with every motion of an epoch.
    pub seq: u32,
}

/// How a finished motion ended.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Finish {
    /// At its target.
    Arrived,
    /// By an alarm, an abort, a stop or the dead-man.
    Cut,
}

/// What was read from the controller.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Serialize, Deserialize)]
#[expect(
    clippy::struct_excessive_bools,
    reason = "each is one field of a status line"
)]
pub struct Reading {
    /// It answered a fence with an epoch above the motion's before this was read: nothing older can start any more.
    pub fenced: bool,
    /// Count of the controller's starts, unchanged since the motion was sent.
    pub same_boot: bool,
    /// The last motion it accepted.
    pub accepted: Option<MotionNumber>,
    /// The last motion it finished, and how.
    pub finished: Option<(MotionNumber, Finish)>,
    /// It moves.
    pub moving: bool,
    /// It is held: a motion may go on when somebody releases it.
    pub held: bool,
    /// Its pose is the target, within tolerance.
    pub at_target: bool,
    /// This is at least the second reading in a row that says the same.
    pub settled: bool,
}

/// What follows.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Verdict {
    /// Observed at the target, still: done.
    Executed,
    /// Proven that it never began and never will: it may be sent again, under a new number.
    NotExecuted,
    /// It began, ended elsewhere, and stands.
    Interrupted,
    /// Read again.
    Wait,
    /// Only a human can say.
    InDoubt,
}

/// What became of motion `sent`, by what was read. Never guesses: without a fence there is nothing but doubt, and
/// "not executed" needs the number of the controller, never a pose.
#[must_use]
pub fn decide_motion(sent: MotionNumber, reading: Option<&Reading>) -> Verdict {
    let Some(read) = reading else {
        return Verdict::InDoubt;
    };
    if !read.fenced {
        return Verdict::InDoubt;
    }
    if read.accepted.is_none_or(|accepted| accepted < sent) {
        return Verdict::NotExecuted;
    }
    if read.accepted.is_some_and(|accepted| accepted > sent) {
        // Somebody else's motion came after it: what this one did cannot be read any more.
        return Verdict::InDoubt;
    }
    match read.finished {
        Some((number, finish)) if number == sent => {
            if read.moving {
                return Verdict::Wait;
            }
            match finish {
                Finish::Arrived if read.at_target => Verdict::Executed,
                // It arrived and is elsewhere now: moved by hand.
                Finish::Arrived => Verdict::InDoubt,
                Finish::Cut => Verdict::Interrupted,
            }
        }
        Some(_) | None => {
            if !read.same_boot {
                return Verdict::InDoubt;
            }
            if read.moving || read.held || !read.settled {
                return Verdict::Wait;
            }
            Verdict::InDoubt
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const SENT: MotionNumber = MotionNumber { epoch: 2, seq: 3 };

    fn reading() -> Reading {
        Reading {
            fenced: true,
            same_boot: true,
            accepted: Some(SENT),
            finished: Some((SENT, Finish::Arrived)),
            moving: false,
            held: false,
            at_target: true,
            settled: true,
        }
    }

    #[test]
    fn nothing_is_decided_without_a_fence() {
        let open = Reading {
            fenced: false,
            ..reading()
        };
        assert_eq!(decide_motion(SENT, Some(&open)), Verdict::InDoubt);
        assert_eq!(decide_motion(SENT, None), Verdict::InDoubt);
    }

    #[test]
    fn a_motion_that_was_never_accepted_may_be_sent_again() {
        let before = MotionNumber { epoch: 2, seq: 2 };
        for accepted in [None, Some(before)] {
            let read = Reading {
                accepted,
                finished: None,
                ..reading()
            };
            assert_eq!(decide_motion(SENT, Some(&read)), Verdict::NotExecuted);
        }
    }

    #[test]
    fn a_finished_motion_is_executed_only_at_its_target() {
        assert_eq!(decide_motion(SENT, Some(&reading())), Verdict::Executed);
        let moved_by_hand = Reading {
            at_target: false,
            ..reading()
        };
        assert_eq!(decide_motion(SENT, Some(&moved_by_hand)), Verdict::InDoubt);
        let cut = Reading {
            finished: Some((SENT, Finish::Cut)),
            ..reading()
        };
        assert_eq!(decide_motion(SENT, Some(&cut)), Verdict::Interrupted);
    }

    #[test]
    fn an_accepted_motion_is_waited_for_while_the_controller_knows_it() {
        let begun = Reading {
            finished: None,
            moving: true,
            ..reading()
        };
        assert_eq!(decide_motion(SENT, Some(&begun)), Verdict::Wait);
        let held = Reading {
            finished: None,
            held: true,
            ..reading()
        };
        assert_eq!(decide_motion(SENT, Some(&held)), Verdict::Wait);
        let once = Reading {
            finished: None,
            settled: false,
            ..reading()
        };
        assert_eq!(decide_motion(SENT, Some(&once)), Verdict::Wait);
        let rebooted = Reading {
            finished: None,
            same_boot: false,
            moving: true,
            ..reading()
        };
        assert_eq!(decide_motion(SENT, Some(&rebooted)), Verdict::InDoubt);
        let lost = Reading {
            finished: None,
            ..reading()
        };
        assert_eq!(decide_motion(SENT, Some(&lost)), Verdict::InDoubt);
    }

    #[test]
    fn a_later_motion_of_somebody_else_hides_the_truth() {
        let other = MotionNumber { epoch: 2, seq: 4 };
        let read = Reading {
            accepted: Some(other),
            ..reading()
        };
        assert_eq!(decide_motion(SENT, Some(&read)), Verdict::InDoubt);
    }
}
