//! A move that is straight in joint space.

use kinematics::{ArmModel, Axis, PendantJoints};

use super::joint_move::MotionLimits;
use super::progress::Progress;

/// A shorter way of every joint is none, degrees: far below what the encoders of a motor tell apart, and above the
/// rounding of inverse kinematics.
const RESOLUTION_DEG: f64 = 1e-9;

/// The fastest progress of all joints together from `from` to `to`, in degrees of the joint that goes farthest, at these
/// parts of the model's speeds, and of its accelerations and jerks. `None` where there is no way, or no speed.
#[must_use]
pub fn straight_in_joint_space(
    arm: &ArmModel,
    (from, to): (&PendantJoints, &PendantJoints),
    speed: f64,
    acceleration: f64,
) -> Option<Progress> {
    let travels = Axis::ALL.map(|axis| (to.of(axis).0 - from.of(axis).0).abs());
    let way = travels.into_iter().fold(0.0, f64::max);
    let mut limits = MotionLimits {
        velocity: f64::INFINITY,
        acceleration: f64::INFINITY,
        jerk: f64::INFINITY,
    };
    for (axis, travel) in Axis::ALL.into_iter().zip(travels) {
        if travel > 0.0 {
            // The others have their parts of the farthest one.
            let part = way / travel;
            let lower = |limit: &mut f64, own: f64| *limit = limit.min(own * part);
            lower(&mut limits.velocity, arm.max_speed(axis).0 * speed);
            lower(
                &mut limits.acceleration,
                arm.max_acceleration(axis).0 * acceleration,
            );
            lower(&mut limits.jerk, arm.max_jerk(axis).0 * acceleration);
        }
    }
    if way > RESOLUTION_DEG {
        Progress::try_new(way, limits)
    } else {
        None
    }
}
