//! The course of a job: acting states that end when the arm is still, and steps that follow one another.

use std::sync::Arc;

use crate::claims::Holder;
use crate::fact::Fact;
use crate::faults::Fault;
use crate::job::phase::{Phase, Shown};
use crate::job::{Compensation, Job, JobState, StepState, Why};
use crate::session::{Session, SessionState};
use crate::words;
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

    /// Whether everything a job needs is seen to be well again.
    pub(crate) fn may_resume(&self, job: &Job) -> Result<(), String> {
        if self.cell.ops_of(job.id).next().is_some() {
            return Err("an operation is not decided".into());
        }
        if let Some(arm) = &job.arm {
            if !self.cell.arm_ready(arm) {
                return Err(format!("arm {arm} is not ready"));
            }
            if !self.cell.arm_still(arm) {
                return Err(format!("arm {arm} is not seen to stand still"));
            }
            if let Some(load) = self.cell.book.custody.doubt_of(arm) {
                return Err(format!("nobody knows where load {load} is"));
            }
        }
        let Some(session) = self.cell.session_of(job) else {
            return Ok(());
        };
        // Where another arm of the point is not heard, no permit would last; see `supervise_session`.
        if let Some(arm) = self.cell.unheard_at(&session.point) {
            return Err(format!("arm {arm} of {} is not heard", session.point));
        }
        let from = session.faulted.map_or(session.state, |(from, _)| from);
        if from.is_docked() {
            let live = self.cell.live.mobiles.get(&session.mobile_robot);
            let beats = live.map_or(0, |m| m.beats);
            let enough = u64::from(self.cell.setup.timers.heartbeats_to_resume);
            if session.faulted.is_some() && beats < enough {
                return Err(format!("{beats} of {enough} heartbeats"));
            }
            // Docked or not, a mobile robot without its order has to be called anew.
            self.still_serves(session)?;
            return self.cell.dock_evidence(session);
        }
        if session.assigned
            && !matches!(from, SessionState::TransferDone | SessionState::ExitGranted)
        {
            let Some(seen) = self.cell.mobile_seen(&session.mobile_robot) else {
                return Err(format!("{} is not heard", session.mobile_robot));
            };
            if !seen.mode.is_automatic() {
                return Err(format!(
                    "{} is in mode {}",
                    session.mobile_robot,
                    words::capitals(seen.mode)
                ));
            }
            return self.still_serves(session);
        }
        Ok(())
    }

    /// It has its order, and no fatal error. What the supervision would fault at once is not taken up again.
    fn still_serves(&self, session: &Session) -> Result<(), String> {
        let Some(seen) = self.cell.mobile_seen(&session.mobile_robot) else {
            return Err(format!("{} is not heard", session.mobile_robot));
        };
        if session.echoes && seen.order.is_none() {
            return Err(format!("{} dropped its order", session.mobile_robot));
        }
        if seen.errors.iter().any(|e| e.fatal) {
            return Err(format!("{} reports a fatal error", session.mobile_robot));
        }
        Ok(())
    }

    /// UNHOLDING, UNSUSPENDING: first the positions are read again, then the session, then it goes on.
    fn resume(&mut self, job: &Job) {
        if job.why != Why::Awaiting && self.may_resume(job).is_err() {
            let _told = self.dropped_meanwhile(job);
            return;
        }
        if let Some(session) = self.cell.session_of(job).cloned()
            && session.state == SessionState::Faulted
        {
            self.continue_session(&session);
        }
        self.withdraw(job.id, "the job goes on");
        // Its question was replaced by a newer one, which is answered now; nobody has decided about the step yet.
        if let Some(step) = job
            .steps
            .iter()
            .position(|s| s.state == StepState::Retriable)
        {
            let text = "it is still to be decided".to_owned();
            self.step_stuck(job, step, Fault::ControllerAlarm, &text, None);
            return;
        }
        let begun = job.is_done(Phase::Precheck);
        self.go(
            job.id,
            if begun {
                JobState::Execute
            } else {
                JobState::Starting
            },
            Why::Course,
            "",
        );
    }

    /// F13 on top of another fault: while nobody could look, the mobile robot dropped its order. Waiting for it to be
    /// well again would be for ever; the arm leaves, and it is called anew.
    fn dropped_meanwhile(&mut self, job: &Job) -> bool {
        let ready = job
            .arm
            .as_ref()
            .is_none_or(|arm| self.cell.arm_ready(arm) && self.cell.arm_still(arm));
        let told = matches!(
            job.why,
            Why::Fault {
                fault: Fault::ModeChanged
            }
        );
        let dropped = ready
            && !told
            && self.cell.ops_of(job.id).next().is_none()
            && self.cell.session_of(job).is_some_and(|session| {
                let from = session.faulted.map_or(session.state, |(from, _)| from);
                let leaves = matches!(
                    from,
                    SessionState::TransferDone | SessionState::ExitGranted | SessionState::Exited
                );
                !leaves
            })
            && self.has_dropped_its_order(job);
        if dropped {
            self.mobile_fault(job, Fault::ModeChanged, "it dropped its order");
        }
        dropped
    }

    /// SUSPENDED by a fault that may end by itself.
    fn run_suspended(&mut self, job: &Job) {
        let fault = match &job.why {
            Why::Fault { fault } => *fault,
            Why::Recovering => Fault::Restarted,
            Why::Course | Why::Awaiting | Why::Human { .. } | Why::DeadlinePassed => return,
        };
        if fault != Fault::ModeChanged && self.dropped_meanwhile(job) {
            return;
        }
        // F12, F13: the arm leaves the zone first.
        if let Some(step) = job
            .steps
            .iter()
            .position(|s| s.plan.phase == Phase::BackOut && s.state == StepState::Running)
        {
            self.run_operations(job, step);
            return;
        }
        let in_zone = job.near.as_ref().is_some_and(crate::PlaceRef::in_zone);
        let leaves = matches!(fault, Fault::HeartbeatLost | Fault::ModeChanged);
        let ready = job.arm.as_ref().is_some_and(|a| self.cell.arm_ready(a));
        if leaves && in_zone && ready && self.cell.ops_of(job.id).next().is_none() {
            self.add_back_out(job);
            return;
        }
        let by_itself = matches!(
            fault,
            Fault::NoAnswer | Fault::HeartbeatLost | Fault::ModeChanged | Fault::Restarted
        );
        if by_itself && self.may_resume(job).is_ok() {
            self.withdraw(job.id, "it is well again");
            self.go(
                job.id,
                JobState::Unsuspending,
                job.why.clone(),
                "it is well again",
            );
            return;
        }
        if fault == Fault::ModeChanged {
            self.redispatch_if_automatic(job);
        }
        if fault == Fault::TargetBlocked {
            let free = job.steps.iter().any(|s| {
                s.plan.phase == Phase::PlaceApproach
                    && s.state == StepState::Running
                    && s.plan
                        .place
                        .as_ref()
                        .and_then(|p| self.location_of(job, p))
                        .is_some_and(|at| self.cell.is_target_free(job, &at))
            });
            if free {
                self.withdraw(job.id, "the place is free");
                self.go(
                    job.id,
                    JobState::Unsuspending,
                    job.why.clone(),
                    "the place is free",
                );
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
        if let Some(step) = job
            .steps
            .iter()
            .position(|s| s.plan.phase == Phase::BackOut && s.state == StepState::Running)
        {
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
