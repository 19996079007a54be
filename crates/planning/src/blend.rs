//! Via points, gone past at speed: straight pieces of joint space with rounded corners.
//!
//! Each piece is gone along at a constant velocity; around each via point a quintic of textbook
//! (2.18) leads from the one velocity to the next, acceleration zero at both its ends. Over the
//! time `2 h` its velocity is `v1 + (v2 - v1) (3 s^2 - 2 s^3)`, so its acceleration is at most `1.5
//! |v2 - v1| / 2h`, its jerk `6 |v2 - v1| / (2h)^2`, and it passes the via point at a distance of
//! `3/32 |v2 - v1| 2h`.

use crate::jerk::MotionLimits;
use crate::state::{NotFinite, State};
use crate::trajectory::between;

/// Why via points were refused. Points and joints count from 1.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
pub enum BlendError {
    /// Too few or too many points.
    #[error("{count} points; a blended move has 2 to {MAX_POINTS}")]
    Points {
        /// How many were given.
        count: usize,
    },
    /// A move of no joints.
    #[error("a move needs at least one joint")]
    NoJoints,
    /// A position that is no number.
    #[error("point {point}, joint {joint}: {source}")]
    NotFinite {
        /// Which point.
        point: usize,
        /// Which joint.
        joint: usize,
        /// What is wrong with it.
        source: NotFinite,
    },
    /// A via point that the joint cannot reach.
    #[error("point {point}, joint {joint} is at {value}; it can be from {least} to {most}")]
    Unreachable {
        /// Which point.
        point: usize,
        /// Which joint.
        joint: usize,
        /// Where it would be.
        value: f64,
        /// Where it may be.
        least: f64,
        /// Where it may be.
        most: f64,
    },
    /// Two neighbors that are one point.
    #[error("points {first} and {} are the same", .first + 1)]
    SamePoint {
        /// The first of the two.
        first: usize,
    },
    /// A limit that is no limit.
    #[error("joint {joint}: a limit is {value}; it must be a number from 1e-9 to 1e9")]
    Limit {
        /// Which joint.
        joint: usize,
        /// What was given.
        value: f64,
    },
    /// A range of a joint that is none.
    #[error("joint {joint}: the range from {least} to {most} is none")]
    Range {
        /// Which joint.
        joint: usize,
        /// Its lower end.
        least: f64,
        /// Its upper end.
        most: f64,
    },
}

const MAX_POINTS: usize = 1000;
/// The shortest piece and blend, in seconds.
const LEAST: f64 = 1e-3;

/// A move of `N` joints through the neighborhood of via points, at rest at both ends.
#[derive(Clone, Debug, PartialEq)]
pub struct BlendedMove<const N: usize> {
    points: Vec<[f64; N]>,
    /// When each point would be passed without blends.
    times: Vec<f64>,
    /// Half the duration of the blend at each point.
    halves: Vec<f64>,
    /// One more than points: at rest, the pieces, at rest.
    velocities: Vec<[f64; N]>,
}

impl<const N: usize> BlendedMove<N> {
    /// A move past `points`, whose joints stay in `ranges` and `limits`.
    ///
    /// Each piece is as fast as its slowest joint allows, or slower where two blends would overlap.
    ///
    /// # Errors
    /// Names the point and joint that is wrong.
    pub fn try_new(
        points: &[[f64; N]],
        ranges: &[(f64, f64); N],
        limits: &[MotionLimits; N],
    ) -> Result<BlendedMove<N>, BlendError> {
        check(points, ranges, limits)?;
        let pairs = points.iter().zip(points.iter().skip(1));
        let mut pieces: Vec<f64> = pairs
            .map(|(a, b)| {
                let ways = a.iter().zip(b).zip(limits);
                let times = ways.map(|((a, b), limits)| (b - a).abs() / limits.velocity);
                times.fold(LEAST, f64::max)
            })
            .collect();
        loop {
            let velocities = velocities(points, &pieces);
            let halves = halves(&velocities, limits);
            let blends = halves.iter().zip(halves.iter().skip(1));
            let mut longer = false;
            for (piece, (before, after)) in pieces.iter_mut().zip(blends) {
                if before + after > *piece {
                    // Slower pieces need shorter blends, so this ends.
                    *piece = (before + after).max(1.05 * *piece);
                    longer = true;
                }
            }
            if longer {
                continue;
            }
            let mut times = vec![halves.first().copied().unwrap_or(0.0)];
            let mut time = halves.first().copied().unwrap_or(0.0);
            for piece in &pieces {
                time += piece;
                times.push(time);
            }
            return Ok(BlendedMove {
                points: points.to_vec(),
                times,
                halves,
                velocities,
            });
        }
    }

    /// In seconds.
    #[must_use]
    pub fn duration(&self) -> f64 {
        let last = |values: &[f64]| values.last().copied().unwrap_or(0.0);
        last(&self.times) + last(&self.halves)
    }

    /// When each point is passed most nearly, in seconds.
    #[must_use]
    pub fn times(&self) -> &[f64] {
        &self.times
    }

    /// How far each joint stays away from each point at that time; the ends are reached at the
    /// ends.
    #[must_use]
    pub fn deviations(&self) -> Vec<[f64; N]> {
        let pairs = self.velocities.iter().zip(self.velocities.iter().skip(1));
        pairs
            .zip(&self.halves)
            .map(|((before, after), half)| {
                let mut deviation = *after;
                for (joint, before) in deviation.iter_mut().zip(before) {
                    *joint = 3.0 / 32.0 * 2.0 * half * (*joint - before).abs();
                }
                deviation
            })
            .collect()
    }

    /// The states `t` seconds after the start: before it the start, after the end the goal.
    #[must_use]
    pub fn at(&self, t: f64) -> [State; N] {
        let t = t.clamp(0.0, self.duration());
        let passed = self.times.partition_point(|time| *time <= t);
        // The point whose blend may be on, or the piece before `passed`.
        let near = [passed.checked_sub(1), Some(passed)];
        for index in near.into_iter().flatten() {
            if let (Some(&time), Some(&half)) = (self.times.get(index), self.halves.get(index))
                && (t - time).abs() < half
            {
                return Self::joints(|joint| {
                    let (from, to) = (
                        self.straight(index, joint, time - half),
                        self.straight(index + 1, joint, time + half),
                    );
                    between(from, to, 2.0 * half).at(t - time + half)
                });
            }
        }
        Self::joints(|joint| self.straight(passed, joint, t))
    }

    fn joints(state: impl Fn(usize) -> State) -> [State; N] {
        let mut states = [State::default(); N];
        for (joint, slot) in states.iter_mut().enumerate() {
            *slot = state(joint);
        }
        states
    }

    /// On piece `piece`; piece 0 is the rest before the first point, the last the rest after all.
    fn straight(&self, piece: usize, joint: usize, t: f64) -> State {
        let from = piece.saturating_sub(1);
        let of = |all: &[[f64; N]], index: usize| {
            let values = all.get(index).or(all.last());
            values
                .and_then(|values| values.get(joint))
                .copied()
                .unwrap_or(0.0)
        };
        let velocity = of(&self.velocities, piece);
        let since = t - self.times.get(from).copied().unwrap_or(0.0);
        State {
            position: of(&self.points, from) + velocity * since,
            velocity,
            acceleration: 0.0,
        }
    }
}

fn velocities<const N: usize>(points: &[[f64; N]], pieces: &[f64]) -> Vec<[f64; N]> {
    let pairs = points.iter().zip(points.iter().skip(1)).zip(pieces);
    let inner = pairs.map(|((a, b), piece)| {
        let mut velocity = *b;
        for (joint, from) in velocity.iter_mut().zip(a) {
            *joint = (*joint - from) / piece;
        }
        velocity
    });
    let rest = std::iter::once([0.0; N]);
    rest.clone().chain(inner).chain(rest).collect()
}

fn halves<const N: usize>(velocities: &[[f64; N]], limits: &[MotionLimits; N]) -> Vec<f64> {
    let pairs = velocities.iter().zip(velocities.iter().skip(1));
    pairs
        .map(|(before, after)| {
            let changes = before.iter().zip(after).zip(limits);
            let longest = changes.map(|((before, after), limits)| {
                let change = (after - before).abs();
                let by_acceleration = 1.5 * change / limits.acceleration;
                by_acceleration.max((6.0 * change / limits.jerk).sqrt())
            });
            0.5 * longest.fold(LEAST, f64::max)
        })
        .collect()
}

fn check<const N: usize>(
    points: &[[f64; N]],
    ranges: &[(f64, f64); N],
    limits: &[MotionLimits; N],
) -> Result<(), BlendError> {
    let count = points.len();
    if N == 0 {
        return Err(BlendError::NoJoints);
    }
    if !(2..=MAX_POINTS).contains(&count) {
        return Err(BlendError::Points { count });
    }
    for (joint, (limits, &(least, most))) in (1..).zip(limits.iter().zip(ranges)) {
        for value in [limits.velocity, limits.acceleration, limits.jerk] {
            if !(1e-9..=1e9).contains(&value) {
                return Err(BlendError::Limit { joint, value });
            }
        }
        if least.is_nan() || most.is_nan() || least >= most {
            return Err(BlendError::Range { joint, least, most });
        }
    }
    for (point, joints) in (1..).zip(points) {
        for (joint, (&value, &(least, most))) in (1..).zip(joints.iter().zip(ranges)) {
            State::at_rest(value)
                .check_finite()
                .map_err(|source| BlendError::NotFinite {
                    point,
                    joint,
                    source,
                })?;
            if !(least..=most).contains(&value) {
                return Err(BlendError::Unreachable {
                    point,
                    joint,
                    value,
                    least,
                    most,
                });
            }
        }
    }
    let pairs = points.iter().zip(points.iter().skip(1));
    for (first, (a, b)) in (1..).zip(pairs) {
        if a.iter().zip(b).all(|(a, b)| (a - b).abs() < 1e-12) {
            return Err(BlendError::SamePoint { first });
        }
    }
    Ok(())
}
