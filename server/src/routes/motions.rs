//! Motions: asking for one, and what became of each.

use std::sync::Arc;
use std::time::Duration;

use api::{Motion, MotionBody, MotionList, MotionState, Outcome, ProblemCode, Tier};
use axum::Json;
use axum::extract::State;
use axum::http::{HeaderMap, HeaderName, HeaderValue, StatusCode, header};
use axum::response::{IntoResponse, Response};
use journal::{LookupError, Refusal};
use tokio::time::Instant;
use uuid::Uuid;

use super::caller::Caller;
use super::motion_body::{self, Timing};
use super::motion_zones;
use super::page::{MAX_PAGE, Page};
use super::params::{ControlHeader, MotionId, RobotOf, RobotPath};
use super::prefer::Prefer;
use super::preview::{check_expected, plan_of};
use super::responses::{AnyProblem, BodyProblem, ControlProblem, CrossSite, LinkProblem, NotFound};
use crate::authority::Claim;
use crate::extract::JsonBody;
use crate::journal::Trouble;
use crate::link::cell_server::{CellServerLink, Phase};
use crate::motions::{
    Asked, Entry, Numbered, Planned, Progress, Record, RequestKey, Start, Started, problem_of,
    resolve,
};
use crate::problem::{Problem, REPLAYED};
use crate::request_id::RequestId;
use crate::state::{App, Robot, RobotLink};
use crate::target::Prepared;

/// What an answer may take longer than the motion's deadline: the link tells a little after it.
const LATE: Duration = Duration::from_secs(5);
/// Bytes that hold nearly every motion: memory is asked for once.
const COMMON_BODY: usize = 1024;
const PREFERENCE_APPLIED: HeaderName = HeaderName::from_static("preference-applied");

/// Moves the robot.
///
/// The pose is rounded to thousandths of a millimeter and of a degree, as the controller's wire carries it, and
/// checked in the configuration the controller's program keeps: reach, joint limits, singularities. Its intent is
/// written to the journal, then it is sent, once. At tier 0 the answer `accepted` is the last thing the server can
/// know of a motion, and the request is answered when the controller has answered; `Prefer: wait=N` shortens that.
///
/// `Idempotency-Key` is the caller's own word for the motion: the same request again with the same key, within seven
/// days, is answered with what became of that motion, and nothing is sent.
#[utoipa::path(
    post, path = "/api/v1/cells/{cell}/robots/{robot}/motions", tag = "motions",
    params(
        RobotPath, ControlHeader,
        ("idempotency-key" = String, Header, max_length = 128, description = "The caller's own word for this motion, e.g. a UUID."),
        ("prefer" = Option<String>, Header, description = "`wait=N`: answer when the motion is at its end, or after N seconds (60 at most); `respond-async`: at once."),
    ),
    request_body = MotionBody,
    responses(
        (status = 200, description = "The motion is done: seen at its target, standing still.", body = Motion,
            headers(("location" = String, description = "Where the motion is."))),
        (status = 202, description = "The motion is kept and on its way; at tier 0: the controller took it.", body = Motion,
            headers(
                ("location" = String, description = "Where the motion is."),
                ("preference-applied" = String, description = "`wait=N`, where the caller asked for it."),
                ("idempotency-replayed" = bool, description = "Present and `true` where the motion was asked for before."),
            )),
        (status = 400, description = "`idempotency-missing`: the header is missing. `invalid-json`.", body = api::Problem, content_type = "application/problem+json"),
        (status = 409, description = "`controller-rejected`: the controller refused it. `deadline-passed`: it waited too long and was not sent. `in-doubt`: an earlier motion has to be decided first. `idempotency-in-flight`: the first request with this key is still being answered. `plan-expired`, `stale-state`, `pose-stale`: what it was made from does not hold any more. `motion-canceled`, `motion-interrupted`, `server-restarted`: what became of it. `not-supported`: this controller cannot do it. `control-lost`: control of the cell ended before it was sent.",
            body = api::Problem, content_type = "application/problem+json"),
        (status = 422, description = "`validation`: the body does not fit. `out-of-workspace`, `joint-limit-exceeded`, `no-solution-in-configuration`, `singularity`: the arm cannot do it. `zone-violation`: its way enters a keep-out zone or leaves the work area. `idempotency-mismatch`: the key was used for something else. Nothing was sent.",
            body = api::Problem, content_type = "application/problem+json"),
        ControlProblem, CrossSite, NotFound, BodyProblem, LinkProblem, AnyProblem,
    ),
)]
#[expect(
    clippy::too_many_arguments,
    reason = "each takes its part of the request"
)]
pub(super) async fn create_motion(
    State(app): State<Arc<App>>,
    RobotOf(robot): RobotOf,
    Caller(principal): Caller,
    control: Claim,
    prefer: Prefer,
    request_id: RequestId,
    headers: HeaderMap,
    JsonBody(body): JsonBody<MotionBody>,
) -> Result<MotionAnswer, Problem> {
    let plan = &robot.plan;
    let of_robot = |problem: Problem| problem.robot(&plan.id);
    let key = RequestKey::of(&headers).map_err(of_robot)?;
    let path = format!("POST {}", path_of(&robot, None));
    // What is compared is what was understood, whatever the order of the keys and the blanks between them.
    let understood = serde_json::to_vec(&body)
        .map_err(|error| Problem::not_sent(ProblemCode::Internal, error.to_string()))?;
    let claim = key.claim(&principal, &path, &understood)?;
    let guard = app.keys.enter(&claim.key).map_err(of_robot)?;
    if let Some(motion) = asked_before(&robot, &claim).await.map_err(of_robot)? {
        return answer(&robot, motion, prefer, Patience::Answered, Replay::Before).await;
    }
    let timing = motion_body::check(&body, plan, robot.motions.now()).map_err(of_robot)?;
    let refused = |problem: Problem| {
        tracing::info!(
            robot.id = plan.id,
            request_id = &*request_id,
            reason = problem.detail(),
            "the motion was refused and not sent"
        );
        problem.robot(&plan.id)
    };
    let Timing {
        begin_by,
        deadline,
        not_after,
    } = timing;
    let stops = robot.motions.stops();
    let (motion, is_new, patience) = match &robot.link {
        RobotLink::Seed(_) => {
            let prepared = prepared(&app, &robot, &body).map_err(refused)?;
            let start = Start {
                prepared,
                entry: Entry {
                    asked: Asked::of(&prepared),
                    request_id: request_id.clone(),
                    principal,
                    reason: body.reason,
                    not_after: Some(not_after),
                },
                claim: Some(claim),
                control,
                begin_by,
                deadline,
                stops,
                guard: Some(guard.clone()),
            };
            match robot.start(start).await? {
                Started::New { motion, .. } => (motion, true, Patience::Until(deadline)),
                Started::Replayed(motion) => (motion, false, Patience::Answered),
            }
        }
        RobotLink::CellServer(link) => {
            let reason = body.reason.clone();
            let of_link = link.clone();
            let of_app = Arc::clone(&app);
            let resolve = move |robot: &Robot| asked(&of_app, robot, &of_link, &body);
            let numbered = Numbered {
                resolve: Box::new(resolve),
                request_id: request_id.clone(),
                principal,
                reason,
                not_after,
                begin_by,
                claim,
                control,
                stops,
                guard: guard.clone(),
            };
            let started = robot.start_numbered(link, numbered).await;
            let (motion, is_new) = started.map_err(refused)?;
            (motion, is_new, Patience::Answered)
        }
    };
    let replay = if is_new {
        Replay::First
    } else {
        Replay::Before
    };
    let answered = answer(&robot, motion, prefer, patience, replay).await;
    drop(guard);
    answered
}

/// What a controller of tier 0 is to be sent: the plan's, or the body's.
fn prepared(app: &App, robot: &Robot, body: &MotionBody) -> Result<Prepared, Problem> {
    let plan = plan_of(robot, body)?;
    check_expected(robot, body, plan.as_ref())?;
    no_doubt(robot)?;
    let prepared = match plan.map(|plan| plan.planned) {
        Some(Planned::Seed(prepared)) => prepared,
        Some(Planned::Numbered(_)) | None => motion_body::prepare(robot, body)?,
    };
    motion_zones::check(app, robot, &Asked::of(&prepared))?;
    Ok(prepared)
}

/// What a controller of tier 2 is to be sent: the plan's, or the body's.
fn asked(
    app: &App,
    robot: &Robot,
    link: &CellServerLink,
    body: &MotionBody,
) -> Result<Asked, Problem> {
    let plan = plan_of(robot, body)?;
    check_expected(robot, body, plan.as_ref())?;
    no_doubt(robot)?;
    let asked = match plan.map(|plan| plan.planned) {
        Some(Planned::Numbered(asked)) => asked,
        Some(Planned::Seed(_)) | None => resolve(robot, link, body, motion_body::refused)?,
    };
    // A plan was checked when it was made; who is at a hand-over point has changed since.
    motion_zones::check(app, robot, &asked)?;
    Ok(asked)
}

/// Lists a robot's motions, newest first.
///
/// The server shows the last 1,000 of each robot, after a restart those that the journal has. An older one is found
/// by its id.
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
pub(super) async fn list_motions(RobotOf(robot): RobotOf, page: Page<Uuid>) -> Json<MotionList> {
    debug_assert!(page.limit <= MAX_PAGE);
    let (records, more) = robot.motions.book.page(page.cursor, page.limit);
    let next_cursor = records
        .last()
        .filter(|_| more)
        .map(|record| record.id.to_string());
    Json(MotionList {
        motions: records
            .iter()
            .map(|record| shown_motion(&robot, record))
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
    responses(
        (status = 200, description = "The motion.", body = Motion),
        (status = 503, description = "`journal-unavailable`: the motion is not among the last ones, and the journal cannot be read.",
            body = api::Problem, content_type = "application/problem+json"),
        NotFound, AnyProblem,
    ),
)]
pub(super) async fn get_motion(
    RobotOf(robot): RobotOf,
    MotionId(id): MotionId,
) -> Result<Json<Motion>, Problem> {
    let record = find(&robot, id).await?;
    Ok(Json(shown_motion(&robot, &record)))
}

/// A motion as the API shows it: what is known of it, and what the controller says of it now.
pub(super) fn shown_motion(robot: &Robot, record: &Record) -> Motion {
    let mut motion = record.body(&robot.plan);
    if let RobotLink::CellServer(link) = &robot.link
        && matches!(record.progress, Progress::Accepted | Progress::Executing)
    {
        let view = link.view();
        let in_flight = view
            .in_flight
            .filter(|in_flight| in_flight.motion == record.id);
        if let (Some(in_flight), Some(seen)) = (in_flight, view.status) {
            if seen.line.held {
                motion.state = MotionState::Paused;
            } else if seen.line.finished == in_flight.number
                || (robot.plan.tier == Tier::SeedStatus
                    && in_flight.phase == Phase::Executing
                    && !seen.line.moving)
            {
                motion.state = MotionState::Settling;
            }
        }
    }
    motion
}

/// A motion of the robot.
pub(super) async fn find(robot: &Robot, id: Uuid) -> Result<Record, Problem> {
    let found = robot
        .motions
        .find(id)
        .await
        .map_err(|error| Problem::new(ProblemCode::JournalUnavailable, error.to_string()))?;
    found.ok_or_else(|| Problem::not_found(format!("robot `{}` has no motion {id}", robot.plan.id)))
}

/// The motion a key stands for, if it was used before.
async fn asked_before(robot: &Robot, claim: &journal::Claim) -> Result<Option<Uuid>, Problem> {
    let motions = &robot.motions;
    match motions.journal().lookup(claim, motions.now()).await {
        Ok(None) => Ok(None),
        Ok(Some(replay)) => match replay.first.record.motion() {
            Some(motion) => Ok(Some(motion.0)),
            None => Err(Trouble::Refused(Refusal::KeyReused {
                first: replay.first.position,
            })
            .problem()),
        },
        // Its request is no longer being answered, so what is known of it is the answer.
        Err(LookupError::Refused(Refusal::KeyInFlight { motion })) => Ok(Some(motion.0)),
        Err(LookupError::Refused(refusal)) => Err(Trouble::Refused(refusal).problem()),
        Err(LookupError::Read(error)) => Err(Problem::not_sent(
            ProblemCode::JournalUnavailable,
            error.to_string(),
        )),
    }
}

/// Refuses a motion while an earlier one is in doubt: where the arm is, and whether it is about to move, is not known.
pub(super) fn no_doubt(robot: &Robot) -> Result<(), Problem> {
    let Some(doubt) = robot.motions.book.first_doubt() else {
        return Ok(());
    };
    let plan = &robot.plan;
    let detail = format!("what became of motion {doubt} is not known, and nobody has decided");
    Err(Problem::not_sent(ProblemCode::InDoubt, detail)
        .robot(&plan.id)
        .motion(Some(doubt))
        .hint(&format!(
            "Look at the robot, then answer at /api/v1/cells/{}/interventions/{doubt}/respond.",
            plan.cell
        )))
}

/// For how long an answer is waited for where the caller does not say.
#[derive(Clone, Copy, Debug)]
enum Patience {
    /// The controller answers by then.
    Until(Instant),
    /// It was answered before.
    Answered,
}

/// Whether the motion was asked for before.
#[derive(Clone, Copy, Debug, Eq, PartialEq)]
enum Replay {
    First,
    Before,
}

/// Waits for a motion as long as the caller wants, and answers with what is known then.
async fn answer(
    robot: &Arc<Robot>,
    motion: Uuid,
    prefer: Prefer,
    patience: Patience,
    replay: Replay,
) -> Result<MotionAnswer, Problem> {
    let limit = match (prefer.wait(), patience) {
        (Some(wait), _) => Instant::now() + wait,
        (None, Patience::Until(deadline)) => deadline + LATE,
        (None, Patience::Answered) => Instant::now(),
    };
    let known = robot
        .motions
        .book
        .wait(motion, limit, |progress| progress.end().is_some())
        .await;
    let record = match known {
        Some(record) => record,
        // Asked for so long ago that only the journal knows it.
        None => find(robot, motion).await.map_err(|problem| {
            problem
                .outcome(Outcome::Unknown)
                .motion(Some(motion))
                .robot(&robot.plan.id)
        })?,
    };
    if let Some(problem) = problem_of(&robot.plan, &record) {
        return Err(match replay {
            Replay::First => problem,
            Replay::Before => problem.replayed(),
        });
    }
    let body = shown_motion(robot, &record);
    Ok(MotionAnswer {
        status: if body.state == MotionState::Succeeded {
            StatusCode::OK
        } else {
            StatusCode::ACCEPTED
        },
        location: path_of(robot, Some(motion)),
        applied: prefer.applied(),
        replay,
        body,
    })
}

fn path_of(robot: &Robot, motion: Option<Uuid>) -> String {
    let plan = &robot.plan;
    let all = format!("/api/v1/cells/{}/robots/{}/motions", plan.cell, plan.id);
    match motion {
        Some(motion) => format!("{all}/{motion}"),
        None => all,
    }
}

/// A motion as the answer to the request for it.
#[derive(Debug)]
pub(super) struct MotionAnswer {
    status: StatusCode,
    location: String,
    applied: Option<String>,
    replay: Replay,
    body: Motion,
}

impl IntoResponse for MotionAnswer {
    fn into_response(self) -> Response {
        let mut body = Vec::with_capacity(COMMON_BODY);
        let mut response = match serde_json::to_writer(&mut body, &self.body) {
            Ok(()) => {
                let json = HeaderValue::from_static("application/json");
                (self.status, [(header::CONTENT_TYPE, json)], body).into_response()
            }
            // It says why, as for every other body.
            Err(_) => Json(self.body).into_response(),
        };
        let headers = response.headers_mut();
        // Ids of cells and robots are visible ASCII.
        for (name, text) in [
            (header::LOCATION, Some(self.location)),
            (PREFERENCE_APPLIED, self.applied),
            (
                REPLAYED,
                (self.replay == Replay::Before).then(|| "true".to_owned()),
            ),
        ] {
            if let Some(value) = text.and_then(|text| HeaderValue::try_from(text).ok()) {
                let _none = headers.insert(name, value);
            }
        }
        response
    }
}
