//! What can be looked at from outside.

use super::Controller;
use crate::alarms::Alarm;
use crate::devices::FileName;
use crate::ledger::LedgerEntry;

impl Controller {
    /// The registers of the controller: `R[n]`, `SR[n]`, `PR[n]`.
    #[must_use]
    pub fn registers(&self) -> &karel::Registers {
        self.machine.registers()
    }

    /// The files of the devices, `RD:`, `MC:` and so on.
    #[must_use]
    pub fn files(&self) -> Vec<(FileName, Vec<u8>)> {
        let files = self.hardware.devices.files();
        files
            .map(|(name, bytes)| (name.clone(), bytes.to_vec()))
            .collect()
    }

    /// Where the joints are, in degrees.
    #[must_use]
    pub fn joints_deg(&self) -> [f64; 6] {
        self.hardware.executor.joints(self.hardware.now).degrees()
    }

    /// Ledger entries above the number `after`, oldest first.
    #[must_use]
    pub fn ledger(&self, after: u64) -> Vec<LedgerEntry> {
        self.hardware.ledger.after(after).cloned().collect()
    }

    /// How many ledger entries were dropped.
    #[must_use]
    pub fn ledger_dropped(&self) -> u64 {
        self.hardware.ledger.dropped()
    }

    /// The alarms, oldest first.
    #[must_use]
    pub fn alarms(&self) -> Vec<Alarm> {
        self.hardware.alarms.iter().cloned().collect()
    }

    /// How many alarms were dropped.
    #[must_use]
    pub fn alarms_dropped(&self) -> u64 {
        self.hardware.alarms.dropped()
    }

    /// The last lines that programs wrote to the pendant's USER screen.
    #[must_use]
    pub fn screen(&self) -> Vec<String> {
        self.hardware.screen.iter().cloned().collect()
    }
}
