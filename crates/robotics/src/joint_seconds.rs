//! How long a joint motion takes.

use kinematics::{ArmModel, PendantJoints};
use planning::jerk::straight_in_joint_space;

/// How many seconds a controller takes from `from` to `to` with all joints together, at this part of the highest speeds,
/// with the model's accelerations and jerks; 0 where there is no way.
#[must_use]
pub fn joint_seconds(arm: &ArmModel, from: &PendantJoints, to: &PendantJoints, speed: f64) -> f64 {
    let progress = straight_in_joint_space(arm, (from, to), speed, 1.0);
    progress.map_or(0.0, |progress| progress.duration())
}

#[cfg(test)]
mod tests {
    use super::*;

    /// J1 has 195 deg/s, 390 deg/s2 and 3900 deg/s3, and 156 degrees are enough to reach them all: 156 / 195 + 195 / 390 +
    /// 390 / 3900 s. At a tenth of the speed the whole acceleration is not: 156 / 19.5 + 2 sqrt(19.5 / 3900) s. J6 alone,
    /// with 550, 1100 and 11000, would be there sooner.
    #[test]
    fn a_joint_motion_has_ramps_of_its_acceleration() {
        let arm = ArmModel::builtin("fanuc-m20ia").unwrap();
        let from = PendantJoints::from_degrees([-78.0, 0.0, 0.0, 0.0, -90.0, 0.0]);
        let to = PendantJoints::from_degrees([78.0, 0.0, 0.0, 0.0, -90.0, 156.0]);
        let is = |speed: f64, wanted: f64| {
            let seconds = joint_seconds(arm, &from, &to, speed);
            assert!((seconds - wanted).abs() < 1e-9, "{seconds} is not {wanted}");
        };
        is(1.0, 156.0 / 195.0 + 0.5 + 0.1);
        is(0.1, 156.0 / 19.5 + 2.0 * (19.5_f64 / 3900.0).sqrt());
        assert!(joint_seconds(arm, &from, &from, 1.0).abs() < f64::EPSILON);
    }
}
