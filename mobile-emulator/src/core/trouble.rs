//! Faults, hands on the robot, loads, and the battery.

use std::time::Duration;

use api::{MobileErrorLevel, OperatingMode, SignalName};

use super::Core;
use crate::error::Refusal;
use crate::fault::{Fault, SlipMoment};
use crate::ledger::{DriveEnd, LedgerEvent, OrderOutcome, Violation};
use crate::outbound::Outbound;

impl Core {
    /// Sets a fault. Its number.
    pub(crate) fn set_fault(&mut self, fault: Fault) -> Result<u64, Refusal> {
        fault.check()?;
        if let Fault::LoadMissing { slot }
        | Fault::LoadWrong { slot, .. }
        | Fault::LoadExtra { slot, .. }
        | Fault::MisreportLoad { slot, .. } = &fault
        {
            self.slots.check(slot)?;
        }
        let mut fault = fault;
        if let Fault::DrivesOff { after_s } = &mut fault {
            // The book counts from the moment it docked.
            let docked = self.mission.as_ref().and_then(|mission| mission.docked_at);
            *after_s += docked.map_or(0.0, |at| self.now.saturating_sub(at).as_secs_f64());
        }
        let mut late_now = false;
        if let Fault::Late { delay_s } = &fault
            && self.driving()
        {
            self.be_late(*delay_s);
            late_now = true;
        }
        let id = if late_now {
            // It holds already.
            0
        } else {
            self.faults.set(fault.clone(), self.now)?
        };
        self.note(LedgerEvent::FaultSet {
            id,
            fault: fault.clone(),
        });
        self.happen(fault)?;
        self.refresh_obstacles();
        self.pump();
        Ok(id)
    }

    /// Ends all faults that last or wait.
    pub(crate) fn clear_faults(&mut self) -> usize {
        let count = self.faults.clear();
        self.late_until = None;
        self.clear_error("LOCALIZATION_LOST");
        self.note(LedgerEvent::FaultsCleared { count });
        self.refresh_obstacles();
        self.pump();
        count
    }

    /// What a fault does at once.
    #[expect(
        clippy::wildcard_enum_match_arm,
        reason = "all others wait for their moment, or are asked for"
    )]
    fn happen(&mut self, fault: Fault) -> Result<(), Refusal> {
        match fault {
            Fault::Slip {
                forward_mm,
                left_mm,
                turn_deg,
                when: SlipMoment::Now,
                noticed,
            } => self.slip((forward_mm, left_mm, turn_deg), noticed),
            Fault::Unlocalized { .. } => self.raise(
                MobileErrorLevel::Fatal,
                "LOCALIZATION_LOST",
                "the robot does not know where it is",
            ),
            Fault::Mode { mode } => self.set_mode(mode),
            Fault::Crash { down_s } => self.crash(down_s),
            Fault::Battery { percent } => {
                self.charge = percent;
                self.watch_battery();
            }
            Fault::LoadMissing { slot } => {
                let load = self.slots.take(&slot)?;
                // Unseen: a load that fell off tells nobody.
                self.note(LedgerEvent::LoadTaken { slot, load });
            }
            Fault::LoadWrong { slot, load } => {
                let before = self.slots.take(&slot)?;
                if let Err(refused) = self.slots.put(&slot, &load) {
                    let _as_before = self.slots.put(&slot, &before);
                    return Err(refused);
                }
                self.note(LedgerEvent::LoadTaken {
                    slot: slot.clone(),
                    load: before,
                });
                self.note(LedgerEvent::LoadPut { slot, load });
            }
            Fault::LoadExtra { slot, load } => {
                self.slots.put(&slot, &load)?;
                self.note(LedgerEvent::LoadPut { slot, load });
            }
            _ => {}
        }
        Ok(())
    }

    fn set_mode(&mut self, mode: OperatingMode) {
        if self.down_until.is_some() {
            self.mode = mode;
            return;
        }
        if mode == self.mode {
            return;
        }
        self.mode = mode;
        self.note(LedgerEvent::Mode { mode });
        match mode {
            // ASSUMPTION: as in VDA 5050, an order does not outlive manual operation.
            OperatingMode::Manual | OperatingMode::Service => {
                self.signal(SignalName::MrMode);
                self.end_order(OrderOutcome::Lost);
            }
            OperatingMode::Automatic | OperatingMode::Semiautomatic | OperatingMode::Intervened => {
                self.signal(SignalName::MrMode);
            }
        }
    }

    fn crash(&mut self, down_s: f64) {
        if self.down_until.is_some() {
            return;
        }
        let down = Duration::try_from_secs_f64(down_s).unwrap_or_default();
        // ASSUMPTION: orders and permits live in its memory; mode switch, loads and orders that are over do not.
        self.note(LedgerEvent::Crashed { boot: self.boot });
        self.end_drive(DriveEnd::Disabled);
        self.end_order(OrderOutcome::Lost);
        self.down_until = Some(self.now.saturating_add(down));
        self.seen = 0;
        self.paused = false;
        self.errors.clear();
        self.at_point = None;
        self.visits = None;
        self.late_until = None;
        self.stuck_since = None;
        self.cell_away = false;
        self.boot += 1;
        self.outbound = Outbound::new(self.boot, self.plan.backoff);
        self.sends.clear();
    }

    /// Whether it has no power; starts it when it is time.
    pub(super) fn down(&mut self) -> bool {
        let Some(until) = self.down_until else {
            return false;
        };
        if self.now < until {
            return true;
        }
        self.down_until = None;
        // It looks around where it stands.
        self.motion.measure();
        self.note(LedgerEvent::Booted { boot: self.boot });
        self.next_heartbeat = self.now;
        self.watch_battery();
        false
    }

    /// Puts a load into a slot, as an arm does.
    pub(crate) fn put(&mut self, slot: &str, load: &str) -> Result<(), Refusal> {
        self.slots.put(slot, load)?;
        self.note(LedgerEvent::LoadPut {
            slot: slot.to_owned(),
            load: load.to_owned(),
        });
        self.load_changed();
        Ok(())
    }

    /// Takes what lies in a slot, as an arm does.
    pub(crate) fn take(&mut self, slot: &str) -> Result<String, Refusal> {
        let load = self.slots.take(slot)?;
        self.note(LedgerEvent::LoadTaken {
            slot: slot.to_owned(),
            load: load.clone(),
        });
        self.load_changed();
        Ok(load)
    }

    fn load_changed(&mut self) {
        let _forget = self.caught.remove("load");
        if self.motion.moved() {
            let detail = "the robot moved at that moment".to_owned();
            self.catch("load", Violation::LoadMovedWhileDriving, detail);
        } else if self.mission.as_ref().is_some_and(|mission| mission.permit) {
            let detail = "the robot might have driven off at any moment".to_owned();
            self.catch("load", Violation::LoadMovedUnderMovePermit, detail);
        }
        if self.down_until.is_none() {
            self.signal(SignalName::LoadChanged);
            self.pump();
        }
    }

    pub(super) fn drain(&mut self, percent: f64) {
        self.charge = (self.charge - percent).max(0.0);
        self.watch_battery();
    }

    fn watch_battery(&mut self) {
        let (charge, battery) = (self.charge, &self.plan.battery);
        let (low, empty) = (battery.low_percent, battery.empty_percent);
        if charge > low {
            if !self.errors.is_empty() {
                self.clear_error("BATTERY_LOW");
                self.clear_error("BATTERY_EMPTY");
            }
            return;
        }
        if self.down_until.is_some() {
            return;
        }
        if charge <= empty {
            let description = format!("{charge:.1} %; it stands at {empty} %");
            self.raise(MobileErrorLevel::Fatal, "BATTERY_EMPTY", &description);
        } else {
            let description = format!("{charge:.1} %; low is {low} %");
            self.raise(MobileErrorLevel::Warning, "BATTERY_LOW", &description);
        }
    }
}
