//! Which joints reach a pose.

mod methods;

use std::cmp::Ordering;

use api::arms::{ArmBranch, ArmInverseBody, ArmInverseResult, ArmSolver};
use kinematics::serial::{JointValues, SerialArm, Task};
use kinematics::{Frames, Pose, SingularityKind};

use crate::arm::{Arm, task_of};
use crate::convert::{frames_of, pose_at, shown};
use crate::refusal::{Refusal, RefusalKind, count_or, within, within_or};

pub(crate) use methods::{Found, Question, Target, solve};

/// Steps of a search, all starts together.
const MOST_STEPS: f64 = 100_000.0;

/// Whether [`inverse`] would search, which takes long, or compute.
///
/// # Errors
/// No such model, or a method that does not cover it.
pub fn is_search(model: &str, body: &ArmInverseBody) -> Result<bool, Refusal> {
    let method = Arm::named(model)?.solver(body.method)?;
    Ok(method == ArmSolver::DampedLeastSquares)
}

/// Every joint set that reaches a pose, by the method that was asked for.
///
/// Closed form and quartic after the thesis's (14) to (18), the textbook's geometric solution (1.34) to (1.57), the
/// paper's (3) and (4) for its five-link arm, damped least squares for any arm. Those inside the ranges come first,
/// the nearest to `near_deg_mm` before the others. Joint sets outside the ranges are told too; with none inside,
/// `reason` says why.
///
/// # Errors
/// No such model, a method that does not cover it, an item that is out of its range, or a pose that no joint set
/// reaches: how far it is out of reach, or how near a search got.
pub fn inverse(model: &str, body: &ArmInverseBody) -> Result<ArmInverseResult, Refusal> {
    let arm = Arm::named(model)?;
    let method = arm.solver(body.method)?;
    let frames = frames_of(&body.frames)?;
    let near = match &body.near_deg_mm {
        Some(near) => arm.joints("near_deg_mm", near)?,
        None => arm.serial.home(),
    };
    let target = target(body, method)?;
    let task = match method {
        ArmSolver::DampedLeastSquares => arm.task(body.task),
        ArmSolver::ClosedForm | ArmSolver::Quartic | ArmSolver::Textbook | ArmSolver::FiveLink => {
            let own = arm.task(None);
            if let Some(asked) = body.task.filter(|asked| *asked != own) {
                let detail = format!(
                    "{method:?} solves {own:?} only, not {asked:?}; damped-least-squares takes any task"
                );
                return Err(Refusal::invalid("task", detail));
            }
            own
        }
    };
    let question = Question {
        arm,
        framed: arm.serial.with_frames(&frames),
        frames,
        task: task_of(task),
        search: search_of(body)?,
    };
    let found = solve(&question, method, &target, &near)?;
    let mut branches: Vec<ArmBranch> = found
        .iter()
        .map(|found| branch(&question, found, &target, &near))
        .collect();
    branches.sort_by(order);
    let nearest = branches.first().is_some_and(|first| first.within_ranges);
    Ok(ArmInverseResult {
        method,
        task,
        nearest: nearest.then_some(0),
        reason: (!nearest).then(|| reason(&branches)),
        branches,
    })
}

fn target(body: &ArmInverseBody, method: ArmSolver) -> Result<Target, Refusal> {
    match (&body.pose, &body.points) {
        (Some(pose), None) => Ok(Target::Pose(pose_at("pose", pose)?)),
        (None, Some(points)) if method == ArmSolver::FiveLink => {
            for (path, point) in [("points.e_mm", points.e_mm), ("points.f_mm", points.f_mm)] {
                for value in point {
                    let _ = within(path, value, [-1e6, 1e6], "mm")?;
                }
            }
            Ok(Target::Points(points.e_mm, points.f_mm))
        }
        (None, Some(_)) => Err(Refusal::invalid(
            "points",
            format!("E and F are the five-link arm's; {method:?} takes a pose"),
        )),
        (Some(_), Some(_)) => Err(Refusal::invalid(
            "points",
            "there is a pose too; give one of them",
        )),
        (None, None) => Err(Refusal::invalid("pose", "it is missing")),
    }
}

fn search_of(body: &ArmInverseBody) -> Result<kinematics::serial::DlsOptions, Refusal> {
    let usual = kinematics::serial::DlsOptions::default();
    let Some(search) = &body.search else {
        return Ok(usual);
    };
    let position_tolerance_mm = within_or(
        "search.position_tolerance_mm",
        search.position_tolerance_mm,
        usual.position_tolerance_mm,
        [1e-9, 100.0],
        "mm",
    )?;
    let rotation = within_or(
        "search.rotation_tolerance_deg",
        search.rotation_tolerance_deg,
        usual.rotation_tolerance_rad.to_degrees(),
        [1e-10, 90.0],
        "deg",
    )?;
    let max_steps = count_or("search.max_steps", search.max_steps, 200, [1, 10_000])?;
    let starts = count_or("search.starts", search.starts, 20, [1, 1000])?;
    let effort = f64::from(max_steps) * f64::from(starts);
    if effort > MOST_STEPS {
        let detail = format!(
            "{starts} starts of {max_steps} steps are {effort} steps; at most {MOST_STEPS} are made"
        );
        return Err(Refusal::invalid("search", detail).with_value(effort));
    }
    Ok(kinematics::serial::DlsOptions {
        position_tolerance_mm,
        rotation_tolerance_rad: rotation.to_radians(),
        max_steps: max_steps.try_into().unwrap_or(usual.max_steps),
        starts: starts.try_into().unwrap_or(usual.starts),
    })
}

fn branch(question: &Question, found: &Found, target: &Target, near: &JointValues) -> ArmBranch {
    let arm = &question.arm;
    let joints = arm.shown(&found.joints);
    let outside = arm.outside(&found.joints);
    let (position, rotation) = target.errors(question, &found.joints);
    let present = arm.shown(near);
    let away = joints.iter().zip(&present).map(|(a, b)| (a - b).abs());
    ArmBranch {
        within_ranges: outside.is_empty(),
        outside,
        configuration: arm.configuration(&joints),
        singular: found.singular.clone(),
        position_error_mm: position,
        rotation_error_deg: rotation.to_degrees(),
        distance_deg_mm: shown(away.fold(0.0, f64::max)),
        steps: found.steps,
        joints_deg_mm: joints,
    }
}

fn order(a: &ArmBranch, b: &ArmBranch) -> Ordering {
    b.within_ranges
        .cmp(&a.within_ranges)
        .then_with(|| a.distance_deg_mm.total_cmp(&b.distance_deg_mm))
}

/// Of the branch that is beyond its ranges by the least.
fn reason(branches: &[ArmBranch]) -> String {
    let excess = |branch: &ArmBranch| {
        let beyond = branch.outside.iter().map(|outside| {
            (outside.min_deg_mm - outside.value_deg_mm)
                .max(outside.value_deg_mm - outside.max_deg_mm)
        });
        beyond.fold(0.0, f64::max)
    };
    let least = branches
        .iter()
        .min_by(|a, b| excess(a).total_cmp(&excess(b)));
    let count = branches.len();
    let joints: Vec<String> = least
        .into_iter()
        .flat_map(|branch| &branch.outside)
        .map(|outside| {
            format!(
                "{} would be {:.3}, its range is {} to {}",
                outside.joint, outside.value_deg_mm, outside.min_deg_mm, outside.max_deg_mm
            )
        })
        .collect();
    format!(
        "{count} joint sets reach the pose, none inside the ranges; of the nearest, {}",
        joints.join("; ")
    )
}

impl Target {
    /// How far the joints' pose is off, in millimeters and radians, as far as the task asks.
    fn errors(&self, question: &Question, joints: &JointValues) -> (f64, f64) {
        match self {
            Target::Pose(X_UT) => pose_errors(&question.framed, question.task, joints, X_UT),
            Target::Points(e, f) => methods::point_errors(question, joints, e, f),
        }
    }
}

fn pose_errors(arm: &SerialArm, task: Task, joints: &JointValues, X_UT: &Pose) -> (f64, f64) {
    let Ok(is) = arm.forward(joints) else {
        return (f64::MAX, f64::MAX);
    };
    let (position, rotation) = is.distance_to(X_UT);
    let rotation = match task {
        Task::Pose => rotation.0,
        Task::PositionAndAxis => {
            let z = |pose: &Pose| pose.isometry().rotation * nalgebra::Vector3::z();
            let (a, b) = (z(&is), z(X_UT));
            a.cross(&b).norm().atan2(a.dot(&b))
        }
        Task::PositionAndHeading => {
            let turn = X_UT.isometry().rotation * is.isometry().rotation.inverse();
            let r = turn.to_rotation_matrix();
            (r[(1, 0)] - r[(0, 1)]).atan2(r[(0, 0)] + r[(1, 1)]).abs()
        }
        Task::Position => 0.0,
    };
    (position.0, rotation)
}

pub(crate) fn singular_name(kind: SingularityKind) -> String {
    kind.to_string()
}

/// Of what no joint set reaches.
pub(crate) fn out_of_reach(path: &str, detail: impl std::fmt::Display) -> Refusal {
    Refusal::new(RefusalKind::OutOfReach, path, detail)
}

/// `X_WF` of the tool's pose.
pub(crate) fn flange(frames: &Frames, X_UT: &Pose) -> Pose {
    frames.flange_in_world(X_UT)
}
