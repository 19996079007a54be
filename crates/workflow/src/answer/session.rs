//! Questions about a hand-over whose job is over: where the mobile robot is, and whether it leaves.

use crate::fact::Fact;
use crate::input::{Refusal, Reply};
use crate::intervention::{Answer, Decided, Question};
use crate::session::SessionState;
use crate::signal::Message;
use crate::words;
use crate::work::Work;

impl Work<'_> {
    pub(super) fn answer_session(
        &mut self,
        question: &Question,
        decided: Decided,
    ) -> Result<Reply, Refusal> {
        let answer = decided.answer;
        let Some(session) = question.session.and_then(|s| self.session(s)) else {
            return Err(Refusal::Conflict {
                command: format!("answer {}", words::word(&answer)),
                text: "its session is not known any more".into(),
            });
        };
        self.emit(Fact::Answered {
            intervention: question.id,
            decided,
        });
        if answer == Answer::OperatorMoved {
            self.close(&session, SessionState::Exited);
        } else if answer == Answer::CancelOrder {
            if let Some(order) = session.order {
                self.tell(&session, Message::CancelOrder { order });
            }
            if session.state.may_become(SessionState::Canceling) {
                self.move_session(&session, SessionState::Canceling);
            }
        } else {
            self.tell(&session, Message::StopPause);
            match (session.state, session.faulted) {
                (SessionState::Faulted, Some((from, _))) if from.is_docked() => {
                    self.move_session(&session, SessionState::TransferDone);
                    let reason = "its job is over".to_owned();
                    self.tell(&session, Message::TransferFailed { reason });
                }
                (SessionState::Faulted, Some((SessionState::ExitGranted, _))) => {
                    self.move_session(&session, SessionState::TransferDone);
                }
                (SessionState::Faulted, _) => self.cancel_order(&session),
                (SessionState::ExitGranted, _) => {
                    self.emit(Fact::SessionResent {
                        session: session.id,
                    });
                    self.tell_exit(&session);
                }
                _ => self.emit(Fact::SessionResent {
                    session: session.id,
                }),
            }
        }
        Ok(Reply::Done)
    }
}
