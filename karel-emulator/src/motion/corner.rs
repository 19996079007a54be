//! Corners between two motions that are rounded instead of stopped at.
//!
//! The next motion begins while the one before still brakes, and both displacements add up:
//! `q(t) = q1(t) + q2(t) - corner`. Each of them has a continuous velocity, so their sum has one.

use kinematics::{ArmModel, Axis, PendantJoints, Pose};

use super::path::{INTERPOLATION_PERIOD_S, Path};

/// The way around a corner.
#[derive(Clone, Debug)]
pub enum Blend {
    /// The sum of both motions in joint space.
    Joints,
    /// Through these joints, equally far apart in path time.
    Sampled(Vec<PendantJoints>),
}

/// For how many seconds of path time the motion behind a corner runs together with the end of the one before it.
///
/// ASSUMPTION: `CNTn` begins the next motion when the last n percent of the deceleration are left, so that CNT100
/// keeps the speed and rounds most. CNT0 nearly stops: one interpolation period is left. The next motion is not
/// farther then than the end of its own acceleration, and neither way inside of the corner is longer than half of the
/// shorter leg. An axis that turns back there gets both accelerations at once, as behind a filter of the commanded
/// speeds. Without `after`, what the motion itself allows: from then on the program goes on.
#[must_use]
pub fn overlap_of_a_corner(percent: f64, before: &Path, after: Option<&Path>) -> f64 {
    let ramp = before.ramp();
    let alone = (percent / 100.0 * ramp)
        .max(INTERPOLATION_PERIOD_S)
        .min(ramp);
    let Some(after) = after else {
        return alone;
    };
    let (one, other) = lengths(before, after);
    let half = 0.5 * one.min(other);
    // Braking mirrors accelerating.
    let reach = |path: &Path, length: f64| match half / length {
        share if share > 0.0 => path.time_of(share),
        _ => 0.0,
    };
    let overlap = alone.min(after.ramp());
    overlap.min(reach(before, one)).min(reach(after, other))
}

/// How long both legs are in the same unit: millimeters of the tool if both are ways of the tool, else degrees.
fn lengths(before: &Path, after: &Path) -> (f64, f64) {
    match (before.tool_way(), after.tool_way()) {
        (Some((one, _)), Some((other, _))) if one > 0.0 && other > 0.0 => (one, other),
        _ => (before.chord(), after.chord()),
    }
}

/// The way around the corner between two motions that overlap for `overlap` seconds.
///
/// Ways of the same tool add up as ways of the tool, anything else in joint space. `None` where that would leave the
/// joint limits or the configuration, or where a joint would have to be faster than it can.
///
/// ASSUMPTION: such a corner is driven to exactly and not rounded; no alarm is raised.
#[must_use]
pub fn plan(model: &ArmModel, before: &Path, after: &Path, overlap: f64) -> Option<Blend> {
    let corner = Corner {
        model,
        before,
        after,
        begin: before.duration() - overlap,
    };
    match (before.tool_way(), after.tool_way()) {
        // Inside of the triangle of start, corner and end, whose corners are within the limits.
        (None, None) => Some(Blend::Joints),
        (Some((_, tool)), Some((_, other))) if tool == other => {
            let start = model.forward(before.to()) * *tool;
            let samples = corner.sampled(overlap, |t| corner.tool(&start, tool, t))?;
            Some(Blend::Sampled(samples))
        }
        _ => {
            let _checked = corner.sampled(overlap, |t| Some(corner.joints(t)))?;
            Some(Blend::Joints)
        }
    }
}

struct Corner<'a> {
    model: &'a ArmModel,
    before: &'a Path,
    after: &'a Path,
    /// Path time of the motion before at which the other one starts.
    begin: f64,
}

impl Corner<'_> {
    fn joints(&self, t: f64) -> PendantJoints {
        let one = self.before.at_time(self.begin + t);
        sum(&one, &self.after.at_time(t), self.before.to())
    }

    /// The joints that bring the tool to the sum of both ways.
    fn tool(&self, corner: &Pose, tool: &Pose, t: f64) -> Option<PendantJoints> {
        let of = |joints: &PendantJoints| self.model.forward(joints) * *tool;
        let one = of(&self.before.at_time(self.begin + t));
        let other = of(&self.after.at_time(t));
        let mut added = *(one * corner.inverse() * other).isometry();
        added.translation.vector = one.isometry().translation.vector
            + other.isometry().translation.vector
            - corner.isometry().translation.vector;
        let flange = Pose::try_from_isometry(added).ok()? * tool.inverse();
        let near = kinematics::Seed::Near(self.joints(t));
        let solution = self.model.inverse(&flange, near).ok()?;
        let branch = self.model.configuration(self.before.to());
        let same = solution.configuration.same_branch(branch);
        same.then_some(solution.joints)
    }

    /// One place each interpolation period, if all of them are possible.
    fn sampled(
        &self,
        overlap: f64,
        at: impl Fn(f64) -> Option<PendantJoints>,
    ) -> Option<Vec<PendantJoints>> {
        let steps = (overlap / INTERPOLATION_PERIOD_S).clamp(4.0, 1000.0).ceil();
        let mut samples = vec![self.before.at_time(self.begin)];
        let mut step = 1.0;
        while step <= steps {
            let joints = at(overlap * step / steps)?;
            self.model.check_limits(&joints).ok()?;
            let period = overlap / steps;
            let slow = samples.last().is_none_or(|last| {
                Axis::ALL.into_iter().all(|axis| {
                    let speed = (joints.of(axis).0 - last.of(axis).0).abs() / period;
                    speed <= self.model.max_speed(axis).0 * (1.0 + 1e-6)
                })
            });
            if !slow {
                return None;
            }
            samples.push(joints);
            step += 1.0;
        }
        Some(samples)
    }
}

/// `one + other - corner`, joint by joint.
pub(super) fn sum(
    one: &PendantJoints,
    other: &PendantJoints,
    corner: &PendantJoints,
) -> PendantJoints {
    let mut joints = one.degrees();
    let steps = other.degrees().into_iter().zip(corner.degrees());
    for (joint, (other, corner)) in joints.iter_mut().zip(steps) {
        *joint += other - corner;
    }
    PendantJoints::from_degrees(joints)
}

#[cfg(test)]
#[path = "corner_tests.rs"]
mod tests;
