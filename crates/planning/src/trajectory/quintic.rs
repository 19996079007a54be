//! One segment of fifth degree.

use super::polynomial::{Extremes, Polynomial};
use super::{TrajectoryError, check_bounded, check_time};
use crate::state::State;

/// The polynomial of fifth degree between two states, (2.16)-(2.23) of the textbook.
///
/// The textbook inverts a matrix of powers of the clock's time, which loses its digits when the
/// clock is far from zero; here time is normalised, and the six coefficients are closed forms.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Quintic {
    start_time: f64,
    polynomial: Polynomial,
}

impl Quintic {
    /// From `start` at the time `t0` to `goal` at the time `t1`, in seconds.
    ///
    /// # Errors
    /// Names the state or time that is no finite number, a `t1` that is not after `t0`, and states
    /// that the time cannot join within what a number holds.
    pub fn try_new(
        start: State,
        goal: State,
        t0: f64,
        t1: f64,
    ) -> Result<Quintic, TrajectoryError> {
        for (point, state) in [("start", start), ("goal", goal)] {
            state
                .check_finite()
                .map_err(|source| TrajectoryError::NotFinite { point, source })?;
        }
        let t0 = check_time("start time", t0, None)?;
        let t1 = check_time("end time", t1, Some(t0))?;
        let duration = t1 - t0;
        let polynomial = between(start, goal, duration);
        check_bounded(&polynomial.extremes(), duration)?;
        Ok(Quintic {
            start_time: t0,
            polynomial,
        })
    }

    /// In seconds.
    #[must_use]
    pub fn duration(&self) -> f64 {
        self.polynomial.duration
    }

    /// The state at a time between the two; before and after, the polynomial goes on.
    #[must_use]
    pub fn at(&self, time: f64) -> State {
        self.polynomial.at(time - self.start_time)
    }

    /// What the segment asks of the joint at most.
    #[must_use]
    pub fn extremes(&self) -> Extremes {
        self.polynomial.extremes()
    }
}

/// `c0` to `c2` are the start; what is missing at the end of position, velocity and acceleration
/// gives `c3` to `c5`: `c3 = 10 p - 4 v + a / 2`, `c4 = -15 p + 7 v - a`, `c5 = 6 p - 3 v + a / 2`.
pub(crate) fn between(start: State, goal: State, duration: f64) -> Polynomial {
    let square = duration * duration;
    let (c0, c1, c2) = (
        start.position,
        start.velocity * duration,
        0.5 * start.acceleration * square,
    );
    let p = goal.position - c0 - c1 - c2;
    let v = goal.velocity * duration - c1 - 2.0 * c2;
    let a = goal.acceleration * square - 2.0 * c2;
    let c = [
        c0,
        c1,
        c2,
        10.0 * p - 4.0 * v + 0.5 * a,
        -15.0 * p + 7.0 * v - a,
        6.0 * p - 3.0 * v + 0.5 * a,
    ];
    Polynomial { c, duration }
}
