//! A command from its sending to its end, by the status lines alone.

use std::time::Duration;

use protocol::v2::{FinishStatus, StatusLine, WirePose};
use tokio::time::Instant;
use units::{Degrees, Millimeters};

use super::error::LinkError;
use super::judge::{Conclusion, Finding, Open, Verdict, joints_apart, judge, poses_apart};
use super::order::{Instruction, MotionEnd};
use super::plan::{CellServerPlan, GIVE_UP};
use super::seed_judge::{self, Answered, Known};
use super::view::{ControllerView, Observed};

/// The least time between two status lines that are to be of the same standstill, by the server's clock.
const APART: Duration = Duration::from_millis(200);
/// How far the arm may seem to move and stand still all the same.
const SAME_POSITION: Millimeters = Millimeters(0.1);
const SAME_ROTATION: Degrees = Degrees(0.05);

/// Follows an open command through what the link publishes.
#[derive(Debug)]
pub(super) struct Follower<'a> {
    plan: &'a CellServerPlan,
    open: Open,
    /// A finding that has to stay true before it is believed.
    settling: Option<Settling>,
    lost_since: Option<Instant>,
    /// The status line judged last.
    seen: u64,
    executing: bool,
    /// For the seed's pose server: what is known of the command port, and since when.
    answered: Answered,
    answered_at: Instant,
    start: Option<WirePose>,
    stopped: bool,
}

#[derive(Clone, Copy, Debug)]
struct Settling {
    finding: Finding,
    first: StatusLine,
    since: Instant,
}

/// What one look at the link tells.
#[derive(Debug, Default)]
pub(super) struct Look {
    /// The controller has stored the number; said once.
    pub(super) accepted: bool,
    /// The arm moves for it; said once.
    pub(super) executing: bool,
    pub(super) end: Option<MotionEnd>,
}

impl<'a> Follower<'a> {
    pub(super) fn new(plan: &'a CellServerPlan, open: Open) -> Self {
        Self {
            plan,
            open,
            settling: None,
            lost_since: None,
            seen: 0,
            executing: false,
            answered: if open.accepted {
                Answered::Taken
            } else {
                Answered::Never { fenced: false }
            },
            answered_at: Instant::now(),
            start: None,
            stopped: false,
        }
    }

    /// A command that was just sent, from `start`: an answer may come.
    pub(super) fn sent(plan: &'a CellServerPlan, open: Open, start: Option<WirePose>) -> Self {
        Self {
            answered: Answered::NotYet,
            start,
            ..Self::new(plan, open)
        }
    }

    /// No answer tells, and none will.
    pub(super) fn unanswered(&mut self, fenced: bool) {
        self.know(Answered::Never { fenced });
    }

    /// A stop was asked for and, where `confirmed`, the controller has ended what it had.
    pub(super) fn stopped(&mut self, confirmed: bool) {
        self.stopped = confirmed;
        self.know(self.answered);
    }

    fn know(&mut self, answered: Answered) {
        self.answered = answered;
        self.answered_at = Instant::now();
        self.settling = None;
    }

    pub(super) fn is_accepted(&self) -> bool {
        self.open.accepted
    }

    /// The controller said so on the command port. Says whether that is news.
    pub(super) fn acknowledged(&mut self) -> bool {
        let news = !std::mem::replace(&mut self.open.accepted, true);
        if news {
            self.know(Answered::Taken);
        }
        news
    }

    /// When to look again although nothing was published.
    pub(super) fn deadline(&self) -> Option<Instant> {
        self.lost_since.map(|since| since + GIVE_UP)
    }

    pub(super) fn look(&mut self, view: &ControllerView) -> Look {
        let mut look = Look::default();
        let now = Instant::now();
        if !view.is_connected() {
            self.settling = None;
            let since = *self.lost_since.get_or_insert(now);
            if now.duration_since(since) >= GIVE_UP {
                look.end = Some(MotionEnd::InDoubt {
                    error: LinkError::Lost { after: GIVE_UP },
                    status: None,
                });
            }
            return look;
        }
        self.lost_since = None;
        let Some(observed) = view.status else {
            return look;
        };
        if observed.count == self.seen {
            return look;
        }
        self.seen = observed.count;
        let status = observed.line;
        let begun = match self.open.command {
            Instruction::Numbered(_) if status.accepted == self.open.number => {
                look.accepted = self.acknowledged();
                status.finished < self.open.number
            }
            Instruction::Numbered(_) => false,
            Instruction::Seed(_) if observed.asked_at < self.answered_at => return look,
            Instruction::Seed(_) => self.answered != Answered::NotYet,
        };
        if begun && status.moving && !self.executing {
            self.executing = true;
            look.executing = true;
        }
        look.end = self.end(&observed);
        look
    }

    fn end(&mut self, observed: &Observed) -> Option<MotionEnd> {
        let status = observed.line;
        let tolerance = self.plan.tolerance;
        let verdict = match &self.open.command {
            Instruction::Numbered(_) => judge(&status, &self.open, tolerance),
            Instruction::Seed(target) => {
                let known = Known {
                    answered: self.answered,
                    start: self.start,
                    moved: self.executing,
                    stopped: self.stopped,
                };
                seed_judge::judge(&status, &self.open, target, known, tolerance)
            }
        };
        let finding = match verdict {
            Verdict::Unless(finding) => finding,
            Verdict::Wait => {
                self.settling = None;
                return None;
            }
            Verdict::Arrived => return Some(MotionEnd::Arrived { status }),
            Verdict::Interrupted(fin_status) => {
                return Some(MotionEnd::Interrupted { fin_status, status });
            }
            Verdict::Lost(finding) => return Some(self.believed(finding, status)),
        };
        match self.settling {
            Some(settling) if settling.still(finding, &status) => {
                let lasted = observed.at.duration_since(settling.since);
                (lasted >= self.needed(finding)).then(|| self.believed(finding, status))
            }
            Some(_) | None => {
                self.settling = Some(Settling {
                    finding,
                    first: status,
                    since: observed.at,
                });
                None
            }
        }
    }

    /// How long a finding has to stay true.
    fn needed(&self, finding: Finding) -> Duration {
        let scaled = match finding {
            Finding::NotTaken { .. } => self.plan.drain(),
            Finding::Forgotten { .. }
            | Finding::Unfinished
            | Finding::PoseMismatch { .. }
            | Finding::OutputMismatch { .. }
            | Finding::Restarted { .. }
            | Finding::Overtaken { .. }
            | Finding::NotBegun
            | Finding::Unanswered { .. } => self.plan.settle(),
            Finding::Reached | Finding::Halted | Finding::Alarmed => Duration::ZERO,
        };
        scaled.max(APART.div_f64(self.plan.time_scale))
    }

    fn believed(&self, finding: Finding, status: StatusLine) -> MotionEnd {
        match finding.conclusion(self.open.number) {
            Conclusion::Ended(FinishStatus::Arrived) => MotionEnd::Arrived { status },
            Conclusion::Ended(fin_status) => MotionEnd::Interrupted { fin_status, status },
            Conclusion::Doubt(error) if matches!(finding, Finding::NotTaken { .. }) => {
                MotionEnd::NotSent { error }
            }
            Conclusion::Doubt(error) => MotionEnd::InDoubt {
                error,
                status: Some(status),
            },
        }
    }
}

impl Settling {
    /// Whether a later status line shows the same thing at the same place. That a command was not taken does not
    /// depend on where the arm is.
    fn still(&self, finding: Finding, status: &StatusLine) -> bool {
        if !self.finding.same_kind(finding) {
            return false;
        }
        if matches!(
            finding,
            Finding::NotTaken { .. } | Finding::Forgotten { .. }
        ) {
            return true;
        }
        let (apart, turned) = poses_apart(&self.first.pose, &status.pose);
        let joints = joints_apart(&self.first.joints, &status.joints);
        apart <= SAME_POSITION && turned <= SAME_ROTATION && joints <= SAME_ROTATION
    }
}
