//! A path of the tool in time, and the joints along it.

use kinematics::serial::{JointValues, SerialArm};
use units::{MmPerSec, MmPerSec2, RadPerSec};

use super::error::{ToolError, ToolMoveError};
use super::path::ToolPath;
use super::solved::{SolvedArm, SolvedFollower};
use crate::jerk::{MotionLimits, MoveError, Progress, Quantity};
use crate::wanted::Wanted;

/// What the tool may do at most.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ToolLimits {
    /// Of the tool center point.
    pub speed: MmPerSec,
    /// Along the path.
    pub acceleration: MmPerSec2,
    /// Along the path, in mm/s³.
    pub jerk: f64,
    /// Of the tool's orientation; its acceleration and jerk are in proportion to the speeds.
    pub turning: RadPerSec,
}

/// The arm at one instant.
#[derive(Clone, Debug, PartialEq)]
pub struct Sample {
    /// Seconds since the start.
    pub time: f64,
    /// On the path, from 0 to 1.
    pub parameter: f64,
    /// The joints.
    pub joints: JointValues,
}

/// Joints along a path of the tool, one sample a period.
#[derive(Clone, Debug, PartialEq)]
pub struct ToolMove {
    samples: Vec<Sample>,
    slowed: f64,
    limited_by: Option<String>,
}

/// Parts of a path that are checked before any time is planned.
const CHECKS: u32 = 200;
const MOST_SAMPLES: u32 = 1_000_000;
const SLOWEST: f64 = 1000.0;

impl ToolMove {
    /// Moves the tool along `path`, in the user frame of the arm's frames, beginning at `start`; rest at
    /// both ends, one sample each `period` seconds, as long as it is `wanted`. Each joint keeps the speed and
    /// acceleration of the model at every sample; where one would not, the whole move is slowed down.
    ///
    /// # Errors
    /// Where and why the arm cannot follow: parameter, pose, joint, limit.
    pub fn try_new(
        solved: &SolvedArm<'_>,
        path: &ToolPath,
        limits: &ToolLimits,
        start: &JointValues,
        period: f64,
        wanted: Wanted<'_>,
    ) -> Result<ToolMove, ToolMoveError> {
        check_limits(limits)?;
        if !(0.0005..=1.0).contains(&period) {
            return Err(ToolError::Period { value: period }.into());
        }
        let follower = SolvedFollower::new(solved, path);
        follower.check_start(start)?;
        let steepest = check_whole(&follower, path, start, wanted)?;
        let profile = parameter_profile(limits, &steepest)?;
        let (mut slowed, mut limited_by) = (1.0, None);
        // Each round measures the joints at the slower pace; two are the rule.
        for _ in 0..8 {
            let samples = samples(&follower, &profile, slowed, (start, period), wanted)?;
            let Some(worst) = worst(solved.arm, &samples, period) else {
                return Ok(ToolMove {
                    samples,
                    slowed,
                    limited_by,
                });
            };
            slowed *= worst.factor * 1.001;
            limited_by = Some(worst.joint.clone());
            if slowed > SLOWEST {
                return Err(ToolError::TooSlow {
                    joint: worst.joint,
                    parameter: worst.parameter,
                    factor: slowed,
                }
                .into());
            }
        }
        Err(ToolError::TooSlow {
            joint: limited_by.unwrap_or_default(),
            parameter: 1.0,
            factor: slowed,
        }
        .into())
    }

    /// One each period, the first at the start and the last at the end.
    #[must_use]
    pub fn samples(&self) -> &[Sample] {
        &self.samples
    }

    /// In seconds.
    #[must_use]
    pub fn duration(&self) -> f64 {
        self.samples.last().map_or(0.0, |sample| sample.time)
    }

    /// How many times longer the move takes because of the joints; 1 if the tool's own limits
    /// decide.
    #[must_use]
    pub fn slowed(&self) -> f64 {
        self.slowed
    }

    /// The joint that slows the move.
    #[must_use]
    pub fn limited_by(&self) -> Option<&str> {
        self.limited_by.as_deref()
    }
}

/// The largest ways for a whole unit of the parameter.
struct Steepest {
    millimeters: f64,
    radians: f64,
}

/// Follows the path without time.
fn check_whole(
    follower: &SolvedFollower<'_>,
    path: &ToolPath,
    start: &JointValues,
    wanted: Wanted<'_>,
) -> Result<Steepest, ToolMoveError> {
    let (mut joints, mut pose) = (start.clone(), path.pose_at(0.0)?);
    let mut steepest = Steepest {
        millimeters: 0.0,
        radians: 0.0,
    };
    let checks = f64::from(CHECKS);
    for step in 1..=CHECKS {
        wanted.check()?;
        let step = f64::from(step);
        joints = follower.follow((step - 1.0) / checks, &joints, step / checks)?;
        let next = path.pose_at(step / checks)?;
        let (distance, angle) = pose.distance_to(&next);
        steepest.millimeters = steepest.millimeters.max(distance.0 * checks);
        steepest.radians = steepest.radians.max(angle.0 * checks);
        pose = next;
    }
    Ok(steepest)
}

fn samples(
    follower: &SolvedFollower<'_>,
    profile: &Progress,
    slowed: f64,
    (start, period): (&JointValues, f64),
    wanted: Wanted<'_>,
) -> Result<Vec<Sample>, ToolMoveError> {
    let duration = profile.duration() * slowed;
    let count = (duration / period).ceil();
    if count > f64::from(MOST_SAMPLES) {
        return Err(ToolError::TooLong {
            samples: count,
            most: MOST_SAMPLES,
        }
        .into());
    }
    // The move lasts a whole number of periods.
    let pace = profile.duration() / (count * period);
    let mut samples = vec![Sample {
        time: 0.0,
        parameter: 0.0,
        joints: start.clone(),
    }];
    let mut joints = start.clone();
    let mut before = 0.0;
    for step in (1..=MOST_SAMPLES).take_while(|step| f64::from(*step) <= count) {
        wanted.check()?;
        let time = f64::from(step) * period;
        let parameter = profile.at(time * pace).position.clamp(0.0, 1.0);
        joints = follower.follow(before, &joints, parameter)?;
        before = parameter;
        samples.push(Sample {
            time,
            parameter,
            joints: joints.clone(),
        });
    }
    Ok(samples)
}

fn parameter_profile(limits: &ToolLimits, steepest: &Steepest) -> Result<Progress, ToolError> {
    // A tool that only turns has no length; one that only moves does not turn.
    let by_length = limits.speed.0 / steepest.millimeters.max(f64::MIN_POSITIVE);
    let by_angle = limits.turning.0 / steepest.radians.max(f64::MIN_POSITIVE);
    let velocity = by_length.min(by_angle);
    let share = velocity / limits.speed.0;
    let limits = MotionLimits {
        velocity,
        acceleration: limits.acceleration.0 * share,
        jerk: limits.jerk * share,
    };
    Progress::try_new(1.0, limits).ok_or(ToolError::Profile(MoveError::Limit {
        joint: 1,
        quantity: Quantity::Velocity,
        value: velocity,
    }))
}

struct Worst {
    joint: String,
    parameter: f64,
    factor: f64,
}

/// The joint that is farthest beyond its speed or acceleration between samples; the arm rests
/// before the first and after the last.
fn worst(arm: &SerialArm, samples: &[Sample], period: f64) -> Option<Worst> {
    let mut worst: Option<Worst> = None;
    for (index, joint) in arm.joint_list().iter().enumerate() {
        let at = |sample: &Sample| sample.joints.as_slice().get(index).copied();
        let mut speed_before = 0.0;
        let pairs = samples.iter().zip(samples.iter().skip(1));
        let speeds = pairs
            .filter_map(|(a, b)| Some((b.parameter, (at(b)? - at(a)?) / period)))
            .chain([(1.0, 0.0)]);
        for (parameter, speed) in speeds {
            let acceleration = (speed - speed_before) / period;
            speed_before = speed;
            let by_speed = speed.abs() / joint.max_speed;
            let factor = by_speed.max((acceleration.abs() / joint.max_acceleration).sqrt());
            if factor > 1.0 && worst.as_ref().is_none_or(|worst| worst.factor < factor) {
                worst = Some(Worst {
                    joint: joint.name.clone(),
                    parameter,
                    factor,
                });
            }
        }
    }
    worst
}

fn check_limits(limits: &ToolLimits) -> Result<(), ToolError> {
    let all = [
        ("speed", limits.speed.0),
        ("acceleration", limits.acceleration.0),
        ("jerk", limits.jerk),
        ("turning", limits.turning.0),
    ];
    all.into_iter().try_for_each(|(item, value)| {
        if (1e-6..=1e6).contains(&value) {
            Ok(())
        } else {
            Err(ToolError::Limit { item, value })
        }
    })
}
