//! Joint values of an arm with any number of joints.

use nalgebra::DVector;

/// Joint values, base first: radians for a revolute joint, millimeters for a prismatic one, as the
/// arm's display counts them.
///
/// [`crate::serial::SerialArm::joints`] makes them from degrees and millimeters; they are finite
/// and as many as that arm has joints.
#[derive(Clone, Debug, PartialEq)]
pub struct JointValues(pub(crate) DVector<f64>);

impl JointValues {
    /// Radians and millimeters, base first.
    #[must_use]
    pub fn as_slice(&self) -> &[f64] {
        self.0.as_slice()
    }

    /// The same as a vector of nalgebra.
    #[must_use]
    pub fn as_vector(&self) -> &DVector<f64> {
        &self.0
    }

    /// The values a `share` of the way from these to `to`, which are the same arm's: each joint evenly.
    #[must_use]
    pub fn toward(&self, to: &JointValues, share: f64) -> JointValues {
        JointValues(self.0.zip_map(&to.0, |from, to| from + share * (to - from)))
    }

    /// How many joints there are.
    #[must_use]
    pub fn len(&self) -> usize {
        self.0.len()
    }

    /// Are there none?
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.0.is_empty()
    }
}
