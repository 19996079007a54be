//! A joint motion: six axes that start together and stop together.

use kinematics::{ArmModel, Axis, PendantJoints};
use units::MmPerSec;

use super::profile::Profile;

/// `$SPEEDLIM`: the `$SPEED` at which a joint motion runs its slowest-limited axis at full speed.
///
/// ASSUMPTION: 2000 mm/s, the usual value; programs of the field refuse speeds from 2000 upward.
pub const SPEED_LIMIT: MmPerSec = MmPerSec(2000.0);

/// The shortest motion: one interpolation period of the controller, in seconds.
///
/// ASSUMPTION: 8 ms, the default of the R-30iA. A move to where the arm stands takes one period, too.
pub const INTERPOLATION_PERIOD_S: f64 = 0.008;

/// A straight line in joint space with a synchronized trapezoidal profile.
#[derive(Clone, Debug, PartialEq)]
pub struct JointPath {
    from: PendantJoints,
    to: PendantJoints,
    /// `None`: the arm stands still for one interpolation period.
    profile: Option<Profile>,
}

impl JointPath {
    /// The fastest synchronized motion of `model` at `speed` / [`SPEED_LIMIT`] of every axis' maximum speed.
    ///
    /// Maximum accelerations are those of the model, not scaled by the speed.
    #[must_use]
    pub fn plan(model: &ArmModel, from: PendantJoints, to: PendantJoints, speed: MmPerSec) -> Self {
        let fraction = speed.0 / SPEED_LIMIT.0;
        let mut rate = f64::INFINITY;
        let mut acceleration = f64::INFINITY;
        for ((axis, start), end) in Axis::ALL.into_iter().zip(from.degrees()).zip(to.degrees()) {
            let travel = (end - start).abs();
            if travel > 0.0 {
                rate = rate.min(model.max_speed(axis).0 * fraction / travel);
                acceleration = acceleration.min(model.max_acceleration(axis).0 / travel);
            }
        }
        Self {
            from,
            to,
            profile: Profile::try_new(rate, acceleration),
        }
    }

    /// Where the motion starts.
    #[must_use]
    pub fn from(&self) -> &PendantJoints {
        &self.from
    }

    /// Where the motion ends.
    #[must_use]
    pub fn to(&self) -> &PendantJoints {
        &self.to
    }

    /// Path time from start to standstill, s, at 100 % override.
    #[must_use]
    pub fn duration(&self) -> f64 {
        self.profile
            .map_or(0.0, |p| p.duration())
            .max(INTERPOLATION_PERIOD_S)
    }

    /// Progress 0 to 1 at path time `t`, s.
    #[must_use]
    pub fn progress(&self, t: f64) -> f64 {
        self.profile.map_or(0.0, |p| p.progress(t))
    }

    /// Rate of progress, 1/s, at path time `t`, s, and the slope with which the path brakes, 1/s².
    #[must_use]
    pub fn braking(&self, t: f64) -> Option<(f64, f64)> {
        self.profile.map(|p| (p.rate(t), p.acceleration()))
    }

    /// The joints at a progress of 0 to 1. Exactly `to` at 1.
    #[must_use]
    pub fn at(&self, progress: f64) -> PendantJoints {
        if progress >= 1.0 {
            return self.to;
        }
        let (from, to) = (self.from.degrees(), self.to.degrees());
        let mut joints = from;
        for ((joint, start), end) in joints.iter_mut().zip(from).zip(to) {
            *joint = start + (end - start) * progress;
        }
        PendantJoints::from_degrees(joints)
    }
}
