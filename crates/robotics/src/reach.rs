//! Which poses an arm reaches.

use std::num::NonZeroUsize;

use api::PoseBody;
use api::arms::{ArmSolver, ReachBody, ReachGrid, ReachPlane, ReachResult};
use kinematics::Pose;
use kinematics::serial::DlsOptions;
use planning::Wanted;

use crate::arm::{Arm, task_of};
use crate::convert::{frames_of, pose_at, shown};
use crate::inverse::{Question, Target, solve};
use crate::refusal::{Refusal, RefusalKind, length, within};

/// The most poses of one question, by what one of them costs.
fn most(method: ArmSolver) -> usize {
    match method {
        ArmSolver::ClosedForm => 250_000,
        ArmSolver::Quartic | ArmSolver::Textbook | ArmSolver::FiveLink => 20_000,
        ArmSolver::DampedLeastSquares => 2000,
    }
}

/// Poses that the closed form does between two looks at whether it is wanted: a millisecond.
const CHUNK: usize = 8192;

/// A search that serves to tell whether there is a way, not to move there.
const SEARCH: DlsOptions = DlsOptions {
    position_tolerance_mm: 1e-3,
    rotation_tolerance_rad: 1e-5,
    max_steps: 60,
    starts: 3,
};

/// In how many ways an arm reaches each of a set of poses, or each point of a plane.
///
/// Solved as by [`crate::inverse()`], without keeping the joints. Damped least squares finds one way or none, and may
/// miss one.
///
/// # Errors
/// No such model; a pose, grid, frame or method that is none; more poses than are looked at.
pub fn reach(model: &str, body: &ReachBody) -> Result<ReachResult, Refusal> {
    reach_while(model, body, Wanted::ALWAYS)
}

/// As [`reach`], as long as the answer is `wanted`.
///
/// # Errors
/// As [`reach`]; [`RefusalKind::BrokenOff`].
pub fn reach_while(
    model: &str,
    body: &ReachBody,
    wanted: Wanted<'_>,
) -> Result<ReachResult, Refusal> {
    let arm = Arm::named(model)?;
    let method = arm.solver(body.method)?;
    let frames = frames_of(&body.frames)?;
    let task = arm.task(
        body.task
            .filter(|_| method == ArmSolver::DampedLeastSquares),
    );
    let (poses, u_mm, v_mm) = match (&body.poses, &body.grid) {
        (Some(poses), None) => (listed(poses, method)?, Vec::new(), Vec::new()),
        (None, Some(grid)) => gridded(grid, method)?,
        (Some(_), Some(_)) => {
            return Err(Refusal::invalid(
                "grid",
                "there are poses too; give one of them",
            ));
        }
        (None, None) => return Err(Refusal::invalid("poses", "they are missing")),
    };
    let question = Question {
        arm,
        framed: arm.serial.with_frames(&frames),
        frames,
        task: task_of(task),
        search: SEARCH,
    };
    let counts = counted(&question, method, &poses, wanted)?;
    Ok(ReachResult {
        method,
        task,
        u_mm,
        v_mm,
        reachable: counts.iter().filter(|(_, inside)| *inside > 0).count(),
        solutions: counts.iter().map(|(solutions, _)| *solutions).collect(),
        inside: counts.iter().map(|(_, inside)| *inside).collect(),
    })
}

fn counted(
    question: &Question,
    method: ArmSolver,
    poses: &[Pose],
    wanted: Wanted<'_>,
) -> Result<Vec<(u8, u8)>, Refusal> {
    let arm = &question.arm;
    let mut counts = Vec::with_capacity(poses.len());
    if let (ArmSolver::ClosedForm, Some(model)) = (method, arm.closed) {
        for poses in poses.chunks(CHUNK) {
            wanted.check().map_err(Refusal::broken_off)?;
            let flanges: Vec<Pose> = poses
                .iter()
                .map(|X_UT| question.frames.flange_in_world(X_UT))
                .collect();
            let map = model
                .reachability(&flanges, NonZeroUsize::MIN)
                .map_err(|error| Refusal::invalid("poses", error))?;
            counts.extend(map.iter().map(|reach| (reach.solutions, reach.inside)));
        }
        return Ok(counts);
    }
    // A search begins where the one before ended.
    let mut near = arm.serial.home();
    for pose in poses {
        wanted.check().map_err(Refusal::broken_off)?;
        counts.push(match solve(question, method, &Target::Pose(*pose), &near) {
            Ok(found) => {
                let inside = found
                    .iter()
                    .filter(|found| arm.outside(&found.joints).is_empty());
                let count = |number: usize| u8::try_from(number).unwrap_or(u8::MAX);
                let counted = (count(found.len()), count(inside.count()));
                if method == ArmSolver::DampedLeastSquares
                    && let Some(first) = found.into_iter().next()
                {
                    near = first.joints;
                }
                counted
            }
            Err(refusal) if refusal.kind == RefusalKind::OutOfReach => (0, 0),
            Err(refusal) => return Err(refusal),
        });
    }
    Ok(counts)
}

fn listed(poses: &[PoseBody], method: ArmSolver) -> Result<Vec<Pose>, Refusal> {
    length("poses", poses.len(), [1, most(method)], "poses")?;
    let all = poses.iter().enumerate();
    all.map(|(index, pose)| pose_at(&format!("poses[{index}]"), pose))
        .collect()
}

type Gridded = (Vec<Pose>, Vec<f64>, Vec<f64>);

fn gridded(grid: &ReachGrid, method: ArmSolver) -> Result<Gridded, Refusal> {
    let step = within("grid.step_mm", grid.step_mm, [1e-3, 1e6], "mm")?;
    let _ = within("grid.across_mm", grid.across_mm, [-1e6, 1e6], "mm")?;
    let along = |path: &str, [from, to]: [f64; 2]| -> Result<u32, Refusal> {
        let _ = within(&format!("{path}[0]"), from, [-1e6, 1e6], "mm")?;
        let _ = within(&format!("{path}[1]"), to, [from, 1e6], "mm")?;
        let steps = ((to - from) / step + 1e-9).floor();
        // More columns than any grid has.
        let _ = within(path, steps, [0.0, 249_999.0], "steps")?;
        let counted = (0_u32..).take_while(|count| f64::from(*count) <= steps);
        Ok(counted.last().unwrap_or(0))
    };
    let (columns, rows) = (
        along("grid.u_mm", grid.u_mm)?,
        along("grid.v_mm", grid.v_mm)?,
    );
    let count = (f64::from(columns) + 1.0) * (f64::from(rows) + 1.0);
    let most = most(method);
    let limit = u32::try_from(most).map_or(f64::MAX, f64::from);
    if count > limit {
        let detail = format!(
            "{} x {} points, steps of {step} mm, are {count}; at most {most} are looked at by {method:?}",
            columns + 1,
            rows + 1
        );
        return Err(Refusal {
            max: Some(limit),
            ..Refusal::invalid("grid.step_mm", detail).with_value(count)
        });
    }
    let at = |from: f64, index: u32| from + f64::from(index) * step;
    let u: Vec<f64> = (0..=columns).map(|index| at(grid.u_mm[0], index)).collect();
    let v: Vec<f64> = (0..=rows).map(|index| at(grid.v_mm[0], index)).collect();
    let mut poses = Vec::new();
    for v in &v {
        for u in &u {
            poses.push(pose_at("grid", &place(grid, *u, *v))?);
        }
    }
    let shown_all = |list: Vec<f64>| list.into_iter().map(shown).collect();
    Ok((poses, shown_all(u), shown_all(v)))
}

fn place(grid: &ReachGrid, u: f64, v: f64) -> PoseBody {
    let across = grid.across_mm;
    let (x, y, z) = match grid.plane {
        ReachPlane::Xy => (u, v, across),
        ReachPlane::Xz => (u, across, v),
        ReachPlane::Yz => (across, u, v),
    };
    [x, y, z, grid.w_deg, grid.p_deg, grid.r_deg].into()
}
