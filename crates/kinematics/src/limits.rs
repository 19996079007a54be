//! Joint limits, and the report of what exceeds them.

use std::fmt;

use units::Degrees;

use crate::joints::{Axis, PendantJoints};
use crate::model::ArmModel;

/// A joint exactly at its limit is inside: turning degrees into radians and back may move it by
/// this much.
pub(crate) const ROUNDING_DEG: f64 = 1e-9;

/// Highest jerk of a joint whose model file gives none, for each unit of its highest acceleration, 1/s.
///
/// ASSUMPTION: the whole acceleration is there after a tenth of a second. Manufacturers publish none.
pub(crate) const JERK_PER_ACCELERATION: f64 = 10.0;

/// The range of a joint, as the pendant counts it; both ends are inside.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Limits {
    /// The lowest legal value.
    pub min: Degrees,
    /// The highest legal value.
    pub max: Degrees,
}

impl Limits {
    /// The distance to the nearest limit; negative outside.
    #[must_use]
    pub fn margin(&self, value: Degrees) -> Degrees {
        let (below, above) = (value.0 - self.min.0, self.max.0 - value.0);
        // Not f64::min: that would drop a NaN.
        Degrees(if below < above { below } else { above })
    }

    /// Is the value inside, apart from rounding?
    #[must_use]
    pub fn contains(&self, value: Degrees) -> bool {
        self.margin(value).0 >= -ROUNDING_DEG
    }
}

/// One joint beyond one limit.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LimitViolation {
    /// The joint.
    pub joint: Axis,
    /// Where it would be.
    pub value: Degrees,
    /// Where it may be.
    pub limits: Limits,
    /// How far beyond the nearer limit.
    pub excess: Degrees,
}

/// `J3 would be 212.40°, its limit is 200.00° (over by 12.40°)`
impl fmt::Display for LimitViolation {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self {
            joint,
            value,
            limits,
            excess,
        } = self;
        let (limit, side) = if *value > limits.max {
            (limits.max, "over")
        } else {
            (limits.min, "under")
        };
        write!(
            f,
            "{joint} would be {value:.2}, its limit is {limit:.2} ({side} by {excess:.2})"
        )
    }
}

/// Every joint beyond a limit, J1 first.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub struct LimitViolations(Vec<LimitViolation>);

impl LimitViolations {
    /// The violations of `joints`; none if all are inside.
    pub(crate) fn of(model: &ArmModel, joints: &PendantJoints) -> Self {
        let violations = Axis::ALL
            .into_iter()
            .filter_map(|joint| {
                let (value, limits) = (joints.of(joint), model.limits(joint));
                let outside = !limits.contains(value);
                outside.then(|| LimitViolation {
                    joint,
                    value,
                    limits,
                    excess: -limits.margin(value),
                })
            })
            .collect();
        Self(violations)
    }

    /// Are all joints inside?
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.0.is_empty()
    }

    /// The violations, J1 first.
    pub fn iter(&self) -> impl Iterator<Item = &LimitViolation> {
        self.0.iter()
    }

    /// The joint that is farthest beyond its limit.
    #[must_use]
    pub fn worst(&self) -> Option<&LimitViolation> {
        self.0
            .iter()
            .max_by(|a, b| a.excess.0.total_cmp(&b.excess.0))
    }
}

/// The violations, separated by `; `.
impl fmt::Display for LimitViolations {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        for (index, violation) in self.0.iter().enumerate() {
            let separator = if index == 0 { "" } else { "; " };
            write!(f, "{separator}{violation}")?;
        }
        Ok(())
    }
}
