//! Durations, and what is said of many.

use std::time::Duration;

/// Durations in no order.
#[derive(Clone, Debug, Default)]
pub(crate) struct Latencies(Vec<Duration>);

impl Latencies {
    pub(crate) fn push(&mut self, one: Duration) {
        self.0.push(one);
    }

    pub(crate) fn add(&mut self, mut others: Self) {
        self.0.append(&mut others.0);
    }

    pub(crate) fn count(&self) -> usize {
        self.0.len()
    }

    /// The median, the 99th percentile and the largest, in milliseconds; absent where there are none.
    pub(crate) fn summary(&self) -> Option<Summary> {
        let mut sorted = self.0.clone();
        sorted.sort_unstable();
        let millis = |index: usize| {
            let last = sorted.len().checked_sub(1)?;
            sorted
                .get(index.min(last))
                .map(|one| one.as_secs_f64() * 1e3)
        };
        Some(Summary {
            p50: millis(sorted.len() / 2)?,
            p99: millis(sorted.len() * 99 / 100)?,
            max: millis(usize::MAX)?,
        })
    }
}

/// Milliseconds.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Summary {
    pub(crate) p50: f64,
    pub(crate) p99: f64,
    pub(crate) max: f64,
}
