//! Answers of humans: one decision for each question, by name, with a reason.

use uuid::Uuid;

use crate::claims::Resource;
use crate::commands_in::allowed;
use crate::custody::{Evidence, Location};
use crate::effect::{Action, GripAction};
use crate::fact::{Fact, Rewind};
use crate::faults::Fault;
use crate::input::{OpResult, Principal, Refusal, Reply};
use crate::intervention::{Answer, Decided, Detail, Question};
use crate::job::params::OnCancel;
use crate::job::phase::Phase;
use crate::job::undo::Choice;
use crate::job::{Compensation, Item, Job, JobState, StepState, Why};
use crate::session::SessionState;
use crate::signal::Message;
use crate::supervise::grip_of;
use crate::words;
use crate::work::Work;

impl Work<'_> {
    pub(crate) fn respond(
        &mut self,
        id: Uuid,
        answer: Answer,
        detail: Detail,
        principal: &Principal,
        reason: &str,
    ) -> Result<Reply, Refusal> {
        let name = format!("answer {}", words::small(answer));
        allowed(&name, principal, reason)?;
        let Some(found) = self.cell.book.interventions.get(&id).cloned() else {
            return Err(Refusal::Unknown {
                what: "intervention",
                id: id.to_string(),
            });
        };
        let decided = Decided {
            answer,
            detail,
            principal: principal.name.clone(),
            reason: reason.to_owned(),
        };
        if found.decided.as_ref() == Some(&decided) {
            return Ok(Reply::Unchanged);
        }
        let conflict = |text: String| Refusal::Conflict {
            command: name.clone(),
            text,
        };
        if !found.is_open() {
            return Err(conflict("the question was decided or withdrawn".into()));
        }
        if !found.question.answers.contains(&answer) {
            let allowed = found.question.answers.iter().map(words::small);
            let allowed = allowed.collect::<Vec<_>>().join(", ");
            return Err(conflict(format!("allowed are {allowed}")));
        }
        if principal.role < answer.needs() {
            return Err(Refusal::Forbidden {
                command: name,
                needed: answer.needs(),
            });
        }
        let question = found.question.clone();
        if question.session.is_some() {
            return self.answer_session(&question, decided);
        }
        if let (None, Some(load)) = (question.job, &question.load) {
            return self.answer_load(&question, load, decided, principal, reason);
        }
        let Some(job) = question.job.and_then(|j| self.job(j)) else {
            return Err(conflict("its job is not known any more".into()));
        };
        let reply = self.answer_job(&job, &question, decided, principal)?;
        self.wait_anew(job.id);
        Ok(reply)
    }

    /// The question where a load is that no job has.
    fn answer_load(
        &mut self,
        question: &Question,
        asked: &str,
        decided: Decided,
        principal: &Principal,
        reason: &str,
    ) -> Result<Reply, Refusal> {
        let Detail::Custody {
            load,
            confirm,
            location,
        } = &decided.detail
        else {
            return Err(Refusal::Invalid {
                item: "detail".into(),
                problem: format!("{} needs to know where", words::small(decided.answer)),
            });
        };
        if load != asked {
            return Err(Refusal::Conflict {
                command: format!("answer {}", words::small(decided.answer)),
                text: format!("the question is about load {asked}"),
            });
        }
        self.set_custody(load, location, confirm, principal, reason)?;
        self.answers_instead_of_withdrawing(question);
        self.emit(Fact::Answered {
            intervention: question.id,
            decided,
        });
        Ok(Reply::Done)
    }

    /// The statement itself withdrew the question; here it is an answer.
    fn answers_instead_of_withdrawing(&mut self, question: &Question) {
        self.facts.retain(
            |f| !matches!(f, Fact::Withdrawn { intervention, .. } if *intervention == question.id),
        );
        if let Some(open) = self.cell.book.interventions.get_mut(&question.id) {
            std::sync::Arc::make_mut(open).withdrawn = None;
        }
    }

    /// A job that goes on undoing after an answer begins its waits anew.
    fn wait_anew(&mut self, job: Uuid) {
        let Some(job) = self.job(job).filter(|j| j.state == JobState::Stopping) else {
            return;
        };
        for (step, found) in job.steps.iter().enumerate() {
            if found.state == StepState::Running && found.op.is_none() {
                self.emit(Fact::StepResent { job: job.id, step });
            }
        }
    }

    #[expect(clippy::too_many_lines, reason = "a table: what each answer does")]
    fn answer_job(
        &mut self,
        job: &Job,
        question: &Question,
        decided: Decided,
        principal: &Principal,
    ) -> Result<Reply, Refusal> {
        let (answer, detail, reason) = (
            decided.answer,
            decided.detail.clone(),
            decided.reason.clone(),
        );
        let why = Why::Human {
            principal: principal.name.clone(),
        };
        let no = |text: String| Refusal::Conflict {
            command: format!("answer {}", words::small(answer)),
            text,
        };
        // Whatever an answer needs is checked before it is written down.
        match (answer, &detail) {
            (Answer::Resume | Answer::Replan | Answer::Retreat, _) => {
                let moving_on = question.op.is_none();
                if moving_on && let Err(text) = self.may_resume_by_hand(job, answer) {
                    return Err(no(text));
                }
            }
            (Answer::ChooseMobileRobot, Detail::MobileRobot { mobile_robot }) => {
                let mut open = job.clone();
                open.spec.mobile_robot = Some(mobile_robot.clone());
                if self.cell.choose_mobile_robot(&open, None).is_none() {
                    return Err(no(format!(
                        "{mobile_robot} is not free, or has not the slots"
                    )));
                }
            }
            (Answer::ChooseSlot, Detail::Place { place }) => {
                let arm = job.arm.clone().unwrap_or_default();
                if !self.place_usable(&arm, place) {
                    return Err(no(format!("{place} is not free, not taught or not known")));
                }
            }
            (
                Answer::SetCustody,
                Detail::Custody {
                    load,
                    confirm,
                    location,
                },
            ) => {
                if question.load.as_ref() != Some(load) {
                    return Err(no(format!(
                        "the question is about load {:?}",
                        question.load
                    )));
                }
                self.set_custody(load, location, confirm, principal, &reason)?;
                self.answers_instead_of_withdrawing(question);
            }
            (Answer::SwapMobileRobot, Detail::MobileRobot { mobile_robot }) => {
                self.check_swap(job, mobile_robot)?;
            }
            (
                Answer::ChooseMobileRobot
                | Answer::ChooseSlot
                | Answer::SetCustody
                | Answer::SwapMobileRobot,
                _,
            ) => {
                return Err(Refusal::Invalid {
                    item: "detail".into(),
                    problem: format!("{} needs to know which", words::small(answer)),
                });
            }
            _ => {}
        }
        self.emit(Fact::Answered {
            intervention: question.id,
            decided,
        });
        let goes_on = matches!(
            answer,
            Answer::Resume | Answer::Replan | Answer::Retreat | Answer::Cancel
        );
        if goes_on && job.waits_for_hand() {
            self.decided_by_hand(job);
        }
        let Some(job) = self.job(job.id) else {
            return Ok(Reply::Done);
        };
        let job = &*job;
        match answer {
            Answer::Cancel | Answer::SendBack if job.state == JobState::Stopping => {
                self.undo_with(job, Choice::LeaveOnMobileRobot);
            }
            Answer::Cancel | Answer::SendBack => self.cancel(job, why, &reason),
            Answer::Abort => {
                let text = reason.as_str();
                let _reply = self.command(job.id, crate::Command::Abort, principal, text)?;
            }
            Answer::Resume | Answer::Replan => {
                self.accept_definition(job);
                self.go_on_by_hand(job, question, &why, &reason);
            }
            Answer::Retreat => {
                self.put_steps_back(job);
                if let Some(job) = self.job(job.id) {
                    self.leave_first(&job);
                    self.resume_or_undo(&job, &why, &reason);
                }
            }
            Answer::Happened => self.happened(job, question),
            Answer::DidNotHappen => {
                if let Some(op) = question.op {
                    let text = format!("{}: {reason}", principal.name);
                    self.emit(Fact::OpEnded {
                        op,
                        result: OpResult::NotExecuted { text },
                    });
                }
            }
            Answer::Retry => self.retry(job, question, &why, &reason),
            Answer::Redispatch if question.fault == Fault::DockFailed && self.back_out(job) => {
                self.again(job, Phase::Dock);
                self.resume_job(job, why, &reason);
            }
            Answer::Redispatch => {
                if !self.redispatch(job) {
                    // It waits once more for the one that was ordered.
                    self.again(job, Phase::Await);
                }
                self.resume_job(job, why, &reason);
            }
            Answer::ChooseMobileRobot => {
                if let Detail::MobileRobot { mobile_robot } = &detail {
                    self.hand_on(job, mobile_robot);
                }
                self.resume_job(job, why, &reason);
            }
            Answer::AcceptMeasured => {
                if let Some(session) = self.cell.session_of(job).cloned() {
                    self.emit(Fact::MeasuredAccepted {
                        session: session.id,
                    });
                    self.tell(&session, Message::Retry);
                }
                self.again(job, Phase::Dock);
                self.resume_job(job, why, &reason);
            }
            Answer::Rescan => {
                for phase in [Phase::VerifyLoad, Phase::VerifyEmpty, Phase::VerifyOnMr] {
                    self.again(job, phase);
                }
                self.resume_job(job, why, &reason);
            }
            Answer::Accept => {
                self.emit(Fact::LoadsAccepted { job: job.id });
                for phase in [Phase::VerifyLoad, Phase::VerifyEmpty, Phase::VerifyOnMr] {
                    self.again(job, phase);
                }
                self.resume_job(job, why, &reason);
            }
            Answer::ChooseSlot => {
                if let Detail::Place { place } = detail {
                    self.go_elsewhere(job, place);
                }
                self.resume_job(job, why, &reason);
            }
            Answer::RejectBin if job.state == JobState::Stopping => {
                self.undo_with(job, Choice::Held(OnCancel::RejectBin));
            }
            Answer::RejectBin => {
                if let Some(place) = job.spec.reject_slot.clone() {
                    self.go_elsewhere(job, place);
                }
                self.resume_job(job, why, &reason);
            }
            Answer::PutBack => {
                self.go(job.id, JobState::Stopping, why, reason.clone());
                self.drop_running(job);
                if let Some(job) = self.job(job.id) {
                    self.undo_with(&job, Choice::Held(OnCancel::ReturnToMr));
                }
            }
            Answer::Complete => self.undo_with(job, Choice::Held(OnCancel::Complete)),
            Answer::Repick => {
                if job.state != JobState::Stopping {
                    self.go(job.id, JobState::Stopping, why, reason.clone());
                }
                if let Some(job) = self.job(job.id) {
                    self.undo_with(&job, Choice::Repick);
                }
            }
            Answer::Wait => self.resume_job(job, why, &reason),
            Answer::SetCustody => {
                if job.state == JobState::Stopping {
                    self.undo_again(job);
                }
            }
            Answer::MarkDelivered => {
                if let Some(mobile_robot) = &job.mobile_robot {
                    self.delivered(mobile_robot);
                }
            }
            Answer::SwapMobileRobot => {
                if let Detail::MobileRobot { mobile_robot } = &detail {
                    self.swap(job, mobile_robot, principal, &reason);
                }
                self.resume_job(job, why, &reason);
            }
            Answer::ConfirmStill => self.confirmed_still(job),
            Answer::Hold | Answer::OperatorMoved | Answer::CancelOrder => {}
        }
        Ok(Reply::Done)
    }

    fn may_resume_by_hand(&self, job: &Job, answer: Answer) -> Result<(), String> {
        let Some(arm) = &job.arm else { return Ok(()) };
        if answer == Answer::Retreat || job.state == JobState::Stopping {
            return if self.cell.arm_ready(arm) && self.cell.arm_still(arm) {
                Ok(())
            } else {
                Err(format!("arm {arm} is not ready"))
            };
        }
        self.may_resume(job)
    }

    /// Happened: the step's operation counts as done, and custody with it.
    fn happened(&mut self, job: &Job, question: &Question) {
        let Some(op) = question.op else {
            // A rejected operation that a human carried out: its step is over, the rest follows from where the arm is.
            let stuck = job
                .steps
                .iter()
                .position(|s| s.state == StepState::Retriable);
            if let Some(step) = stuck {
                self.step_to(
                    job,
                    step,
                    StepState::Succeeded,
                    "a human says that it happened",
                );
            }
            return;
        };
        let Some(found) = self.cell.book.ops.get(&op).cloned() else {
            return;
        };
        let result = match &found.action {
            Action::Grip { action } => {
                let close = *action == GripAction::Close;
                OpResult::Gripped {
                    closed: close,
                    open: !close,
                    part_present: close,
                }
            }
            Action::Move { .. } => OpResult::Arrived,
            Action::Precheck { .. } => OpResult::Prechecked {
                failures: Vec::new(),
            },
        };
        let _reply = self.op_ended_by_hand(op, result);
    }

    fn op_ended_by_hand(&mut self, op: Uuid, result: OpResult) -> Result<Reply, Refusal> {
        debug_assert!(!matches!(result, OpResult::InDoubt { .. }));
        self.op_ended(op, result)
    }

    /// Replan, resume: the operation in doubt is given up, and the step goes on from where the arm is.
    fn go_on_by_hand(&mut self, job: &Job, question: &Question, why: &Why, reason: &str) {
        if let Some(op) = question.op
            && self
                .cell
                .book
                .ops
                .get(&op)
                .is_some_and(|o| grip_of(&o.action).is_none())
        {
            let text = format!("planned again: {reason}");
            self.emit(Fact::OpEnded {
                op,
                result: OpResult::Interrupted { text },
            });
        }
        let Some(job) = self.job(job.id) else { return };
        self.put_steps_back(&job);
        if job.is_displaced() {
            self.leave_first(&job);
        }
        let Some(job) = self.job(job.id) else { return };
        self.resume_or_undo(&job, why, reason);
    }

    fn put_steps_back(&mut self, job: &Job) {
        for (step, found) in job.steps.iter().enumerate() {
            if found.state == StepState::Retriable {
                self.emit(Fact::StepMoved {
                    job: job.id,
                    step,
                    to: StepState::Running,
                    attempt: found.attempt,
                    text: "planned again".into(),
                });
            }
        }
    }

    fn resume_or_undo(&mut self, job: &Job, why: &Why, reason: &str) {
        if job.state != JobState::Stopping {
            self.resume_job(job, why.clone(), reason);
        }
    }

    /// HELD goes through UNHOLDING, SUSPENDED through UNSUSPENDING; both read the positions first.
    fn resume_job(&mut self, job: &Job, why: Why, reason: &str) {
        if matches!(job.state, JobState::Held | JobState::Holding) {
            self.go(job.id, JobState::Unholding, why, reason);
        } else if matches!(job.state, JobState::Suspended | JobState::Suspending) {
            self.go(job.id, JobState::Unsuspending, why, reason);
        }
    }

    /// A step that waits begins its wait anew.
    fn again(&mut self, job: &Job, phase: Phase) {
        if let Some(step) = job.find(phase)
            && matches!(
                job.step(step).map(|s| s.state),
                Some(StepState::Running | StepState::Retriable)
            )
        {
            let to = StepState::Pending;
            let text = "a human lets it be tried again".to_owned();
            self.emit(Fact::StepMoved {
                job: job.id,
                step,
                to,
                attempt: 0,
                text,
            });
        }
    }

    fn retry(&mut self, job: &Job, question: &Question, why: &Why, reason: &str) {
        if question.fault == Fault::TransportFailed
            && let Some(mobile_robot) = job.mobile_robot.clone()
            && let Some(transport) = self.transport_of(&mobile_robot)
        {
            self.resend_transport(&mobile_robot, &transport);
            self.again(job, Phase::Transport);
        }
        if question.fault == Fault::NotAcknowledged {
            if let Some(session) = self.cell.session_of(job).cloned() {
                self.send_order(&session);
            }
            self.again(job, Phase::Call);
        }
        if question.fault == Fault::DockFailed {
            if let Some(session) = self.cell.session_of(job).cloned() {
                self.emit(Fact::SessionRewound {
                    session: session.id,
                    to: Rewind::Dock,
                });
                self.tell(&session, Message::Retry);
            }
            self.again(job, Phase::Dock);
        }
        self.resume_job(job, why.clone(), reason);
    }

    /// F18: another place for the load in the gripper.
    fn go_elsewhere(&mut self, job: &Job, place: String) {
        let waiting = job
            .steps
            .iter()
            .position(|s| s.plan.phase == Phase::PlaceApproach && s.state == StepState::Running);
        if let Some((index, item)) = waiting.and_then(|s| job.item_of(s)) {
            self.redirect(
                job,
                index,
                Item {
                    place,
                    ..item.clone()
                },
            );
        }
    }

    fn undo_with(&mut self, job: &Job, choice: Choice) {
        self.plan_undo(job, Some(choice));
    }

    /// Nothing of the old plan goes on.
    fn drop_running(&mut self, job: &Job) {
        if job.compensation != Compensation::None {
            self.emit(Fact::CompensationMoved {
                job: job.id,
                to: Compensation::None,
            });
        }
    }

    fn check_swap(&self, job: &Job, to: &str) -> Result<(), Refusal> {
        let no = |text: String| {
            Err(Refusal::Conflict {
                command: "answer SwapMobileRobot".into(),
                text,
            })
        };
        let Some(setup) = self.cell.setup.mobile_robot(to) else {
            return Err(Refusal::Unknown {
                what: "mobile robot",
                id: to.to_owned(),
            });
        };
        if !self
            .cell
            .book
            .claims
            .is_free(&Resource::MobileRobot(to.to_owned()))
        {
            return no(format!("{to} has something else to do"));
        }
        for item in &job.items {
            let at = Location::MobileRobot {
                mobile_robot: to.to_owned(),
                slot: item.slot.clone(),
            };
            // Somebody may have said already that the load itself is there.
            let there = self.cell.book.custody.at(&at);
            let its_own = there.is_some() && there == item.load.as_deref();
            if !setup.slots.contains(&item.slot) || !(its_own || self.cell.is_free(&at)) {
                return no(format!("{} of {to} is not free", item.slot));
            }
        }
        Ok(())
    }

    /// F20: the loads are on another mobile robot now, which drives on.
    fn swap(&mut self, job: &Job, to: &str, principal: &Principal, reason: &str) {
        let Some(from) = job.mobile_robot.clone() else {
            return;
        };
        let transport = self.transport_of(&from);
        for item in &job.items {
            let there = Location::MobileRobot {
                mobile_robot: from.clone(),
                slot: item.slot.clone(),
            };
            let now = Location::MobileRobot {
                mobile_robot: to.to_owned(),
                slot: item.slot.clone(),
            };
            // The first one has reported meanwhile that it is gone: this is the answer to where.
            let gone = item.load.clone().filter(|load| {
                let at = self.cell.book.custody.of(load);
                matches!(at, Some(Location::Unknown { arm: None }))
            });
            if let Some(load) = gone {
                let said = self.set_custody(&load, &now, &load, principal, reason);
                debug_assert!(said.is_ok(), "{said:?}");
            } else if let Some(load) = self.cell.book.custody.at(&there).map(str::to_owned) {
                self.emit(Fact::CustodyMoved {
                    load,
                    to: now,
                    by: Evidence::Human {
                        principal: principal.name.clone(),
                        reason: reason.to_owned(),
                    },
                });
            }
        }
        self.emit(Fact::TransportEnded { mobile_robot: from });
        self.emit(Fact::JobAssigned {
            job: job.id,
            arm: job.arm.clone().unwrap_or_default(),
            mobile_robot: to.to_owned(),
        });
        if let Some(transport) = transport {
            let order = self.ids.next_id();
            let destination = transport.destination.clone();
            let mobile_robot = to.to_owned();
            self.emit(Fact::TransportBegun {
                mobile_robot,
                job: job.id,
                order,
                destination,
                session: None,
                update: 1,
            });
            let transport = crate::book::Transport {
                order,
                session: None,
                update: 1,
                ..transport
            };
            self.resend_transport(to, &transport);
        }
        self.again(job, Phase::Transport);
    }

    /// A human looked: the arm stands. The acting state ends.
    fn confirmed_still(&mut self, job: &Job) {
        if job.state == JobState::Holding {
            self.go(job.id, JobState::Held, job.why.clone(), job.text.clone());
        } else if job.state == JobState::Suspending {
            self.go(
                job.id,
                JobState::Suspended,
                job.why.clone(),
                job.text.clone(),
            );
        } else if job.state == JobState::Aborting {
            self.aborted(job);
        }
    }

    fn answer_session(&mut self, question: &Question, decided: Decided) -> Result<Reply, Refusal> {
        let answer = decided.answer;
        let Some(session) = question.session.and_then(|s| self.session(s)) else {
            return Err(Refusal::Conflict {
                command: format!("answer {}", words::small(answer)),
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
