//! The panel: the controller over HTTP, for people and for tests. It can look and not touch.

use axum::Router;
use axum::extract::{Query, Request, State as Shared};
use axum::http::{StatusCode, header};
use axum::middleware::{self, Next};
use axum::response::{Html, IntoResponse, Json, Response};
use axum::routing::get;
use serde::{Deserialize, Serialize};
use tokio::sync::mpsc;

use crate::driver::{Command, Page};
use crate::error::ControllerStopped;
use crate::virtual_controller::ask;

const PAGE: &str = include_str!("page.html");

type Commands = mpsc::Sender<Command>;

/// The routes of the panel.
pub(crate) fn router(commands: Commands) -> Router {
    Router::new()
        .route("/", get(|| async { Html(PAGE) }))
        .route("/state", get(state))
        .route("/ledger", get(ledger))
        .route("/alarms", get(alarms))
        .route("/screen", get(screen))
        .fallback(not_found)
        .layer(middleware::from_fn(only_local_names))
        .with_state(commands)
}

/// A list of a bounded log.
#[derive(Serialize)]
struct List<T> {
    /// Older entries that are not kept any more.
    dropped: u64,
    entries: Vec<T>,
}

impl<T> From<Page<T>> for List<T> {
    fn from(page: Page<T>) -> Self {
        Self {
            dropped: page.dropped,
            entries: page.entries,
        }
    }
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct LedgerQuery {
    /// Only entries with a higher number.
    #[serde(default)]
    after: u64,
}

async fn state(Shared(commands): Shared<Commands>) -> Result<Response, ControllerStopped> {
    Ok(Json(ask(&commands, Command::State).await?).into_response())
}

async fn ledger(
    Shared(commands): Shared<Commands>,
    query: Result<Query<LedgerQuery>, axum::extract::rejection::QueryRejection>,
) -> Result<Response, ControllerStopped> {
    let after = match query {
        Ok(Query(LedgerQuery { after })) => after,
        Err(rejection) => return Ok(problem(StatusCode::BAD_REQUEST, &rejection.body_text())),
    };
    let page = ask(&commands, |answer| Command::Ledger { after, answer }).await?;
    Ok(Json(List::from(page)).into_response())
}

async fn alarms(Shared(commands): Shared<Commands>) -> Result<Response, ControllerStopped> {
    Ok(Json(List::from(ask(&commands, Command::Alarms).await?)).into_response())
}

async fn screen(Shared(commands): Shared<Commands>) -> Result<Response, ControllerStopped> {
    Ok(Json(ask(&commands, Command::Screen).await?).into_response())
}

async fn not_found(request: Request) -> Response {
    let text = format!("there is no {} on this panel", request.uri().path());
    problem(StatusCode::NOT_FOUND, &text)
}

/// A page of another origin must not read the panel through a name that it points to this machine.
async fn only_local_names(request: Request, next: Next) -> Response {
    let host = request
        .headers()
        .get(header::HOST)
        .and_then(|host| host.to_str().ok());
    if host.is_some_and(is_local_name) {
        next.run(request).await
    } else {
        problem(
            StatusCode::FORBIDDEN,
            "the panel answers to loopback names only",
        )
    }
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
