//! The way of one motion: a line in joint space, or one of the tool center point, and how fast it is traveled.

use std::sync::Arc;

use kinematics::{ArmModel, PendantJoints, Pose};
use planning::jerk::{Progress, straight_in_joint_space};
use units::MmPerSec;

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

/// A way with a synchronized, jerk-limited progress.
#[derive(Clone, Debug)]
pub struct Path {
    from: PendantJoints,
    to: PendantJoints,
    line: Line,
    /// Degrees of the axis that goes farthest, or millimeters or degrees of the tool. `None`: the arm stands still for
    /// one interpolation period.
    progress: Option<Progress>,
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
    /// Maximum accelerations and jerks are those of the model, not scaled by the speed.
    #[must_use]
    pub fn joint(
        model: &ArmModel,
        from: PendantJoints,
        to: PendantJoints,
        speed: MmPerSec,
    ) -> Self {
        Self::joint_at(model, from, to, speed.0 / SPEED_LIMIT.0, 1.0)
    }

    /// As [`Self::joint`], at these parts of the maximum speeds, and of the maximum accelerations and jerks.
    ///
    /// ASSUMPTION: a way of every axis of less than 1e-9 degrees is none: the arm stands still for one interpolation period
    /// and is there. That is far below what the encoders of a motor tell apart, and above the rounding of inverse kinematics.
    #[must_use]
    pub fn joint_at(
        model: &ArmModel,
        from: PendantJoints,
        to: PendantJoints,
        speed: f64,
        acceleration: f64,
    ) -> Self {
        Self {
            from,
            to,
            line: Line::Joint,
            progress: straight_in_joint_space(model, (&from, &to), speed, acceleration),
        }
    }

    /// The way of `tool`, `length` mm long, through `samples`, at least two.
    pub(super) fn of_tool(
        samples: Vec<PendantJoints>,
        (length, tool): (f64, Pose),
        progress: Progress,
    ) -> Option<Self> {
        let (from, to) = (*samples.first()?, *samples.last()?);
        let samples = samples.into();
        let line = Line::Tool {
            samples,
            length,
            tool,
        };
        Some(Self {
            from,
            to,
            line,
            progress: Some(progress),
        })
    }

    /// No way at all.
    pub(super) fn standing(at: PendantJoints) -> Self {
        Self {
            from: at,
            to: at,
            line: Line::Joint,
            progress: None,
        }
    }

    /// The same way at this part of its speed, with the same acceleration.
    #[must_use]
    pub fn slower(&self, part: f64) -> Self {
        let progress = self.progress.as_ref();
        Self {
            progress: progress.and_then(|progress| progress.slower(part)),
            ..self.clone()
        }
    }

    /// The same way within the same limits, slow enough to take so many seconds.
    ///
    /// # Errors
    /// The shortest time, if this one is shorter.
    pub fn lasting(&self, seconds: f64) -> Result<Self, f64> {
        let Some(progress) = &self.progress else {
            return Ok(self.clone());
        };
        let progress = Some(progress.lasting(seconds)?);
        Ok(Self {
            progress,
            ..self.clone()
        })
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
        let rate = self.progress.map_or(0.0, |p| p.peak() / p.way());
        longest * SPEED_SAMPLES * rate
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
        self.progress
            .map_or(0.0, |p| p.duration())
            .max(INTERPOLATION_PERIOD_S)
    }

    /// How long the way is accelerated, and decelerated, s.
    #[must_use]
    pub fn ramp(&self) -> f64 {
        self.progress.map_or(0.0, |p| p.ramp())
    }

    /// Path time at which this share of the way is traveled, s.
    #[must_use]
    pub fn time_of(&self, share: f64) -> f64 {
        self.progress.map_or(0.0, |p| p.reaches(share * p.way()))
    }

    /// How long braking would take from path time `t`, and for how much of that the deceleration builds up, s.
    #[must_use]
    pub fn braking(&self, t: f64) -> (f64, f64) {
        self.progress.map_or((0.0, 0.0), |p| p.braking(t))
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
        self.at(self.progress.map_or(0.0, |p| p.at(t).position / p.way()))
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

#[cfg(test)]
mod tests {
    use kinematics::Axis;

    use super::*;

    #[test]
    fn a_move_shorter_than_an_encoder_sees_is_one_to_where_the_arm_stands() {
        let arm = ArmModel::builtin("fanuc-m20ia").unwrap();
        let path = |by: f64| {
            let [from, to] = [0.0, by].map(|j5| [0.0, 0.0, 0.0, 0.0, j5, 0.0]);
            let [from, to] = [from, to].map(PendantJoints::from_degrees);
            Path::joint_at(arm, from, to, 1.0, 1.0)
        };
        for by in [0.0, 7e-16, -9e-10] {
            let none = path(by);
            assert!((none.duration() - INTERPOLATION_PERIOD_S).abs() < 1e-12);
            assert_eq!(none.at_time(0.004), *none.from());
            assert_eq!(none.at(1.0), *none.to());
            assert!(none.ramp() <= 0.0 && none.braking(0.004) <= (0.0, 0.0));
        }
        // 32 way / jerk is the cube of the time; it takes one period nevertheless.
        let short = path(2e-9);
        let expected = (32.0 * 2e-9 / arm.max_jerk(Axis::J5).0).cbrt();
        assert!((2.0 * short.ramp() - expected).abs() < 1e-12);
        assert!((short.duration() - INTERPOLATION_PERIOD_S).abs() < 1e-12);
        let longer = path(-1e-3);
        let expected = (32.0 * 1e-3 / arm.max_jerk(Axis::J5).0).cbrt();
        assert!((longer.duration() - expected).abs() < 1e-9);
    }
}
