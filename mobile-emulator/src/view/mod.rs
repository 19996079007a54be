//! The robot over HTTP, for people and for tests: look at it, make it fail, move its loads, push it messages.

mod body;
mod serve;

use axum::Router;
use axum::extract::rejection::QueryRejection;
use axum::extract::{DefaultBodyLimit, Query, Request, State as Shared};
use axum::http::{HeaderMap, HeaderValue, Method, StatusCode, header};
use axum::middleware::{self, Next};
use axum::response::{Html, IntoResponse, Json, Response};
use axum::routing::{get, post};
use serde::{Deserialize, Serialize};
use tokio::net::TcpListener;
use tokio::sync::mpsc;
use tokio_util::sync::CancellationToken;
use tokio_util::task::TaskTracker;

use crate::driver::Command;
use crate::error::{Refusal, RobotStopped};
use crate::fault::Fault;
use crate::ledger::LedgerEntry;
use crate::robot::ask;
use body::Body;

const PAGE: &str = include_str!("page.html");
/// The longest body; an order with all its places fits.
const MAX_BODY: usize = 256 * 1024;

type Commands = mpsc::Sender<Command>;

/// The page runs its own script and asks its own origin, nothing else.
const CONTENT_POLICY: &str = "default-src 'none'; img-src data:; script-src 'unsafe-inline'; style-src 'unsafe-inline'; \
    connect-src 'self'; base-uri 'none'; form-action 'none'; frame-ancestors 'none'";

/// Serves the view until `stop`.
pub(crate) async fn serve(
    listener: TcpListener,
    commands: Commands,
    exposed: bool,
    stop: CancellationToken,
    tracker: TaskTracker,
) {
    serve::serve(listener, router(commands, exposed), stop, tracker).await;
}

fn router(commands: Commands, exposed: bool) -> Router {
    let routes = Router::new()
        .route("/", get(|| async { Html(PAGE) }))
        .route("/state", get(state))
        .route("/ledger", get(ledger))
        .route("/faults", get(faults).post(set_fault).delete(clear_faults))
        .route("/loads", get(loads).post(set_load))
        .route("/messages", post(push))
        .fallback(not_found)
        .method_not_allowed_fallback(not_allowed)
        .layer(DefaultBodyLimit::max(MAX_BODY))
        .with_state(commands);
    routes.layer(middleware::from_fn_with_state(exposed, guard))
}

/// Why there is no answer.
enum Refused {
    Robot(Refusal),
    Request(StatusCode, String),
}

impl From<Refusal> for Refused {
    fn from(refusal: Refusal) -> Self {
        Self::Robot(refusal)
    }
}

impl From<RobotStopped> for Refused {
    fn from(stopped: RobotStopped) -> Self {
        Self::Robot(stopped.into())
    }
}

impl IntoResponse for Refused {
    fn into_response(self) -> Response {
        match self {
            Self::Robot(refusal) => {
                let status = match &refusal {
                    Refusal::UnknownSlot { .. } | Refusal::Value { .. } => {
                        StatusCode::UNPROCESSABLE_ENTITY
                    }
                    Refusal::SlotTaken { .. }
                    | Refusal::SlotEmpty { .. }
                    | Refusal::LoadElsewhere { .. }
                    | Refusal::Gap { .. }
                    | Refusal::NoVisit { .. } => StatusCode::CONFLICT,
                    Refusal::Down | Refusal::Stopped(_) => StatusCode::SERVICE_UNAVAILABLE,
                };
                problem(status, &refusal.to_string())
            }
            Self::Request(status, detail) => problem(status, &detail),
        }
    }
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct LedgerQuery {
    /// Only entries with a higher number.
    #[serde(default)]
    after: u64,
    /// Only so many, the newest.
    limit: Option<usize>,
    /// Heartbeats too, which outnumber all else.
    #[serde(default = "yes")]
    heartbeats: bool,
}

const fn yes() -> bool {
    true
}

/// A list of a bounded log.
#[derive(Serialize)]
struct List {
    /// Older entries that are not kept any more.
    dropped: u64,
    entries: Vec<LedgerEntry>,
}

/// What shall lie in a slot.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct LoadBody {
    slot: String,
    /// The load to put there; `null` takes what lies there.
    load: Option<String>,
}

async fn state(Shared(commands): Shared<Commands>) -> Result<Response, Refused> {
    Ok(Json(ask(&commands, Command::State).await?).into_response())
}

async fn ledger(
    Shared(commands): Shared<Commands>,
    query: Result<Query<LedgerQuery>, QueryRejection>,
) -> Result<Response, Refused> {
    let Query(LedgerQuery {
        after,
        limit,
        heartbeats,
    }) = query.map_err(|error| Refused::Request(StatusCode::BAD_REQUEST, error.body_text()))?;
    let page = ask(&commands, |answer| Command::Ledger { after, answer }).await?;
    let mut entries = page.entries;
    entries.retain(|entry| heartbeats || !entry.event.is_heartbeat());
    let surplus = limit.map_or(0, |limit| entries.len().saturating_sub(limit));
    drop(entries.drain(..surplus));
    let dropped = page.dropped;
    Ok(Json(List { dropped, entries }).into_response())
}

async fn faults(Shared(commands): Shared<Commands>) -> Result<Response, Refused> {
    Ok(Json(ask(&commands, Command::State).await?.faults).into_response())
}

async fn set_fault(
    Shared(commands): Shared<Commands>,
    Body(fault): Body<Fault>,
) -> Result<Response, Refused> {
    let id = ask(&commands, |answer| Command::SetFault { fault, answer }).await??;
    let body = serde_json::json!({ "id": id });
    Ok((StatusCode::CREATED, Json(body)).into_response())
}

async fn clear_faults(Shared(commands): Shared<Commands>) -> Result<Response, Refused> {
    let cleared = ask(&commands, Command::ClearFaults).await?;
    Ok(Json(serde_json::json!({ "cleared": cleared })).into_response())
}

async fn loads(Shared(commands): Shared<Commands>) -> Result<Response, Refused> {
    Ok(Json(ask(&commands, Command::State).await?.slots).into_response())
}

async fn set_load(
    Shared(commands): Shared<Commands>,
    Body(LoadBody { slot, load }): Body<LoadBody>,
) -> Result<Response, Refused> {
    match load {
        Some(load) => ask(&commands, |answer| Command::Put { slot, load, answer }).await??,
        None => drop(ask(&commands, |answer| Command::Take { slot, answer }).await??),
    }
    loads(Shared(commands)).await
}

async fn push(
    Shared(commands): Shared<Commands>,
    Body(message): Body<api::OutboxMessage>,
) -> Result<Response, Refused> {
    let n = message.n;
    let message = Box::new(message);
    ask(&commands, |answer| Command::Push { message, answer }).await??;
    Ok(Json(serde_json::json!({ "n": n })).into_response())
}

async fn not_found(request: Request) -> Response {
    let text = format!("there is no {} on this robot", request.uri().path());
    problem(StatusCode::NOT_FOUND, &text)
}

async fn not_allowed(request: Request) -> Response {
    let text = format!(
        "{} cannot be sent to {}",
        request.method(),
        request.uri().path()
    );
    problem(StatusCode::METHOD_NOT_ALLOWED, &text)
}

async fn guard(Shared(exposed): Shared<bool>, request: Request, next: Next) -> Response {
    let mut response = match admit(exposed, request.method(), request.headers()) {
        Ok(()) => next.run(request).await,
        Err(reason) => problem(StatusCode::FORBIDDEN, reason),
    };
    for (name, value) in [
        (header::CONTENT_SECURITY_POLICY, CONTENT_POLICY),
        (header::X_CONTENT_TYPE_OPTIONS, "nosniff"),
        (header::CACHE_CONTROL, "no-store"),
    ] {
        let _previous = response
            .headers_mut()
            .insert(name, HeaderValue::from_static(value));
    }
    response
}

/// A page of another origin must not reach the robot through a name that it points to this machine, nor send it a form.
fn admit(exposed: bool, method: &Method, headers: &HeaderMap) -> Result<(), &'static str> {
    let text = |name| headers.get(name).and_then(|value| value.to_str().ok());
    let host = text(header::HOST);
    if !exposed && !host.is_some_and(is_local_name) {
        return Err("the robot answers to loopback names only");
    }
    let same_origin = match (text(header::ORIGIN), host) {
        (None, _) => true,
        (Some(origin), Some(host)) => origin.strip_prefix("http://") == Some(host),
        (Some(_), None) => false,
    };
    if !matches!(*method, Method::GET | Method::HEAD) && !same_origin {
        return Err("the request comes from a page of another origin");
    }
    Ok(())
}

fn is_local_name(host: &str) -> bool {
    let name = match host.strip_prefix('[') {
        Some(rest) => rest.split(']').next().unwrap_or_default(),
        None => host.split(':').next().unwrap_or_default(),
    };
    name.eq_ignore_ascii_case("localhost")
        || name
            .parse::<std::net::IpAddr>()
            .is_ok_and(|ip| ip.is_loopback())
}

/// An error as `application/problem+json`.
fn problem(status: StatusCode, detail: &str) -> Response {
    let body = serde_json::json!({
        "title": status.canonical_reason(),
        "status": status.as_u16(),
        "detail": detail,
    });
    let kind = [(header::CONTENT_TYPE, "application/problem+json")];
    (status, kind, body.to_string()).into_response()
}
