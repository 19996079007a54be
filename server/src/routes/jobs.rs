//! Jobs of the group workflows: asking for one, steering it, looking at it.

use std::sync::Arc;

use api::{Job, JobBody, JobCommand, JobCommandBody, JobList, JobState, Outcome, ProblemCode};
use axum::Json;
use axum::extract::{FromRequestParts, State};
use axum::http::request::Parts;
use axum::http::{HeaderMap, HeaderName, StatusCode, Uri, header};
use jiff::Timestamp;
use uuid::Uuid;
use workflow::{Input, NewJob, Reply};

use super::page::{Cursor, Page};
use super::params::{CellId, CellPath, invalid, param, path_params};
use super::responses::{AnyProblem, BodyProblem, CrossSite, KeptProblem, NotFound};
use crate::extract::{JsonBody, ListJson};
use crate::identity::Principal;
use crate::jobs;
use crate::motions::RequestKey;
use crate::problem::{Problem, REPLAYED, outcome_of_nothing_sent};
use crate::state::{App, Cell, shown};

/// The headers of an answer that may have been given before.
pub(super) type Replayed = Option<[(HeaderName, &'static str); 1]>;

pub(super) fn replayed(replayed: bool) -> Replayed {
    replayed.then_some([(REPLAYED, "true")])
}

/// Asks for a job. It waits in the queue for what it needs, and starts by itself.
///
/// Everything a job names has to be in the cell's set-up; what is missing is named. The same request again with the
/// same key, within seven days and over restarts too, is answered with the job it made.
#[utoipa::path(
    post, path = "/api/v1/cells/{cell}/jobs", tag = "jobs",
    params(
        CellPath,
        ("idempotency-key" = String, Header, max_length = 128, description = "The caller's own word for this job, e.g. a UUID."),
    ),
    request_body = JobBody,
    responses(
        (status = 201, description = "The job, in the queue; or what became of it, where the key was used before.", body = Job,
            headers(
                ("location" = String, description = "Where the job is."),
                ("idempotency-replayed" = bool, description = "Present and `true` where the job was asked for before."),
            )),
        (status = 400, description = "`idempotency-missing`: the header is missing. `invalid-json`.", body = api::Problem, content_type = "application/problem+json"),
        (status = 409, description = "`queue-full`: 200 jobs are open.", body = api::Problem, content_type = "application/problem+json"),
        (status = 422, description = "`validation`: an item does not fit the set-up, or where the loads are. `zone-violation`: a way of the arm leads through a keep-out zone or the hand-over zone of another place, or out of its work area. `idempotency-mismatch`: the key was used for something else.",
            body = api::Problem, content_type = "application/problem+json"),
        KeptProblem, CrossSite, NotFound, BodyProblem, AnyProblem,
    ),
)]
pub(super) async fn create_job(
    State(app): State<Arc<App>>,
    CellId(cell): CellId,
    caller: Principal,
    headers: HeaderMap,
    ListJson(body): ListJson<JobBody>,
) -> Result<(StatusCode, Replayed, [(HeaderName, String); 1], Json<Job>), Problem> {
    let cell = cell_to_change(&app, &cell)?;
    let key = RequestKey::of(&headers)?;
    let path = format!("POST /api/v1/cells/{}/jobs", cell.id);
    let claim = key.claim(caller.name(), &path, &understood(&body)?)?;
    let job = match admitted(cell, &body, app.clock.now()).await {
        Ok(job) => job,
        // A deadline that has passed since, or a zone that was put in the way, is no reason to deny what was asked for in
        // time.
        Err(problem) => {
            return match app.journal.lookup(&claim, app.clock.now()).await {
                Ok(Some(replay)) => match made_by(&replay) {
                    Some(id) => created(&app, cell, id, true).await,
                    None => Err(problem),
                },
                _ => Err(problem),
            };
        }
    };
    let input = Input::CreateJob { job: Box::new(job) };
    let told = cell.work.ask_with(input, claim).await;
    let told = jobs::told(told, ProblemCode::WrongJobState, "params.")?;
    let Reply::Created(id) = told.reply else {
        let detail = "the cell did not say which job it made";
        return Err(Problem::new(ProblemCode::Internal, detail));
    };
    created(&app, cell, id, told.replayed).await
}

/// What is asked for, where it fits whatever the cell is doing.
pub(super) async fn admitted(
    cell: &Cell,
    body: &JobBody,
    now: Timestamp,
) -> Result<NewJob, Problem> {
    let job = jobs::new_job(body, cell.work.clock(), now)?;
    jobs::admit(&cell.setup, &job).await?;
    Ok(job)
}

fn made_by(replay: &journal::Replay) -> Option<Uuid> {
    match crate::cell::told_before(replay).reply {
        Reply::Created(id) => Some(id),
        Reply::Done | Reply::Unchanged | Reply::Signal(_) => None,
    }
}

async fn created(
    app: &App,
    cell: &Cell,
    id: Uuid,
    again: bool,
) -> Result<(StatusCode, Replayed, [(HeaderName, String); 1], Json<Job>), Problem> {
    let location = format!("/api/v1/cells/{}/jobs/{id}", cell.id);
    Ok((
        StatusCode::CREATED,
        replayed(again),
        [(header::LOCATION, location)],
        Json(shown_job(app, cell, id).await?),
    ))
}

/// Lists the jobs, the newest first.
///
/// The cell remembers those that are open and the last of the others; an older one is found by its id.
#[utoipa::path(
    get, path = "/api/v1/cells/{cell}/jobs", tag = "jobs",
    params(
        CellPath,
        ("state" = Option<Vec<JobState>>, Query, description = "Only jobs in this state; may be given several times."),
        ("limit" = Option<usize>, Query, minimum = 1, maximum = 200, description = "How many at most; 50 where absent."),
        ("cursor" = Option<String>, Query, description = "The `next_cursor` of the page before."),
    ),
    responses(
        (status = 200, description = "A page of jobs.", body = JobList),
        (status = 422, description = "`validation`: the query does not fit.", body = api::Problem, content_type = "application/problem+json"),
        NotFound, AnyProblem,
    ),
)]
pub(super) async fn list_jobs(
    State(app): State<Arc<App>>,
    CellId(cell): CellId,
    query: JobsQuery,
) -> Result<Json<JobList>, Problem> {
    let cell = app.cell(&cell)?;
    let view = cell.work.view();
    let mut all = view.jobs(cell.work.clock().now());
    all.retain(|job| {
        let state = jobs::state_of(job.state);
        query.page.cursor.is_none_or(|before| job.number < before.0)
            && (query.states.is_empty() || query.states.contains(&state))
    });
    all.reverse();
    let more = all.len() > query.page.limit;
    all.truncate(query.page.limit);
    Ok(Json(JobList {
        next_cursor: all
            .last()
            .filter(|_| more)
            .map(|last| last.number.to_string()),
        jobs: all.iter().map(|job| jobs::summary(&view, job)).collect(),
    }))
}

/// Shows a job: state, phase, steps with the time they have left, items, claims, timers, the open question.
#[utoipa::path(
    get, path = "/api/v1/cells/{cell}/jobs/{job}", tag = "jobs",
    params(CellPath, ("job" = Uuid, Path, description = "The job's id.")),
    responses(
        (status = 200, description = "The job.", body = Job),
        (status = 503, description = "`journal-unavailable`: the job is not among the last ones, and the journal cannot be read.",
            body = api::Problem, content_type = "application/problem+json"),
        NotFound, AnyProblem,
    ),
)]
pub(super) async fn get_job(
    State(app): State<Arc<App>>,
    JobOf { cell, job }: JobOf,
) -> Result<Json<Job>, Problem> {
    let cell = app.cell(&cell)?;
    shown_job(&app, cell, job).await.map(Json)
}

/// Steers a job.
///
/// `stop` and `abort` need no key: they end in the same state however often they are sent. Every other command needs
/// one, and with it is carried out once. What a job's state does not allow is refused; `commands` of the job says what
/// is possible.
#[utoipa::path(
    post, path = "/api/v1/cells/{cell}/jobs/{job}/commands", tag = "jobs",
    params(
        CellPath,
        ("job" = Uuid, Path, description = "The job's id."),
        ("idempotency-key" = Option<String>, Header, max_length = 128, description = "The caller's own word for this command; not needed for `stop` and `abort`."),
    ),
    request_body = JobCommandBody,
    responses(
        (status = 200, description = "The job. The command was taken; what follows from it takes its time.", body = Job,
            headers(("idempotency-replayed" = bool, description = "Present and `true` where the command was taken before."))),
        (status = 400, description = "`idempotency-missing`: the header is missing. `invalid-json`.", body = api::Problem, content_type = "application/problem+json"),
        (status = 409, description = "`wrong-job-state`: the job's state does not allow it.", body = api::Problem, content_type = "application/problem+json"),
        (status = 422, description = "`validation`: the reason is missing. `idempotency-mismatch`: the key was used for something else.",
            body = api::Problem, content_type = "application/problem+json"),
        KeptProblem, CrossSite, NotFound, BodyProblem, AnyProblem,
    ),
)]
pub(super) async fn command_job(
    State(app): State<Arc<App>>,
    JobOf { cell, job }: JobOf,
    caller: Principal,
    headers: HeaderMap,
    JsonBody(body): JsonBody<JobCommandBody>,
) -> Result<(Replayed, Json<Job>), Problem> {
    let cell = cell_to_change(&app, &cell)?;
    let claim = match body.command {
        JobCommand::Stop | JobCommand::Abort => None,
        JobCommand::Hold
        | JobCommand::Unhold
        | JobCommand::RetryStep
        | JobCommand::SkipStep
        | JobCommand::CompleteManually
        | JobCommand::Compensate
        | JobCommand::Clear
        | JobCommand::Reset => {
            let key = RequestKey::of(&headers)?;
            let path = format!("POST /api/v1/cells/{}/jobs/{job}/commands", cell.id);
            Some(key.claim(caller.name(), &path, &understood(&body)?)?)
        }
    };
    jobs::reason(&body.reason)?;
    let input = Input::JobCommand {
        job,
        command: jobs::command(body.command),
        principal: jobs::principal(&caller),
        reason: body.reason,
    };
    let again = match claim {
        None => {
            let reply = cell.work.ask(input).await;
            let _reply = reply.map_err(|no| jobs::problem(no, ProblemCode::WrongJobState, ""))?;
            false
        }
        Some(claim) => {
            let told = cell.work.ask_with(input, claim).await;
            jobs::told(told, ProblemCode::WrongJobState, "")?.replayed
        }
    };
    Ok((replayed(again), Json(shown_job(&app, cell, job).await?)))
}

/// A job as the cell has it, or else as the journal does.
async fn shown_job(app: &App, cell: &Cell, id: Uuid) -> Result<Job, Problem> {
    let view = cell.work.view();
    let clock = cell.work.clock();
    let now = app.clock.now();
    if let Some(job) = view.job(clock.now(), id) {
        return Ok(jobs::job(&cell.id, &view, &job, clock, now));
    }
    let history = story_of(app, cell, id).await?;
    let job = jobs::remembered(&history).ok_or_else(|| no_such(&cell.id, id))?;
    Ok(jobs::job(&cell.id, &view, &job, clock, now))
}

/// What the journal has of a job.
pub(super) async fn story_of(app: &App, cell: &Cell, id: Uuid) -> Result<jobs::History, Problem> {
    let span = cell.work.span(id).ok_or_else(|| no_such(&cell.id, id))?;
    jobs::story(&app.journal, &cell.id, span, id).await
}

fn no_such(cell: &str, job: Uuid) -> Problem {
    Problem::not_found(format!("cell `{cell}` has no job {job}"))
}

/// The cell of a request that changes something.
pub(super) fn cell_to_change<'a>(app: &'a App, cell: &str) -> Result<&'a Cell, Problem> {
    app.cell(cell)
        .map_err(|problem| problem.outcome(Outcome::NotSent))
}

/// What was understood of a body, whatever the order of its keys and the blanks between them.
pub(super) fn understood<T: serde::Serialize>(body: &T) -> Result<Vec<u8>, Problem> {
    serde_json::to_vec(body)
        .map_err(|error| Problem::not_sent(ProblemCode::Internal, error.to_string()))
}

/// The cell and the job a path names. What is no id cannot be the id of a job.
pub(super) struct JobOf {
    pub(super) cell: String,
    pub(super) job: Uuid,
}

impl FromRequestParts<Arc<App>> for JobOf {
    type Rejection = Problem;

    async fn from_request_parts(parts: &mut Parts, _: &Arc<App>) -> Result<Self, Problem> {
        let outcome = outcome_of_nothing_sent(&parts.method);
        let params = path_params(parts).await?;
        let job = Uuid::parse_str(param(&params, "job")?)
            .map_err(|_| Problem::not_found("the job's id is not a UUID").outcome(outcome))?;
        Ok(Self {
            cell: param(&params, "cell")?.to_owned(),
            job,
        })
    }
}

/// A job's number: the page has the jobs before it.
#[derive(Clone, Copy, Debug, Eq, PartialEq)]
pub(super) struct JobNumber(u64);

impl Cursor for JobNumber {
    const DEFAULT_LIMIT: usize = 50;

    fn parse(text: &str) -> Option<Self> {
        text.parse().ok().map(Self)
    }
}

/// The query of the list of jobs.
#[derive(Clone, Debug, Eq, PartialEq)]
pub(super) struct JobsQuery {
    page: Page<JobNumber>,
    /// Only jobs in one of these; empty: in any.
    states: Vec<JobState>,
}

impl FromRequestParts<Arc<App>> for JobsQuery {
    type Rejection = Problem;

    async fn from_request_parts(parts: &mut Parts, _: &Arc<App>) -> Result<Self, Problem> {
        Self::of(&parts.uri)
    }
}

impl JobsQuery {
    fn of(uri: &Uri) -> Result<Self, Problem> {
        let mut states = Vec::new();
        let page = Page::with_filter(uri, Some("state"), |value| {
            states.push(state(value)?);
            Ok(())
        })?;
        Ok(Self { page, states })
    }
}

fn state(text: &str) -> Result<JobState, Problem> {
    let value = serde_json::Value::String(text.to_owned());
    serde_json::from_value(value).map_err(|_| {
        let all: Vec<_> = JobState::ALL
            .iter()
            .filter_map(|state| serde_json::to_value(state).ok())
            .filter_map(|state| state.as_str().map(str::to_owned))
            .collect();
        let message = format!("`{}` is none of {}", shown(text), all.join(", "));
        invalid("state", message, None)
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    fn query(text: &str) -> Result<JobsQuery, Problem> {
        JobsQuery::of(&format!("/jobs?{text}").parse().unwrap())
    }

    #[test]
    fn a_list_of_jobs_is_filtered_and_paged() {
        let asked = query("state=HELD&state=SUSPENDED&limit=3&cursor=12").unwrap();
        assert_eq!(asked.states, [JobState::Held, JobState::Suspended]);
        let page = Page {
            limit: 3,
            cursor: Some(JobNumber(12)),
        };
        assert_eq!(asked.page, page);
        assert_eq!(query("").unwrap().page.limit, 50);
        for wrong in [
            "state=held",
            "state=",
            "limit=0",
            "limit=201",
            "limit=1&limit=2",
            "cursor=x",
            "cursor=-1",
            "open=true",
        ] {
            assert!(query(wrong).is_err(), "{wrong}");
        }
    }
}
