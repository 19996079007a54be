//! Why the tool cannot be moved along a path.

use std::fmt;

use kinematics::serial::{DlsError, JointKind, SerialError};
use kinematics::{IkError, LimitViolations, Xyzwpr};
use units::{Degrees, Millimeters};

use super::path::PathError;
use crate::jerk::MoveError;
use crate::wanted::BrokenOff;

/// Where a joint is, as its display shows it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct JointValue {
    /// Degrees or millimeters.
    pub value: f64,
    /// What the joint does.
    pub kind: JointKind,
}

impl From<Degrees> for JointValue {
    fn from(Degrees(value): Degrees) -> Self {
        JointValue {
            value,
            kind: JointKind::Revolute,
        }
    }
}

/// As degrees and millimeters are written.
impl fmt::Display for JointValue {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self.kind {
            JointKind::Revolute => Degrees(self.value).fmt(f),
            JointKind::Prismatic => Millimeters(self.value).fmt(f),
        }
    }
}

/// Why a move of the tool of any arm is not possible, and where.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum ToolMoveError {
    /// As of an arm that is solved in closed form.
    #[error(transparent)]
    Tool(#[from] ToolError),
    /// The search for joints that reach a pose of the path ended before it.
    #[error("at {parameter:.4} of the path, {pose}: {source}")]
    NotReached {
        /// From 0 to 1.
        parameter: f64,
        /// Of the tool in the user frame.
        pose: Box<Xyzwpr>,
        /// How near it got.
        source: DlsError,
    },
    /// Joints of another arm.
    #[error(transparent)]
    Joints(#[from] SerialError),
    /// Nobody waited for the move any more.
    #[error(transparent)]
    BrokenOff(#[from] BrokenOff),
}

impl From<PathError> for ToolMoveError {
    fn from(error: PathError) -> Self {
        ToolMoveError::Tool(error.into())
    }
}

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
        joint: String,
        /// Before.
        from: JointValue,
        /// After.
        to: JointValue,
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
        joint: String,
        /// Where it is.
        is: JointValue,
        /// Where it would have to be.
        begins: JointValue,
    },
    /// The move would have to be slower than any that makes sense.
    #[error("{joint} slows the move {factor:.0} times, at {parameter:.4} of the path")]
    TooSlow {
        /// The joint at its limit.
        joint: String,
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
