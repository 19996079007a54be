//! How faults are answered, always in the same order: permits safe, arm safe, tell the mobile robot, job state, ask.

use uuid::Uuid;

use crate::fact::Fact;
use crate::faults::Fault;
use crate::intervention::Answer;
use crate::job::{Job, JobState, StepState, Why};
use crate::session::{Session, SessionState};
use crate::signal::Message;
use crate::words;
use crate::work::{Ask, Work};

/// What to do about a fault of a job.
#[derive(Default)]
pub(crate) struct Reaction {
    pub fault: Fault,
    pub text: String,
    /// Take the permits of its session back.
    pub permits: bool,
    /// Stop its arm.
    pub stop: bool,
    /// Tell the mobile robot to stand still.
    pub pause: bool,
    /// Holding, Suspending, Aborting; `None`: it stays.
    pub state: Option<JobState>,
    /// What to ask.
    pub ask: Option<Ask>,
}

impl Work<'_> {
    pub(crate) fn react(&mut self, job: &Job, reaction: Reaction) {
        let Reaction {
            fault,
            text,
            permits,
            stop,
            pause,
            state,
            ask,
        } = reaction;
        self.note(job.id, fault, text.clone());
        let session = self.cell.session_of(job).cloned();
        if permits && let Some(session) = &session {
            self.fault_session(session, fault);
        }
        if stop && let Some(arm) = &job.arm {
            self.stop_arm(arm, &text);
        }
        if pause && let Some(session) = &session {
            self.tell(session, Message::StartPause);
        }
        if let Some(to) = state
            && (outranks(to, job.state) || (to == job.state && merely_waits(job)))
        {
            if to == JobState::Aborting {
                self.withdraw(job.id, "the job was aborted");
            }
            self.go(job.id, to, Why::Fault { fault }, text);
        }
        if let Some(ask) = ask {
            self.ask(Ask {
                job: Some(job.id),
                fault,
                ..ask
            });
        }
    }

    /// Both permits 0. The mobile robot is told, because a permit it holds is now void.
    pub(crate) fn fault_session(&mut self, session: &Session, fault: Fault) {
        let exempt = matches!(
            session.state,
            SessionState::Reserved
                | SessionState::Faulted
                | SessionState::Exited
                | SessionState::Canceling
                | SessionState::Released
                | SessionState::Canceled
        );
        if exempt {
            return;
        }
        self.emit(Fact::SessionMoved {
            session: session.id,
            to: SessionState::Faulted,
            fault: Some(fault),
        });
        self.tell(session, Message::MovePermit { granted: false });
    }

    /// A step that may not simply be started again: a human says how to go on.
    pub(crate) fn step_stuck(
        &mut self,
        job: &Job,
        step: usize,
        fault: Fault,
        text: &str,
        op: Option<Uuid>,
    ) {
        if is_over(job) {
            return;
        }
        self.step_to(job, step, StepState::Retriable, text);
        let Some(job) = self.job(job.id) else { return };
        let what = job
            .step(step)
            .map(|s| words::word(&s.plan.phase))
            .unwrap_or_default();
        let ask = Ask {
            op,
            question: format!("{what} did not succeed: {text}. How should the job go on?"),
            known: self.known_of(&job),
            unknown: vec!["why it happened".into()],
            answers: vec![
                Answer::Retreat,
                Answer::Replan,
                Answer::Happened,
                Answer::Abort,
                Answer::Cancel,
            ],
            ..Ask::default()
        };
        let state = Some(JobState::Holding);
        self.react(
            &job,
            Reaction {
                fault,
                text: text.into(),
                state,
                ask: Some(ask),
                ..Reaction::default()
            },
        );
    }

    /// F10: nobody knows where a load is.
    pub(crate) fn part_lost(&mut self, job: &Job, load: &str, text: &str) {
        let arm = job.arm.clone();
        self.react(
            job,
            Reaction {
                fault: Fault::PartLost,
                text: text.into(),
                permits: true,
                stop: true,
                ..Reaction::default()
            },
        );
        self.emit(Fact::CustodyMoved {
            load: load.to_owned(),
            to: crate::Location::Unknown { arm },
            by: crate::Evidence::Doubt { text: text.into() },
        });
        if outranks(JobState::Aborting, job.state) {
            self.withdraw(job.id, "the job was aborted");
            self.go(
                job.id,
                JobState::Aborting,
                Why::Fault {
                    fault: Fault::PartLost,
                },
                text,
            );
        }
        let known = self
            .job(job.id)
            .map(|j| self.known_of(&j))
            .unwrap_or_default();
        self.ask(Ask {
            job: Some(job.id),
            load: Some(load.to_owned()),
            fault: Fault::PartLost,
            question: format!("{text}. Where is load {load}?"),
            known,
            unknown: vec![format!("where load {load} is")],
            answers: vec![Answer::SetCustody],
            ..Ask::default()
        });
    }

    /// What can be said for certain about a job, for a question.
    pub(crate) fn known_of(&self, job: &Job) -> Vec<String> {
        let mut known = Vec::new();
        if let Some(arm) = &job.arm {
            let seen = match self.cell.arm_seen(arm) {
                Some(s) if s.still => "stands still",
                Some(_) => "moves",
                None => "is not heard",
            };
            known.push(format!("arm {arm} {seen}"));
            known.push(match self.cell.book.custody.in_gripper(arm) {
                Some(load) => format!("load {load} is in its gripper"),
                None => format!("no load is booked in the gripper of {arm}"),
            });
        }
        if let Some(session) = self.cell.session_of(job) {
            known.push(format!(
                "{} at {}: the hand-over is {}",
                session.mobile_robot,
                session.point,
                words::word(&session.state)
            ));
        }
        known
    }
}

/// Nothing of the job goes on; what its last operation does is not asked about any more.
pub(crate) const fn is_over(job: &Job) -> bool {
    matches!(
        job.state,
        JobState::Aborting
            | JobState::Aborted
            | JobState::Clearing
            | JobState::Stopped
            | JobState::Complete
            | JobState::Resetting
    )
}

/// On its way to a wait that belongs to its course: a fault gives it another reason.
fn merely_waits(job: &Job) -> bool {
    job.state == JobState::Suspending && matches!(job.why, Why::Awaiting | Why::Course)
}

/// A fault never lifts a job out of a state that is stricter than the one it asks for.
pub(crate) const fn outranks(to: JobState, from: JobState) -> bool {
    rank(to) > rank(from)
}

const fn rank(state: JobState) -> u8 {
    match state {
        JobState::Complete | JobState::Stopped | JobState::Clearing => 9,
        JobState::Aborting | JobState::Aborted => 8,
        JobState::Stopping => 6,
        JobState::Holding | JobState::Held => 4,
        JobState::Suspending => 2,
        // A merely waiting job is SUSPENDED too; a fault makes it SUSPENDING again, with another reason.
        JobState::Suspended
        | JobState::Idle
        | JobState::Starting
        | JobState::Execute
        | JobState::Completing
        | JobState::Unholding
        | JobState::Unsuspending
        | JobState::Resetting => 0,
    }
}
