//! Motion by a velocity vector: section 6 of the paper, for any arm.

use nalgebra::{Matrix3, Vector3};

use crate::serial::arm::SerialArm;
use crate::serial::error::{OutsideRange, SerialError};
use crate::serial::task::{Scaled, Task};
use crate::serial::values::JointValues;
use crate::serial::velocity::PseudoInverse;

const MAX_SPEED_MM_S: f64 = 100_000.0;
const MAX_TIME_S: f64 = 3600.0;
const MAX_STEPS: usize = 100_000;
/// How near a step has to come to the line, as part of the span, and in radians.
const ON_LINE: f64 = 1e-11;
/// A posture is singular if a singular value is below this part of the largest.
const SINGULAR: f64 = 1e-4;

/// Where the flange goes; it keeps its rotation, as far as the task holds it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum VelocityCommand {
    /// This velocity in the world, in millimeters a second.
    Vector(Vector3<f64>),
    /// This speed along the flange's Z axis (the paper's EF) as it is at the start.
    AlongTool(f64),
}

/// One moment of the motion.
#[derive(Clone, Debug, PartialEq)]
pub struct MotionSample {
    /// Seconds from the start.
    pub time_s: f64,
    /// The joints.
    pub joints: JointValues,
    /// The flange's position in the world, in millimeters.
    pub position: Vector3<f64>,
}

/// How a motion ended.
#[derive(Clone, Debug, PartialEq)]
pub enum MotionEnd {
    /// After all of its time.
    Completed,
    /// A joint would leave its range.
    Limit(OutsideRange),
    /// A joint would have to be faster than it can.
    TooFast {
        /// Which.
        joint: String,
        /// The share of its highest speed that it would need, above 1.
        load: f64,
    },
    /// The arm comes to a singular posture, or to the end of its reach.
    Singular {
        /// The smallest singular value as a part of the largest.
        ratio: f64,
    },
}

/// A motion, as far as it goes.
#[derive(Clone, Debug, PartialEq)]
pub struct VelocityMotion {
    /// From the start to where it ended, all inside the ranges.
    pub samples: Vec<MotionSample>,
    /// Why it ended there.
    pub end: MotionEnd,
}

/// Why there is no motion.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum MotionError {
    /// The start is not the arm's.
    #[error(transparent)]
    Joints(#[from] SerialError),
    /// The start is outside the ranges.
    #[error("the start is outside the ranges: {0}")]
    StartOutside(OutsideRange),
    /// A speed, a time or a number of steps that cannot be.
    #[error("{name} is {value}; it must be {wanted}")]
    Value {
        /// Which.
        name: &'static str,
        /// What was given.
        value: f64,
        /// What it must be.
        wanted: &'static str,
    },
}

impl SerialArm {
    /// Moves the flange from `start` with a constant velocity for `time_s` seconds, in `steps`
    /// steps, holding what `task` asks for.
    ///
    /// Each step is solved to the line itself, so nothing drifts. The motion stops at the last
    /// sample before a range's end, a joint's highest speed or a singularity, and says which; the
    /// time of a stop is found to a millionth of a step.
    ///
    /// # Errors
    /// The start, the speed, the time or the number of steps is not one.
    pub fn move_by_velocity(
        &self,
        start: &JointValues,
        command: VelocityCommand,
        time_s: f64,
        steps: usize,
        task: Task,
    ) -> Result<VelocityMotion, MotionError> {
        self.check_count(start.len())?;
        if let Some(outside) = self.outside(start).into_iter().next() {
            return Err(MotionError::StartOutside(outside));
        }
        check(command, time_s, steps)?;
        let stance = self.stance(&self.chain(start));
        let line = Line {
            from: stance.position,
            rotation: stance.rotation,
            velocity: match command {
                VelocityCommand::Vector(velocity) => velocity,
                VelocityCommand::AlongTool(speed) => stance.rotation.column(2) * speed,
            },
            task,
        };
        let sample = |time_s: f64, joints: JointValues| MotionSample {
            time_s,
            joints,
            position: line.at(time_s),
        };
        let mut samples = vec![sample(0.0, start.clone())];
        let (mut now, mut joints) = (0.0, start.clone());
        for step in 1..=steps {
            let share = |count: usize| u32::try_from(count).map_or(0.0, f64::from);
            let next = time_s * share(step) / share(steps);
            match self.step(&line, &joints, now, next) {
                Ok(reached) => {
                    samples.push(sample(next, reached.clone()));
                    (now, joints) = (next, reached);
                }
                Err(mut end) => {
                    // The last moment that is still possible, by halving.
                    let (mut good, mut bad) = (now, next);
                    let mut last = None;
                    for _ in 0..20 {
                        let middle = f64::midpoint(good, bad);
                        match self.step(&line, &joints, now, middle) {
                            Ok(reached) => {
                                good = middle;
                                last = Some(reached);
                            }
                            Err(reason) => {
                                bad = middle;
                                end = reason;
                            }
                        }
                    }
                    if let Some(reached) = last {
                        samples.push(sample(good, reached));
                    }
                    return Ok(VelocityMotion { samples, end });
                }
            }
        }
        Ok(VelocityMotion {
            samples,
            end: MotionEnd::Completed,
        })
    }

    /// The joints at `time`, near those before, or why the motion ends.
    fn step(
        &self,
        line: &Line,
        before: &JointValues,
        then: f64,
        time: f64,
    ) -> Result<JointValues, MotionEnd> {
        let units = self.joint_units();
        let mut joints = before.clone();
        let mut ratio = 0.0;
        for _ in 0..20 {
            let stance = self.stance(&self.chain(&joints));
            let position = line.at(time) - stance.position;
            let rotation = line.task.rotation_error(&stance.rotation, &line.rotation);
            let scaled = Scaled::of(self, &stance, line.task);
            let values = scaled.matrix.singular_values();
            ratio = values.min() / values.max();
            if ratio < SINGULAR {
                return Err(MotionEnd::Singular { ratio });
            }
            if position.norm() <= ON_LINE * self.span && rotation.norm() <= ON_LINE {
                return self.allowed(joints, before, time - then);
            }
            let error = nalgebra::Vector6::new(
                position.x, position.y, position.z, rotation.x, rotation.y, rotation.z,
            );
            let step = PseudoInverse::of(&scaled.matrix).solve(&scaled.twist(&error));
            // A step of more than a radian is no correction any more.
            if step.amax() > 1.0 {
                break;
            }
            joints.0 += step.component_mul(&units);
        }
        Err(MotionEnd::Singular { ratio })
    }

    fn allowed(
        &self,
        joints: JointValues,
        before: &JointValues,
        time: f64,
    ) -> Result<JointValues, MotionEnd> {
        if let Some(outside) = self.outside(&joints).into_iter().next() {
            return Err(MotionEnd::Limit(outside));
        }
        let ways = joints.as_slice().iter().zip(before.as_slice());
        for (joint, (now, then)) in self.joints.iter().zip(ways) {
            let load = (now - then).abs() / (time * joint.max_speed);
            if load > 1.0 {
                return Err(MotionEnd::TooFast {
                    joint: joint.name.clone(),
                    load,
                });
            }
        }
        Ok(joints)
    }
}

struct Line {
    from: Vector3<f64>,
    rotation: Matrix3<f64>,
    velocity: Vector3<f64>,
    task: Task,
}

impl Line {
    fn at(&self, time: f64) -> Vector3<f64> {
        self.from + self.velocity * time
    }
}

fn check(command: VelocityCommand, time_s: f64, steps: usize) -> Result<(), MotionError> {
    let speed = match command {
        VelocityCommand::Vector(velocity) => velocity.norm(),
        VelocityCommand::AlongTool(speed) => speed,
    };
    let refused = |name, value, wanted| MotionError::Value {
        name,
        value,
        wanted,
    };
    if speed.is_nan() || speed <= 0.0 || speed > MAX_SPEED_MM_S {
        let wanted = "above 0 and not above 100000 mm/s";
        return Err(refused("the speed", speed, wanted));
    }
    if time_s.is_nan() || time_s <= 0.0 || time_s > MAX_TIME_S {
        return Err(refused("the time", time_s, "above 0 and not above 3600 s"));
    }
    if steps == 0 || steps > MAX_STEPS {
        let steps = u32::try_from(steps).map_or(f64::MAX, f64::from);
        return Err(refused("the number of steps", steps, "from 1 to 100000"));
    }
    Ok(())
}
