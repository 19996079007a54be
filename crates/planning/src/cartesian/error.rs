//! Why the tool cannot be moved along a path.

use kinematics::{Axis, IkError, LimitViolations, Xyzwpr};
use units::Degrees;

use super::path::PathError;
use crate::jerk::MoveError;

/// Why a move of the tool is not possible, and where.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum ToolError {
    /// A limit of the tool that is no limit.
    #[error("the tool's {item} is {value}; it must be a number from 1e-6 to 1e6")]
    Limit {
        /// `speed`, `acceleration`, `jerk`, `turning`.
        item: &'static str,
        /// What was given.
        value: f64,
    },
    /// A period that is no period.
    #[error("the period is {value} s; it must be from 0.0005 to 1 s")]
    Period {
        /// What was given.
        value: f64,
    },
    /// The path itself.
    #[error(transparent)]
    Path(#[from] PathError),
    /// The arm does not reach a pose of the path.
    #[error("at {parameter:.4} of the path, {pose}: {source}")]
    Unreachable {
        /// From 0 to 1.
        parameter: f64,
        /// Of the tool in the user frame.
        pose: Box<Xyzwpr>,
        /// Which joint, its value and its limit, or how far out of reach.
        source: IkError,
    },
    /// Two neighboring poses are only reached by joints far apart: a singularity, or a limit that
    /// forces the arm into another branch.
    #[error("at {parameter:.4} of the path, {pose}: {joint} would jump from {from:.2} to {to:.2}")]
    Jump {
        /// From 0 to 1.
        parameter: f64,
        /// Of the tool in the user frame.
        pose: Box<Xyzwpr>,
        /// The joint with the longest way.
        joint: Axis,
        /// Before.
        from: Degrees,
        /// After.
        to: Degrees,
    },
    /// With the wrist on its own way, no place of the arm keeps the tool on the path.
    #[error("at {parameter:.4} of the path, no place of the arm keeps the tool on it")]
    Wrist {
        /// From 0 to 1.
        parameter: f64,
    },
    /// With the wrist on its own way, a joint leaves its range.
    #[error("at {parameter:.4} of the path: {violations}")]
    WristLimits {
        /// From 0 to 1.
        parameter: f64,
        /// Which joints.
        violations: LimitViolations,
    },
    /// The arm does not stand where the path begins.
    #[error("{joint} is at {is:.3}, the path begins at {begins:.3}")]
    StartElsewhere {
        /// The joint that is farthest off.
        joint: Axis,
        /// Where it is.
        is: Degrees,
        /// Where it would have to be.
        begins: Degrees,
    },
    /// The move would have to be slower than any that makes sense.
    #[error("{joint} slows the move {factor:.0} times, at {parameter:.4} of the path")]
    TooSlow {
        /// The joint at its limit.
        joint: Axis,
        /// From 0 to 1.
        parameter: f64,
        /// How many times slower.
        factor: f64,
    },
    /// Planning the path parameter in time.
    #[error("planning the path parameter in time")]
    Profile(#[source] MoveError),
    /// A path with more samples than are held at once.
    #[error("{samples} samples; at most {most} are planned at once")]
    TooLong {
        /// How many the path needs.
        samples: f64,
        /// How many there may be.
        most: u32,
    },
}
