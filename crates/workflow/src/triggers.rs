//! Jobs that a mobile robot starts by its own signal.
//!
//! Exactly once for each number of a mobile robot: the signal and the job it starts are one decision, and a copy of a
//! signal that was kept is answered and not acted on, over a restart too.

use crate::fact::Fact;
use crate::input::Refusal;
use crate::job::params::Workflow;
use crate::setup::Trigger;
use crate::signal::Signal;
use crate::work::Work;

impl Work<'_> {
    /// Starts the jobs that are configured for this signal.
    pub(crate) fn trigger(&mut self, signal: &Signal) {
        // With an order it does what the cell told it: that is no news.
        let by_itself = signal.state.order.is_none()
            && self
                .cell
                .book
                .open_session_of(&signal.mobile_robot)
                .is_none()
            && self.transport_of(&signal.mobile_robot).is_none();
        if !by_itself {
            return;
        }
        let setup = self.cell.setup.clone();
        for trigger in setup.triggers.iter().filter(|t| t.is_meant(signal)) {
            if let Err(text) = self.fire(trigger, signal) {
                self.emit(Fact::TriggerSkipped {
                    trigger: trigger.id.clone(),
                    mobile_robot: signal.mobile_robot.clone(),
                    boot: signal.boot,
                    seq: signal.seq,
                    text,
                });
            }
        }
    }

    fn fire(&mut self, trigger: &Trigger, signal: &Signal) -> Result<(), String> {
        let Signal {
            mobile_robot,
            boot,
            seq,
            ..
        } = signal;
        let origin = format!("{mobile_robot}/{boot}/{seq}");
        let mut own = self.cell.book.jobs.values();
        // One at a time for each mobile robot; and never twice for one signal, whatever made it come back.
        let earlier = own.find(|j| {
            j.trigger.as_deref() == Some(&trigger.id)
                && (j.origin.as_ref() == Some(&origin)
                    || !j.state.is_final() && j.signaled_by(mobile_robot))
        });
        if let Some(earlier) = earlier {
            return Err(format!("its job {} is not over", earlier.id));
        }
        let empty = signal.state.loads.as_ref().is_some_and(Vec::is_empty);
        if empty && trigger.job.workflow == Workflow::DeliveryAndPlacement {
            return Err(format!("{mobile_robot} carries nothing"));
        }
        let mut spec = trigger.job.clone();
        let _named = spec
            .mobile_robot
            .get_or_insert_with(|| mobile_robot.clone());
        spec.deadline = trigger.deadline_ms.map(|ms| self.now.saturating_add(ms));
        let from = (trigger.id.clone(), origin);
        match self.create_for(spec, Some(from)) {
            Ok(_job) => Ok(()),
            // The signal itself was fine; the job does not fit what is so now.
            Err(refusal @ (Refusal::Invalid { .. } | Refusal::Conflict { .. })) => {
                Err(refusal.to_string())
            }
            Err(refusal) => Err(format!("no job: {refusal}")),
        }
    }
}
