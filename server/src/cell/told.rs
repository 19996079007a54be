use std::collections::{BTreeMap, HashMap};
use std::sync::{Arc, Mutex, PoisonError};

use jiff::Timestamp;

use crate::journal::{Keeps, SharedJournal};

/// As many as an outbox holds: older messages are not in it any more.
const REMEMBERED: usize = 256;

/// When each message to a mobile robot was written, and how messages are numbered.
#[derive(Clone, Debug)]
pub(super) struct TellTimes {
    /// What the cell's numbers are counted from.
    first: u64,
    times: Arc<Mutex<HashMap<String, BTreeMap<u64, Timestamp>>>>,
}

impl TellTimes {
    /// Of a cell that begins with what `journal` knows.
    ///
    /// A mobile robot takes a message only if its number is above those it has. A journal that ends with the process
    /// begins with 1 again, so there numbers are counted from the time of the start.
    pub(super) fn of(journal: &SharedJournal, now: Timestamp) -> Self {
        let first = match journal.keeps() {
            Keeps::OverRestarts => 0,
            Keeps::UntilTheEnd => {
                // Up to the year 2255 this is a whole number in every program that reads JSON.
                u64::try_from(now.as_millisecond()).unwrap_or(0) * 1_000
            }
        };
        Self {
            first,
            times: Arc::default(),
        }
    }

    pub(super) fn first(&self) -> u64 {
        self.first
    }

    pub(super) fn note(&self, mobile_robot: &str, n: u64, at: Timestamp) {
        let mut times = self.times.lock().unwrap_or_else(PoisonError::into_inner);
        let of_robot = times.entry(mobile_robot.to_owned()).or_default();
        let _first = of_robot.insert(n, at);
        while of_robot.len() > REMEMBERED {
            let _oldest = of_robot.pop_first();
        }
    }

    pub(super) fn at(&self, mobile_robot: &str, n: u64) -> Option<Timestamp> {
        let times = self.times.lock().unwrap_or_else(PoisonError::into_inner);
        times.get(mobile_robot)?.get(&n).copied()
    }
}
