//! Why joint values are not an arm's.

use std::fmt;

use crate::serial::JointKind;

/// Why joint values were refused.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum SerialError {
    /// As many values as joints are needed.
    #[error("{given} joint values were given; {arm} has {wanted} joints")]
    JointCount {
        /// The arm.
        arm: String,
        /// How many joints it has.
        wanted: usize,
        /// How many values were given.
        given: usize,
    },
    /// A value is NaN or infinite, or far beyond any joint.
    #[error("{joint} is {value}; it must be a number from -{max} to {max} {}", .kind.unit())]
    NotAValue {
        /// The joint.
        joint: String,
        /// What was given, in degrees or millimeters.
        value: f64,
        /// The largest magnitude that is taken.
        max: f64,
        /// What kind of joint it is.
        kind: JointKind,
    },
}

/// One joint beyond its range, in degrees or millimeters.
#[derive(Clone, Debug, PartialEq)]
pub struct OutsideRange {
    /// The joint.
    pub joint: String,
    /// Where it is or would be.
    pub value: f64,
    /// The lowest legal value.
    pub min: f64,
    /// The highest legal value.
    pub max: f64,
    /// What kind of joint it is: degrees or millimeters.
    pub kind: JointKind,
}

/// `J3 would be 212.40 deg, its range is -70.00 to 200.00`
impl fmt::Display for OutsideRange {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self {
            joint,
            value,
            min,
            max,
            kind,
        } = self;
        let unit = kind.unit();
        write!(
            f,
            "{joint} would be {value:.2} {unit}, its range is {min:.2} to {max:.2}"
        )
    }
}
