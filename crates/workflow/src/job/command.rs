//! What an operator does with a job.

use uuid::Uuid;

use crate::book::OpState;
use crate::commands_in::{allowed, word};
use crate::effect::Action;
use crate::fact::Fact;
use crate::faults::Fault;
use crate::input::{Command, Principal, Refusal, Reply};
use crate::job::phase::Phase;
use crate::job::{Compensation, Job, JobState, StepState, Why};
use crate::react::Reaction;
use crate::words;
use crate::work::Work;

impl Work<'_> {
    #[expect(
        clippy::too_many_lines,
        reason = "a table: what each command does in each state"
    )]
    pub(crate) fn command(
        &mut self,
        id: Uuid,
        command: Command,
        principal: &Principal,
        reason: &str,
    ) -> Result<Reply, Refusal> {
        allowed(word(command), principal, reason)?;
        let Some(job) = self.job(id) else {
            return Err(Refusal::Unknown {
                what: "job",
                id: id.to_string(),
            });
        };
        let state = job.state;
        let why = Why::Human {
            principal: principal.name.clone(),
        };
        let no = |text: &str| {
            Err(Refusal::Conflict {
                command: word(command).to_owned(),
                text: format!("the job is {}: {text}", words::word(&state)),
            })
        };
        match command {
            Command::Hold => match state {
                JobState::Holding | JobState::Held => return Ok(Reply::Unchanged),
                JobState::Starting
                | JobState::Execute
                | JobState::Suspending
                | JobState::Suspended
                | JobState::Unsuspending
                | JobState::Unholding => {
                    self.stop_motion(&job, reason);
                    self.go(id, JobState::Holding, why, reason);
                }
                JobState::Idle
                | JobState::Completing
                | JobState::Complete
                | JobState::Stopping
                | JobState::Stopped
                | JobState::Aborting
                | JobState::Aborted
                | JobState::Clearing
                | JobState::Resetting => return no("only a running job can be held"),
            },
            Command::Unhold => {
                if state != JobState::Held {
                    return no("only a held job can be unheld");
                }
                if self.cell.book.question_of(id).is_some() {
                    return no("a question has to be answered first");
                }
                if job.steps.iter().any(|s| s.state == StepState::Retriable) {
                    return no("a step failed: retry-step or complete-manually first");
                }
                if let Err(text) = self.may_resume(&job) {
                    return no(&text);
                }
                self.go(id, JobState::Unholding, why, reason);
            }
            Command::Stop | Command::Compensate => match state {
                JobState::Stopping | JobState::Stopped => return Ok(Reply::Unchanged),
                JobState::Idle => self.go(id, JobState::Stopped, why, reason),
                JobState::Complete
                | JobState::Completing
                | JobState::Aborting
                | JobState::Aborted
                | JobState::Clearing
                | JobState::Resetting => return no("it cannot be stopped any more"),
                JobState::Starting
                | JobState::Execute
                | JobState::Holding
                | JobState::Held
                | JobState::Unholding
                | JobState::Suspending
                | JobState::Suspended
                | JobState::Unsuspending => self.cancel(&job, why, reason),
            },
            Command::Abort => match state {
                JobState::Aborting | JobState::Aborted => return Ok(Reply::Unchanged),
                JobState::Complete
                | JobState::Stopped
                | JobState::Clearing
                | JobState::Resetting => {
                    return no("it is over");
                }
                JobState::Idle => self.go(id, JobState::Stopped, why, reason),
                JobState::Starting
                | JobState::Execute
                | JobState::Completing
                | JobState::Holding
                | JobState::Held
                | JobState::Unholding
                | JobState::Suspending
                | JobState::Suspended
                | JobState::Unsuspending
                | JobState::Stopping => self.abort(&job, why, reason),
            },
            Command::RetryStep | Command::SkipStep | Command::CompleteManually => {
                return self.step_command(&job, command);
            }
            Command::Clear => {
                if state != JobState::Aborted {
                    return no("only an aborted job can be cleared");
                }
                if self.cell.book.question_of(id).is_some() {
                    return no("a question has to be answered first");
                }
                self.go(id, JobState::Clearing, why, reason);
            }
            Command::Reset => {
                if state != JobState::Stopped {
                    return no("only a stopped job can be reset");
                }
                if self.cell.session_of(&job).is_some() {
                    return no("its hand-over session is still open");
                }
                let mut spec = job.spec.clone();
                spec.deadline = None;
                let items = crate::job::validate::items_of(&self.cell, &spec, self.now)?;
                for (item, to) in items.into_iter().enumerate() {
                    self.emit(Fact::ItemChanged { job: id, item, to });
                }
                self.go(id, JobState::Resetting, why, reason);
            }
        }
        Ok(Reply::Done)
    }

    /// F16, F17: stop, then undo what can be undone.
    pub(crate) fn cancel(&mut self, job: &Job, why: Why, reason: &str) {
        self.note(job.id, Fault::Canceled, reason);
        self.stop_motion(job, reason);
        self.withdraw(job.id, "the job was canceled");
        let open: Vec<_> = self
            .cell
            .ops_of(job.id)
            .filter(|(_, state)| *state == OpState::Running)
            .map(|(op, _)| op)
            .collect();
        for op in open {
            // Planning moves nothing: its answer is not waited for.
            let planning = self
                .cell
                .book
                .ops
                .get(&op)
                .is_some_and(|o| matches!(o.action, Action::Precheck { .. }));
            if planning {
                let text = "the job was canceled".to_owned();
                self.emit(Fact::OpEnded {
                    op,
                    result: crate::OpResult::NotExecuted { text },
                });
            }
        }
        self.go(job.id, JobState::Stopping, why, reason);
        if job.arm.is_none() {
            self.go(job.id, JobState::Stopped, Why::Course, reason);
        }
    }

    fn abort(&mut self, job: &Job, why: Why, reason: &str) {
        self.react(
            job,
            Reaction {
                fault: Fault::Canceled,
                text: reason.to_owned(),
                permits: true,
                stop: true,
                ..Reaction::default()
            },
        );
        self.withdraw(job.id, "the job was aborted");
        self.go(job.id, JobState::Aborting, why, reason);
    }

    /// Stops a motion of this job, if there is one. A gripper that acts is waited for.
    pub(crate) fn stop_motion(&mut self, job: &Job, text: &str) {
        let moving = self.cell.book.ops.values().any(|op| {
            op.job == job.id
                && op.state == OpState::Running
                && matches!(op.action, Action::Move { .. })
        });
        if let (true, Some(arm)) = (moving, &job.arm) {
            self.stop_arm(arm, text);
        }
    }

    fn step_command(&mut self, job: &Job, command: Command) -> Result<Reply, Refusal> {
        let no = |text: String| {
            Err(Refusal::Conflict {
                command: word(command).to_owned(),
                text,
            })
        };
        if !matches!(job.state, JobState::Held | JobState::Suspended) {
            return no(format!(
                "the job is {}; hold it first",
                words::word(&job.state)
            ));
        }
        if self.cell.ops_of(job.id).next().is_some() {
            return no("an operation is not decided".into());
        }
        let step = job
            .steps
            .iter()
            .position(|s| s.state == StepState::Retriable)
            .or_else(|| job.steps.iter().position(|s| s.state == StepState::Running));
        let Some(step) = step else {
            return no("no step is waiting".into());
        };
        let phase = job.step(step).map_or(Phase::Close, |s| s.plan.phase);
        if command == Command::CompleteManually {
            return self.complete_manually(job, step, phase);
        }
        if command == Command::SkipStep {
            if !phase.may_skip() {
                return no(format!("{} is a deed, not a check", words::word(&phase)));
            }
            if phase == Phase::VerifyLoad && job.items.iter().any(|i| i.load.is_none()) {
                return no("the loads have no names yet; accept them instead".into());
            }
            self.step_to(job, step, StepState::Skipped, "skipped by a human");
        } else {
            let attempt = 0;
            let text = "a human lets it be tried again".to_owned();
            let to = StepState::Pending;
            self.emit(Fact::StepMoved {
                job: job.id,
                step,
                to,
                attempt,
                text,
            });
        }
        self.withdraw(job.id, "a human decided about the step");
        Ok(Reply::Done)
    }

    /// The books have to agree with what the human says was done: custody is set first.
    fn complete_manually(
        &mut self,
        job: &Job,
        step: usize,
        phase: Phase,
    ) -> Result<Reply, Refusal> {
        let no = |text: String| {
            Err(Refusal::Conflict {
                command: "complete-manually".to_owned(),
                text,
            })
        };
        let held = job
            .arm
            .as_ref()
            .and_then(|a| self.cell.book.custody.in_gripper(a));
        let load = job.item_of(step).and_then(|(_, item)| item.load.as_deref());
        let agrees = if phase == Phase::Grip {
            held.is_some() && held == load
        } else if phase == Phase::Release {
            let place = job.step(step).and_then(|s| s.plan.place.clone());
            let at = place.and_then(|p| self.location_of(job, &p));
            at.is_some() && load.and_then(|l| self.cell.book.custody.of(l)) == at.as_ref()
        } else if phase == Phase::VerifyLoad {
            job.items.iter().all(|i| i.load.is_some())
        } else if matches!(phase, Phase::VerifyEmpty | Phase::VerifyOnMr) {
            true
        } else {
            return no(format!(
                "{} is proven by what is seen, not by words",
                words::word(&phase)
            ));
        };
        if !agrees {
            return no(format!(
                "{}: say first where the load is (set-custody)",
                words::word(&phase)
            ));
        }
        self.step_to(job, step, StepState::Succeeded, "completed by a human");
        self.withdraw(job.id, "a human completed the step");
        Ok(Reply::Done)
    }

    /// A job whose compensation was blocked goes on undoing.
    pub(crate) fn undo_again(&mut self, job: &Job) {
        self.emit(Fact::CompensationMoved {
            job: job.id,
            to: Compensation::None,
        });
    }
}
