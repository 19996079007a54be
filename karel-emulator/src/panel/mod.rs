//! The panel: the controller over HTTP, for people and for tests. Its page can look and not touch; what changes
//! something is the [control interface](control), if it is open.

pub mod control;

use axum::Router;
use axum::extract::rejection::QueryRejection;
use axum::extract::{Query, RawQuery, State as Shared};
use axum::http::StatusCode;
use axum::response::{Html, IntoResponse, Json, Response};
use axum::routing::get;
use local_view::{Door, problem};
use serde::{Deserialize, Serialize};
use tokio::net::TcpListener;
use tokio::sync::{mpsc, watch};
use tokio_util::sync::CancellationToken;
use tokio_util::task::TaskTracker;

use crate::config::ControlAccess;
use crate::driver::{Command, Page};
use crate::error::ControllerStopped;
use crate::json::of_query;
use crate::state::State;
use crate::virtual_controller::ask;

const PAGE: &str = include_str!("page.html");

type Commands = mpsc::Sender<Command>;

/// Who answers the visitors of a panel, and what they may do.
#[derive(Clone, Debug)]
pub(crate) struct Visitors {
    pub(crate) commands: Commands,
    pub(crate) states: watch::Receiver<State>,
    pub(crate) access: ControlAccess,
}

/// Serves the panel until `stop`.
pub(crate) async fn serve(
    listener: TcpListener,
    visitors: Visitors,
    stop: CancellationToken,
    tracker: TaskTracker,
) {
    local_view::serve(listener, router(visitors), stop, tracker).await;
}

/// The routes of the panel.
pub(crate) fn router(visitors: Visitors) -> Router {
    let commands = visitors.commands.clone();
    let routes = Router::new()
        .route("/", get(|| async { Html(PAGE) }))
        .route("/state", get(state))
        .route("/ledger", get(ledger))
        .route("/alarms", get(alarms))
        .route("/screen", get(screen))
        .with_state(commands)
        .merge(control::router(visitors));
    Door::local("panel").around(routes)
}

/// A list of a bounded log.
#[derive(Serialize)]
struct List<T> {
    /// Older entries that are not kept any more.
    dropped: u64,
    entries: Vec<T>,
}

/// The newest `limit` entries of a page.
fn list<T: Serialize>(page: Page<T>, limit: Option<usize>) -> Response {
    let Page {
        mut entries,
        dropped,
    } = page;
    let surplus = limit.map_or(0, |limit| entries.len().saturating_sub(limit));
    drop(entries.drain(..surplus));
    Json(List { dropped, entries }).into_response()
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct LedgerQuery {
    /// Only entries with a higher number.
    #[serde(default)]
    after: u64,
    /// Only so many, the newest. All that are kept, if it is missing; what is kept is bounded.
    limit: Option<usize>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct AlarmsQuery {
    /// As for the ledger.
    limit: Option<usize>,
}

async fn state(Shared(commands): Shared<Commands>) -> Result<Response, ControllerStopped> {
    Ok(Json(ask(&commands, Command::State).await?).into_response())
}

async fn ledger(
    Shared(commands): Shared<Commands>,
    RawQuery(raw): RawQuery,
    query: Result<Query<LedgerQuery>, QueryRejection>,
) -> Result<Response, ControllerStopped> {
    let LedgerQuery { after, limit } = match query {
        Ok(Query(query)) => query,
        Err(rejection) => return Ok(unread_query(raw, &rejection)),
    };
    let page = ask(&commands, |answer| Command::Ledger { after, answer }).await?;
    Ok(list(page, limit))
}

async fn alarms(
    Shared(commands): Shared<Commands>,
    RawQuery(raw): RawQuery,
    query: Result<Query<AlarmsQuery>, QueryRejection>,
) -> Result<Response, ControllerStopped> {
    let AlarmsQuery { limit } = match query {
        Ok(Query(query)) => query,
        Err(rejection) => return Ok(unread_query(raw, &rejection)),
    };
    Ok(list(ask(&commands, Command::Alarms).await?, limit))
}

async fn screen(Shared(commands): Shared<Commands>) -> Result<Response, ControllerStopped> {
    Ok(Json(ask(&commands, Command::Screen).await?).into_response())
}

fn unread_query(query: Option<String>, rejection: &QueryRejection) -> Response {
    let query = query.unwrap_or_default();
    problem(
        StatusCode::BAD_REQUEST,
        &of_query(&query, &rejection.body_text()),
    )
}

impl IntoResponse for ControllerStopped {
    fn into_response(self) -> Response {
        problem(StatusCode::SERVICE_UNAVAILABLE, &self.to_string())
    }
}
