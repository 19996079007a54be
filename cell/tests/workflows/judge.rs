//! What has to be true after any number of crashes, by the emulators' own accounts.

use std::time::Duration;

use mobile_emulator::LedgerEvent;
use serde_json::Value;

use crate::kit::TestCell;
use crate::operator::location;

/// States of a session with a permit.
const PERMITS: [&str; 4] = [
    "access_granted",
    "positioned",
    "transferring",
    "exit_granted",
];
const LOADS: [&str; 4] = ["load-1", "load-2", "load-3", "load-4"];

/// What the crashes of a job met.
#[derive(Debug, Default)]
pub(crate) struct Story {
    /// Permits that were out.
    pub(crate) permits_withdrawn: usize,
    /// Operations of the arm that were under way.
    pub(crate) asked_after: usize,
}

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

    /// What the journal tells of a job. After each start all permits are withdrawn in the same record as the recovery
    /// itself; and no operation begins before it is known how the one before it ended.
    pub(crate) async fn assert_story(&self, job: &str) -> Story {
        let events = self.story(job).await;
        let (mut open, mut session) = (false, String::new());
        let mut story = Story::default();
        for (index, event) in events.iter().enumerate() {
            let text = event["text"].as_str().unwrap();
            match event["kind"].as_str().unwrap() {
                "op_started" => {
                    assert!(!open, "{text}: the one before has no end: {events:#?}");
                    open = true;
                }
                "op_ended" => open = false,
                "session_moved" => session = text.to_lowercase(),
                "op_reconciling" => story.asked_after += 1,
                "recovered" if PERMITS.iter().any(|state| session.contains(state)) => {
                    let faulted = events.iter().skip(index + 1).any(|next| {
                        let text = next["text"].as_str().unwrap().to_lowercase();
                        record(next) == record(event)
                            && next["kind"] == "session_moved"
                            && text.contains("faulted")
                    });
                    assert!(faulted, "{session}: a permit outlived a crash: {events:#?}");
                    story.permits_withdrawn += 1;
                }
                _ => {}
            }
        }
        assert!(!open, "{events:#?}");
        story
    }

    pub(crate) async fn story(&self, job: &str) -> Vec<Value> {
        let (mut all, mut cursor) = (Vec::new(), String::new());
        loop {
            let page = self
                .get(&format!("/jobs/{job}/events?limit=200{cursor}"))
                .await;
            all.extend(page["events"].as_array().cloned().unwrap_or_default());
            match page["next_cursor"].as_str() {
                Some(next) => cursor = format!("&cursor={next}"),
                None => return all,
            }
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

/// The record of the journal that an event stands in.
fn record(event: &Value) -> &str {
    let id = event["id"].as_str().unwrap();
    id.split_once(['.', '-', ':'])
        .map_or(id, |(record, _)| record)
}
