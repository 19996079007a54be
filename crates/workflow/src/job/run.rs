//! The course of a job: acting states that end when the arm is still, and steps that follow one another.

use std::sync::Arc;

use crate::claims::Holder;
use crate::fact::Fact;
use crate::job::phase::{Phase, Shown};
use crate::job::{Compensation, Job, JobState, StepState, Why};
use crate::session::SessionState;
use crate::work::Work;

/// The load a gripper was acting on.
fn load_of_grip(job: &Job, op: &crate::book::Op) -> Option<String> {
    let _grip = crate::supervise::grip_of(&op.action)?;
    job.item_of(op.step).and_then(|(_, item)| item.load.clone())
}

impl Work<'_> {
    pub(crate) fn run_jobs(&mut self) {
        let before = self.facts.len();
        for id in self.jobs() {
            let Some(job) = self.job(id) else { continue };
            self.run_job(&job);
            if self.facts.len() > before {
                return;
            }
        }
    }

    fn run_job(&mut self, job: &Arc<Job>) {
        let quiet = self.cell.is_quiet(job);
        match job.state {
            JobState::Holding if quiet => self.go_on(job, JobState::Held),
            JobState::Suspending if quiet => self.go_on(job, JobState::Suspended),
            JobState::Aborting if quiet => self.aborted(job),
            JobState::Unholding | JobState::Unsuspending => self.resume(job),
            JobState::Clearing if quiet => self.cleared(job),
            JobState::Resetting => self.go(job.id, JobState::Idle, Why::Course, ""),
            JobState::Suspended if job.why != Why::Awaiting => self.run_suspended(job),
            JobState::Stopping if job.compensation == Compensation::None => {
                if quiet && self.cell.ops_of(job.id).next().is_none() {
                    self.plan_undo(job, None);
                }
            }
            JobState::Stopping if job.compensation == Compensation::Blocked => {}
            JobState::Starting
            | JobState::Execute
            | JobState::Completing
            | JobState::Stopping
            | JobState::Suspended => self.run_steps(job),
            JobState::Idle
            | JobState::Complete
            | JobState::Holding
            | JobState::Held
            | JobState::Suspending
            | JobState::Stopped
            | JobState::Aborting
            | JobState::Aborted
            | JobState::Clearing => {}
        }
    }

    fn go_on(&mut self, job: &Job, to: JobState) {
        self.go(job.id, to, job.why.clone(), job.text.clone());
    }

    /// The arm stands; motions that nobody heard the end of have ended somewhere, grips are unknown.
    pub(crate) fn aborted(&mut self, job: &Job) {
        let open: Vec<_> = self.cell.ops_of(job.id).map(|(id, _)| id).collect();
        for id in open {
            let Some(op) = self.cell.book.ops.get(&id).cloned() else {
                continue;
            };
            if let Some(load) = load_of_grip(job, &op) {
                let text = "the job was aborted while the gripper acted";
                self.emit(Fact::OpEnded {
                    op: id,
                    result: crate::OpResult::Interrupted { text: text.into() },
                });
                self.part_lost(job, &load, text);
                return;
            }
            let text = "the job was aborted".to_owned();
            self.emit(Fact::OpEnded {
                op: id,
                result: crate::OpResult::Interrupted { text },
            });
        }
        self.go_on(job, JobState::Aborted);
    }

    /// A human cleared an aborted job. What it had is free; its mobile robot waits for a decision.
    fn cleared(&mut self, job: &Job) {
        let session = self.cell.session_of(job).cloned();
        self.emit(Fact::Released {
            by: Holder::Job(job.id),
            resources: None,
        });
        self.go_on(job, JobState::Stopped);
        let Some(session) = session else { return };
        match session.state {
            SessionState::Reserved if session.order.is_none() => {
                self.close(&session, SessionState::Canceled);
            }
            SessionState::TransferDone
            | SessionState::ExitGranted
            | SessionState::Canceling
            | SessionState::Exited => {}
            SessionState::Reserved
            | SessionState::AccessPending
            | SessionState::AccessGranted
            | SessionState::Positioned
            | SessionState::Docked
            | SessionState::TransferReady
            | SessionState::Transferring
            | SessionState::Faulted
            | SessionState::Released
            | SessionState::Canceled => {
                self.does_not_leave(&session, "its job was aborted and cleared");
            }
        }
    }

    /// Appends and starts a step that drives the arm out.
    pub(crate) fn add_back_out(&mut self, job: &Job) {
        let mut b = crate::job::plan::Builder::after(job.steps.len(), false);
        let step = b.then(Phase::BackOut, None, None);
        self.emit(Fact::Planned {
            job: job.id,
            steps: b.steps(),
            drop: Vec::new(),
            definition: None,
        });
        if let Some(job) = self.job(job.id) {
            self.step_to(&job, step, StepState::Running, "");
        }
    }

    fn run_steps(&mut self, job: &Arc<Job>) {
        if self.show(job) {
            return;
        }
        let stopping = job.state == JobState::Stopping;
        if stopping && self.undo_needs_session(job) {
            return;
        }
        // Out first: what else runs begins anew behind it.
        if let Some(step) = job.backing_out() {
            self.run_operations(job, step);
            return;
        }
        for (index, step) in job.steps.iter().enumerate() {
            let counts = !stopping || step.plan.undo;
            let ready = step
                .plan
                .needs
                .iter()
                .all(|need| job.step(*need).is_none_or(|s| s.state.is_done()));
            if counts && step.state == StepState::Pending && ready {
                self.step_to(job, index, StepState::Running, "");
                return;
            }
        }
        let before = self.facts.len();
        for (index, step) in job.steps.iter().enumerate() {
            if step.state != StepState::Running {
                continue;
            }
            if step.plan.phase.is_arm_work() {
                self.run_operations(job, index);
            } else {
                self.run_wait(job, index);
            }
            if self.facts.len() > before {
                return;
            }
        }
    }

    /// An undoing that has to enter the zone needs the session back, as soon as everything is well.
    fn undo_needs_session(&mut self, job: &Job) -> bool {
        let zone = job.steps.iter().any(|s| {
            s.plan.undo
                && !s.state.is_done()
                && s.plan.place.as_ref().is_some_and(crate::PlaceRef::in_zone)
        });
        let Some(session) = self.cell.session_of(job).cloned() else {
            return false;
        };
        let docked = session.faulted.is_some_and(|(from, _)| from.is_docked());
        let needed = zone && docked && self.may_resume(job).is_ok();
        if needed {
            self.continue_session(&session);
        }
        needed
    }

    /// Brings the `PackML` state in line with what the steps do. True if it had to change.
    fn show(&mut self, job: &Job) -> bool {
        if job.state == JobState::Stopping {
            return false;
        }
        let running: Vec<_> = job
            .steps
            .iter()
            .filter(|s| s.state == StepState::Running)
            .map(|s| s.plan.phase.row().shown)
            .collect();
        let has = |shown: Shown| running.contains(&shown);
        let want = if running.is_empty() {
            return false;
        } else if has(Shown::Execute) {
            JobState::Execute
        } else if has(Shown::Completing) {
            JobState::Completing
        } else if has(Shown::Waiting) {
            JobState::Suspended
        } else if job.is_done(Phase::Dock) || job.state == JobState::Execute {
            JobState::Execute
        } else {
            JobState::Starting
        };
        if want == job.state {
            return false;
        }
        match (job.state, want) {
            (_, JobState::Suspended) => {
                self.go(
                    job.id,
                    JobState::Suspending,
                    Why::Awaiting,
                    "it waits for the mobile robot",
                );
            }
            (JobState::Suspended, _) => {
                self.go(job.id, JobState::Unsuspending, Why::Awaiting, "");
            }
            (_, to) => self.go(job.id, to, Why::Course, ""),
        }
        true
    }

    fn run_wait(&mut self, job: &Job, step: usize) {
        let Some(found) = job.step(step) else { return };
        let session = self.cell.session_of(job).cloned();
        let done = |work: &mut Self| work.step_to(job, step, StepState::Succeeded, "");
        match found.plan.phase {
            Phase::Call => match session {
                // It would refuse: it is still on its way out with the order before. The timer ends this wait.
                Some(s) if s.order.is_none() && self.works_on_another(&s) => {}
                Some(s) if s.order.is_none() => self.send_order(&s),
                Some(s) if s.assigned => done(self),
                Some(_) | None => {}
            },
            Phase::Await => {
                let there = |s: &crate::session::Session| {
                    s.state == SessionState::Positioned || s.state.is_docked()
                };
                if session.is_some_and(|s| there(&s)) {
                    done(self);
                }
            }
            Phase::Dock => {
                if session.is_some_and(|s| s.state.is_docked()) {
                    done(self);
                }
            }
            Phase::VerifyLoad => self.verify_load(job, step),
            Phase::VerifyEmpty => self.verify_empty(job, step),
            Phase::VerifyOnMr => self.verify_on_mr(job, step),
            Phase::Permit => match session {
                Some(s) if s.state == SessionState::Transferring => done(self),
                Some(s) => self.grant_entry(&s),
                None => {}
            },
            Phase::ReleaseMr => match session {
                Some(s) if s.state.is_docked() => self.begin_exit(job, &s, None),
                Some(_) | None => done(self),
            },
            Phase::Exit => match session {
                Some(s) if s.state.is_docked() => self.begin_exit(job, &s, None),
                // F19: the arm is free, the session stays open.
                Some(s)
                    if self.cell.book.question_of_session(s.id).is_some()
                        && job.spec.workflow == crate::Workflow::DeliveryAndPlacement =>
                {
                    self.step_to(job, step, StepState::Succeeded, "the point stays occupied");
                }
                Some(_) => {}
                None => done(self),
            },
            Phase::Transport => {
                let under_way = job.mobile_robot.as_ref().is_some_and(|m| {
                    self.cell
                        .book
                        .mobiles
                        .get(m)
                        .is_some_and(|b| b.transport.as_ref().is_some_and(|t| t.job == job.id))
                });
                if !under_way {
                    done(self);
                }
            }
            Phase::Dismiss => self.dismiss(job, step),
            Phase::Close => {
                self.emit(Fact::Released {
                    by: Holder::Job(job.id),
                    resources: None,
                });
                done(self);
                let undone = job.compensation != Compensation::None;
                if undone {
                    let to = Compensation::Done;
                    self.emit(Fact::CompensationMoved { job: job.id, to });
                }
                let to = if found.plan.undo {
                    JobState::Stopped
                } else {
                    JobState::Complete
                };
                let why = if found.plan.undo {
                    job.why.clone()
                } else {
                    Why::Course
                };
                self.go(job.id, to, why, job.text.clone());
            }
            Phase::Reserve
            | Phase::Precheck
            | Phase::Approach
            | Phase::Grip
            | Phase::LiftClear
            | Phase::PlaceApproach
            | Phase::Release
            | Phase::Retreat
            | Phase::BackOut => {}
        }
    }
}
