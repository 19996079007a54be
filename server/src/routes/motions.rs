//! Motions: asking for one, and what became of each.

use std::time::Duration;

use api::{
    Motion, MotionBody, MotionList, MotionType, Outcome, ProblemCode, TargetBody, Violation,
};
use axum::Json;
use axum::http::{HeaderName, StatusCode, header};
use units::MmPerSec;

use super::params::{ControlHeader, MAX_PAGE, MotionId, Page, RobotOf, RobotPath};
use super::responses::{
    AnyProblem, BodyProblem, ControlProblem, CrossSite, InvalidJson, LinkProblem, NotFound,
};
use crate::authority::Claim;
use crate::commands::{CommandFailure, no_base};
use crate::config::{MAX_DEADLINE_MS, RobotPlan};
use crate::extract::JsonBody;
use crate::problem::Problem;
use crate::request_id::RequestId;
use crate::state::Robot;
use crate::target::{Paths, Prepared, Refusal};
use crate::wire_bodies::point_of;

const PATHS: Paths = Paths {
    speed: "speed_mm_s",
    point: [
        "target.pose.x_mm",
        "target.pose.y_mm",
        "target.pose.z_mm",
        "target.pose.w_deg",
        "target.pose.p_deg",
        "target.pose.r_deg",
    ],
    joints: "target.joints",
};
/// The longest reason, in characters.
const MAX_REASON: usize = 200;

/// Moves the robot.
///
/// The pose is rounded to thousandths of a millimeter and of a degree, as the controller's wire carries it, and
/// checked in the configuration the controller's program keeps: reach, joint limits, singularities. Then it is sent,
/// once. At tier 0 the answer `accepted` is the last thing the server can know of a motion.
#[utoipa::path(
    post, path = "/api/v1/cells/{cell}/robots/{robot}/motions", tag = "motions",
    params(RobotPath, ControlHeader),
    request_body = MotionBody,
    responses(
        (status = 202, description = "The controller took the motion.", body = Motion,
            headers(("location" = String, description = "Where the motion is."))),
        (status = 409, description = "`controller-rejected`: the controller refused it. `deadline-passed`: it waited too long and was not sent. `control-lost`: control of the cell ended before it was sent.",
            body = api::Problem, content_type = "application/problem+json"),
        (status = 422, description = "`validation`: the body does not fit. `out-of-workspace`, `joint-limit-exceeded`, `no-solution-in-configuration`, `singularity`: the arm cannot do it. Nothing was sent.",
            body = api::Problem, content_type = "application/problem+json"),
        ControlProblem, CrossSite, InvalidJson, NotFound, BodyProblem, LinkProblem, AnyProblem,
    ),
)]
pub(super) async fn create_motion(
    RobotOf(robot): RobotOf,
    claim: Claim,
    request_id: RequestId,
    JsonBody(body): JsonBody<MotionBody>,
) -> Result<(StatusCode, [(HeaderName, String); 1], Json<Motion>), Problem> {
    let plan = &robot.plan;
    check(&body).map_err(|problem| problem.robot(&plan.id))?;
    let prepared = prepare(plan, &body).map_err(|refusal| {
        refusal.log(&plan.id, &request_id);
        refused(plan, &refusal)
    })?;
    let within = body
        .deadline_ms
        .map_or(plan.deadline, Duration::from_millis);
    let accepted = robot
        .carry_out(prepared, claim, request_id, within, body.reason)
        .await
        .map_err(|failure| problem_of(&robot, failure))?;
    let motion = robot.motions.get(accepted.motion).ok_or_else(|| {
        Problem::new(ProblemCode::Internal, "the motion was forgotten at once")
            .outcome(Outcome::Unknown)
            .motion(Some(accepted.motion))
    })?;
    let location = format!(
        "/api/v1/cells/{}/robots/{}/motions/{}",
        plan.cell, plan.id, accepted.motion
    );
    Ok((
        StatusCode::ACCEPTED,
        [(header::LOCATION, location)],
        Json(motion.body(plan)),
    ))
}

/// Lists a robot's motions, newest first.
///
/// The server keeps the last 1,000 of each robot in memory, and none across a restart.
#[utoipa::path(
    get, path = "/api/v1/cells/{cell}/robots/{robot}/motions", tag = "motions",
    params(
        RobotPath,
        ("limit" = Option<usize>, Query, minimum = 1, maximum = 200, description = "How many at most; 50 where absent."),
        ("cursor" = Option<uuid::Uuid>, Query, description = "The `next_cursor` of the page before."),
    ),
    responses(
        (status = 200, description = "A page of motions.", body = MotionList),
        (status = 422, description = "`validation`: the query does not fit.", body = api::Problem, content_type = "application/problem+json"),
        NotFound, AnyProblem,
    ),
)]
pub(super) async fn list_motions(RobotOf(robot): RobotOf, page: Page) -> Json<MotionList> {
    debug_assert!(page.limit <= MAX_PAGE);
    let (records, more) = robot.motions.page(page.before, page.limit);
    let next_cursor = records
        .last()
        .filter(|_| more)
        .map(|record| record.id.to_string());
    Json(MotionList {
        motions: records
            .iter()
            .map(|record| record.body(&robot.plan))
            .collect(),
        next_cursor,
    })
}

/// Shows a motion and what became of it.
#[utoipa::path(
    get, path = "/api/v1/cells/{cell}/robots/{robot}/motions/{id}", tag = "motions",
    params(
        RobotPath,
        ("id" = uuid::Uuid, Path, description = "The motion's id."),
    ),
    responses((status = 200, description = "The motion.", body = Motion), NotFound, AnyProblem),
)]
pub(super) async fn get_motion(
    RobotOf(robot): RobotOf,
    MotionId(id): MotionId,
) -> Result<Json<Motion>, Problem> {
    let record = robot.motions.get(id).ok_or_else(|| {
        Problem::not_found(format!(
            "robot `{}` has no motion {id}, or no longer",
            robot.plan.id
        ))
    })?;
    Ok(Json(record.body(&robot.plan)))
}

/// Checks what needs no arm: which fields go together, and their ranges.
fn check(body: &MotionBody) -> Result<(), Problem> {
    let mut violations = Vec::new();
    match (body.motion_type, body.target.is_some()) {
        (MotionType::Joint, false) => violations.push(violation(
            "target",
            "missing; a JOINT motion needs `pose` or `joints`",
        )),
        (MotionType::Home, true) => {
            violations.push(violation("target", "a HOME motion has no target"));
        }
        (MotionType::Joint, true) | (MotionType::Home, false) => {}
    }
    if let Some(deadline) = body.deadline_ms
        && !(1..=MAX_DEADLINE_MS).contains(&deadline)
    {
        #[expect(clippy::cast_precision_loss, reason = "only shown")]
        violations.push(Violation {
            value: Some(deadline as f64),
            min: Some(1.0),
            max: Some(MAX_DEADLINE_MS as f64),
            ..violation(
                "deadline_ms",
                &format!("{deadline} ms is not from 1 to {MAX_DEADLINE_MS} ms"),
            )
        });
    }
    if let Some(reason) = &body.reason {
        let length = reason.chars().count();
        if length > MAX_REASON {
            violations.push(violation(
                "reason",
                &format!("{length} characters; {MAX_REASON} at most"),
            ));
        }
    }
    let Some(first) = violations.first() else {
        return Ok(());
    };
    let detail = format!("{}: {}", first.item, first.message);
    Err(Problem::not_sent(ProblemCode::Validation, detail).violations(violations))
}

fn violation(item: &str, message: &str) -> Violation {
    Violation {
        item: item.to_owned(),
        message: message.to_owned(),
        ..Violation::default()
    }
}

fn prepare(plan: &RobotPlan, body: &MotionBody) -> Result<Prepared, Refusal> {
    let speed = MmPerSec(body.speed_mm_s);
    match &body.target {
        Some(TargetBody::Pose(pose)) => plan.prepare_point(&point_of(pose), speed),
        Some(TargetBody::Joints(joints)) => plan.prepare_joints((*joints).into(), speed),
        None => plan.prepare_home(speed),
    }
}

fn refused(plan: &RobotPlan, refusal: &Refusal) -> Problem {
    Problem::not_sent(refusal.code(), refusal.to_string())
        .robot(&plan.id)
        .violations(refusal.violations(&PATHS))
}

fn problem_of(robot: &Robot, failure: CommandFailure) -> Problem {
    match failure {
        CommandFailure::Rejected { motion, reply } => robot.rejected(motion, reply),
        CommandFailure::Refused(refusal) => refused(&robot.plan, &refusal),
        CommandFailure::NoBase(base) => {
            Problem::not_sent(ProblemCode::NoAcceptedTarget, no_base(base)).robot(&robot.plan.id)
        }
        CommandFailure::Problem(problem) => problem,
    }
}
