//! Joint values: as the pendant shows them, and as the chain of links has them.

use std::fmt;

use units::Degrees;

/// One of the six axes.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
#[expect(missing_docs, reason = "the names say it all")]
pub enum Axis {
    J1,
    J2,
    J3,
    J4,
    J5,
    J6,
}

impl Axis {
    /// All axes, base first.
    pub const ALL: [Axis; 6] = [Axis::J1, Axis::J2, Axis::J3, Axis::J4, Axis::J5, Axis::J6];

    /// The value that belongs to this axis.
    #[must_use]
    pub fn of<T: Copy>(self, values: &[T; 6]) -> T {
        let [j1, j2, j3, j4, j5, j6] = *values;
        match self {
            Axis::J1 => j1,
            Axis::J2 => j2,
            Axis::J3 => j3,
            Axis::J4 => j4,
            Axis::J5 => j5,
            Axis::J6 => j6,
        }
    }
}

/// `J1` to `J6`.
impl fmt::Display for Axis {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Axis::J1 => "J1",
            Axis::J2 => "J2",
            Axis::J3 => "J3",
            Axis::J4 => "J4",
            Axis::J5 => "J5",
            Axis::J6 => "J6",
        })
    }
}

/// A joint value that no joint can have.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
#[error("{axis} is {value}; a joint value must be a finite number")]
pub struct JointsError {
    /// The joint in question.
    pub axis: Axis,
    /// What it was given.
    pub value: Degrees,
}

macro_rules! joint_values {
    ($(#[$doc:meta])* $name:ident) => {
        $(#[$doc])*
        #[derive(Clone, Copy, Debug, Default, PartialEq)]
        pub struct $name([f64; 6]);

        impl $name {
            /// Joint values from degrees, J1 first, as they are; for values that come from outside
            /// there is [`Self::try_from_degrees`].
            #[must_use]
            pub fn from_degrees(degrees: [f64; 6]) -> Self {
                Self(degrees.map(f64::to_radians))
            }

            /// Joint values from degrees, J1 first.
            ///
            /// # Errors
            /// Names the first joint that is not a finite number. Limits are not checked.
            pub fn try_from_degrees(degrees: [f64; 6]) -> Result<Self, JointsError> {
                for axis in Axis::ALL {
                    let value = axis.of(&degrees);
                    if !value.is_finite() {
                        return Err(JointsError { axis, value: Degrees(value) });
                    }
                }
                Ok(Self::from_degrees(degrees))
            }

            /// Joint values from radians, J1 first, as they are.
            #[must_use]
            pub fn from_radians(radians: [f64; 6]) -> Self {
                Self(radians)
            }

            /// Degrees, J1 first.
            #[must_use]
            pub fn degrees(&self) -> [f64; 6] {
                self.0.map(f64::to_degrees)
            }

            /// Radians, J1 first.
            #[must_use]
            pub fn radians(&self) -> [f64; 6] {
                self.0
            }

            /// The value of one axis.
            #[must_use]
            pub fn of(&self, axis: Axis) -> Degrees {
                Degrees(axis.of(&self.0).to_degrees())
            }
        }

        /// `J1 0.000°, J2 0.000°, ..`
        impl fmt::Display for $name {
            fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
                let digits = f.precision().unwrap_or(3);
                for axis in Axis::ALL {
                    let comma = if axis == Axis::J1 { "" } else { ", " };
                    write!(f, "{comma}{axis} {:.digits$}", self.of(axis))?;
                }
                Ok(())
            }
        }
    };
}

joint_values!(
    /// Joint values as the pendant shows them.
    ///
    /// On a FANUC arm the pendant's J3 is measured against the horizontal, so it stands still while
    /// J2 moves; [`crate::ArmModel::chain`] turns these into [`ChainJoints`].
    PendantJoints
);
joint_values!(
    /// Joint values of the chain of links: the angles of the Denavit-Hartenberg table.
    ChainJoints
);

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_joint_that_is_not_a_number_is_refused_by_name() {
        let error =
            PendantJoints::try_from_degrees([0.0, 0.0, f64::NAN, 0.0, 0.0, 0.0]).unwrap_err();
        assert_eq!(error.axis, Axis::J3);
        assert_eq!(
            error.to_string(),
            "J3 is NaN\u{b0}; a joint value must be a finite number"
        );
        let error =
            ChainJoints::try_from_degrees([f64::INFINITY, 0.0, 0.0, 0.0, 0.0, 0.0]).unwrap_err();
        assert_eq!(error.axis, Axis::J1);
    }

    #[test]
    fn joints_print_with_their_names() {
        let joints = PendantJoints::from_degrees([0.0, 12.5, 0.0, 0.0, -90.0, 0.0]);
        assert_eq!(
            format!("{joints:.1}"),
            "J1 0.0\u{b0}, J2 12.5\u{b0}, J3 0.0\u{b0}, J4 0.0\u{b0}, J5 -90.0\u{b0}, J6 0.0\u{b0}"
        );
    }
}
