//! Switching the controller off and on.

use karel::Status;

use super::Controller;
use crate::alarms::Severity;

/// SYST-026: the controller was switched on and all is well.
const SYST_POWER_UP: Status = Status::new(24, 26);

/// SYST-997: a program that runs from power-on does not start. A number of our own.
const SYST_NOT_STARTED: Status = Status::new(24, 997);

/// What is left of the memory that a battery keeps.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum CmosMemory {
    /// All of it: variables `IN CMOS`, registers, system variables.
    Kept,
    /// Nothing, as after a battery was changed too late.
    Lost,
}

impl Controller {
    /// Switches off and on at once: connections end, the arm brakes, programs start anew.
    ///
    /// Time goes on; the ledger and the alarm history are those of whoever watches, and stay.
    ///
    /// ASSUMPTION: the programs that run are started again at power-on, as if they were set up so; the brakes
    /// take as long as those of an abort.
    pub fn power_cycle(&mut self, memory: CmosMemory) {
        self.power_off(memory);
        self.power_on();
    }

    /// Switches off: connections end, the arm brakes, tasks are gone.
    pub(super) fn power_off(&mut self, memory: CmosMemory) {
        for task in std::mem::take(&mut self.tasks) {
            self.hardware.release_ports(task.id);
        }
        self.hardware.power_cycle(memory);
        let kept = self.machine.export_cmos();
        self.machine.power_cycle();
        if memory == CmosMemory::Kept {
            for variable in self.machine.import_cmos(&kept) {
                tracing::warn!("The variable {variable} was not kept.");
            }
        }
        if let Some(remote) = &mut self.remote {
            remote.forget();
        }
        self.end_wedges();
    }

    /// Switches on: the programs start that are set up so.
    pub(super) fn power_on(&mut self) {
        self.off_until = None;
        self.power_cycles += 1;
        self.hardware.post(
            SYST_POWER_UP,
            "System normal power up".to_owned(),
            Severity::Warn,
        );
        for name in self.run.clone() {
            if let Err(error) = self.start_task(&name) {
                let text = format!("The program {name} does not start: {error}");
                self.hardware.post(SYST_NOT_STARTED, text, Severity::Warn);
            }
        }
        self.follow_tasks();
    }
}
