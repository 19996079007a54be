//! The course of a session: each rule looks at what was said and seen, and takes the next transition.

use std::sync::Arc;

use crate::claims::Holder;
use crate::fact::Fact;
use crate::faults::Fault;
use crate::intervention::Answer;
use crate::job::JobState;
use crate::session::{Session, SessionState};
use crate::signal::Message;
use crate::words;
use crate::work::{Ask, Work};

impl Work<'_> {
    pub(crate) fn run_sessions(&mut self) {
        let before = self.facts.len();
        for session in self.open_sessions() {
            self.run_session(&session);
            if self.facts.len() > before {
                return;
            }
        }
    }

    fn run_session(&mut self, session: &Arc<Session>) {
        let Some(point) = self.cell.setup.point(&session.point).cloned() else {
            return;
        };
        let job = self.job(session.job);
        let runs = job
            .as_ref()
            .is_some_and(|j| j.runs() && j.state != JobState::Stopping);
        let seen = self.cell.mobile_seen(&session.mobile_robot).cloned();
        match session.state {
            SessionState::Reserved if session.assigned && runs => {
                self.move_session(session, SessionState::AccessPending);
            }
            SessionState::AccessPending
                if runs
                    && self.cell.arm_clear(&point)
                    && seen.as_ref().is_some_and(|s| s.mode.is_automatic()) =>
            {
                self.move_session(session, SessionState::AccessGranted);
                self.tell(session, Message::MovePermit { granted: true });
            }
            SessionState::AccessGranted if session.arrived && runs => {
                self.move_session(session, SessionState::Positioned);
            }
            SessionState::Positioned if session.backs_out => {
                if let Some(job) = job.filter(|_| session.cleared && runs) {
                    let _called = self.redispatch(&job);
                }
            }
            SessionState::Positioned if session.docked.is_some() && runs => {
                let evidence = self.cell.dock_evidence(session);
                match evidence.and_then(|()| self.cell.way_evidence(session)) {
                    Ok(()) => {
                        self.move_session(session, SessionState::Docked);
                        self.tell(session, Message::MovePermit { granted: false });
                    }
                    Err(text) => self.dock_failed(session, &text),
                }
            }
            SessionState::TransferDone if self.cell.arm_clear(&point) && self.may_exit(session) => {
                self.move_session(session, SessionState::ExitGranted);
                self.tell_exit(session);
            }
            SessionState::ExitGranted if session.cleared => {
                self.close(session, SessionState::Exited);
            }
            SessionState::ExitGranted
                if !session.left && seen.as_ref().is_some_and(|s| s.driving) =>
            {
                self.emit(Fact::SessionLeft {
                    session: session.id,
                });
            }
            SessionState::Canceling => {
                let inside = seen.as_ref().is_some_and(|s| {
                    s.at_point.as_deref() == Some(&session.point)
                        && !s.driving
                        && s.mode.is_automatic()
                });
                // Away for certain: it said so, or it reports to be elsewhere without this order.
                let away = seen.is_some_and(|s| {
                    s.order != session.order
                        && s.at_point.as_deref() != Some(&session.point)
                        && session.echoes
                        && !s.driving
                });
                if session.cleared || away || !session.assigned && session.resends > 0 {
                    self.close(session, SessionState::Canceled);
                } else if inside && self.cell.arm_clear(&point) {
                    // It gave its order up in the zone, and may not stay there: it needs the permit to drive out.
                    self.move_session(session, SessionState::ExitGranted);
                    self.tell_exit(session);
                }
            }
            SessionState::Exited => self.close(session, SessionState::Released),
            SessionState::Faulted if session.cleared => self.close(session, SessionState::Exited),
            SessionState::Reserved
            | SessionState::AccessPending
            | SessionState::AccessGranted
            | SessionState::Positioned
            | SessionState::Docked
            | SessionState::TransferReady
            | SessionState::Transferring
            | SessionState::TransferDone
            | SessionState::ExitGranted
            | SessionState::Faulted
            | SessionState::Released
            | SessionState::Canceled => {}
        }
    }

    /// It may go, and it may move: a mobile robot that was told to stand waits for both.
    pub(crate) fn tell_exit(&mut self, session: &Session) {
        self.tell(session, Message::MovePermit { granted: true });
        self.tell(session, Message::ExitGranted);
    }

    /// An aborted job keeps its mobile robot where it is until a human has decided.
    fn may_exit(&self, session: &Session) -> bool {
        self.cell
            .book
            .jobs
            .get(&session.job)
            .is_none_or(|j| !matches!(j.state, JobState::Aborting | JobState::Aborted))
    }

    /// Ends a session, or its presence at the point; what it held is free when it is closed.
    pub(crate) fn close(&mut self, session: &Session, to: SessionState) {
        self.move_session(session, to);
        if to.is_closed() {
            self.emit(Fact::Released {
                by: Holder::Session(session.id),
                resources: None,
            });
        }
        if let Some(open) = self.cell.book.question_of_session(session.id) {
            let intervention = open.question.id;
            self.emit(Fact::Withdrawn {
                intervention,
                text: "the point is clear".into(),
            });
        }
    }

    /// Takes the order back before the mobile robot docked.
    pub(crate) fn cancel_order(&mut self, session: &Session) {
        let Some(order) = session.order else {
            self.close(session, SessionState::Canceled);
            return;
        };
        self.move_session(session, SessionState::Canceling);
        self.tell(session, Message::MovePermit { granted: false });
        self.tell(session, Message::CancelOrder { order });
    }

    /// A faulted session goes on from its last safe state.
    pub(crate) fn continue_session(&mut self, session: &Session) {
        let Some((from, _)) = session.faulted else {
            return;
        };
        self.move_session(session, from.last_safe());
    }

    /// F19: it does not go. The point stays occupied.
    pub(crate) fn does_not_leave(&mut self, session: &Session, text: &str) {
        self.note(session.job, Fault::DoesNotLeave, text);
        self.ask(Ask {
            session: Some(session.id),
            job: Some(session.job),
            fault: Fault::DoesNotLeave,
            question: format!(
                "{} does not leave {}: {text}",
                session.mobile_robot, session.point
            ),
            known: vec![
                format!("the hand-over is {}", words::word(&session.state)),
                "the arm has no permit to enter".into(),
            ],
            unknown: vec![format!("whether {} can move", session.mobile_robot)],
            answers: vec![Answer::Retry, Answer::OperatorMoved, Answer::CancelOrder],
            ..Ask::default()
        });
    }

    /// The timer of a session on its way out.
    pub(crate) fn session_late(&mut self, session: &Session) {
        let again = session.resends < self.cell.setup.timers.resends;
        match session.state {
            SessionState::ExitGranted if again && !session.left => {
                self.emit(Fact::SessionResent {
                    session: session.id,
                });
                self.tell_exit(session);
            }
            SessionState::Canceling if again => {
                self.emit(Fact::SessionResent {
                    session: session.id,
                });
                if let Some(order) = session.order {
                    self.tell(session, Message::CancelOrder { order });
                }
            }
            SessionState::TransferDone => {
                self.does_not_leave(session, "the zone is not clear of arms");
            }
            SessionState::Reserved
            | SessionState::AccessPending
            | SessionState::AccessGranted
            | SessionState::Positioned
            | SessionState::Docked
            | SessionState::TransferReady
            | SessionState::Transferring
            | SessionState::ExitGranted
            | SessionState::Exited
            | SessionState::Released
            | SessionState::Faulted
            | SessionState::Canceling
            | SessionState::Canceled => {
                self.does_not_leave(session, "it was told, and is still there");
            }
        }
    }
}
