//! The panel: the controller over HTTP, for people and for tests. Its page can look and not touch; what changes
//! something is the [control interface](control), if it is open.

pub mod control;
mod serve;

use axum::Router;
use axum::extract::rejection::QueryRejection;
use axum::extract::{Query, RawQuery, Request, State as Shared};
use axum::http::{HeaderValue, StatusCode, header};
use axum::middleware::{self, Next};
use axum::response::{Html, IntoResponse, Json, Response};
use axum::routing::get;
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

/// The page runs its own script and asks its own origin, nothing else.
const CONTENT_POLICY: &str = "default-src 'none'; img-src data:; script-src 'unsafe-inline'; style-src 'unsafe-inline'; \
    connect-src 'self'; base-uri 'none'; form-action 'none'; frame-ancestors 'none'";

/// Serves the panel until `stop`.
pub(crate) async fn serve(
    listener: TcpListener,
    visitors: Visitors,
    stop: CancellationToken,
    tracker: TaskTracker,
) {
    serve::serve(listener, router(visitors), stop, tracker).await;
}

/// The routes of the panel.
pub(crate) fn router(visitors: Visitors) -> Router {
    let commands = visitors.commands.clone();
    Router::new()
        .route("/", get(|| async { Html(PAGE) }))
        .route("/state", get(state))
        .route("/ledger", get(ledger))
        .route("/alarms", get(alarms))
        .route("/screen", get(screen))
        .with_state(commands)
        .merge(control::router(visitors))
        .fallback(not_found)
        .method_not_allowed_fallback(not_allowed)
        .layer(middleware::from_fn(guard))
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

async fn not_found(request: Request) -> Response {
    let text = format!("there is no {} on this panel", request.uri().path());
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

/// A page of another origin must not read the panel through a name that it points to this machine, nor frame it.
async fn guard(request: Request, next: Next) -> Response {
    let host = request
        .headers()
        .get(header::HOST)
        .and_then(|host| host.to_str().ok());
    let mut response = if host.is_some_and(is_local_name) {
        next.run(request).await
    } else {
        problem(
            StatusCode::FORBIDDEN,
            "the panel answers to loopback names only",
        )
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

impl IntoResponse for ControllerStopped {
    fn into_response(self) -> Response {
        problem(StatusCode::SERVICE_UNAVAILABLE, &self.to_string())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn only_loopback_names_are_local() {
        for name in [
            "localhost",
            "LOCALHOST:8081",
            "127.0.0.1",
            "127.0.0.1:8081",
            "[::1]:8081",
        ] {
            assert!(is_local_name(name), "{name}");
        }
        for name in [
            "evil.example",
            "127.0.0.1.evil.example:80",
            "10.0.0.1",
            "",
            "[fe80::1]",
        ] {
            assert!(!is_local_name(name), "{name}");
        }
    }
}
