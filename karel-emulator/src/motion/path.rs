//! The way of one motion: a line in joint space, or one of the tool center point, and how fast it is traveled.

use std::sync::Arc;

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

/// A way with a synchronized trapezoidal profile.
#[derive(Clone, Debug, PartialEq)]
pub struct Path {
    from: PendantJoints,
    to: PendantJoints,
    line: Line,
    /// Part of the way that was traveled before: a motion that was held goes on from there.
    begin: f64,
    /// Rate and slope of progress, 1/s and 1/s².
    rate: f64,
    acceleration: f64,
    /// `None`: the arm stands still for one interpolation period.
    profile: Option<Profile>,
}

#[derive(Clone, Debug, PartialEq)]
enum Line {
    /// Straight in joint space.
    Joint,
    /// Through these joints, which are equally far apart on the way of the tool center point.
    Sampled(Arc<[PendantJoints]>),
}

impl Path {
    /// The fastest synchronized joint motion of `model` at `speed` / [`SPEED_LIMIT`] of every axis' maximum speed.
    ///
    /// Maximum accelerations are those of the model, not scaled by the speed.
    #[must_use]
    pub fn joint(
        model: &ArmModel,
        from: PendantJoints,
        to: PendantJoints,
        speed: MmPerSec,
    ) -> Self {
        Self::joint_at(model, from, to, speed.0 / SPEED_LIMIT.0, 1.0)
    }

    /// As [`Self::joint`], at these parts of the maximum speeds and of the maximum accelerations.
    #[must_use]
    pub fn joint_at(
        model: &ArmModel,
        from: PendantJoints,
        to: PendantJoints,
        speed: f64,
        acceleration: f64,
    ) -> Self {
        let mut rate = f64::INFINITY;
        let mut slope = f64::INFINITY;
        for ((axis, start), end) in Axis::ALL.into_iter().zip(from.degrees()).zip(to.degrees()) {
            let travel = (end - start).abs();
            if travel > 0.0 {
                rate = rate.min(model.max_speed(axis).0 * speed / travel);
                slope = slope.min(model.max_acceleration(axis).0 * acceleration / travel);
            }
        }
        Self::new(from, to, Line::Joint, (rate, slope))
    }

    /// Through `samples`, at least two, at this rate (1/s) and slope (1/s²) of progress.
    pub(super) fn sampled(samples: Vec<PendantJoints>, (rate, slope): (f64, f64)) -> Option<Self> {
        let (from, to) = (*samples.first()?, *samples.last()?);
        let line = Line::Sampled(samples.into());
        Some(Self::new(from, to, line, (rate, slope)))
    }

    fn new(
        from: PendantJoints,
        to: PendantJoints,
        line: Line,
        (rate, acceleration): (f64, f64),
    ) -> Self {
        Self {
            from,
            to,
            line,
            begin: 0.0,
            rate,
            acceleration,
            profile: Profile::try_new(rate, acceleration),
        }
    }

    /// What is left of the way at a progress of 0 to 1, from a standstill there.
    #[must_use]
    pub fn remaining(&self, progress: f64) -> Self {
        let left = (1.0 - progress).max(0.0);
        let (rate, acceleration) = (self.rate / left, self.acceleration / left);
        Self {
            begin: self.whole(progress),
            rate,
            acceleration,
            profile: Profile::try_new(rate, acceleration),
            ..self.clone()
        }
    }

    /// Where the way starts.
    #[must_use]
    pub fn from(&self) -> &PendantJoints {
        &self.from
    }

    /// Where the way ends.
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
        let whole = self.whole(progress);
        if whole >= 1.0 {
            return self.to;
        }
        match &self.line {
            Line::Joint => between(&self.from, &self.to, whole),
            Line::Sampled(samples) => {
                let steps = samples.len().saturating_sub(1);
                #[expect(
                    clippy::cast_precision_loss,
                    reason = "a path has a few thousand samples"
                )]
                let place = whole.max(0.0) * steps as f64;
                #[expect(
                    clippy::cast_possible_truncation,
                    clippy::cast_sign_loss,
                    reason = "between 0 and the number of samples"
                )]
                let index = place.floor() as usize;
                match (samples.get(index), samples.get(index + 1)) {
                    (Some(before), Some(after)) => between(before, after, place.fract()),
                    (_, None) | (None, _) => self.to,
                }
            }
        }
    }

    /// Progress of the whole way.
    fn whole(&self, progress: f64) -> f64 {
        self.begin + (1.0 - self.begin) * progress
    }
}

fn between(from: &PendantJoints, to: &PendantJoints, share: f64) -> PendantJoints {
    let (from, to) = (from.degrees(), to.degrees());
    let mut joints = from;
    for ((joint, start), end) in joints.iter_mut().zip(from).zip(to) {
        *joint = start + (end - start) * share;
    }
    PendantJoints::from_degrees(joints)
}
