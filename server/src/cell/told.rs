use std::collections::{BTreeMap, HashMap};
use std::sync::{Arc, Mutex, PoisonError};

use jiff::Timestamp;
use serde::{Deserialize, Serialize};

use crate::journal::{Keeps, SharedJournal};

/// As many as an outbox holds: older messages are not in it any more.
const REMEMBERED: usize = 256;

/// When messages were written, as it is kept with a snapshot.
#[derive(Debug, Serialize, Deserialize)]
pub(super) struct KeptTimes(BTreeMap<String, BTreeMap<u64, Timestamp>>);

/// When each message to a mobile robot was written, and each was last heard; and how messages are numbered.
#[derive(Clone, Debug)]
pub(super) struct TellTimes {
    /// What the cell's numbers are counted from.
    first: u64,
    robots: Arc<Mutex<HashMap<String, Times>>>,
}

#[derive(Debug, Default)]
struct Times {
    written: BTreeMap<u64, Timestamp>,
    heard: Option<Timestamp>,
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
            robots: Arc::default(),
        }
    }

    pub(super) fn first(&self) -> u64 {
        self.first
    }

    pub(super) fn note(&self, mobile_robot: &str, n: u64, at: Timestamp) {
        self.with(mobile_robot, |times| {
            let _first = times.written.insert(n, at);
            while times.written.len() > REMEMBERED {
                let _oldest = times.written.pop_first();
            }
        });
    }

    pub(super) fn at(&self, mobile_robot: &str, n: u64) -> Option<Timestamp> {
        self.with(mobile_robot, |times| times.written.get(&n).copied())
    }

    pub(super) fn heard(&self, mobile_robot: &str, at: Timestamp) {
        self.with(mobile_robot, |times| times.heard = Some(at));
    }

    pub(super) fn heard_at(&self, mobile_robot: &str) -> Option<Timestamp> {
        self.with(mobile_robot, |times| times.heard)
    }

    /// When the messages that are remembered were written, for a snapshot.
    pub(super) fn kept(&self) -> KeptTimes {
        let robots = self.robots.lock().unwrap_or_else(PoisonError::into_inner);
        let times = robots.iter();
        KeptTimes(
            times
                .map(|(robot, times)| (robot.clone(), times.written.clone()))
                .collect(),
        )
    }

    /// Takes up what was kept.
    pub(super) fn take_up(&self, KeptTimes(kept): KeptTimes) {
        for (robot, written) in kept {
            self.with(&robot, |times| times.written = written);
        }
    }

    /// Only of robots of the set-up, so there are not more of them.
    fn with<T>(&self, mobile_robot: &str, then: impl FnOnce(&mut Times) -> T) -> T {
        let mut robots = self.robots.lock().unwrap_or_else(PoisonError::into_inner);
        then(robots.entry(mobile_robot.to_owned()).or_default())
    }
}
