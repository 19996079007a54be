//! Looking: the state, the ledger, the trace, the USER screen.

use axum::extract::{Json, State as Shared};
use serde::{Deserialize, Serialize};
use utoipa::{IntoParams, ToSchema};
use utoipa_axum::{router::OpenApiRouter, routes};

use super::super::Visitors;
use super::parts::{AnyProblem, Asked, Body, Refusal};
use crate::controller::{TRACE_LINES, TraceEntry};
use crate::ledger::LedgerEntry;
use crate::state::State;
use crate::virtual_controller::visit;

/// Ledger entries in one answer.
const ENTRIES: usize = 10_000;

pub(super) fn routes() -> OpenApiRouter<Visitors> {
    OpenApiRouter::new()
        .routes(routes!(get_state))
        .routes(routes!(get_ledger))
        .routes(routes!(get_trace, set_trace))
        .routes(routes!(get_screen))
}

/// Which entries of the ledger.
#[derive(Clone, Debug, Deserialize, IntoParams)]
#[serde(deny_unknown_fields)]
struct LedgerQuery {
    /// Only entries with a higher number: the cursor.
    #[serde(default)]
    after: u64,
    /// Only so many, the oldest of those, up to 10000.
    limit: Option<usize>,
    /// If there is none, wait for one up to so many seconds, at most 30.
    wait_s: Option<f64>,
}

/// Entries of the ledger.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, ToSchema)]
pub struct LedgerList {
    /// Older entries that are not kept any more.
    pub dropped: u64,
    /// Oldest first.
    pub entries: Vec<LedgerEntry>,
    /// The cursor for what comes after these.
    pub next: u64,
}

/// Which lines of the trace.
#[derive(Clone, Debug, Deserialize, IntoParams)]
#[serde(deny_unknown_fields)]
struct TraceQuery {
    /// Only lines with a higher number: the cursor.
    #[serde(default)]
    after: u64,
    /// Only so many, the oldest of those, up to 10000.
    limit: Option<usize>,
}

/// Executed lines.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, ToSchema)]
pub struct TraceList {
    /// Whether lines are traced.
    pub on: bool,
    /// Older lines that are not kept any more.
    pub dropped: u64,
    /// Oldest first.
    pub lines: Vec<TraceEntry>,
    /// The cursor for what comes after these.
    pub next: u64,
}

/// What is traced.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, ToSchema)]
#[serde(deny_unknown_fields)]
pub struct SetTrace {
    /// Whether lines are traced.
    pub on: bool,
    /// Only of this task; of all if it is missing.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub task: Option<String>,
}

/// The pendant's USER screen.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, ToSchema)]
pub struct Screen {
    /// The last lines that programs wrote.
    pub lines: Vec<String>,
}

/// Shows the controller at one look.
#[utoipa::path(get, path = "/api/v1/state", tag = "state",
    responses((status = 200, description = "The state.", body = State), AnyProblem))]
async fn get_state(Shared(visitors): Shared<Visitors>) -> Result<Json<State>, Refusal> {
    Ok(Json(
        visit(&visitors.commands, |driver| driver.core.state()).await?,
    ))
}

/// Lists what the arm did; waits for something new, if asked to.
#[utoipa::path(get, path = "/api/v1/ledger", tag = "state", params(LedgerQuery),
    responses((status = 200, description = "The entries.", body = LedgerList), AnyProblem))]
async fn get_ledger(
    Shared(mut visitors): Shared<Visitors>,
    Asked(query): Asked<LedgerQuery>,
) -> Result<Json<LedgerList>, Refusal> {
    let LedgerQuery {
        after,
        limit,
        wait_s,
    } = query;
    let limit = limit.unwrap_or(ENTRIES);
    if !(1..=ENTRIES).contains(&limit) {
        return Err(Refusal::range("limit", limit, "1 to 10000"));
    }
    if let Some(wait_s) = wait_s {
        visitors
            .wait(wait_s, |state| state.ledger_seq > after)
            .await?;
    }
    let answer = visit(&visitors.commands, move |driver| {
        let mut entries = driver.core.ledger(after);
        entries.truncate(limit);
        LedgerList {
            dropped: driver.core.ledger_dropped(),
            next: entries.last().map_or(after, |entry| entry.seq),
            entries,
        }
    });
    Ok(Json(answer.await?))
}

/// Lists the lines that were executed while the trace was on.
#[utoipa::path(get, path = "/api/v1/trace", tag = "state", params(TraceQuery),
    responses((status = 200, description = "The lines.", body = TraceList), AnyProblem))]
async fn get_trace(
    Shared(visitors): Shared<Visitors>,
    Asked(TraceQuery { after, limit }): Asked<TraceQuery>,
) -> Result<Json<TraceList>, Refusal> {
    let limit = limit.unwrap_or(TRACE_LINES);
    if !(1..=TRACE_LINES).contains(&limit) {
        return Err(Refusal::range("limit", limit, "1 to 10000"));
    }
    let answer = visit(&visitors.commands, move |driver| {
        let (lines, dropped) = driver.core.trace(after, limit);
        TraceList {
            on: driver.core.is_traced(),
            dropped,
            next: lines.last().map_or(after, |line| line.seq),
            lines,
        }
    });
    Ok(Json(answer.await?))
}

/// Switches the trace on or off. Traced tasks cost more of this machine's time, and no controller time.
#[utoipa::path(put, path = "/api/v1/trace", tag = "state", request_body = SetTrace,
    responses((status = 200, description = "The lines so far.", body = TraceList), AnyProblem))]
async fn set_trace(
    Shared(visitors): Shared<Visitors>,
    Body(SetTrace { on, task }): Body<SetTrace>,
) -> Result<Json<TraceList>, Refusal> {
    let set = visit(&visitors.commands, move |driver| {
        driver.core.set_trace(on, task.as_deref())
    });
    set.await??;
    let query = TraceQuery {
        after: 0,
        limit: None,
    };
    get_trace(Shared(visitors), Asked(query)).await
}

/// Shows the pendant's USER screen.
#[utoipa::path(get, path = "/api/v1/screen", tag = "state",
    responses((status = 200, description = "The screen.", body = Screen), AnyProblem))]
async fn get_screen(Shared(visitors): Shared<Visitors>) -> Result<Json<Screen>, Refusal> {
    let lines = visit(&visitors.commands, |driver| driver.core.screen()).await?;
    Ok(Json(Screen { lines }))
}
