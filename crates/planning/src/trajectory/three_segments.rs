//! Lift-off, transfer and set-down through two via points.

use nalgebra::{SMatrix, SVector};

use super::polynomial::{Extremes, Polynomial};
use super::{TrajectoryError, check_bounded, check_time};
use crate::state::{NotFinite, Part, State};

/// The degrees of the three polynomials; each choice has the fourteen coefficients that the
/// fourteen conditions need.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Degrees {
    /// Fourth, third, fourth: (2.31)-(2.33) of the textbook.
    FourThreeFour,
    /// Third, fifth, third.
    ThreeFiveThree,
}

/// Three polynomials through four positions, velocity and acceleration continuous; (2.24)-(2.42) of
/// the textbook, with the durations that its (2.40) leaves out.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ThreeSegments {
    /// t0 to t3.
    times: [f64; 4],
    segments: [Polynomial; 3],
}

type Matrix = SMatrix<f64, 14, 14>;

impl ThreeSegments {
    /// From `start` through the positions `via` to `goal`, at the four `times` in seconds.
    ///
    /// # Errors
    /// Names the state, via point or time that is no finite number, the time that is not after the
    /// one before it, and states that the times cannot join within what a number holds.
    pub fn try_new(
        degrees: Degrees,
        start: State,
        via: [f64; 2],
        goal: State,
        times: [f64; 4],
    ) -> Result<ThreeSegments, TrajectoryError> {
        check_points(start, via, goal)?;
        let [t0, t1, t2, t3] = times;
        let t0 = check_time("start time", t0, None)?;
        let t1 = check_time("time of the first via point", t1, Some(t0))?;
        let t2 = check_time("time of the second via point", t2, Some(t1))?;
        let t3 = check_time("end time", t3, Some(t2))?;
        let durations = [t1 - t0, t2 - t1, t3 - t2];
        let impossible = TrajectoryError::Impossible {
            part: Part::Acceleration,
            value: f64::INFINITY,
            duration: t3 - t0,
            bound: super::BOUND,
        };
        let segments = solved(degrees, start, via, goal, durations).ok_or(impossible)?;
        let trajectory = ThreeSegments { times, segments };
        check_bounded(&trajectory.extremes(), t3 - t0)?;
        Ok(trajectory)
    }

    /// The times given.
    #[must_use]
    pub fn times(&self) -> [f64; 4] {
        self.times
    }

    /// The state at a time from the first to the last; before and after, the outer polynomials go
    /// on.
    #[must_use]
    pub fn at(&self, time: f64) -> State {
        let [t0, t1, t2, _] = self.times;
        let [a, b, c] = &self.segments;
        if time < t1 {
            a.at(time - t0)
        } else if time < t2 {
            b.at(time - t1)
        } else {
            c.at(time - t2)
        }
    }

    /// What the trajectory asks of the joint at most.
    #[must_use]
    pub fn extremes(&self) -> Extremes {
        let segments = self.segments.iter().map(Polynomial::extremes);
        segments.fold(Extremes::default(), Extremes::join)
    }
}

fn check_points(start: State, via: [f64; 2], goal: State) -> Result<(), TrajectoryError> {
    let [first, second] = via;
    let points = [
        ("start", start),
        ("first via point", State::at_rest(first)),
        ("second via point", State::at_rest(second)),
        ("goal", goal),
    ];
    points.into_iter().try_for_each(|(point, state)| {
        let checked = state.check_finite();
        checked.map_err(|source: NotFinite| TrajectoryError::NotFinite { point, source })
    })
}

/// The row of `p^(order)(tau)` for tau 0 or 1, over the powers from 0.
fn row(order: usize, tau_is_one: bool, coefficients: usize) -> impl Iterator<Item = f64> {
    (0..coefficients).map(move |power| {
        if power < order || (!tau_is_one && power != order) {
            return 0.0;
        }
        let factors = (power - order + 1..=power).map(|factor| u8::try_from(factor).unwrap_or(0));
        factors.map(f64::from).product()
    })
}

/// Solves the fourteen conditions. The derivatives in tau are divided by the segment's duration,
/// which (2.40) does only where the three durations are the same.
fn solved(
    degrees: Degrees,
    start: State,
    via: [f64; 2],
    goal: State,
    durations: [f64; 3],
) -> Option<[Polynomial; 3]> {
    let counts: [usize; 3] = match degrees {
        Degrees::FourThreeFour => [5, 4, 5],
        Degrees::ThreeFiveThree => [4, 6, 4],
    };
    let [na, nb, _] = counts;
    let offsets = [0, na, na + nb];
    let [q1, q2] = via;
    // (segment, order, at its end, value), and continuity of (order) between two segments.
    let given = [
        (0, 0, false, start.position),
        (0, 1, false, start.velocity),
        (0, 2, false, start.acceleration),
        (0, 0, true, q1),
        (1, 0, false, q1),
        (1, 0, true, q2),
        (2, 0, false, q2),
        (2, 0, true, goal.position),
        (2, 1, true, goal.velocity),
        (2, 2, true, goal.acceleration),
    ];
    let continuity = [(0, 1), (0, 2), (1, 1), (1, 2)];

    let mut matrix = Matrix::zeros();
    let mut right = SVector::<f64, 14>::zeros();
    let mut put = |index: usize, segment: usize, order: usize, at_end: bool, sign: f64| {
        let (count, offset) = (counts.get(segment), offsets.get(segment));
        let (Some(&count), Some(&offset), Some(duration)) = (count, offset, durations.get(segment))
        else {
            return;
        };
        let scale = sign / (0..order).fold(1.0, |product, _| product * duration);
        for (column, value) in (offset..).zip(row(order, at_end, count)) {
            if let Some(entry) = matrix.get_mut((index, column)) {
                *entry += scale * value;
            }
        }
    };
    for (index, (segment, order, at_end, value)) in given.into_iter().enumerate() {
        put(index, segment, order, at_end, 1.0);
        if let Some(entry) = right.get_mut(index) {
            *entry = value;
        }
    }
    for (index, (segment, order)) in (given.len()..).zip(continuity) {
        put(index, segment, order, true, 1.0);
        put(index, segment + 1, order, false, -1.0);
    }
    let solution = matrix.full_piv_lu().solve(&right)?;
    let mut all = solution.iter().copied();
    let mut next = |count: usize, duration: f64| {
        let mut c = [0.0; 6];
        for (slot, value) in c.iter_mut().zip(all.by_ref().take(count)) {
            *slot = value;
        }
        Polynomial { c, duration }
    };
    let [da, db, dc] = durations;
    let [na, nb, nc] = counts;
    Some([next(na, da), next(nb, db), next(nc, dc)])
}
