//! Trapezoidal progress along a path of length one.
//!
//! ```text
//! rate  ^      ____________
//!       |     /            \
//!       |    /              \
//!       +---+----------------+---> path time
//!        ramp    cruise    ramp
//! ```
//! A short path never reaches its cruising rate and the trapezoid becomes a triangle.

/// Progress from 0 to 1 with bounded rate and bounded acceleration, at rest at both ends.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Profile {
    /// Rate while cruising, 1/s.
    peak: f64,
    /// Slope of both ramps, 1/s².
    acceleration: f64,
    /// Length of each ramp, s.
    ramp: f64,
    /// Length of the cruise, s.
    cruise: f64,
}

impl Profile {
    /// The fastest trapezoid whose rate stays at or below `rate` (1/s) and whose slope is `acceleration` (1/s²).
    ///
    /// `None` unless both are finite and positive.
    #[must_use]
    pub fn try_new(rate: f64, acceleration: f64) -> Option<Self> {
        let usable = |value: f64| value.is_finite() && value > 0.0;
        if !usable(rate) || !usable(acceleration) {
            return None;
        }
        // A triangle of area one has its tip at sqrt(acceleration).
        let peak = rate.min(acceleration.sqrt());
        let ramp = peak / acceleration;
        let cruise = (1.0 / peak - ramp).max(0.0);
        Some(Self {
            peak,
            acceleration,
            ramp,
            cruise,
        })
    }

    /// The cruising rate with which everything takes so many seconds at this slope; `None` if it cannot be so short.
    #[must_use]
    pub fn rate_for(seconds: f64, acceleration: f64) -> Option<f64> {
        let below = seconds * seconds - 4.0 / acceleration;
        (below >= 0.0).then(|| 0.5 * acceleration * (seconds - below.sqrt()))
    }

    /// Path time from start to standstill, s.
    #[must_use]
    pub fn duration(&self) -> f64 {
        2.0 * self.ramp + self.cruise
    }

    /// The slope of the ramps, 1/s².
    #[must_use]
    pub fn acceleration(&self) -> f64 {
        self.acceleration
    }

    /// Rate while cruising, 1/s.
    #[must_use]
    pub fn peak(&self) -> f64 {
        self.peak
    }

    /// Length of each ramp, s.
    #[must_use]
    pub fn ramp(&self) -> f64 {
        self.ramp
    }

    /// Progress, 0 to 1, at path time `t` seconds. Before the start it is 0, after the end 1.
    #[must_use]
    pub fn progress(&self, t: f64) -> f64 {
        if t <= 0.0 {
            return 0.0;
        }
        let left = self.duration() - t;
        if left <= 0.0 {
            1.0
        } else if t < self.ramp {
            0.5 * self.acceleration * t * t
        } else if left < self.ramp {
            1.0 - 0.5 * self.acceleration * left * left
        } else {
            self.peak * (t - 0.5 * self.ramp)
        }
    }

    /// Rate of progress, 1/s, at path time `t` seconds.
    #[must_use]
    pub fn rate(&self, t: f64) -> f64 {
        let left = self.duration() - t;
        if t <= 0.0 || left <= 0.0 {
            0.0
        } else {
            self.peak
                .min(self.acceleration * t)
                .min(self.acceleration * left)
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn profiles() -> impl Strategy<Value = Profile> {
        (1e-3..1e3, 1e-3..1e4)
            .prop_map(|(rate, acceleration)| Profile::try_new(rate, acceleration).unwrap())
    }

    proptest! {
        #[test]
        fn progress_starts_at_zero_ends_at_one_and_never_goes_back(
            profile in profiles(), a in 0.0..1.0f64, b in 0.0..1.0f64,
        ) {
            let (early, late) = (a.min(b) * profile.duration(), a.max(b) * profile.duration());
            prop_assert!(profile.progress(early) <= profile.progress(late) + 1e-12);
            prop_assert!(profile.progress(0.0) <= 0.0);
            prop_assert!(profile.progress(profile.duration()) >= 1.0);
        }

        #[test]
        fn rate_and_acceleration_limits_hold(
            rate in 1e-3..1e3f64, acceleration in 1e-3..1e4f64, at in 0.0..1.0f64,
        ) {
            let profile = Profile::try_new(rate, acceleration).unwrap();
            let step = profile.duration() * 1e-4;
            let t = at * (profile.duration() - 2.0 * step);
            let slope = (profile.progress(t + step) - profile.progress(t)) / step;
            prop_assert!(slope <= rate * (1.0 + 1e-6));
            let bend = (profile.rate(t + step) - profile.rate(t)) / step;
            prop_assert!(bend.abs() <= acceleration * (1.0 + 1e-6));
        }

        #[test]
        fn rate_is_the_derivative_of_progress(profile in profiles(), at in 0.01..0.99f64) {
            let t = at * profile.duration();
            let h = profile.duration() * 1e-6;
            let slope = (profile.progress(t + h) - profile.progress(t - h)) / (2.0 * h);
            prop_assert!((slope - profile.rate(t)).abs() <= 1e-3 * profile.rate(t));
        }
    }

    #[test]
    fn a_long_path_cruises_and_a_short_one_is_a_triangle() {
        let long = Profile::try_new(0.5, 1.0).unwrap();
        assert!((long.duration() - 2.5).abs() < 1e-12);
        let short = Profile::try_new(100.0, 1.0).unwrap();
        assert!((short.duration() - 2.0).abs() < 1e-12);
        assert!((short.progress(1.0) - 0.5).abs() < 1e-12);
    }

    #[test]
    fn a_time_that_is_given_is_taken() {
        let rate = Profile::rate_for(3.0, 1.0).unwrap();
        let profile = Profile::try_new(rate, 1.0).unwrap();
        assert!((profile.duration() - 3.0).abs() < 1e-12);
        assert_eq!(Profile::rate_for(1.9, 1.0), None, "2 s is the shortest");
    }

    #[test]
    fn a_standstill_or_nonsense_has_no_profile() {
        for (rate, acceleration) in [(0.0, 1.0), (-1.0, 1.0), (f64::NAN, 1.0), (1.0, 0.0)] {
            assert_eq!(Profile::try_new(rate, acceleration), None);
        }
    }
}
