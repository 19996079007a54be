//! The tool along a path.

use api::arms::{ArmOutside, ArmTask};
use api::trajectory::{ToolPathBody, ToolPathFailure, ToolPathKind, ToolPathResult};
use kinematics::serial::{DlsOptions, JointValues};
use kinematics::{IkError, LimitViolations, Pose, Seed};
use planning::cartesian::{
    Extent, PathError, Sample, SolvedArm, Solver, ToolError, ToolLimits, ToolMove, ToolMoveError,
    ToolPath,
};
use planning::jerk::MotionLimits;
use planning::{State, Wanted};
use units::{MmPerSec, MmPerSec2, RadPerSec};

use crate::arm::{Arm, task_of};
use crate::convert::{frames_of, pose_at, pose_body, position_of, shown};
use crate::refusal::{Refusal, length, within, within_or};
use crate::sampled::{MOST_SAMPLES, Moment, peaks, samples};

const TOOL: [f64; 2] = [1e-6, 1e6];
const MOST_POSES: usize = 1000;

/// The joints while the tool goes along a line, an arc, a circle or a spline, with its orientation; inverse kinematics
/// at every step, the whole move slowed down where a joint would be too fast. An arm that the closed form covers is solved
/// by it; any other one by damped least squares from the step before, as far as its task asks.
///
/// The lectures' 5.2: `q = ikin(H(t))`. Where the arm cannot follow, `failure` says where and why, and there are no
/// samples.
///
/// # Errors
/// No such model; a path, limit or start that is none.
pub fn tool_path(model: &str, body: &ToolPathBody) -> Result<ToolPathResult, Refusal> {
    tool_path_while(model, body, Wanted::ALWAYS)
}

/// As [`tool_path`], as long as the answer is `wanted`.
///
/// # Errors
/// As [`tool_path`]; [`crate::RefusalKind::BrokenOff`].
pub fn tool_path_while(
    model: &str,
    body: &ToolPathBody,
    wanted: Wanted<'_>,
) -> Result<ToolPathResult, Refusal> {
    let arm = Arm::named(model)?;
    let frames = frames_of(&body.frames)?;
    let (path, first) = path(body)?;
    let limits = limits(body)?;
    let period = within_or("period_s", body.period_s, 0.02, [0.0005, 1.0], "s")?;
    let path_mm = way(&path);
    let failed = |failure| ToolPathResult {
        feasible: false,
        failure: Some(failure),
        joints: names(&arm),
        duration_s: 0.0,
        slowed: 1.0,
        limited_by: None,
        samples: Vec::new(),
        peaks: Vec::new(),
        path_mm: path_mm.clone(),
    };
    let task = arm.task(body.task);
    let solver = match arm.closed {
        Some(closed) if task == ArmTask::Pose => Solver::ClosedForm(closed),
        Some(_) | None => Solver::Search(task_of(task)),
    };
    let solved = SolvedArm {
        arm: arm.serial,
        frames: &frames,
        solver,
    };
    let start = match &body.start_deg_mm {
        Some(start) => arm.joints_inside("start_deg_mm", start)?,
        None => match beginning(&solved, &first) {
            Ok(start) => start,
            Err(failure) => return Ok(failed(failure)),
        },
    };
    let planned = ToolMove::try_new(&solved, &path, &limits, &start, period, wanted);
    let planned = match planned {
        Ok(planned) => planned,
        Err(error) => return failure(&arm, &error).map(failed),
    };
    let count = planned.samples().len();
    if count > MOST_SAMPLES {
        let detail = format!(
            "{:.3} s in steps of {period} s are {count} samples; at most {MOST_SAMPLES} are told",
            planned.duration()
        );
        return Err(Refusal::invalid("period_s", detail).with_value(period));
    }
    let moments = moments(planned.samples());
    let limits = joint_limits(&arm);
    Ok(ToolPathResult {
        feasible: true,
        failure: None,
        joints: names(&arm),
        duration_s: planned.duration(),
        slowed: planned.slowed(),
        limited_by: planned.limited_by().map(str::to_owned),
        samples: samples(&arm, &arm.serial.with_frames(&frames), &moments),
        peaks: peaks(&arm, &moments, &limits),
        path_mm,
    })
}

/// The joints at the first pose, those nearest to home.
fn beginning(solved: &SolvedArm<'_>, X_UT: &Pose) -> Result<JointValues, ToolPathFailure> {
    let (arm, home) = (solved.arm, solved.arm.home());
    match solved.solver {
        Solver::ClosedForm(model) => {
            let X_WF = solved.frames.flange_in_world(X_UT);
            let found = model
                .inverse(&X_WF, Seed::Near(model.home()))
                .map_err(|error| unreachable(0.0, Some(X_UT), &error))?;
            arm.joints_from_radians(&found.joints.radians())
                .map_err(|error| stopped(0.0, Some(X_UT), &error))
        }
        Solver::Search(task) => {
            let framed = arm.with_frames(solved.frames);
            let found = framed.solve(X_UT, task, &home, &DlsOptions::default());
            found
                .map(|found| found.joints)
                .map_err(|error| stopped(0.0, Some(X_UT), &error))
        }
    }
}

fn names(arm: &Arm) -> Vec<String> {
    let joints = arm.serial.joint_list().iter();
    joints.map(|joint| joint.name.clone()).collect()
}

fn path(body: &ToolPathBody) -> Result<(ToolPath, Pose), Refusal> {
    let count = match body.kind {
        ToolPathKind::Line => [2, 2],
        ToolPathKind::Arc | ToolPathKind::Circle => [3, 3],
        ToolPathKind::Spline => [2, MOST_POSES],
    };
    length(
        "poses",
        body.poses.len(),
        count,
        "poses of this kind of path",
    )?;
    let mut poses = Vec::new();
    for (index, pose) in body.poses.iter().enumerate() {
        poses.push(pose_at(&format!("poses[{index}]"), pose)?);
    }
    let path = match (body.kind, poses.as_slice()) {
        (ToolPathKind::Line, [start, goal]) => ToolPath::line(start, goal),
        (ToolPathKind::Arc, [start, via, goal]) => ToolPath::circle(start, via, goal, Extent::Arc),
        (ToolPathKind::Circle, [start, via, goal]) => {
            ToolPath::circle(start, via, goal, Extent::WholeTurn)
        }
        (_, poses) => ToolPath::spline(poses),
    };
    let path = path.map_err(|error| path_refusal(&error))?;
    let first = poses.first().copied().unwrap_or_else(Pose::identity);
    Ok((path, first))
}

fn path_refusal(error: &PathError) -> Refusal {
    let path = match error {
        PathError::SamePoint { second, .. } | PathError::HalfTurn { second } => {
            format!("poses[{}]", second.saturating_sub(1))
        }
        PathError::NoWay => "poses[1]".to_owned(),
        PathError::Points { .. } | PathError::Straight { .. } | PathError::Pose(_) => {
            "poses".to_owned()
        }
    };
    Refusal::invalid(path, error)
}

fn limits(body: &ToolPathBody) -> Result<ToolLimits, Refusal> {
    let speed = within("speed_mm_s", body.speed_mm_s, TOOL, "mm/s")?;
    let usual = (5.0 * speed).min(1e6);
    let acceleration = within_or(
        "acceleration_mm_s2",
        body.acceleration_mm_s2,
        usual,
        TOOL,
        "mm/s2",
    )?;
    let usual = (10.0 * acceleration).min(1e6);
    let jerk = within_or("jerk_mm_s3", body.jerk_mm_s3, usual, TOOL, "mm/s3")?;
    let turning = within_or(
        "turning_deg_s",
        body.turning_deg_s,
        90.0,
        [1e-3, 1e5],
        "deg/s",
    )?;
    Ok(ToolLimits {
        speed: MmPerSec(speed),
        acceleration: MmPerSec2(acceleration),
        jerk,
        turning: RadPerSec(turning.to_radians()),
    })
}

/// Where the tool would go, as far as that can be told.
fn way(path: &ToolPath) -> Vec<[f64; 3]> {
    let shares = (0..=100_u32).map(|share| f64::from(share) / 100.0);
    shares
        .filter_map(|share| path.pose_at(share).ok())
        .map(|pose| position_of(&pose))
        .collect()
}

/// Velocities and accelerations out of the positions, by central differences.
fn moments(path: &[Sample]) -> Vec<Moment> {
    let positions: Vec<(f64, Vec<f64>)> = path
        .iter()
        .map(|sample| (sample.time, sample.joints.as_slice().to_vec()))
        .collect();
    let velocities = slopes(&positions);
    let accelerations = slopes(&velocities);
    let jerks = slopes(&accelerations);
    let all = positions
        .iter()
        .zip(velocities)
        .zip(accelerations)
        .zip(jerks);
    all.map(
        |((((time, position), (_, velocity)), (_, acceleration)), (_, jerks))| {
            let states = position.iter().zip(velocity).zip(acceleration);
            Moment {
                time: *time,
                states: states
                    .map(|((position, velocity), acceleration)| State {
                        position: *position,
                        velocity,
                        acceleration,
                    })
                    .collect(),
                jerks,
            }
        },
    )
    .collect()
}

/// Of each number over time: from the moment before to the one after. The move is at rest at both ends.
fn slopes(values: &[(f64, Vec<f64>)]) -> Vec<(f64, Vec<f64>)> {
    let mut slopes: Vec<(f64, Vec<f64>)> = values
        .iter()
        .map(|(time, values)| (*time, vec![0.0; values.len()]))
        .collect();
    let between = values.iter().zip(values.iter().skip(2));
    for ((_, slope), ((t0, before), (t1, after))) in slopes.iter_mut().skip(1).zip(between) {
        for (slope, (a, b)) in slope.iter_mut().zip(before.iter().zip(after)) {
            *slope = (b - a) / (t1 - t0);
        }
    }
    slopes
}

fn joint_limits(arm: &Arm) -> Vec<MotionLimits> {
    let joints = arm.serial.joint_list().iter();
    joints
        .map(|joint| MotionLimits {
            velocity: joint.max_speed,
            acceleration: joint.max_acceleration,
            jerk: f64::INFINITY,
        })
        .collect()
}

/// Where the arm cannot follow; a question that makes no sense is refused.
fn failure(arm: &Arm, error: &ToolMoveError) -> Result<ToolPathFailure, Refusal> {
    let error = match error {
        ToolMoveError::Tool(error) => error,
        ToolMoveError::NotReached {
            parameter,
            pose,
            source,
        } => {
            return Ok(ToolPathFailure {
                pose: Some(pose_body(pose)),
                ..stopped(*parameter, None, source)
            });
        }
        ToolMoveError::Joints(error) => return Err(Refusal::invalid("start_deg_mm", error)),
        ToolMoveError::BrokenOff(error) => return Err(Refusal::broken_off(*error)),
    };
    match error {
        ToolError::Unreachable {
            parameter,
            pose,
            source,
        } => Ok(ToolPathFailure {
            pose: Some(pose_body(pose)),
            ..unreachable(*parameter, None, source)
        }),
        ToolError::Jump {
            parameter,
            pose,
            joint,
            from,
            to,
        } => Ok(ToolPathFailure {
            parameter: shown(*parameter),
            pose: Some(pose_body(pose)),
            reason: format!(
                "{joint} would jump from {from:.2} to {to:.2}: a singularity, or a range that forces another branch"
            ),
            outside: Vec::new(),
        }),
        // With the wrist on its own way, which no question asks for.
        ToolError::Wrist { parameter } => Ok(stopped(*parameter, None, error)),
        ToolError::WristLimits {
            parameter,
            violations,
        } => Ok(ToolPathFailure {
            parameter: shown(*parameter),
            pose: None,
            reason: error.to_string(),
            outside: outside(violations),
        }),
        ToolError::TooSlow {
            joint,
            parameter,
            factor,
        } => Ok(ToolPathFailure {
            parameter: shown(*parameter),
            pose: None,
            reason: format!(
                "{joint} would slow the move {factor:.0} times; 1000 times is the most"
            ),
            outside: Vec::new(),
        }),
        ToolError::StartElsewhere { joint, is, begins } => {
            let index = arm.index(joint);
            let detail = format!("{joint} is at {is:.3}, the path begins at {begins:.3}");
            Err(Refusal::invalid(format!("start_deg_mm[{index}]"), detail).with_value(is.value))
        }
        ToolError::Path(error) => Err(path_refusal(error)),
        ToolError::TooLong { .. } | ToolError::Period { .. } => {
            Err(Refusal::invalid("period_s", error))
        }
        ToolError::Limit { .. } | ToolError::Profile(_) => {
            Err(Refusal::invalid("speed_mm_s", error))
        }
    }
}

fn stopped(parameter: f64, pose: Option<&Pose>, why: &dyn std::error::Error) -> ToolPathFailure {
    ToolPathFailure {
        parameter: shown(parameter),
        pose: pose.map(|pose| pose_body(&pose.xyzwpr())),
        reason: why.to_string(),
        outside: Vec::new(),
    }
}

fn unreachable(parameter: f64, pose: Option<&Pose>, error: &IkError) -> ToolPathFailure {
    let outside = match error {
        IkError::JointLimit { violations, .. } => outside(violations),
        IkError::OutOfReach { .. }
        | IkError::NoSolutionInConfiguration { .. }
        | IkError::NotFinite(_) => Vec::new(),
    };
    ToolPathFailure {
        outside,
        ..stopped(parameter, pose, error)
    }
}

fn outside(violations: &LimitViolations) -> Vec<ArmOutside> {
    violations
        .iter()
        .map(|violation| ArmOutside {
            joint: violation.joint.to_string(),
            value_deg_mm: shown(violation.value.0),
            min_deg_mm: violation.limits.min.0,
            max_deg_mm: violation.limits.max.0,
        })
        .collect()
}
