//! What a motion would be: checked as if it were asked for, and nothing is sent.

use std::sync::Arc;

use api::{JointsBody, MotionBody, MotionPreview, ProblemCode};
use axum::Json;
use axum::extract::State;
use jiff::SignedDuration;
use kinematics::{PendantJoints, Pose};
use tokio::time::Instant;
use uuid::Uuid;

use super::kinematics::{branch_body, order};
use super::params::{RobotOf, RobotPath};
use super::responses::{AnyProblem, BodyProblem, CrossSite, InvalidJson, NotFound};
use super::{motion_body, motion_zones, preview_profile};
use crate::extract::JsonBody;
use crate::link::Base;
use crate::motions::{
    Asked, PLAN_KEPT, Plan, Planned, Speed, actual, joint_duration, line_duration,
    point_of_thousandths, resolve,
};
use crate::problem::Problem;
use crate::state::{App, Robot, RobotLink};
use crate::target::margins;
use crate::wire_bodies::{joints_body, pose_body, shown, singularity_body};

/// The largest difference from the start of a plan where the caller names none, in degrees.
const START_TOLERANCE_DEG: f64 = 0.5;

/// Says what a motion would be, and keeps that as a plan.
///
/// A motion with the `plan_id` is then exactly this one, rounded target and all, or it is refused: `plan-expired` after
/// a minute, `stale-state` once anything about the robot's motions has changed or the arm has moved. Nothing is sent
/// here, and no key is needed.
#[utoipa::path(
    post, path = "/api/v1/cells/{cell}/robots/{robot}/motions/preview", tag = "motions",
    params(RobotPath),
    request_body = MotionBody,
    responses(
        (status = 200, description = "What it would be; `feasible` says whether it would be taken.", body = MotionPreview),
        (status = 422, description = "`validation`: the body does not fit.", body = api::Problem, content_type = "application/problem+json"),
        (status = 409, description = "`deadline-passed`: its `not_after` has passed.", body = api::Problem, content_type = "application/problem+json"),
        CrossSite, InvalidJson, NotFound, BodyProblem, AnyProblem,
    ),
)]
pub(super) async fn preview_motion(
    State(app): State<Arc<App>>,
    RobotOf(robot): RobotOf,
    JsonBody(body): JsonBody<MotionBody>,
) -> Result<Json<MotionPreview>, Problem> {
    let of_robot = |problem: Problem| problem.robot(&robot.plan.id);
    let _timing = motion_body::check(&body, &robot.plan, robot.motions.now()).map_err(of_robot)?;
    let revision = robot.motions.book.revision();
    let (planned, start) = match &robot.link {
        RobotLink::Seed(link) => {
            let start = match link.status().base {
                Base::Target(wire) => Some(wire.thousandths()),
                Base::Nothing | Base::InDoubt => None,
            };
            (
                motion_body::prepare(&robot, &body).map(Planned::Seed),
                Start::Target(start),
            )
        }
        RobotLink::CellServer(link) => {
            let start = actual(&robot, link).ok();
            (
                resolve(&robot, link, &body, motion_body::refused).map(Planned::Numbered),
                Start::Actual(start.map(|actual| (actual.point, actual.joints))),
            )
        }
    };
    let planned = planned.and_then(|planned| {
        let asked = planned.asked();
        let from = start.joints();
        let profile = from.and_then(|from| preview_profile::profile(&robot.plan, &from, &asked));
        motion_zones::check_with(&app, &robot, &asked, profile.as_ref())?;
        Ok((planned, profile))
    });
    Ok(Json(match planned {
        Ok((planned, profile)) => MotionPreview {
            profile,
            ..feasible(&robot, planned, start, revision)
        },
        Err(problem) => refused(&problem, start, revision),
    }))
}

/// Where a motion would begin, as far as that is known.
#[derive(Clone, Copy, Debug)]
enum Start {
    /// The target last accepted.
    Target(Option<[i32; 6]>),
    /// The controller's report.
    Actual(Option<([i32; 6], PendantJoints)>),
}

impl Start {
    fn joints(self) -> Option<PendantJoints> {
        match self {
            Self::Actual(Some((_, joints))) => Some(joints),
            Self::Actual(None) | Self::Target(_) => None,
        }
    }

    fn point(self) -> Option<[i32; 6]> {
        match self {
            Self::Actual(actual) => actual.map(|(point, _)| point),
            Self::Target(target) => target,
        }
    }
}

fn feasible(robot: &Arc<Robot>, planned: Planned, start: Start, revision: u64) -> MotionPreview {
    let plan = &robot.plan;
    let motions = &robot.motions;
    let asked = planned.asked();
    let id = Uuid::now_v7();
    motions.plans.keep(Plan {
        id,
        planned,
        revision,
        start: start.joints(),
        expires: Instant::now() + PLAN_KEPT,
    });
    let kept = SignedDuration::try_from(PLAN_KEPT).ok();
    let near = start.joints().unwrap_or(asked.joints);
    MotionPreview {
        feasible: true,
        plan_id: Some(id),
        expires_at: kept.and_then(|kept| motions.now().checked_add(kept).ok()),
        target: Some(pose_body(&point_of_thousandths(asked.point))),
        expected_joints: Some(joints_body(&asked.joints)),
        margins: margins(plan, &asked.joints),
        singularity: Some(singularity_body(&plan.model.singularity(&asked.joints))),
        solutions: solutions(robot, &asked, &near),
        duration_s: duration(robot, &asked, start).map(shown),
        ..empty(start, revision)
    }
}

fn refused(problem: &Problem, start: Start, revision: u64) -> MotionPreview {
    MotionPreview {
        code: Some(problem.code()),
        detail: Some(problem.detail().to_owned()),
        violations: problem.list().to_vec(),
        ..empty(start, revision)
    }
}

fn empty(start: Start, revision: u64) -> MotionPreview {
    MotionPreview {
        feasible: false,
        plan_id: None,
        expires_at: None,
        state_revision: revision,
        target: None,
        expected_joints: None,
        margins: Vec::new(),
        singularity: None,
        solutions: Vec::new(),
        start_joints: start.joints().map(|joints| joints_body(&joints)),
        duration_s: None,
        profile: None,
        code: None,
        detail: None,
        violations: Vec::new(),
    }
}

fn solutions(robot: &Robot, asked: &Asked, near: &PendantJoints) -> Vec<api::BranchBody> {
    let plan = &robot.plan;
    let Ok(pose) = Pose::try_from_xyzwpr(&point_of_thousandths(asked.point)) else {
        return Vec::new();
    };
    let Ok(all) = plan.model.inverse_all(&plan.frames.flange_in_world(&pose)) else {
        return Vec::new();
    };
    let mut all: Vec<_> = all.iter().copied().collect();
    all.sort_by(|a, b| order(plan, near, a, b));
    all.iter()
        .map(|solution| branch_body(plan, near, solution))
        .collect()
}

fn duration(robot: &Robot, asked: &Asked, start: Start) -> Option<f64> {
    match asked.speed {
        Speed::Percent(percent) => start
            .joints()
            .map(|from| joint_duration(&robot.plan, &from, &asked.joints, percent)),
        Speed::MmPerSec(speed) => line_duration(start.point()?, asked.point, speed),
    }
}

/// What a motion is made from: its plan, or its body.
pub(super) fn plan_of(robot: &Robot, body: &MotionBody) -> Result<Option<Plan>, Problem> {
    let Some(id) = body.plan_id else {
        return Ok(None);
    };
    let plan = robot.motions.plans.get(id).ok_or_else(|| {
        let detail = format!("there is no plan {id}, or no longer");
        Problem::not_sent(ProblemCode::PlanExpired, detail)
    })?;
    let asked = plan.planned.asked();
    if asked.motion_type != body.motion_type {
        let detail = format!("type: the plan is of a {:?} motion", asked.motion_type);
        return Err(Problem::not_sent(ProblemCode::Validation, detail));
    }
    Ok(Some(plan))
}

/// Refuses a motion whose caller looked at another state than the present one.
pub(super) fn check_expected(
    robot: &Robot,
    body: &MotionBody,
    plan: Option<&Plan>,
) -> Result<(), Problem> {
    let expect = body.expect.as_ref();
    let revision = robot.motions.book.revision();
    let revisions = [
        plan.map(|plan| plan.revision),
        expect.and_then(|expect| expect.state_revision),
    ];
    for expected in revisions.into_iter().flatten() {
        if expected != revision {
            let detail = format!("the state has revision {revision}, not {expected}");
            return Err(stale(detail));
        }
    }
    let start = match (expect.and_then(|expect| expect.start_joints), plan) {
        (Some(joints), _) => Some(joints),
        (None, Some(plan)) => plan.start.as_ref().map(joints_body),
        (None, None) => None,
    };
    let tolerance = expect
        .and_then(|expect| expect.start_tolerance_deg)
        .unwrap_or(START_TOLERANCE_DEG);
    match (start, &robot.link) {
        (None, _) => Ok(()),
        (Some(start), RobotLink::CellServer(link)) => {
            let actual = actual(robot, link)?;
            near(&actual.joints, start, tolerance)
        }
        (Some(_), RobotLink::Seed(_)) => Err(Problem::not_sent(
            ProblemCode::NotSupported,
            "expect.start_joints: the robot's controller runs the seed program and does not report its joints",
        )),
    }
}

fn near(actual: &PendantJoints, expected: JointsBody, tolerance: f64) -> Result<(), Problem> {
    for (index, (is, was)) in actual
        .degrees()
        .into_iter()
        .zip(<[f64; 6]>::from(expected))
        .enumerate()
    {
        // Written so that what cannot be compared is not near.
        let close = (is - was).abs() <= tolerance;
        if !close {
            return Err(stale(format!(
                "J{} is at {is:.3} degrees, expected at {was:.3} within {tolerance}",
                index + 1
            )));
        }
    }
    Ok(())
}

fn stale(detail: String) -> Problem {
    Problem::not_sent(ProblemCode::StaleState, detail)
        .hint("Look at the robot's state again, then ask again.")
}
