//! The robot over HTTP, for people and for tests: look at it, make it fail, move its loads, push it messages.

mod body;

use axum::Router;
use axum::extract::rejection::QueryRejection;
use axum::extract::{DefaultBodyLimit, Query, State as Shared};
use axum::http::StatusCode;
use axum::response::{Html, IntoResponse, Json, Response};
use axum::routing::{get, post};
use local_view::{Door, problem};
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

/// Serves the view until `stop`.
pub(crate) async fn serve(
    listener: TcpListener,
    commands: Commands,
    exposed: bool,
    stop: CancellationToken,
    tracker: TaskTracker,
) {
    local_view::serve(listener, router(commands, exposed), stop, tracker).await;
}

fn router(commands: Commands, exposed: bool) -> Router {
    let routes = Router::new()
        .route("/", get(|| async { Html(PAGE) }))
        .route("/state", get(state))
        .route("/ledger", get(ledger))
        .route("/faults", get(faults).post(set_fault).delete(clear_faults))
        .route("/loads", get(loads).post(set_load))
        .route("/messages", post(push))
        .layer(DefaultBodyLimit::max(MAX_BODY))
        .with_state(commands);
    Door::local("robot").exposed(exposed).around(routes)
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
