//! Taking a motion back, holding it, stopping the robot, and its speed override.

use std::sync::Arc;
use std::time::Duration;

use api::{
    Motion, MotionState, Outcome, ProblemCode, SpeedOverride, StopBody, StopEffect, StopResult,
    Tier, Violation,
};
use axum::Json;
use axum::extract::State;
use protocol::v2::Percent;
use tokio::time::Instant;
use uuid::Uuid;

use super::motions::{find, shown_motion};
use super::params::{ControlHeader, MotionId, RobotOf, RobotPath};
use super::responses::{
    AnyProblem, BodyProblem, ControlProblem, CrossSite, InvalidJson, LinkProblem, NotFound,
};
use crate::authority::Claim;
use crate::extract::{JsonBody, OptionalJson};
use crate::identity::{Principal, entry};
use crate::link::cell_server::{CellServerLink, LinkError};
use crate::motions::{Progress, Record};
use crate::problem::Problem;
use crate::request_id::RequestId;
use crate::state::{App, Robot, RobotLink};

/// How long the end of a motion that was stopped is waited for.
const SLOWING_DOWN: Duration = Duration::from_secs(5);

/// Takes a motion back.
///
/// One that waits is not sent. One that runs is stopped, where the controller can be told to (tier 2); what waits
/// behind it is then not sent either, because it was to begin from another place. A motion that is canceled already is
/// answered the same again; this needs no key.
#[utoipa::path(
    post, path = "/api/v1/cells/{cell}/robots/{robot}/motions/{id}/cancel", tag = "motions",
    params(RobotPath, ("id" = Uuid, Path, description = "The motion's id.")),
    responses(
        (status = 200, description = "The motion. `canceled`, unless it came to its end before.", body = Motion),
        (status = 409, description = "`wrong-motion-state`: it is at another end. `not-supported`: it is with a controller that cannot be stopped.",
            body = api::Problem, content_type = "application/problem+json"),
        CrossSite, NotFound, LinkProblem, AnyProblem,
    ),
)]
pub(super) async fn cancel_motion(
    RobotOf(robot): RobotOf,
    MotionId(id): MotionId,
) -> Result<Json<Motion>, Problem> {
    let record = command_on(&robot, id).await?;
    let canceled = match &record.progress {
        Progress::Ended { .. } => record,
        Progress::Queued if robot.motions.take_back(id) => find(&robot, id).await?,
        Progress::Queued | Progress::Dispatched | Progress::Accepted | Progress::Executing => {
            let link = controller(
                &robot,
                "the motion is with the controller, which runs the seed program and cannot be told to stop",
            )?;
            let _report = link
                .stop()
                .await
                .map_err(|error| of_link(&error).motion(Some(id)).robot(&robot.plan.id))?;
            let limit = Instant::now() + SLOWING_DOWN;
            let ended = |progress: &Progress| progress.end().is_some();
            match robot.motions.book.wait(id, limit, ended).await {
                Some(record) => record,
                None => find(&robot, id).await?,
            }
        }
    };
    match (canceled.progress.state(), canceled.progress.end()) {
        // Still slowing down: the answer shows the motion as it is.
        (MotionState::Canceled, _) | (_, None) => Ok(Json(shown_motion(&robot, &canceled))),
        (state, Some(_)) => Err(wrong_state(&robot, &canceled, state, "canceled")),
    }
}

/// Holds the running motion; it goes on when it is resumed, here or at the controller.
#[utoipa::path(
    post, path = "/api/v1/cells/{cell}/robots/{robot}/motions/{id}/pause", tag = "motions",
    params(RobotPath, ("id" = Uuid, Path, description = "The motion's id.")),
    responses(
        (status = 200, description = "The motion, held.", body = Motion),
        (status = 409, description = "`wrong-motion-state`: it does not run. `not-supported`: this controller cannot be told to.",
            body = api::Problem, content_type = "application/problem+json"),
        CrossSite, NotFound, LinkProblem, AnyProblem,
    ),
)]
pub(super) async fn pause_motion(
    RobotOf(robot): RobotOf,
    MotionId(id): MotionId,
) -> Result<Json<Motion>, Problem> {
    let (link, record) = running(&robot, id, "paused").await?;
    let _held = link
        .hold()
        .await
        .map_err(|error| of_link(&error).motion(Some(id)).robot(&robot.plan.id))?;
    Ok(Json(shown_motion(&robot, &record)))
}

/// Lets a motion on hold go on. The arm moves, so it needs control of the cell, as a motion does.
#[utoipa::path(
    post, path = "/api/v1/cells/{cell}/robots/{robot}/motions/{id}/resume", tag = "motions",
    params(RobotPath, ControlHeader, ("id" = Uuid, Path, description = "The motion's id.")),
    responses(
        (status = 200, description = "The motion.", body = Motion),
        (status = 409, description = "`wrong-motion-state`: it does not run. `not-supported`: this controller cannot be told to. `control-lost`: control of the cell ended.",
            body = api::Problem, content_type = "application/problem+json"),
        ControlProblem, CrossSite, NotFound, LinkProblem, AnyProblem,
    ),
)]
pub(super) async fn resume_motion(
    RobotOf(robot): RobotOf,
    _control: Claim,
    MotionId(id): MotionId,
) -> Result<Json<Motion>, Problem> {
    let (link, record) = running(&robot, id, "resumed").await?;
    let _resumed = link
        .resume()
        .await
        .map_err(|error| of_link(&error).motion(Some(id)).robot(&robot.plan.id))?;
    Ok(Json(shown_motion(&robot, &record)))
}

/// Stops the robot. It needs no key, no lease and no place in a queue.
///
/// What waits is taken back on every robot. What the arm then does depends on its controller, and `stop_effect` says
/// it: `halts_motion`, or `issues_nothing_more` where a motion that the controller has taken runs to its end. **This is
/// a functional stop and no emergency stop.**
#[utoipa::path(
    post, path = "/api/v1/cells/{cell}/robots/{robot}/stop", tag = "motions",
    params(RobotPath),
    request_body(content = StopBody, description = "May be left out."),
    responses(
        (status = 200, description = "What it did.", body = StopResult),
        (status = 503, description = "`stop-unconfirmed`: nothing more is sent, and the controller has not confirmed that it stops.",
            body = api::Problem, content_type = "application/problem+json"),
        CrossSite, InvalidJson, NotFound, BodyProblem, AnyProblem,
        (status = 422, description = "`validation`: the body does not fit.", body = api::Problem, content_type = "application/problem+json"),
    ),
)]
pub(super) async fn stop_robot(
    State(app): State<Arc<App>>,
    RobotOf(robot): RobotOf,
    principal: Principal,
    request_id: RequestId,
    OptionalJson(body): OptionalJson<StopBody>,
) -> Result<Json<StopResult>, Problem> {
    let category = body.unwrap_or_default().category;
    // First of all: nothing more goes out, whatever the controller answers.
    let canceled = robot.motions.stop();
    tracing::warn!(
        robot.id = robot.plan.id,
        ?category,
        canceled = canceled.len(),
        "a stop was asked for"
    );
    let mut about = entry(&principal, "robot.stop", &*robot.plan.id, &request_id);
    about.cell = Some(robot.plan.cell.clone());
    app.audit.note(about);
    let (stop_effect, text) = match &robot.link {
        RobotLink::Seed(_) => (
            StopEffect::IssuesNothingMore,
            "The server sends nothing more. A motion the controller has taken runs to its end: the program on this \
             controller cannot be told to stop.",
        ),
        RobotLink::CellServer(link) => {
            let report = link
                .stop()
                .await
                .map_err(|error| of_link(&error).robot(&robot.plan.id))?;
            (
                report.effect,
                match robot.plan.tier {
                    Tier::SeedStatus => {
                        "The controller has ended the seed program, and with it the running motion, by a controlled \
                         deceleration. The program is started again when the arm stands still."
                    }
                    Tier::Seed | Tier::CellServer => {
                        "The controller was told to stop and has confirmed it: the running motion ends by a \
                         controlled deceleration."
                    }
                },
            )
        }
    };
    Ok(Json(StopResult {
        robot: robot.plan.id.clone(),
        stop_effect,
        text: text.to_owned(),
        canceled,
    }))
}

/// Shows the controller's general speed override.
#[utoipa::path(
    get, path = "/api/v1/cells/{cell}/robots/{robot}/speed-override", tag = "motions",
    params(RobotPath),
    responses(
        (status = 200, description = "The override.", body = SpeedOverride),
        (status = 409, description = "`not-supported`: this controller does not report it.", body = api::Problem, content_type = "application/problem+json"),
        (status = 503, description = "`controller-disconnected`: it has not reported it yet.", body = api::Problem, content_type = "application/problem+json"),
        NotFound, AnyProblem,
    ),
)]
pub(super) async fn get_speed_override(
    RobotOf(robot): RobotOf,
) -> Result<Json<SpeedOverride>, Problem> {
    let reads = "the seed program does not report the speed override";
    let link = controller(&robot, reads).map_err(|problem| problem.outcome(Outcome::None))?;
    let seen = link.view().status.ok_or_else(|| {
        Problem::new(
            ProblemCode::ControllerDisconnected,
            "the controller has not reported its speed override yet",
        )
        .robot(&robot.plan.id)
        .retry_after_a_second()
    })?;
    Ok(Json(SpeedOverride {
        percent: seen.line.speed_override,
    }))
}

/// Sets the controller's general speed override. It holds for whatever moves the arm from now on, so it needs
/// control of the cell.
#[utoipa::path(
    put, path = "/api/v1/cells/{cell}/robots/{robot}/speed-override", tag = "motions",
    params(RobotPath, ControlHeader),
    request_body = SpeedOverride,
    responses(
        (status = 200, description = "The override, as the controller confirmed it.", body = SpeedOverride),
        (status = 409, description = "`not-supported`: this controller cannot be told. `control-lost`: control of the cell ended.", body = api::Problem, content_type = "application/problem+json"),
        (status = 422, description = "`validation`: not 1 to 100.", body = api::Problem, content_type = "application/problem+json"),
        ControlProblem, CrossSite, InvalidJson, NotFound, BodyProblem, LinkProblem, AnyProblem,
    ),
)]
pub(super) async fn put_speed_override(
    RobotOf(robot): RobotOf,
    _control: Claim,
    JsonBody(body): JsonBody<SpeedOverride>,
) -> Result<Json<SpeedOverride>, Problem> {
    let percent = Percent::try_new(body.percent).map_err(|_| {
        let message = format!("{} is not from 1 to 100", body.percent);
        Problem::not_sent(ProblemCode::Validation, format!("percent: {message}"))
            .robot(&robot.plan.id)
            .violations(vec![Violation {
                item: "percent".to_owned(),
                message,
                value: Some(f64::from(body.percent)),
                min: Some(1.0),
                max: Some(100.0),
            }])
    })?;
    let link = controller(&robot, "the seed program cannot be told a speed override")?;
    let line = link
        .set_override(percent)
        .await
        .map_err(|error| of_link(&error).robot(&robot.plan.id))?;
    Ok(Json(SpeedOverride {
        percent: line.speed_override,
    }))
}

/// The motion a command is about.
async fn command_on(robot: &Robot, id: Uuid) -> Result<Record, Problem> {
    let found = find(robot, id).await;
    found.map_err(|problem| problem.outcome(Outcome::NotSent))
}

async fn running<'a>(
    robot: &'a Robot,
    id: Uuid,
    done: &str,
) -> Result<(&'a CellServerLink, Record), Problem> {
    let record = command_on(robot, id).await?;
    let refusal = "the seed program cannot be told to hold a motion";
    let link = controller(robot, refusal)?;
    if !robot.plan.tier.capabilities().hold_and_continue {
        return Err(Problem::not_sent(ProblemCode::NotSupported, refusal).robot(&robot.plan.id));
    }
    match record.progress {
        Progress::Accepted | Progress::Executing => Ok((link, record)),
        Progress::Queued | Progress::Dispatched | Progress::Ended { .. } => {
            let state = record.progress.state();
            Err(wrong_state(robot, &record, state, done))
        }
    }
}

fn controller<'a>(robot: &'a Robot, otherwise: &str) -> Result<&'a CellServerLink, Problem> {
    match &robot.link {
        RobotLink::CellServer(link) => Ok(link),
        RobotLink::Seed(_) => {
            Err(Problem::not_sent(ProblemCode::NotSupported, otherwise).robot(&robot.plan.id))
        }
    }
}

fn wrong_state(robot: &Robot, record: &Record, state: MotionState, done: &str) -> Problem {
    let detail = format!("the motion is {state:?} and cannot be {done}");
    Problem::not_sent(ProblemCode::WrongMotionState, detail)
        .robot(&robot.plan.id)
        .motion(Some(record.id))
}

fn of_link(error: &LinkError) -> Problem {
    let problem = Problem::new(error.code(), error.chain()).outcome(error.outcome());
    let problem = match error.stop_effect() {
        Some(StopEffect::IssuesNothingMore) => problem.hint(
            "stop_effect: issues_nothing_more. The arm may still move: use the emergency stop if it must not.",
        ),
        Some(StopEffect::HaltsMotion) | None => problem,
    };
    match error.code().status() {
        503 => problem.retry_after_a_second(),
        _ => problem,
    }
}
