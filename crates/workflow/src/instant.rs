//! What a human has a mobile robot do at once. What a job has begun, the job ends.

use crate::fact::Fact;
use crate::faults::Fault;
use crate::input::{Principal, Refusal, Reply, Role};
use crate::permits::Permit;
use crate::signal::{InstantAction, Message};
use crate::work::Work;

impl Work<'_> {
    pub(crate) fn instant(
        &mut self,
        mobile_robot: String,
        action: InstantAction,
        principal: &Principal,
        reason: Option<String>,
    ) -> Result<Reply, Refusal> {
        let command = || format!("{action:?} of {mobile_robot}");
        if principal.role < Role::Operator {
            return Err(Refusal::Forbidden {
                command: command(),
                needed: Role::Operator,
            });
        }
        if self.cell.setup.mobile_robot(&mobile_robot).is_none() {
            return Err(Refusal::Unknown {
                what: "mobile robot",
                id: mobile_robot,
            });
        }
        let no = |text: String| {
            Err(Refusal::Conflict {
                command: command(),
                text,
            })
        };
        let session = self.cell.book.open_session_of(&mobile_robot).cloned();
        let transport = self.transport_of(&mobile_robot);
        let job = session
            .as_ref()
            .map(|s| s.job)
            .or(transport.as_ref().map(|t| t.job));
        let message = match action {
            InstantAction::StartPause => Message::StartPause,
            InstantAction::StateRequest => Message::StateRequest,
            InstantAction::StopPause => {
                if let Some(session) = &session {
                    self.may_go_on(session, &command())?;
                }
                Message::StopPause
            }
            InstantAction::Retry | InstantAction::SkipRetry => {
                if let Some(job) = job.filter(|_| session.is_some()) {
                    return no(format!(
                        "it docks for job {job}; answer the question of the job, or stop it"
                    ));
                }
                if action == InstantAction::Retry {
                    Message::Retry
                } else {
                    Message::SkipRetry
                }
            }
            InstantAction::CancelOrder { order } => {
                let told = self.cell.mobile_seen(&mobile_robot);
                let Some(order) = order.or(told.and_then(|s| s.order)) else {
                    return no("it reports no order".into());
                };
                let of_job = session.as_ref().and_then(|s| s.order) == Some(order)
                    || transport.as_ref().map(|t| t.order) == Some(order);
                if let Some(job) = job.filter(|_| of_job) {
                    return no(format!("order {order} is of job {job}; stop the job"));
                }
                Message::CancelOrder { order }
            }
        };
        self.emit(Fact::InstantActed {
            mobile_robot: mobile_robot.clone(),
            action,
            principal: principal.name.clone(),
            reason,
        });
        self.emit(Fact::Told {
            mobile_robot,
            session: session.map(|s| s.id).or(transport.and_then(|t| t.session)),
            message,
        });
        Ok(Reply::Done)
    }

    /// A pause that protects an arm is ended by what ends the danger.
    fn may_go_on(&self, session: &crate::session::Session, command: &str) -> Result<(), Refusal> {
        let unsafe_because = |text: &str| {
            Err(Refusal::Interlock {
                command: command.to_owned(),
                text: text.to_owned(),
            })
        };
        if matches!(session.faulted, Some((_, Fault::Interlock))) {
            return unsafe_because(
                "the interlock was violated; clear the job and answer its question",
            );
        }
        let point = self.cell.setup.point(&session.point);
        let inside = point.is_some_and(|p| self.cell.arm_may_be_in(p));
        if inside && self.cell.permit_of(session) != Permit::MrMove {
            return unsafe_because("an arm may be in the zone of its point");
        }
        Ok(())
    }
}
