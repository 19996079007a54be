//! How fast path time goes: the override, a hold and a stop change it gradually, never by a jump.

use std::time::Duration;

use super::duration_from_secs_rounded_up;

/// Path time as a function of controller time. Its rate is 1 at an override of 100 % and goes linearly to a new one.
///
/// The arm's path is a function of path time alone, so whatever the rate does, the arm stays on its path.
#[derive(Clone, Copy, Debug)]
pub(super) struct Tempo {
    since: Duration,
    /// Path time at `since`, s.
    at: f64,
    /// Rate at `since`.
    rate: f64,
    target: f64,
    /// Of the rate on its way to the target, 1/s, with its sign.
    slope: f64,
}

impl Tempo {
    /// Path time 0 at `now`, with this rate.
    pub(super) fn new(now: Duration, rate: f64) -> Self {
        Self {
            since: now,
            at: 0.0,
            rate,
            target: rate,
            slope: 0.0,
        }
    }

    /// Path time, s.
    pub(super) fn time(&self, now: Duration) -> f64 {
        let t = seconds_between(self.since, now);
        let ramp = self.ramp();
        let within = t.min(ramp);
        let way = within * (self.rate + 0.5 * self.slope * within);
        self.at + way + (t - within) * self.target
    }

    pub(super) fn rate(&self, now: Duration) -> f64 {
        let t = seconds_between(self.since, now);
        if t >= self.ramp() {
            self.target
        } else {
            self.rate + self.slope * t
        }
    }

    /// From `now` on the rate goes to `target` by `slope` (1/s, without a sign) each second.
    pub(super) fn change(&mut self, now: Duration, target: f64, slope: f64) {
        let (at, rate) = (self.time(now), self.rate(now));
        *self = Self {
            since: now.max(self.since),
            at,
            rate,
            target,
            slope: slope.abs().copysign(target - rate),
        };
    }

    /// When this path time is reached; never, if the rate goes to 0 before.
    pub(super) fn reaches(&self, path_time: f64) -> Option<Duration> {
        let left = (path_time - self.at).max(0.0);
        let ramp = self.ramp();
        let on_ramp = 0.5 * ramp * (self.rate + self.target);
        let seconds = if left <= on_ramp {
            let root = (self.rate * self.rate + 2.0 * self.slope * left).max(0.0);
            let divisor = self.rate + root.sqrt();
            if divisor > 0.0 {
                2.0 * left / divisor
            } else {
                0.0
            }
        } else if self.target > 0.0 {
            ramp + (left - on_ramp) / self.target
        } else {
            return None;
        };
        Some(self.after(seconds))
    }

    /// When path time stands still; `None` if it is not on its way to that.
    pub(super) fn rests(&self) -> Option<Duration> {
        (self.target <= 0.0).then(|| self.after(self.ramp()))
    }

    fn after(&self, seconds: f64) -> Duration {
        if seconds <= 0.0 {
            return self.since;
        }
        let later = duration_from_secs_rounded_up(seconds);
        self.since.saturating_add(later)
    }

    /// Seconds until the rate is what it shall be.
    fn ramp(&self) -> f64 {
        if self.slope == 0.0 {
            return 0.0;
        }
        ((self.target - self.rate) / self.slope).max(0.0)
    }
}

fn seconds_between(earlier: Duration, later: Duration) -> f64 {
    later.saturating_sub(earlier).as_secs_f64()
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    proptest! {
        #[test]
        fn a_path_time_is_reached_when_it_is_said_to_be(
            rate in 0.0..1.0f64, target in 0.0..1.0f64, slope in 0.1..200.0f64, left in 0.0..5.0f64,
        ) {
            let mut tempo = Tempo::new(Duration::from_secs(3), rate);
            tempo.change(Duration::from_secs(4), target, slope);
            let wanted = rate + left;
            match tempo.reaches(wanted) {
                Some(when) => prop_assert!((tempo.time(when) - wanted).abs() < 1e-6),
                None => prop_assert!(target <= 0.0 && tempo.time(Duration::from_secs(99)) <= wanted),
            }
        }

        #[test]
        fn neither_path_time_nor_its_rate_jumps(
            rate in 0.0..1.0f64, target in 0.0..1.0f64, slope in 0.1..200.0f64, at in 0.0..2.0f64,
        ) {
            let mut tempo = Tempo::new(Duration::ZERO, rate);
            tempo.change(Duration::from_secs(1), target, slope);
            let (a, b) = (Duration::from_secs_f64(at), Duration::from_secs_f64(at + 1e-4));
            let way = tempo.time(b) - tempo.time(a);
            prop_assert!((0.0..=1e-4 + 1e-9).contains(&way));
            prop_assert!((tempo.rate(b) - tempo.rate(a)).abs() <= slope * 1e-4 + 1e-6);
        }
    }

    #[test]
    fn a_brake_comes_to_rest_and_stays_there() {
        let mut tempo = Tempo::new(Duration::ZERO, 1.0);
        tempo.change(Duration::from_secs(1), 0.0, 4.0);
        let rest = tempo.rests().unwrap();
        assert!((rest.as_secs_f64() - 1.25).abs() < 1e-6);
        assert!((tempo.time(rest) - 1.125).abs() < 1e-6);
        assert!((tempo.time(Duration::from_secs(50)) - 1.125).abs() < 1e-6);
        assert_eq!(tempo.reaches(2.0), None);
    }
}
