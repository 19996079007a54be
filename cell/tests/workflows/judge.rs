//! What has to be true after any number of crashes, by the emulators' own accounts.

use std::time::Duration;

use mobile_emulator::LedgerEvent;

use crate::kit::TestCell;
use crate::operator::location;

const LOADS: [&str; 4] = ["load-1", "load-2", "load-3", "load-4"];

impl TestCell {
    /// Nothing twice, nothing out of order, every load where it is said to be, no violation of a mobile robot.
    pub(crate) async fn assert_sound(&self) {
        self.assert_nothing_twice().await;
        self.assert_no_violation().await;
        for load in LOADS {
            // A mobile robot says a moment later what was put onto it.
            let what = format!(
                "custody of {load} is where it truly is, {:?}",
                self.truly_at(load)
            );
            self.wait(&what, Duration::from_secs(5), async |cell| {
                let said = cell.custody(load).await["location"].clone();
                let is = location(&cell.truly_at(load));
                // A destination has several names; away is away.
                (said == is || said["at"] == "DELIVERED" && is["at"] == "DELIVERED").then_some(())
            })
            .await;
        }
    }

    pub(crate) async fn assert_no_violation(&self) {
        for robot in self.assembly.plant().mobile_robots() {
            let ledger = robot.ledger().await.unwrap();
            let violations: Vec<_> = ledger
                .iter()
                .filter(|entry| matches!(entry.event, LedgerEvent::Violation { .. }))
                .collect();
            assert!(violations.is_empty(), "{violations:#?}");
        }
    }
}
