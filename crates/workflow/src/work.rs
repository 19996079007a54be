//! One decision in the making: a copy of the cell, on which each fact is folded as soon as it is found.

use std::sync::Arc;

use uuid::Uuid;

use crate::cell::Cell;
use crate::fact::Fact;
use crate::faults::Fault;
use crate::ids::{IdSource, Millis};
use crate::input::{Decision, Input, Refusal, Reply};
use crate::intervention::{Answer, Question};
use crate::job::phase::Phase;
use crate::job::{Job, JobState, StepState, Why};
use crate::session::{Session, SessionState};
use crate::signal::Message;

/// A bound on the facts of one decision; far above anything a sane state needs.
const MOST_FACTS: usize = 4_000;

pub(crate) struct Work<'a> {
    pub cell: Cell,
    pub now: Millis,
    pub ids: &'a mut dyn IdSource,
    pub facts: Vec<Fact>,
}

impl<'a> Work<'a> {
    pub(crate) fn new(cell: Cell, now: Millis, ids: &'a mut dyn IdSource) -> Self {
        Self {
            cell,
            now,
            ids,
            facts: Vec::new(),
        }
    }

    pub(crate) fn decide(mut self, input: Input) -> Result<Decision, Refusal> {
        if !self.cell.live.recovered && input != Input::Recover {
            return Err(Refusal::NotRecovered);
        }
        let idle = self.cell.live.unwritable;
        if !idle {
            self.expire();
        }
        let reply = self.take(input)?;
        if self.cell.live.unwritable {
            self.only_seen()?;
        } else {
            self.settle();
        }
        Ok(Decision {
            facts: self.facts,
            reply,
        })
    }

    /// While the journal cannot be written, nothing that would have to be kept may come of an input.
    fn only_seen(&mut self) -> Result<(), Refusal> {
        if self.facts.iter().any(Fact::is_durable) {
            return Err(Refusal::JournalUnavailable);
        }
        Ok(())
    }

    pub(crate) fn emit(&mut self, fact: Fact) {
        drop(self.cell.fold(Some(self.now), &fact));
        self.facts.push(fact);
    }

    /// Applies the rules until none finds anything to do.
    pub(crate) fn settle(&mut self) {
        while self.facts.len() < MOST_FACTS {
            let before = self.facts.len();
            self.supervise();
            if self.facts.len() == before {
                self.run_sessions();
            }
            if self.facts.len() == before {
                self.run_jobs();
            }
            if self.facts.len() == before {
                self.run_queue();
            }
            if self.facts.len() == before {
                return;
            }
        }
        debug_assert!(
            false,
            "a decision does not come to rest: {:#?}",
            self.facts.iter().rev().take(24).collect::<Vec<_>>()
        );
    }

    pub(crate) fn job(&self, id: Uuid) -> Option<Arc<Job>> {
        self.cell.book.jobs.get(&id).cloned()
    }

    pub(crate) fn session(&self, id: Uuid) -> Option<Arc<Session>> {
        self.cell.book.sessions.get(&id).cloned()
    }

    pub(crate) fn jobs(&self) -> Vec<Uuid> {
        let live = |j: &&Arc<Job>| !j.state.is_final() && j.state != JobState::Idle;
        let mut all: Vec<_> = self
            .cell
            .book
            .jobs
            .values()
            .filter(live)
            .map(|j| (j.number, j.id))
            .collect();
        all.sort_unstable();
        all.into_iter().map(|(_, id)| id).collect()
    }

    pub(crate) fn open_sessions(&self) -> Vec<Arc<Session>> {
        self.cell
            .book
            .sessions
            .values()
            .filter(|s| !s.state.is_closed())
            .cloned()
            .collect()
    }

    pub(crate) fn tell(&mut self, session: &Session, message: Message) {
        self.emit(Fact::Told {
            mobile_robot: session.mobile_robot.clone(),
            session: Some(session.id),
            message,
        });
    }

    pub(crate) fn go(&mut self, job: Uuid, to: JobState, why: Why, text: impl Into<String>) {
        self.emit(Fact::JobMoved {
            job,
            to,
            why,
            text: text.into(),
        });
    }

    pub(crate) fn note(&mut self, job: Uuid, fault: Fault, text: impl Into<String>) {
        self.emit(Fact::FaultNoted {
            job,
            fault,
            text: text.into(),
        });
    }

    pub(crate) fn step_to(&mut self, job: &Job, step: usize, to: StepState, text: &str) {
        let Some(found) = job.steps.get(step) else {
            return;
        };
        let attempt = match (found.state, to) {
            (StepState::Pending | StepState::Retriable, StepState::Running) => {
                found.attempt.saturating_add(1)
            }
            _ => found.attempt,
        };
        self.emit(Fact::StepMoved {
            job: job.id,
            step,
            to,
            attempt,
            text: text.to_owned(),
        });
    }

    /// The step of a phase waits anew from its beginning, if its state is one of `these`.
    pub(crate) fn begin_anew(
        &mut self,
        job: &Job,
        phase: Phase,
        text: &str,
        these: impl Fn(StepState) -> bool,
    ) {
        let Some(step) = job.find(phase) else { return };
        if job.step(step).is_some_and(|s| these(s.state)) {
            self.emit(Fact::StepMoved {
                job: job.id,
                step,
                to: StepState::Pending,
                attempt: 0,
                text: text.to_owned(),
            });
        }
    }

    pub(crate) fn move_session(&mut self, session: &Session, to: SessionState) {
        debug_assert!(
            session.state.may_become(to),
            "{:?} -> {to:?}",
            session.state
        );
        self.emit(Fact::SessionMoved {
            session: session.id,
            to,
            fault: None,
        });
    }

    /// Asks a human. One open question for each job, and one for each session: a newer truth replaces it.
    pub(crate) fn ask(&mut self, ask: Ask) {
        let open = match (ask.session, ask.job) {
            (Some(session), _) => self.cell.book.question_of_session(session),
            (None, Some(job)) => self.cell.book.question_of(job),
            (None, None) => None,
        };
        if let Some(open) = open {
            if open.question.fault == ask.fault && open.question.op == ask.op {
                return;
            }
            let intervention = open.question.id;
            let text = format!("replaced: {}", ask.question);
            self.emit(Fact::Withdrawn { intervention, text });
        }
        let id = self.ids.next_id();
        let question = Box::new(Question {
            id,
            job: ask.job,
            session: ask.session,
            op: ask.op,
            load: ask.load,
            fault: ask.fault,
            question: ask.question,
            known: ask.known,
            unknown: ask.unknown,
            answers: ask.answers,
        });
        self.emit(Fact::Asked { question });
    }

    pub(crate) fn withdraw(&mut self, job: Uuid, text: &str) {
        if let Some(open) = self.cell.book.question_of(job) {
            let intervention = open.question.id;
            self.emit(Fact::Withdrawn {
                intervention,
                text: text.to_owned(),
            });
        }
    }

    pub(crate) fn stop_arm(&mut self, arm: &str, text: &str) {
        self.emit(Fact::ArmStopped {
            arm: arm.to_owned(),
            text: text.to_owned(),
        });
    }

    pub(crate) fn take(&mut self, input: Input) -> Result<Reply, Refusal> {
        self.take_input(input)
    }
}

/// A question before it has an id.
#[derive(Default)]
pub(crate) struct Ask {
    pub job: Option<Uuid>,
    pub session: Option<Uuid>,
    pub op: Option<Uuid>,
    pub load: Option<String>,
    pub fault: Fault,
    pub question: String,
    pub known: Vec<String>,
    pub unknown: Vec<String>,
    pub answers: Vec<Answer>,
}
