//! Control authority of a cell: who has it, taking it, keeping it, giving it back.

use std::sync::Arc;
use std::time::Duration;

use api::{
    AcquireBody, ControlLease, ControlView, LossBehavior, ProblemCode, Role, Station, TransferBody,
    Violation,
};
use axum::Json;
use axum::extract::{FromRequestParts, State};
use axum::http::StatusCode;
use axum::http::request::Parts;
use journal::AuditResult;
use uuid::Uuid;

use super::params::{CellPath, cell_of, param, path_params};
use super::responses::{AnyProblem, BodyProblem, CrossSite, InvalidJson, NotFound};
use crate::authority::{AcquireError, CellControl, Force, Terms};
use crate::extract::JsonBody;
use crate::identity::{Principal, entry};
use crate::problem::{Problem, outcome_of_nothing_sent};
use crate::request_id::RequestId;
use crate::state::App;

const DEFAULT_TTL_S: u32 = 10;
const MIN_TTL_S: u32 = 2;
const MAX_TTL_S: u32 = 60;
/// The longest reason, in characters.
const MAX_REASON: usize = 200;

/// Shows who has control of a cell.
#[utoipa::path(
    get, path = "/api/v1/cells/{cell}/control-authority", tag = "control",
    params(CellPath),
    responses((status = 200, description = "Who has it, and how the lease before ended.", body = ControlView), NotFound, AnyProblem),
)]
pub(super) async fn get_control(ControlOf(control): ControlOf) -> Json<ControlView> {
    Json(control.view())
}

/// Takes control of a cell.
///
/// The answer's `token` goes as `Control-Token` with everything that moves a robot. Keep the lease alive by a
/// heartbeat every third of its `ttl_s`, and give it back when done. `LOCAL` takes control from anybody; `REMOTE`
/// waits until it is free; an admin with `preempt` takes it, and moves nothing. Jobs stand still meanwhile. Stopping a
/// robot needs no control.
#[utoipa::path(
    post, path = "/api/v1/cells/{cell}/control-authority", tag = "control",
    params(CellPath),
    request_body = AcquireBody,
    responses(
        (status = 201, description = "Control is yours.", body = ControlLease),
        (status = 422, description = "`validation`: the body does not fit.", body = api::Problem, content_type = "application/problem+json"),
        (status = 423, description = "`control-held`: somebody else has it; `control` says who, since when and until when.",
            body = api::Problem, content_type = "application/problem+json"),
        (status = 503, description = "`not-recorded`: this start of the server has given all the epochs it has.",
            body = api::Problem, content_type = "application/problem+json"),
        CrossSite, InvalidJson, NotFound, BodyProblem, AnyProblem,
    ),
)]
pub(super) async fn acquire_control(
    State(app): State<Arc<App>>,
    ControlOf(control): ControlOf,
    principal: Principal,
    request_id: RequestId,
    JsonBody(body): JsonBody<AcquireBody>,
) -> Result<(StatusCode, Json<ControlLease>), Problem> {
    let terms = terms(&body, &principal)?;
    let force = if body.preempt {
        Force::Admin
    } else {
        Force::ByStation
    };
    let action = if body.preempt {
        "control.preempt"
    } else {
        "control.acquire"
    };
    let act = control.acquire(terms, force);
    let lease = noted(
        &app,
        &control,
        &principal,
        action,
        &body.reason,
        &request_id,
        act,
    )
    .await?;
    Ok((StatusCode::CREATED, Json(lease)))
}

/// Keeps control: a heartbeat.
///
/// The lease lasts `ttl_s` from now. A heartbeat that comes too late does not bring it back.
#[utoipa::path(
    put, path = "/api/v1/cells/{cell}/control-authority/{lease}", tag = "control",
    params(CellPath, ("lease" = Uuid, Path, description = "The lease.")),
    responses(
        (status = 200, description = "The lease, lengthened.", body = ControlLease),
        (status = 409, description = "`control-lost`: the lease is over; the detail says how it ended.",
            body = api::Problem, content_type = "application/problem+json"),
        (status = 423, description = "`control-held`: the lease is somebody else's.",
            body = api::Problem, content_type = "application/problem+json"),
        CrossSite, NotFound, AnyProblem,
    ),
)]
pub(super) async fn keep_control(
    ControlOf(control): ControlOf,
    LeaseOf(lease): LeaseOf,
    principal: Principal,
) -> Result<Json<ControlLease>, Problem> {
    Ok(Json(control.heartbeat(lease, principal.name())?))
}

/// Gives control back.
///
/// Motions that were accepted go on. A lease that is over already is given back all the same.
#[utoipa::path(
    delete, path = "/api/v1/cells/{cell}/control-authority/{lease}", tag = "control",
    params(CellPath, ("lease" = Uuid, Path, description = "The lease.")),
    responses(
        (status = 200, description = "Who has control now.", body = ControlView),
        (status = 423, description = "`control-held`: the lease is somebody else's.",
            body = api::Problem, content_type = "application/problem+json"),
        CrossSite, NotFound, AnyProblem,
    ),
)]
pub(super) async fn release_control(
    State(app): State<Arc<App>>,
    ControlOf(control): ControlOf,
    LeaseOf(lease): LeaseOf,
    principal: Principal,
    request_id: RequestId,
) -> Result<Json<ControlView>, Problem> {
    let held = control.view().held;
    let epoch = held
        .filter(|held| held.lease == lease)
        .map(|held| held.epoch);
    control.release(lease, principal.name())?;
    let mut about = entry(&principal, "control.release", control.cell(), &request_id);
    about.cell = Some(control.cell().to_owned());
    about.lease = epoch;
    app.audit.note(about);
    Ok(Json(control.view()))
}

/// Hands control to somebody else.
///
/// The lease ends, and the principal named has a new one, which it finds with GET and keeps alive from now on. The new
/// holder is `REMOTE`.
#[utoipa::path(
    post, path = "/api/v1/cells/{cell}/control-authority/{lease}/transfer", tag = "control",
    params(CellPath, ("lease" = Uuid, Path, description = "The lease.")),
    request_body = TransferBody,
    responses(
        (status = 201, description = "The other principal's lease.", body = ControlLease),
        (status = 409, description = "`control-lost`: the lease is over; the detail says how it ended.",
            body = api::Problem, content_type = "application/problem+json"),
        (status = 422, description = "`validation`: the body does not fit, or nobody has that name.", body = api::Problem, content_type = "application/problem+json"),
        (status = 423, description = "`control-held`: the lease is somebody else's.",
            body = api::Problem, content_type = "application/problem+json"),
        (status = 503, description = "`not-recorded`: this start of the server has given all the epochs it has.",
            body = api::Problem, content_type = "application/problem+json"),
        CrossSite, InvalidJson, NotFound, BodyProblem, AnyProblem,
    ),
)]
pub(super) async fn transfer_control(
    State(app): State<Arc<App>>,
    ControlOf(control): ControlOf,
    LeaseOf(lease): LeaseOf,
    principal: Principal,
    request_id: RequestId,
    JsonBody(body): JsonBody<TransferBody>,
) -> Result<(StatusCode, Json<ControlLease>), Problem> {
    check_reason(&body.reason)?;
    if !app.identity.knows(&body.to, app.clock.now()) {
        return Err(validation(
            "to",
            "nobody with a valid token has this name".to_owned(),
        ));
    }
    let act = control.transfer(lease, principal.name(), &body.to, &body.reason);
    let action = "control.transfer";
    let lease = noted(
        &app,
        &control,
        &principal,
        action,
        &body.reason,
        &request_id,
        act,
    )
    .await?;
    Ok((StatusCode::CREATED, Json(lease)))
}

/// Notes what was done, or refused. Nobody waits for the disk to take control of an arm; while the disk takes nothing,
/// nothing moves under that control.
async fn noted(
    app: &App,
    control: &CellControl,
    principal: &Principal,
    action: &str,
    reason: &str,
    request_id: &str,
    act: impl Future<Output = Result<ControlLease, AcquireError>>,
) -> Result<ControlLease, Problem> {
    let mut about = entry(principal, action, control.cell(), request_id);
    about.cell = Some(control.cell().to_owned());
    about.after = Some(reason.to_owned());
    let done = act.await;
    match &done {
        Ok(lease) => about.lease = Some(lease.epoch),
        Err(_) => about.result = AuditResult::Denied,
    }
    app.audit.note(about);
    done.map_err(Problem::from)
}

impl From<AcquireError> for Problem {
    fn from(error: AcquireError) -> Self {
        match error {
            AcquireError::Refused(refused) => refused.into(),
            AcquireError::NotRecorded(error) => error.into(),
        }
    }
}

fn terms(body: &AcquireBody, principal: &Principal) -> Result<Terms, Problem> {
    let ttl_s = body.ttl_s.unwrap_or(DEFAULT_TTL_S);
    if !(MIN_TTL_S..=MAX_TTL_S).contains(&ttl_s) {
        let message = format!("{ttl_s} s is not from {MIN_TTL_S} to {MAX_TTL_S} s");
        let violation = Violation {
            item: "ttl_s".to_owned(),
            value: Some(f64::from(ttl_s)),
            min: Some(f64::from(MIN_TTL_S)),
            max: Some(f64::from(MAX_TTL_S)),
            message: message.clone(),
        };
        return Err(
            Problem::not_sent(ProblemCode::Validation, format!("ttl_s: {message}"))
                .violations(vec![violation]),
        );
    }
    check_reason(&body.reason)?;
    if body.station == Station::Local && !principal.may_be_local() {
        return Err(forbidden(
            principal,
            "LOCAL is for tokens that were made for the cell's own panel (`--local-station`)",
        ));
    }
    if body.preempt && !principal.has(Role::Admin) {
        return Err(forbidden(
            principal,
            "only an admin takes control away from somebody",
        ));
    }
    Ok(Terms {
        holder: principal.name().to_owned(),
        station: body.station,
        ttl: Duration::from_secs(u64::from(ttl_s)),
        loss: body.loss_behavior.unwrap_or(LossBehavior::Stop1),
        reason: body.reason.clone(),
    })
}

fn forbidden(principal: &Principal, why: &str) -> Problem {
    let detail = format!("`{}` may not do this: {why}", principal.name());
    Problem::not_sent(ProblemCode::Forbidden, detail)
}

fn check_reason(reason: &str) -> Result<(), Problem> {
    let length = reason.chars().count();
    if !(1..=MAX_REASON).contains(&length) || reason.trim().is_empty() {
        let message = format!("{length} characters; 1 to {MAX_REASON} are needed, not only blanks");
        return Err(validation("reason", message));
    }
    if reason.chars().any(char::is_control) {
        return Err(validation("reason", "holds a control character".to_owned()));
    }
    Ok(())
}

fn validation(item: &str, message: String) -> Problem {
    Problem::not_sent(ProblemCode::Validation, format!("{item}: {message}")).violations(vec![
        Violation {
            item: item.to_owned(),
            message,
            ..Violation::default()
        },
    ])
}

/// The control authority of the cell a path names.
pub(super) struct ControlOf(Arc<CellControl>);

impl FromRequestParts<Arc<App>> for ControlOf {
    type Rejection = Problem;

    async fn from_request_parts(parts: &mut Parts, app: &Arc<App>) -> Result<Self, Problem> {
        let outcome = outcome_of_nothing_sent(&parts.method);
        let cell = cell_of(parts, app).await;
        let cell = cell.map_err(|problem| problem.outcome(outcome))?;
        Ok(Self(Arc::clone(&cell.control)))
    }
}

/// The lease a path names. What is no id cannot be the id of a lease.
pub(super) struct LeaseOf(Uuid);

impl FromRequestParts<Arc<App>> for LeaseOf {
    type Rejection = Problem;

    async fn from_request_parts(parts: &mut Parts, _: &Arc<App>) -> Result<Self, Problem> {
        let outcome = outcome_of_nothing_sent(&parts.method);
        let params = path_params(parts).await?;
        let lease = Uuid::parse_str(param(&params, "lease")?);
        lease
            .map(Self)
            .map_err(|_| Problem::not_found("the lease's id is not a UUID").outcome(outcome))
    }
}
