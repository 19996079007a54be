//! Why a pose has no joint set.

use std::fmt;

use units::Millimeters;

use crate::configuration::Configuration;
use crate::joints::JointsError;
use crate::limits::LimitViolations;

/// Why a pose cannot be reached.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum IkError {
    /// The wrist center is where the arm cannot be.
    #[error("out of reach: the wrist center is {excess:.3} {bound}")]
    OutOfReach {
        /// By how much.
        excess: Millimeters,
        /// Beyond what.
        bound: ReachBound,
    },
    /// There are joint sets, and every one is beyond a limit; this is the one that misses by the
    /// least.
    #[error("{violations} in branch {branch}; {branches} branches tried")]
    JointLimit {
        /// The joints beyond their limits.
        violations: LimitViolations,
        /// The joint set they belong to.
        branch: Configuration,
        /// How many joint sets reach the pose.
        branches: usize,
    },
    /// The configuration asked for does not reach the pose.
    #[error("no solution in configuration {wanted}: {obstacle}; {}", Would(.available))]
    NoSolutionInConfiguration {
        /// What was asked for.
        wanted: Configuration,
        /// What is in the way.
        obstacle: Obstacle,
        /// The configurations that would do, inside the limits.
        available: Vec<Configuration>,
    },
    /// The joints to stay near are not joints.
    #[error(transparent)]
    NotFinite(#[from] JointsError),
}

/// Which bound a wrist center is beyond.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ReachBound {
    /// Farther from the shoulder than the stretched arm.
    TooFar,
    /// Nearer to the shoulder than the folded arm.
    TooNear,
    /// Nearer to axis 1 than the arm's lateral offset.
    TooNearToAxis1,
}

impl fmt::Display for ReachBound {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            ReachBound::TooFar => "beyond the stretched arm",
            ReachBound::TooNear => "nearer to the shoulder than the folded arm",
            ReachBound::TooNearToAxis1 => "nearer to axis 1 than the arm's lateral offset",
        })
    }
}

/// Why the configuration asked for does not do.
#[derive(Clone, Debug, PartialEq)]
pub enum Obstacle {
    /// The arm does not reach the pose in this posture.
    OutOfReach,
    /// Joints would be beyond their limits.
    Limits(LimitViolations),
}

impl fmt::Display for Obstacle {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Obstacle::OutOfReach => f.write_str("the arm does not reach it in this posture"),
            Obstacle::Limits(violations) => violations.fmt(f),
        }
    }
}

struct Would<'a>(&'a [Configuration]);

impl fmt::Display for Would<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let [first, rest @ ..] = self.0 else {
            return f.write_str("no other configuration would do either");
        };
        write!(f, "{first}")?;
        for configuration in rest {
            write!(f, " or {configuration}")?;
        }
        f.write_str(" would do")
    }
}
