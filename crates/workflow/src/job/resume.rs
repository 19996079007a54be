//! Going on after a hold or a wait: only when everything is seen to be well again.

use crate::faults::Fault;
use crate::job::phase::Phase;
use crate::job::{Job, JobState, StepState, Why};
use crate::session::{Session, SessionState};
use crate::words;
use crate::work::Work;

impl Work<'_> {
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
                    words::word(&seen.mode)
                ));
            }
            return self.still_serves(session);
        }
        Ok(())
    }

    /// It has its order, and no fatal error. What the supervision would fault at once is not taken up again.
    pub(super) fn still_serves(&self, session: &Session) -> Result<(), String> {
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
    pub(super) fn resume(&mut self, job: &Job) {
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
    pub(super) fn dropped_meanwhile(&mut self, job: &Job) -> bool {
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
    pub(super) fn run_suspended(&mut self, job: &Job) {
        let fault = match &job.why {
            Why::Fault { fault } => *fault,
            Why::Recovering => Fault::Restarted,
            Why::Course | Why::Awaiting | Why::Human { .. } | Why::DeadlinePassed => return,
        };
        if fault != Fault::ModeChanged && self.dropped_meanwhile(job) {
            return;
        }
        // F12, F13: the arm leaves the zone first.
        if let Some(step) = job.backing_out() {
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
}
