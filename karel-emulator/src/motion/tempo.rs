//! How fast path time goes: the override, a hold and a stop change it gradually, never by a jump.

use std::time::Duration;

use planning::State;
use planning::jerk::SpeedChange;

use super::duration_from_secs_rounded_up;

/// Path time as a function of controller time. Its rate is 1 at an override of 100 % and changes smoothly to a new one.
///
/// The arm's path is a function of path time alone, so whatever the rate does, the arm stays on its path.
#[derive(Clone, Copy, Debug)]
pub(super) struct Tempo {
    since: Duration,
    /// Of path time, s, and its rate.
    change: SpeedChange,
}

/// How quickly the rate may change.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Agility {
    /// How long it takes from 1 to 0, s.
    pub(super) seconds: f64,
    /// For how much of that the deceleration builds up, s; at most half.
    pub(super) bend: f64,
}

impl Tempo {
    /// Path time 0 at `now`, with this rate.
    pub(super) fn new(now: Duration, rate: f64) -> Self {
        Self {
            since: now,
            change: SpeedChange::steady(0.0, rate),
        }
    }

    /// Path time, s.
    pub(super) fn time(&self, now: Duration) -> f64 {
        self.state(now).position
    }

    pub(super) fn rate(&self, now: Duration) -> f64 {
        self.state(now).velocity
    }

    fn state(&self, now: Duration) -> State {
        let state = self.change.at(seconds_between(self.since, now));
        State {
            velocity: state.velocity.max(0.0),
            ..state
        }
    }

    /// From `now` on the rate goes to `target`.
    pub(super) fn change(&mut self, now: Duration, target: f64, agility: Agility) {
        let mut state = self.state(now);
        let slope = 1.0 / (agility.seconds - agility.bend);
        let mut jerk = slope / agility.bend;
        // Time neither runs backwards nor faster than wanted, however hard the change before this one was.
        let fastest = self.change.target().max(target).max(state.velocity);
        let room = if state.acceleration < 0.0 {
            state.velocity
        } else {
            fastest - state.velocity
        };
        let needed = 0.5 * state.acceleration * state.acceleration / room;
        if needed.is_finite() {
            jerk = jerk.max(needed);
        } else {
            state.acceleration = 0.0;
        }
        *self = Self {
            since: now.max(self.since),
            change: SpeedChange::new(state, target, slope, jerk),
        };
    }

    /// When this path time is reached; never, if the rate goes to 0 before.
    pub(super) fn reaches(&self, path_time: f64) -> Option<Duration> {
        let seconds = self.change.reaches(path_time)?;
        Some(self.after(seconds))
    }

    /// When path time stands still; `None` if it is not on its way to that.
    pub(super) fn rests(&self) -> Option<Duration> {
        (self.change.target() <= 0.0).then(|| self.after(self.change.duration()))
    }

    fn after(&self, seconds: f64) -> Duration {
        if seconds <= 0.0 {
            return self.since;
        }
        let later = duration_from_secs_rounded_up(seconds);
        self.since.saturating_add(later)
    }
}

fn seconds_between(earlier: Duration, later: Duration) -> f64 {
    later.saturating_sub(earlier).as_secs_f64()
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    /// From 1 to 0 in so many seconds; the deceleration builds up for a third of them.
    fn within(seconds: f64) -> Agility {
        Agility {
            seconds,
            bend: seconds / 3.0,
        }
    }

    proptest! {
        #[test]
        fn a_path_time_is_reached_when_it_is_said_to_be(
            rate in 0.0..1.0f64, target in 0.0..1.0f64, seconds in 0.005..10.0f64, left in 0.0..5.0f64,
        ) {
            let mut tempo = Tempo::new(Duration::from_secs(3), rate);
            tempo.change(Duration::from_secs(4), target, within(seconds));
            let wanted = rate + left;
            match tempo.reaches(wanted) {
                Some(when) => prop_assert!((tempo.time(when) - wanted).abs() < 1e-6),
                None => prop_assert!(target <= 0.0 && tempo.time(Duration::from_secs(99)) <= wanted),
            }
        }

        /// However often, and however hard, it is changed.
        #[test]
        fn neither_path_time_nor_its_rate_jumps(
            changes in prop::collection::vec((0.0..1.5f64, 0.0..1.0f64, 0.008..2.0f64), 1..6),
        ) {
            let mut tempo = Tempo::new(Duration::ZERO, 1.0);
            let mut now = Duration::ZERO;
            let mut before = (0.0, 1.0);
            let step = Duration::from_micros(500);
            for (wait, target, seconds) in changes {
                tempo.change(now, target, within(seconds));
                let until = now + Duration::from_secs_f64(wait);
                while now < until {
                    let (time, rate) = (tempo.time(now), tempo.rate(now));
                    let way = time - before.0;
                    prop_assert!((-1e-9..=5.1e-4).contains(&way), "{way}");
                    prop_assert!((0.0..=1.0 + 1e-9).contains(&rate));
                    // At most 1 / (2/3 of 8 ms) each second.
                    prop_assert!((rate - before.1).abs() <= 0.0005 * 1.5 / 0.008 + 1e-6);
                    before = (time, rate);
                    now += step;
                }
            }
        }
    }

    #[test]
    fn a_brake_comes_to_rest_and_stays_there() {
        let mut tempo = Tempo::new(Duration::ZERO, 1.0);
        tempo.change(Duration::from_secs(1), 0.0, within(0.25));
        let rest = tempo.rests().unwrap();
        assert!((rest.as_secs_f64() - 1.25).abs() < 1e-6);
        assert!((tempo.time(rest) - 1.125).abs() < 1e-6);
        assert!((tempo.time(Duration::from_secs(50)) - 1.125).abs() < 1e-6);
        assert_eq!(tempo.reaches(2.0), None);
    }
}
