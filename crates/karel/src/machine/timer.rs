//! Variables that count milliseconds.

use std::time::Duration;

use super::cell::{Address, Cell};
use crate::tp::TimerAction;

/// The variables that `CONNECT TIMER TO` named.
///
/// Time passes only between slices, so bringing them up to date at the start of each is exact.
///
/// ASSUMPTION: a timer that reaches the largest INTEGER stays there; one without a value stays
/// without.
#[derive(Debug, Default)]
pub(crate) struct Timers {
    variables: Vec<Timer>,
    /// `TIMER[1]` and so on of TP programs.
    watches: [Watch; Timers::WATCHES],
}

/// A timer of TP programs.
#[derive(Clone, Copy, Debug, Default)]
struct Watch {
    counted: Duration,
    /// Running since.
    since: Option<Duration>,
}

#[derive(Debug)]
struct Timer {
    at: Address,
    /// Up to here the milliseconds are in the variable.
    counted: Duration,
}

impl Timers {
    /// How many `TIMER[n]` there are.
    ///
    /// ASSUMPTION: as many as a controller has when it is delivered. They are 0 after power-on.
    pub(crate) const WATCHES: usize = 10;

    /// `TIMER[n]=START` and its sisters. `None` if there is no such timer.
    ///
    /// ASSUMPTION: a START goes on from what was counted, a RESET stops and sets to 0.
    pub(crate) fn act(&mut self, n: i32, action: TimerAction, now: Duration) -> Option<()> {
        let watch = self.watches.get_mut(index(n)?)?;
        let counted = watch.at(now);
        *watch = match action {
            TimerAction::Start => Watch {
                counted,
                since: Some(now),
            },
            TimerAction::Stop => Watch {
                counted,
                since: None,
            },
            TimerAction::Reset => Watch::default(),
        };
        Some(())
    }

    /// What `TIMER[n]` has counted.
    pub(crate) fn watch(&self, n: i32, now: Duration) -> Option<Duration> {
        Some(self.watches.get(index(n)?)?.at(now))
    }

    pub(crate) fn connect(&mut self, at: Address, now: Duration) {
        if self.variables.iter().all(|timer| timer.at != at) {
            self.variables.push(Timer { at, counted: now });
        }
    }

    pub(crate) fn disconnect(&mut self, at: Address) {
        self.variables.retain(|timer| timer.at != at);
    }

    pub(crate) fn clear(&mut self) {
        *self = Timers::default();
    }

    /// Adds what has passed to every timer.
    pub(crate) fn follow(&mut self, now: Duration, globals: &mut [Cell]) {
        for timer in &mut self.variables {
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

impl Watch {
    fn at(&self, now: Duration) -> Duration {
        let running = self
            .since
            .map_or(Duration::ZERO, |since| now.saturating_sub(since));
        self.counted.saturating_add(running)
    }
}

fn index(n: i32) -> Option<usize> {
    usize::try_from(n).ok()?.checked_sub(1)
}
