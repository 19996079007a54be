//! What became of an arm's operation, and what follows for its step.

use uuid::Uuid;

use crate::book::{Op, OpState};
use crate::custody::{Evidence, Location};
use crate::effect::{Action, GripAction};
use crate::fact::Fact;
use crate::faults::Fault;
use crate::input::{OpResult, Refusal, Reply};
use crate::intervention::Answer;
use crate::job::operations::describe;
use crate::job::phase::Phase;
use crate::job::{Job, JobState, StepState, Why};
use crate::react::Reaction;
use crate::setup::PlaceRef;
use crate::supervise::grip_of;
use crate::work::{Ask, Work};

impl Work<'_> {
    /// An operation ended: what does it mean?
    pub(crate) fn op_ended(&mut self, id: Uuid, result: OpResult) -> Result<Reply, Refusal> {
        let Some(op) = self.cell.book.ops.get(&id).cloned() else {
            return Ok(Reply::Unchanged);
        };
        let fits = match (&op.action, &result) {
            (Action::Move { .. }, OpResult::Gripped { .. } | OpResult::Prechecked { .. })
            | (Action::Grip { .. } | Action::Precheck { .. }, OpResult::Arrived)
            | (Action::Grip { .. }, OpResult::Prechecked { .. })
            | (Action::Precheck { .. }, OpResult::Gripped { .. }) => false,
            (Action::Move { .. } | Action::Grip { .. } | Action::Precheck { .. }, _) => true,
        };
        if !fits {
            return Err(Refusal::Invalid {
                item: format!("operation {id}"),
                problem: "the result does not belong to this kind of operation".into(),
            });
        }
        let Some(job) = self.job(op.job) else {
            return Ok(Reply::Unchanged);
        };
        if let OpResult::InDoubt { text } = &result {
            self.op_in_doubt(&job, id, &op, text);
            return Ok(Reply::Done);
        }
        if let (OpResult::Interrupted { text }, Some(_)) = (&result, grip_of(&op.action)) {
            self.op_in_doubt(&job, id, &op, text);
            return Ok(Reply::Done);
        }
        if let Some(open) = self.cell.book.question_of(job.id)
            && open.question.op == Some(id)
        {
            self.withdraw(job.id, "the truth was found");
        }
        self.emit(Fact::OpEnded {
            op: id,
            result: result.clone(),
        });
        let Some(job) = self.job(op.job) else {
            return Ok(Reply::Done);
        };
        let over = crate::react::is_over(&job);
        match result {
            _ if over && !matches!(result, OpResult::Gripped { .. }) => {}
            OpResult::Arrived | OpResult::InDoubt { .. } => {}
            OpResult::Prechecked { failures } => {
                if let Some(first) = failures.first() {
                    self.unreachable(&job, op.step, first);
                }
            }
            OpResult::Gripped {
                closed,
                open,
                part_present,
            } => {
                self.gripped(&job, &op, id, (closed, open, part_present));
            }
            OpResult::NotExecuted { text } => self.not_executed(&job, &op, &text),
            OpResult::Interrupted { text } => {
                // Stopped on purpose, or found so after a loss: it is planned again from where the arm is.
                let runs = job.state.runs() && job.state != JobState::Stopping;
                // The alarm may have been seen before the end of the motion it stopped: the question is the same.
                let alarmed = matches!(job.state, JobState::Holding | JobState::Held)
                    && job.why
                        == Why::Fault {
                            fault: Fault::ControllerAlarm,
                        };
                if (runs || alarmed) && op.state == OpState::Running {
                    self.step_stuck(&job, op.step, Fault::ControllerAlarm, &text, None);
                }
            }
            OpResult::Rejected { text } => {
                self.step_stuck(&job, op.step, Fault::ControllerAlarm, &text, None);
            }
        }
        Ok(Reply::Done)
    }

    pub(super) fn not_executed(&mut self, job: &Job, op: &Op, text: &str) {
        let tries = job.step(op.step).map_or(0, |s| s.resends);
        if tries >= self.cell.setup.timers.resends {
            self.step_stuck(job, op.step, Fault::ControllerAlarm, text, None);
        } else {
            self.emit(Fact::StepResent {
                job: job.id,
                step: op.step,
            });
        }
    }

    /// F8. The first time: look it up. If that does not tell either: a human.
    pub(crate) fn op_in_doubt(&mut self, job: &Job, id: Uuid, op: &Op, text: &str) {
        self.emit(Fact::OpDoubted {
            op: id,
            text: text.to_owned(),
        });
        if op.state == OpState::Running {
            self.react(
                job,
                Reaction {
                    fault: Fault::NoAnswer,
                    text: text.into(),
                    permits: true,
                    state: Some(JobState::Suspending),
                    ..Reaction::default()
                },
            );
            return;
        }
        if crate::react::is_over(job) {
            return;
        }
        let mut answers = vec![Answer::Happened, Answer::DidNotHappen];
        if grip_of(&op.action).is_none() {
            answers.push(Answer::Replan);
        }
        answers.push(Answer::Abort);
        let known = self.known_of(job);
        self.ask(Ask {
            job: Some(job.id),
            op: Some(id),
            fault: Fault::NoAnswer,
            question: format!("Did {} happen? {text}", describe(&op.action)),
            known,
            unknown: vec![format!("what became of {}", describe(&op.action))],
            answers,
            ..Ask::default()
        });
    }

    /// The gripper's inputs: custody changes here and nowhere else in the course of a job.
    pub(super) fn gripped(&mut self, job: &Job, op: &Op, id: Uuid, inputs: (bool, bool, bool)) {
        let (closed, open, part_present) = inputs;
        let Some(step) = job.step(op.step).cloned() else {
            return;
        };
        let Some(load) = step
            .plan
            .item
            .and_then(|i| job.items.get(i))
            .and_then(|i| i.load.clone())
        else {
            return;
        };
        let by = Evidence::Gripper { op: id };
        let held = self.cell.book.custody.in_gripper(&op.arm) == Some(load.as_str());
        match (grip_of(&op.action), step.plan.phase) {
            (Some(GripAction::Close), _) if closed && part_present => {
                let to = Location::Gripper {
                    arm: op.arm.clone(),
                };
                self.emit(Fact::CustodyMoved { load, to, by });
            }
            (Some(GripAction::Close), _) => self.grip_failed(job, op.step),
            (Some(GripAction::Open), Phase::Release) if held && open && !part_present => {
                if let Some(to) = step
                    .plan
                    .place
                    .as_ref()
                    .and_then(|p| self.location_of(job, p))
                {
                    self.emit(Fact::CustodyMoved { load, to, by });
                }
            }
            (Some(GripAction::Open), _) if !open || part_present => {
                let text = "after opening, the gripper's inputs do not say that it is empty";
                self.part_lost(job, &load, text);
            }
            (Some(GripAction::Open) | None, _) => {}
        }
    }

    /// Where a load is when it was released at `place`.
    #[expect(
        clippy::unused_self,
        reason = "reads like the other questions to the state"
    )]
    pub(crate) fn location_of(&self, job: &Job, place: &PlaceRef) -> Option<Location> {
        Some(match place {
            PlaceRef::Fixed { place } => Location::Fixed {
                place: place.clone(),
            },
            PlaceRef::MobileRobot { slot, .. } => Location::MobileRobot {
                mobile_robot: job.mobile_robot.clone()?,
                slot: slot.clone(),
            },
        })
    }

    /// F9.
    pub(super) fn grip_failed(&mut self, job: &Job, step: usize) {
        self.note(job.id, Fault::GripFailed, "no part after closing");
        let Some(found) = job.step(step) else { return };
        let attempt = found.attempt.max(1).saturating_add(1);
        let to = found.state;
        let text = "open, retreat and try again".into();
        self.emit(Fact::StepMoved {
            job: job.id,
            step,
            to,
            attempt,
            text,
        });
    }

    /// F9 after the last attempt; the arm is out and open. Now it is F4.
    pub(super) fn grip_given_up(&mut self, job: &Job, step: usize) {
        let text = "the load could not be gripped";
        let approach = job.steps.iter().rposition(|s| {
            s.plan.phase == Phase::Approach
                && s.plan.item == job.step(step).and_then(|s| s.plan.item)
                && s.state == StepState::Succeeded
        });
        for again in [approach, Some(step)].into_iter().flatten() {
            let to = StepState::Pending;
            self.emit(Fact::StepMoved {
                job: job.id,
                step: again,
                to,
                attempt: 0,
                text: text.into(),
            });
        }
        self.load_question(job, Fault::LoadMismatch, text);
    }
}
