//! F3: a mobile robot that cannot dock.

use crate::fact::{Fact, Rewind};
use crate::faults::Fault;
use crate::intervention::Answer;
use crate::job::phase::Phase;
use crate::job::{Job, JobState};
use crate::react::Reaction;
use crate::session::{Session, SessionState};
use crate::signal::Message;
use crate::words;
use crate::work::{Ask, Work};

impl Work<'_> {
    /// F3.
    pub(crate) fn dock_failed(&mut self, session: &Session, text: &str) {
        let Some(job) = self.job(session.job) else {
            return;
        };
        let tries = session.dock_tries;
        self.emit(Fact::SessionRewound {
            session: session.id,
            to: Rewind::Dock,
        });
        let retries = self.cell.setup.timers.dock_retries;
        let Some(step) = job.find(Phase::Dock) else {
            return;
        };
        let used = job
            .step(step)
            .map_or(0, |s| s.resends)
            .max(tries.saturating_sub(1));
        if used < retries {
            self.note(job.id, Fault::DockFailed, text);
            self.emit(Fact::StepResent { job: job.id, step });
            self.tell(session, Message::Retry);
            return;
        }
        // It stands before the dock and waits (VDA 5050: RETRIABLE): the answer says whether it tries again or gives up.
        let measured = session.docked;
        let mut answers = vec![Answer::Retry, Answer::Redispatch, Answer::Cancel];
        if measured.is_some() {
            answers.push(Answer::AcceptMeasured);
        }
        let mut known = self.known_of(&job);
        known.extend(measured.map(|at| format!("it docked at {}", words::pose(&at))));
        let ask = Ask {
            question: format!(
                "{} cannot dock at {}: {text}",
                session.mobile_robot, session.point
            ),
            known,
            unknown: vec!["why it cannot".into()],
            answers,
            ..Ask::default()
        };
        self.react(
            &job,
            Reaction {
                fault: Fault::DockFailed,
                text: text.into(),
                state: Some(JobState::Suspending),
                ask: Some(ask),
                ..Reaction::default()
            },
        );
    }

    /// F3, given up: it drives out, and comes again with a new order when it is clear. False if it is not at the dock.
    pub(crate) fn back_out(&mut self, job: &Job) -> bool {
        let Some(session) = self.cell.session_of(job).cloned() else {
            return false;
        };
        if session.state != SessionState::Positioned {
            return false;
        }
        self.emit(Fact::SessionBacksOut {
            session: session.id,
        });
        self.tell(&session, Message::SkipRetry);
        true
    }
}
