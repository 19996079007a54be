//! The joint sets that reach a pose.

use units::Degrees;

use crate::configuration::Configuration;
use crate::joints::PendantJoints;
use crate::limits::{LimitViolations, ROUNDING_DEG};
use crate::model::ArmModel;
use crate::singularity::Singularity;

/// One joint set that reaches a pose. It was put through the forward kinematics before it was
/// returned.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Solution {
    /// The joints.
    pub joints: PendantJoints,
    /// Which of the joint sets it is.
    pub configuration: Configuration,
    /// The distance of each joint to its nearest limit; negative means beyond it.
    pub margins: [Degrees; 6],
    /// How far it is from the singularities.
    pub singularity: Singularity,
}

impl Solution {
    /// Are all joints inside their limits?
    #[must_use]
    pub fn within_limits(&self) -> bool {
        self.smallest_margin().0 >= -ROUNDING_DEG
    }

    /// The joints beyond their limits.
    #[must_use]
    pub fn violations(&self, model: &ArmModel) -> LimitViolations {
        LimitViolations::of(model, &self.joints)
    }

    /// The margin of the joint that is closest to a limit, or farthest beyond one.
    #[must_use]
    pub fn smallest_margin(&self) -> Degrees {
        let [first, rest @ ..] = self.margins;
        rest.into_iter().fold(
            first,
            |least, margin| if margin < least { margin } else { least },
        )
    }
}

/// The joint sets that reach a pose: at most eight, kept in place, nothing on the heap.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Branches {
    solutions: [Option<Solution>; Self::CAPACITY],
    len: usize,
}

impl Branches {
    /// Front or back, elbow up or down, flip or no flip.
    pub const CAPACITY: usize = 8;

    pub(crate) fn new() -> Self {
        Self {
            solutions: [None; Self::CAPACITY],
            len: 0,
        }
    }

    pub(crate) fn push(&mut self, solution: Solution) {
        if let Some(slot) = self.solutions.get_mut(self.len) {
            *slot = Some(solution);
            self.len += 1;
        }
    }

    /// The solutions: no flip before flip, then front before back, then elbow up before down.
    pub fn iter(&self) -> impl Iterator<Item = &Solution> {
        self.solutions.iter().flatten()
    }

    /// How many there are.
    #[must_use]
    pub fn len(&self) -> usize {
        self.len
    }

    /// Are there none?
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.len == 0
    }
}

impl<'a> IntoIterator for &'a Branches {
    type Item = &'a Solution;
    type IntoIter = std::iter::Flatten<std::slice::Iter<'a, Option<Solution>>>;

    fn into_iter(self) -> Self::IntoIter {
        self.solutions.iter().flatten()
    }
}
