//! What became of a job: its events and its report, from the journal.

use std::sync::Arc;

use api::{JobEventList, JobReport};
use axum::Json;
use axum::extract::State;

use super::jobs::{JobOf, story_of};
use super::page::{Cursor, Page};
use super::params::CellPath;
use super::responses::{AnyProblem, NotFound};
use crate::jobs;
use crate::problem::Problem;
use crate::state::App;

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
    page: Page<EventPlace>,
) -> Result<Json<JobEventList>, Problem> {
    let cell = app.cell(&cell)?;
    let history = story_of(&app, cell, job).await?;
    let mut events = jobs::events(&history);
    if let Some(after) = page.cursor {
        events.retain(|event| EventPlace::parse(&event.id).is_some_and(|place| place > after));
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

/// Where an event stands: its record, and its place in it. The page has what is newer.
#[derive(Clone, Copy, Debug, Eq, Ord, PartialEq, PartialOrd)]
pub(super) struct EventPlace(u64, usize);

impl Cursor for EventPlace {
    const DEFAULT_LIMIT: usize = 100;

    fn parse(text: &str) -> Option<Self> {
        let (position, index) = text.split_once('-')?;
        Some(Self(position.parse().ok()?, index.parse().ok()?))
    }
}
