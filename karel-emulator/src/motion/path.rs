//! The way of one motion: a line in joint space, or one of the tool center point, and how fast it is traveled.

use std::sync::Arc;

use kinematics::{ArmModel, Axis, PendantJoints, Pose};
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

/// Places of a way at which its speed is measured.
const SPEED_SAMPLES: f64 = 200.0;

/// A way with a synchronized trapezoidal profile.
#[derive(Clone, Debug)]
pub struct Path {
    from: PendantJoints,
    to: PendantJoints,
    line: Line,
    /// `None`: the arm stands still for one interpolation period.
    profile: Option<Profile>,
}

#[derive(Clone, Debug)]
enum Line {
    /// Straight in joint space.
    Joint,
    /// The way of a tool, so many millimeters long, through these joints, which are equally far apart on it.
    Tool {
        samples: Arc<[PendantJoints]>,
        length: f64,
        tool: Pose,
    },
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

    /// The way of `tool`, `length` mm long, through `samples`, at least two, at this rate (1/s) and slope (1/s²).
    pub(super) fn of_tool(
        samples: Vec<PendantJoints>,
        (length, tool): (f64, Pose),
        limits: (f64, f64),
    ) -> Option<Self> {
        let (from, to) = (*samples.first()?, *samples.last()?);
        let samples = samples.into();
        let line = Line::Tool {
            samples,
            length,
            tool,
        };
        Some(Self::new(from, to, line, limits))
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
            profile: Profile::try_new(rate, acceleration),
        }
    }

    /// The same way at this part of its speed, with the same acceleration.
    #[must_use]
    pub fn slower(&self, part: f64) -> Self {
        let profile = self.profile.as_ref();
        let slower = profile.and_then(|p| Profile::try_new(p.peak() * part, p.acceleration()));
        Self {
            profile: slower,
            ..self.clone()
        }
    }

    /// The same way with the same acceleration, slow enough to take so many seconds.
    ///
    /// # Errors
    /// The shortest time, if this one is shorter.
    pub fn lasting(&self, seconds: f64) -> Result<Self, f64> {
        let Some(profile) = &self.profile else {
            return Ok(self.clone());
        };
        let rate = Profile::rate_for(seconds, profile.acceleration());
        match rate.filter(|rate| *rate <= profile.peak() * (1.0 + 1e-9)) {
            Some(rate) => Ok(self.slower(rate / profile.peak())),
            None => Err(self.duration()),
        }
    }

    /// The greatest speed, per second, of a point that `place` finds for each joints, if the way is traveled at its
    /// cruising speed all along.
    #[must_use]
    pub fn fastest(&self, place: impl Fn(&PendantJoints) -> [f64; 3]) -> f64 {
        let mut longest = 0.0_f64;
        let mut before = place(&self.from);
        let mut n = 1.0;
        while n <= SPEED_SAMPLES {
            let here = place(&self.at(n / SPEED_SAMPLES));
            let way = here.iter().zip(before).map(|(a, b)| (a - b) * (a - b));
            longest = longest.max(way.sum::<f64>().sqrt());
            before = here;
            n += 1.0;
        }
        longest * SPEED_SAMPLES * self.profile.map_or(0.0, |p| p.peak())
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

    /// How long the way is accelerated, and decelerated, s.
    #[must_use]
    pub fn ramp(&self) -> f64 {
        self.profile.map_or(0.0, |p| p.ramp())
    }

    /// The slope of the ramps, parts of the way each s².
    #[must_use]
    pub fn slope(&self) -> f64 {
        self.profile.map_or(0.0, |p| p.acceleration())
    }

    /// For how long the way would have to be decelerated from path time `t`, s.
    #[must_use]
    pub fn braking_time(&self, t: f64) -> f64 {
        self.profile.map_or(0.0, |p| p.rate(t) / p.acceleration())
    }

    /// Of a way of the tool: how long it is, mm, and the tool on the flange.
    #[must_use]
    pub fn tool_way(&self) -> Option<(f64, &Pose)> {
        match &self.line {
            Line::Joint => None,
            Line::Tool { length, tool, .. } => Some((*length, tool)),
        }
    }

    /// How far the ends are from each other in joint space, degrees.
    #[must_use]
    pub fn chord(&self) -> f64 {
        let ends = self.from.degrees().into_iter().zip(self.to.degrees());
        ends.map(|(a, b)| (b - a) * (b - a)).sum::<f64>().sqrt()
    }

    /// The joints at path time `t`, s. Exactly `to` at the end.
    #[must_use]
    pub fn at_time(&self, t: f64) -> PendantJoints {
        self.at(self.profile.map_or(0.0, |p| p.progress(t)))
    }

    /// The joints at a progress of 0 to 1. Exactly `to` at 1.
    #[must_use]
    pub fn at(&self, progress: f64) -> PendantJoints {
        if progress >= 1.0 {
            return self.to;
        }
        match &self.line {
            Line::Joint => between(&self.from, &self.to, progress),
            Line::Tool { samples, .. } => along(samples, progress).unwrap_or(self.to),
        }
    }
}

/// At this share of the way through samples that are equally far apart.
pub(super) fn along(samples: &[PendantJoints], share: f64) -> Option<PendantJoints> {
    let steps = samples.len().saturating_sub(1);
    #[expect(
        clippy::cast_precision_loss,
        reason = "a path has a few thousand samples"
    )]
    let place = share.max(0.0) * steps as f64;
    #[expect(
        clippy::cast_possible_truncation,
        clippy::cast_sign_loss,
        reason = "between 0 and the number of samples"
    )]
    let index = place.floor() as usize;
    match (samples.get(index), samples.get(index + 1)) {
        (Some(before), Some(after)) => Some(between(before, after, place.fract())),
        (_, None) | (None, _) => samples.last().copied(),
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
