//! Polynomials in time through given states, one joint at a time; for several joints plan each over
//! the same times.
//!
//! Chapter 2.3 of the textbook. These curves keep the boundary states and are smooth, but know no
//! limits: [`Quintic::extremes`] and its like say what they ask of a joint, and [`crate::jerk`]
//! plans within limits.

mod polynomial;
mod quintic;
mod three_segments;

pub use polynomial::Extremes;
pub use quintic::Quintic;
pub(crate) use quintic::between;
pub use three_segments::{Degrees, ThreeSegments};

use crate::state::{NotFinite, Part};

/// Why a trajectory was refused.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
pub enum TrajectoryError {
    /// A state that is no state.
    #[error("{point}: {source}")]
    NotFinite {
        /// `start`, `goal`, `first via point`, `second via point`.
        point: &'static str,
        /// What is wrong with it.
        source: NotFinite,
    },
    /// A time that is NaN or infinite.
    #[error("{item} is {value} s; it must be a finite number")]
    TimeNotFinite {
        /// Which time.
        item: &'static str,
        /// What was given.
        value: f64,
    },
    /// A time that is not after the one before it.
    #[error("{item} is {value} s, which is not after {before} s by at least {least} s")]
    TimeOrder {
        /// Which time.
        item: &'static str,
        /// What was given.
        value: f64,
        /// The time before it.
        before: f64,
        /// The shortest segment.
        least: f64,
    },
    /// The curve would leave what a number can hold: states too large for so short a time.
    #[error("the {part} would reach {value} within {duration} s; the bound is {bound}")]
    Impossible {
        /// Of which quantity.
        part: Part,
        /// Its largest value.
        value: f64,
        /// The time there is.
        duration: f64,
        /// What is allowed.
        bound: f64,
    },
}

/// The shortest segment, in seconds.
pub const LEAST_DURATION: f64 = 1e-6;
/// A coefficient beyond this would leave nothing of the others' digits.
const BOUND: f64 = 1e12;

fn check_time(item: &'static str, value: f64, before: Option<f64>) -> Result<f64, TrajectoryError> {
    if !value.is_finite() {
        return Err(TrajectoryError::TimeNotFinite { item, value });
    }
    match before {
        Some(before) if value - before < LEAST_DURATION => Err(TrajectoryError::TimeOrder {
            item,
            value,
            before,
            least: LEAST_DURATION,
        }),
        Some(_) | None => Ok(value),
    }
}

fn check_bounded(extremes: &Extremes, duration: f64) -> Result<(), TrajectoryError> {
    let parts = [
        (Part::Position, extremes.position),
        (Part::Velocity, extremes.velocity),
        (Part::Acceleration, extremes.acceleration),
    ];
    for (part, value) in parts {
        if value.is_nan() || value.abs() > BOUND {
            return Err(TrajectoryError::Impossible {
                part,
                value,
                duration,
                bound: BOUND,
            });
        }
    }
    Ok(())
}
