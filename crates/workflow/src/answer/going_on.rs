//! How a job goes on after an answer: resumed, tried again, elsewhere, or with what a human saw.

use uuid::Uuid;

use crate::effect::{Action, GripAction};
use crate::fact::{Fact, Rewind};
use crate::faults::Fault;
use crate::input::{OpResult, Refusal, Reply};
use crate::intervention::{Answer, Question};
use crate::job::phase::Phase;
use crate::job::undo::Choice;
use crate::job::{Compensation, Item, Job, JobState, StepState, Why};
use crate::signal::Message;
use crate::supervise::grip_of;
use crate::work::Work;

impl Work<'_> {
    pub(super) fn may_resume_by_hand(&self, job: &Job, answer: Answer) -> Result<(), String> {
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
    pub(super) fn happened(&mut self, job: &Job, question: &Question) {
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

    pub(super) fn op_ended_by_hand(
        &mut self,
        op: Uuid,
        result: OpResult,
    ) -> Result<Reply, Refusal> {
        debug_assert!(!matches!(result, OpResult::InDoubt { .. }));
        self.op_ended(op, result)
    }

    /// Replan, resume: the operation in doubt is given up, and the step goes on from where the arm is.
    pub(super) fn go_on_by_hand(
        &mut self,
        job: &Job,
        question: &Question,
        why: &Why,
        reason: &str,
    ) {
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

    pub(super) fn put_steps_back(&mut self, job: &Job) {
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

    pub(super) fn resume_or_undo(&mut self, job: &Job, why: &Why, reason: &str) {
        if job.state != JobState::Stopping {
            self.resume_job(job, why.clone(), reason);
        }
    }

    /// HELD goes through UNHOLDING, SUSPENDED through UNSUSPENDING; both read the positions first.
    pub(super) fn resume_job(&mut self, job: &Job, why: Why, reason: &str) {
        if matches!(job.state, JobState::Held | JobState::Holding) {
            self.go(job.id, JobState::Unholding, why, reason);
        } else if matches!(job.state, JobState::Suspended | JobState::Suspending) {
            self.go(job.id, JobState::Unsuspending, why, reason);
        }
    }

    /// A step that waits begins its wait anew.
    pub(super) fn again(&mut self, job: &Job, phase: Phase) {
        let waits = |state| matches!(state, StepState::Running | StepState::Retriable);
        self.begin_anew(job, phase, "a human lets it be tried again", waits);
    }

    pub(super) fn retry(&mut self, job: &Job, question: &Question, why: &Why, reason: &str) {
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
    pub(super) fn go_elsewhere(&mut self, job: &Job, place: String) {
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

    pub(super) fn undo_with(&mut self, job: &Job, choice: Choice) {
        self.plan_undo(job, Some(choice));
    }

    /// Nothing of the old plan goes on.
    pub(super) fn drop_running(&mut self, job: &Job) {
        if job.compensation != Compensation::None {
            self.emit(Fact::CompensationMoved {
                job: job.id,
                to: Compensation::None,
            });
        }
    }

    /// A human looked: the arm stands. The acting state ends.
    pub(super) fn confirmed_still(&mut self, job: &Job) {
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

    /// A job that goes on undoing after an answer begins its waits anew.
    pub(super) fn wait_anew(&mut self, job: Uuid) {
        let Some(job) = self.job(job).filter(|j| j.state == JobState::Stopping) else {
            return;
        };
        for (step, found) in job.steps.iter().enumerate() {
            if found.state == StepState::Running && found.op.is_none() {
                self.emit(Fact::StepResent { job: job.id, step });
            }
        }
    }
}
