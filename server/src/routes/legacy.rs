//! The seed's own routes, for the clients that know them: its paths, its keys, its answers.
//!
//! All of them drive the one robot the configuration names, through the same link as every other route.

use std::sync::Arc;

use api::{
    LegacyDelta, LegacyMoved, LegacyPoint, LegacyRefusal, LegacyValidation, LegacyVersion,
    ProblemCode,
};
use axum::Json;
use axum::extract::{FromRequest, FromRequestParts, Query, Request, State};
use axum::http::request::Parts;
use protocol::{MAX_SPEED, MIN_SPEED};
use serde::de::DeserializeOwned;
use units::MmPerSec;

use super::legacy_error::LegacyError;
use super::motion_zones;
use super::responses::{AnyProblem, BodyProblem, CrossSite, LinkProblem};
use crate::authority::{Claim, token};
use crate::extract::read_json;
use crate::identity::Principal;
use crate::link::TargetCheck;
use crate::motions::{Accepted, Asked, CommandFailure};
use crate::problem::Problem;
use crate::request_id::RequestId;
use crate::state::{App, shown};
use crate::target::{Prepared, Refusal, sent_point};
use crate::wire_bodies::{legacy_point, point_of_legacy};

const POINT: [&str; 6] = ["x", "y", "z", "w", "p", "r"];
/// The speed of a move whose request names none, in mm/s.
const DEFAULT_VELOCITY: u16 = 200;

/// Moves to a point.
///
/// The answer means that the controller took the command, not that the arm is there.
#[utoipa::path(
    post, path = "/fanuc/move", tag = "fanuc",
    params(("velocity" = Option<u16>, Query, minimum = 1, maximum = 1999, description = "Programmed speed in mm/s; 200 where absent.")),
    request_body = LegacyPoint,
    responses(
        (status = 200, description = "The controller took the command.", body = LegacyMoved),
        (status = 409, description = "The controller or the server's kinematics refused the point, or its deadline passed in the queue. Nothing moved.",
            content((LegacyRefusal = "application/json"), (api::Problem = "application/problem+json"))),
        (status = 422, description = "The body or the velocity does not fit.", body = LegacyValidation),
        CrossSite, AnyProblem, BodyProblem, LinkProblem,
    ),
)]
pub(super) async fn fanuc_move(
    State(app): State<Arc<App>>,
    LegacyClaim(claim): LegacyClaim,
    request_id: RequestId,
    Velocity(speed): Velocity,
    LegacyBody(body): LegacyBody<LegacyPoint>,
) -> Result<Json<LegacyMoved>, LegacyError> {
    let prepared = app
        .legacy
        .plan
        .prepare_point(&point_of_legacy(&body), speed);
    send(&app, prepared, claim, request_id).await
}

/// Moves to the home joints of the arm model.
#[utoipa::path(
    post, path = "/fanuc/home", tag = "fanuc",
    params(("velocity" = Option<u16>, Query, minimum = 1, maximum = 1999, description = "Programmed speed in mm/s; 200 where absent.")),
    responses(
        (status = 200, description = "The controller took the command.", body = LegacyMoved),
        (status = 409, description = "The controller refused the point, or its deadline passed in the queue. Nothing moved.",
            content((LegacyRefusal = "application/json"), (api::Problem = "application/problem+json"))),
        (status = 422, description = "The velocity does not fit.", body = LegacyValidation),
        CrossSite, AnyProblem, LinkProblem,
    ),
)]
pub(super) async fn fanuc_home(
    State(app): State<Arc<App>>,
    LegacyClaim(claim): LegacyClaim,
    request_id: RequestId,
    Velocity(speed): Velocity,
) -> Result<Json<LegacyMoved>, LegacyError> {
    let prepared = app.legacy.plan.prepare_home(speed);
    send(&app, prepared, claim, request_id).await
}

/// Moves relative to the last accepted target, number by number.
///
/// It counts from the target the controller last accepted through this server, on any route; not from where the arm
/// is. While that target is not known (none yet, or a command in doubt since) it is refused.
#[utoipa::path(
    post, path = "/fanuc/delta", tag = "fanuc",
    params(("velocity" = Option<u16>, Query, minimum = 1, maximum = 1999, description = "Programmed speed in mm/s; 200 where absent.")),
    request_body = LegacyDelta,
    responses(
        (status = 200, description = "The controller took the command.", body = LegacyMoved),
        (status = 409, description = "There is no target to count from, the new point was refused, or its deadline passed in the queue. Nothing moved.",
            content((LegacyRefusal = "application/json"), (api::Problem = "application/problem+json"))),
        (status = 422, description = "The body or the velocity does not fit.", body = LegacyValidation),
        CrossSite, AnyProblem, BodyProblem, LinkProblem,
    ),
)]
pub(super) async fn fanuc_delta(
    State(app): State<Arc<App>>,
    LegacyClaim(claim): LegacyClaim,
    request_id: RequestId,
    Velocity(speed): Velocity,
    LegacyBody(body): LegacyBody<LegacyDelta>,
) -> Result<Json<LegacyMoved>, LegacyError> {
    let robot = &app.legacy;
    let change = [body.dx, body.dy, body.dz, body.dw, body.dp, body.dr];
    let of_zones = Arc::clone(&app);
    let check = TargetCheck::new(move |prepared| {
        motion_zones::check(&of_zones, &of_zones.legacy, &Asked::of(prepared))
    });
    let sent = robot
        .carry_out_delta(change, speed, check, claim, request_id)
        .await;
    answer(sent)
}

/// The server's version.
#[utoipa::path(
    get, path = "/version", tag = "fanuc",
    responses((status = 200, description = "The version.", body = LegacyVersion), AnyProblem),
)]
pub(super) async fn version() -> Json<LegacyVersion> {
    Json(LegacyVersion {
        version: vec![env!("CARGO_PKG_VERSION").to_owned()],
    })
}

/// Sends a move that passed the server's checks, or says why it did not.
async fn send(
    app: &App,
    prepared: Result<Prepared, Refusal>,
    claim: Claim,
    request_id: RequestId,
) -> Result<Json<LegacyMoved>, LegacyError> {
    let robot = &app.legacy;
    let prepared = prepared.map_err(|refusal| {
        refusal.log(&robot.plan.id, &request_id);
        LegacyError::of_refusal(&refusal, &POINT)
    })?;
    motion_zones::check(app, robot, &Asked::of(&prepared)).map_err(LegacyError::of_problem)?;
    let within = robot.plan.deadline;
    let sent = robot.carry_out(prepared, claim, request_id, within).await;
    answer(sent)
}

fn answer(sent: Result<Accepted, CommandFailure>) -> Result<Json<LegacyMoved>, LegacyError> {
    sent.map(|accepted| moved(&accepted))
        .map_err(LegacyError::of_failure)
}

fn moved(accepted: &Accepted) -> Json<LegacyMoved> {
    Json(LegacyMoved {
        current_position: legacy_point(&sent_point(&accepted.sent)),
    })
}

/// On whose behalf the request moves the robot. The seed's clients know of no control authority: they act as `legacy`,
/// while nobody has control. One that sends a `Control-Token` acts as its holder.
pub(super) struct LegacyClaim(Claim);

impl FromRequestParts<Arc<App>> for LegacyClaim {
    type Rejection = LegacyError;

    async fn from_request_parts(parts: &mut Parts, app: &Arc<App>) -> Result<Self, LegacyError> {
        let principal = Principal::from_request_parts(parts, app)
            .await
            .map_err(LegacyError::Problem)?;
        let cell = &app.legacy.plan.cell;
        if !principal.sees_cell(cell) {
            let detail = format!("`{}` sees no robot of these routes", principal.name());
            let problem = Problem::not_sent(ProblemCode::Forbidden, detail);
            return Err(LegacyError::Problem(problem));
        }
        let control = &app.cell(cell).map_err(LegacyError::Problem)?.control;
        let claim = if token(&parts.headers)
            .map_err(LegacyError::Problem)?
            .is_some()
        {
            Claim::of_request(control, &parts.headers, &principal).map_err(LegacyError::Problem)?
        } else {
            let claim = Claim::of_legacy(Arc::clone(control));
            claim
                .check()
                .map_err(|refused| LegacyError::of_control(&refused))?;
            claim
        };
        Ok(Self(claim))
    }
}

/// A JSON body whose errors come in the seed's shape.
pub(super) struct LegacyBody<T>(T);

impl<T: DeserializeOwned> FromRequest<Arc<App>> for LegacyBody<T> {
    type Rejection = LegacyError;

    async fn from_request(request: Request, app: &Arc<App>) -> Result<Self, LegacyError> {
        Ok(Self(read_json(request, &app.server).await?))
    }
}

/// The query `velocity=200`, a speed the robot may be given.
pub(super) struct Velocity(MmPerSec);

impl FromRequestParts<Arc<App>> for Velocity {
    type Rejection = LegacyError;

    async fn from_request_parts(parts: &mut Parts, app: &Arc<App>) -> Result<Self, LegacyError> {
        let max = app.legacy.plan.max_speed.min(MAX_SPEED);
        let Some(query) = parts.uri.query() else {
            return velocity(DEFAULT_VELOCITY, max);
        };
        // The form most requests have needs no decoding.
        if let Some(value) = query.strip_prefix("velocity=").and_then(whole) {
            return velocity(value, max);
        }
        let pairs = Query::<Vec<(String, String)>>::try_from_uri(&parts.uri).map_err(|error| {
            LegacyError::validation(&["query"], "value_error", error.body_text())
        })?;
        let mut given = None;
        for (key, value) in pairs.0 {
            if key != "velocity" {
                let key = shown(&key);
                let message = format!("`{key}` is unknown; the only parameter is `velocity`");
                return Err(LegacyError::validation(
                    &["query", &key],
                    "extra_forbidden",
                    message,
                ));
            }
            if given.is_some() {
                let message = "velocity is given twice";
                return Err(LegacyError::validation(
                    &["query", "velocity"],
                    "duplicate",
                    message,
                ));
            }
            given = Some(whole(&value).ok_or_else(|| out_of_range(&value, max))?);
        }
        velocity(given.unwrap_or(DEFAULT_VELOCITY), max)
    }
}

/// Digits only: Rust's own parser would take a plus sign, which means a space in a query.
fn whole(text: &str) -> Option<u16> {
    let digits = text.bytes().all(|byte| byte.is_ascii_digit());
    text.parse().ok().filter(|_| digits)
}

fn velocity(value: u16, max: u16) -> Result<Velocity, LegacyError> {
    if (MIN_SPEED..=max).contains(&value) {
        Ok(Velocity(MmPerSec(f64::from(value))))
    } else {
        Err(out_of_range(&value.to_string(), max))
    }
}

fn out_of_range(value: &str, max: u16) -> LegacyError {
    let value = shown(value);
    let message =
        format!("velocity is `{value}`; it must be a whole number of {MIN_SPEED} to {max} mm/s");
    LegacyError::validation(&["query", "velocity"], "value_error", message)
}
