//! Variables that count milliseconds.

use std::time::Duration;

use super::cell::{Address, Cell};

/// The variables that `CONNECT TIMER TO` named.
///
/// Time passes only between slices, so bringing them up to date at the start of each is exact.
///
/// ASSUMPTION: a timer that reaches the largest INTEGER stays there; one without a value stays
/// without.
#[derive(Debug, Default)]
pub(crate) struct Timers(Vec<Timer>);

#[derive(Debug)]
struct Timer {
    at: Address,
    /// Up to here the milliseconds are in the variable.
    counted: Duration,
}

impl Timers {
    pub(crate) fn connect(&mut self, at: Address, now: Duration) {
        if self.0.iter().all(|timer| timer.at != at) {
            self.0.push(Timer { at, counted: now });
        }
    }

    pub(crate) fn disconnect(&mut self, at: Address) {
        self.0.retain(|timer| timer.at != at);
    }

    pub(crate) fn clear(&mut self) {
        self.0.clear();
    }

    /// Adds what has passed to every timer.
    pub(crate) fn follow(&mut self, now: Duration, globals: &mut [Cell]) {
        for timer in &mut self.0 {
            let passed = now.saturating_sub(timer.counted).as_millis();
            let Ok(passed) = u64::try_from(passed) else {
                continue;
            };
            if passed == 0 {
                continue;
            }
            timer.counted += Duration::from_millis(passed);
            if let Some(Cell::Integer(value)) = globals.get_mut(timer.at.global_index()) {
                *value = value.saturating_add(i32::try_from(passed).unwrap_or(i32::MAX));
            }
        }
    }
}
