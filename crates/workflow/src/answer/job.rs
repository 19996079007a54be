//! What each answer about a job does.

use crate::fact::Fact;
use crate::faults::Fault;
use crate::input::{OpResult, Principal, Refusal, Reply};
use crate::intervention::{Answer, Decided, Detail, Question};
use crate::job::params::OnCancel;
use crate::job::phase::Phase;
use crate::job::undo::Choice;
use crate::job::{Job, JobState, Why};
use crate::signal::Message;
use crate::words;
use crate::work::Work;

impl Work<'_> {
    /// Whatever an answer needs is checked before it is written down; what a human says about custody is said here.
    fn check_answer(
        &mut self,
        job: &Job,
        question: &Question,
        decided: &Decided,
        principal: &Principal,
    ) -> Result<(), Refusal> {
        let answer = decided.answer;
        let no = |text: String| Refusal::Conflict {
            command: format!("answer {}", words::word(&answer)),
            text,
        };
        match (answer, &decided.detail) {
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
                self.set_custody(load, location, confirm, principal, &decided.reason)?;
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
                    problem: format!("{} needs to know which", words::word(&answer)),
                });
            }
            _ => {}
        }
        Ok(())
    }

    #[expect(clippy::too_many_lines, reason = "a table: what each answer does")]
    pub(super) fn answer_job(
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
        self.check_answer(job, question, &decided, principal)?;
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
}
