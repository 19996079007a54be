//! What became of a job: its events and its report, from the journal.

use std::sync::Arc;

use api::{JobEventList, JobReport};
use axum::Json;
use axum::extract::{FromRequestParts, Query, State};
use axum::http::Uri;
use axum::http::request::Parts;

use super::jobs::{JobOf, story_of};
use super::params::{CellPath, invalid, page_limit};
use super::responses::{AnyProblem, NotFound};
use crate::jobs;
use crate::problem::Problem;
use crate::state::{App, shown};

const DEFAULT_PAGE: usize = 100;

/// Tells what happened to a job, the oldest first.
#[utoipa::path(
    get, path = "/api/v1/cells/{cell}/jobs/{job}/events", tag = "jobs",
    params(
        CellPath,
        ("job" = Uuid, Path, description = "The job's id."),
        ("limit" = Option<usize>, Query, minimum = 1, maximum = 200, description = "How many at most; 100 where absent."),
        ("cursor" = Option<String>, Query, description = "The `next_cursor` of the page before."),
    ),
    responses(
        (status = 200, description = "A page of events.", body = JobEventList),
        (status = 422, description = "`validation`: the query does not fit.", body = api::Problem, content_type = "application/problem+json"),
        (status = 503, description = "`journal-unavailable`: the journal cannot be read.", body = api::Problem, content_type = "application/problem+json"),
        NotFound, AnyProblem,
    ),
)]
pub(super) async fn job_events(
    State(app): State<Arc<App>>,
    JobOf { cell, job }: JobOf,
    page: EventPage,
) -> Result<Json<JobEventList>, Problem> {
    let cell = app.cell(&cell)?;
    let history = story_of(&app, cell, job).await?;
    let mut events = jobs::events(&history);
    if let Some(after) = page.after {
        events.retain(|event| place(&event.id).is_some_and(|place| place > after));
    }
    let more = events.len() > page.limit;
    events.truncate(page.limit);
    Ok(Json(JobEventList {
        next_cursor: events.last().filter(|_| more).map(|last| last.id.clone()),
        events,
    }))
}

/// Reports what a job took: each phase and its attempts, each state, faults, what people decided.
///
/// Of a job that is not over it is what is known so far.
#[utoipa::path(
    get, path = "/api/v1/cells/{cell}/jobs/{job}/report", tag = "jobs",
    params(CellPath, ("job" = Uuid, Path, description = "The job's id.")),
    responses(
        (status = 200, description = "The report.", body = JobReport),
        (status = 503, description = "`journal-unavailable`: the journal cannot be read.", body = api::Problem, content_type = "application/problem+json"),
        NotFound, AnyProblem,
    ),
)]
pub(super) async fn job_report(
    State(app): State<Arc<App>>,
    JobOf { cell, job }: JobOf,
) -> Result<Json<JobReport>, Problem> {
    let cell = app.cell(&cell)?;
    let history = story_of(&app, cell, job).await?;
    let now = (app.clock.now(), app.journal.epoch());
    Ok(Json(jobs::report(&cell.id, &history, now)))
}

/// Where an event stands: its record, and its place in it.
fn place(id: &str) -> Option<(u64, usize)> {
    let (position, index) = id.split_once('-')?;
    Some((position.parse().ok()?, index.parse().ok()?))
}

/// The query of the list of events.
#[derive(Clone, Copy, Debug, Eq, PartialEq)]
pub(super) struct EventPage {
    limit: usize,
    after: Option<(u64, usize)>,
}

impl FromRequestParts<Arc<App>> for EventPage {
    type Rejection = Problem;

    async fn from_request_parts(parts: &mut Parts, _: &Arc<App>) -> Result<Self, Problem> {
        Self::of(&parts.uri)
    }
}

impl EventPage {
    fn of(uri: &Uri) -> Result<Self, Problem> {
        let pairs = Query::<Vec<(String, String)>>::try_from_uri(uri)
            .map_err(|error| invalid("query", error.body_text(), None))?;
        let (mut limit, mut after) = (None, None);
        for (key, value) in pairs.0 {
            let twice = match key.as_str() {
                "limit" => limit.replace(page_limit(&value)?).is_some(),
                "cursor" => {
                    let place = place(&value).ok_or_else(|| {
                        let message =
                            format!("`{}` is not a `next_cursor` of this list", shown(&value));
                        invalid("cursor", message, None)
                    })?;
                    after.replace(place).is_some()
                }
                _ => {
                    let message = "unknown; the parameters are `limit` and `cursor`";
                    return Err(invalid(&shown(&key), message.to_owned(), None));
                }
            };
            if twice {
                return Err(invalid(&key, "given twice".to_owned(), None));
            }
        }
        Ok(Self {
            limit: limit.unwrap_or(DEFAULT_PAGE),
            after,
        })
    }
}
