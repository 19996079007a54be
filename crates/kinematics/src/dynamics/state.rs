//! Joint values with their rates and accelerations.

use crate::serial::{JointValues, SerialArm, SerialError};

/// Joint values, rates and accelerations of an arm, base first, as its display counts them: radians
/// and millimeters, per second and per second squared.
///
/// [`SerialArm::state`] makes them; they are finite and as many as that arm has joints.
#[derive(Clone, Debug, PartialEq)]
pub struct JointState(pub(crate) Vec<[f64; 3]>);

impl JointState {
    /// Value, rate and acceleration of each joint, base first.
    #[must_use]
    pub fn as_slice(&self) -> &[[f64; 3]] {
        &self.0
    }
}

impl SerialArm {
    /// A state of motion: joint values, and rates and accelerations in radians or millimeters and
    /// seconds, base first.
    ///
    /// # Errors
    /// They are not as many as the arm has joints, or a number is not finite or beyond any joint.
    pub fn state(
        &self,
        joints: &JointValues,
        rates: &[f64],
        accelerations: &[f64],
    ) -> Result<JointState, SerialError> {
        self.check_count(joints.len())?;
        // The same bounds as for values, in the joint's own unit.
        let rates = self.joints_from_radians(rates)?;
        let accelerations = self.joints_from_radians(accelerations)?;
        let numbers = joints.as_slice().iter();
        let numbers = numbers.zip(rates.as_slice()).zip(accelerations.as_slice());
        Ok(JointState(
            numbers.map(|((q, v), a)| [*q, *v, *a]).collect(),
        ))
    }
}
