//! The faults that are set, and which of them holds now.

use std::time::Duration;

use api::SignalName;
use serde::Serialize;

use crate::error::Refusal;
use crate::fault::{Fault, Lasting, MAX_FAULTS, SignalFault};

/// A fault that is set.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct ActiveFault {
    /// Counts up with each fault.
    pub id: u64,
    /// The robot's time when it was set.
    pub since_s: f64,
    /// The fault, with what is left of its counts.
    #[serde(flatten)]
    pub fault: Fault,
    #[serde(skip)]
    until: Option<Duration>,
}

/// Whether a fault is over once it was used.
#[derive(Clone, Copy, Debug, Eq, PartialEq)]
pub(crate) enum Used {
    /// It holds again.
    Keep,
    /// It is over.
    Up,
}

#[derive(Clone, Debug, Default)]
pub(crate) struct FaultBook {
    count: u64,
    active: Vec<ActiveFault>,
}

impl FaultBook {
    /// Keeps a fault, if it is one that lasts or waits. Its number.
    pub(crate) fn set(&mut self, fault: Fault, now: Duration) -> Result<u64, Refusal> {
        if self.active.len() >= MAX_FAULTS {
            return Err(Refusal::Value {
                item: "number of faults",
                value: (self.active.len() + 1).to_string(),
                limit: format!("at most {MAX_FAULTS}; clear some"),
            });
        }
        self.count += 1;
        let until = match fault.lasts() {
            Lasting::AtOnce => return Ok(self.count),
            Lasting::UntilUsed => None,
            Lasting::For(seconds) => seconds
                .and_then(|seconds| Duration::try_from_secs_f64(seconds).ok())
                .map(|time| now.saturating_add(time)),
        };
        self.active.push(ActiveFault {
            id: self.count,
            since_s: now.as_secs_f64(),
            fault,
            until,
        });
        Ok(self.count)
    }

    /// Drops those whose time is over. Whether there were any.
    pub(crate) fn expire(&mut self, now: Duration) -> bool {
        let before = self.active.len();
        self.active
            .retain(|active| active.until.is_none_or(|until| now < until));
        self.active.len() != before
    }

    pub(crate) fn clear(&mut self) -> usize {
        let count = self.active.len();
        self.active.clear();
        count
    }

    pub(crate) fn any(&self, wanted: impl Fn(&Fault) -> bool) -> bool {
        self.active.iter().any(|active| wanted(&active.fault))
    }

    pub(crate) fn iter(&self) -> impl Iterator<Item = &Fault> {
        self.active.iter().map(|active| &active.fault)
    }

    pub(crate) fn list(&self) -> Vec<ActiveFault> {
        self.active.clone()
    }

    /// Uses the first fault that `take` wants.
    pub(crate) fn use_first<T>(
        &mut self,
        mut take: impl FnMut(&mut Fault) -> Option<(T, Used)>,
    ) -> Option<T> {
        let mut found = None;
        for (index, active) in self.active.iter_mut().enumerate() {
            if let Some((value, used)) = take(&mut active.fault) {
                found = Some((index, value, used));
                break;
            }
        }
        let (index, value, used) = found?;
        if used == Used::Up {
            let _over = self.active.remove(index);
        }
        Some(value)
    }

    /// Uses the faults that are due for a signal of this name, and counts the others down.
    pub(crate) fn for_signal(&mut self, name: SignalName) -> Vec<SignalFault> {
        let mut due = Vec::new();
        self.active.retain_mut(|active| {
            let Some(found) = active.fault.of_signal() else {
                return true;
            };
            if found.signal.is_some_and(|wanted| wanted != name) {
                return true;
            }
            match found.nth {
                Some(n) if *n > 1 => {
                    *n -= 1;
                    true
                }
                Some(_) | None => {
                    due.push(found.fault);
                    false
                }
            }
        });
        due
    }

    /// When the next fault is over by itself.
    pub(crate) fn next_end(&self) -> Option<Duration> {
        self.active.iter().filter_map(|active| active.until).min()
    }
}

/// Counts a fault down that happens so many times.
pub(crate) fn one_less(times: &mut u32) -> Used {
    *times = times.saturating_sub(1);
    if *times == 0 { Used::Up } else { Used::Keep }
}
