//! What only a person can decide.

use std::sync::Arc;

use api::{
    DoubtAnswer, Intervention, InterventionList, Outcome, ProblemCode, RespondBody, Violation,
};
use axum::Json;
use axum::extract::{FromRequestParts, State};
use axum::http::HeaderMap;
use axum::http::request::Parts;
use uuid::Uuid;
use workflow::Input;
use workflow::view::InterventionView;

use super::jobs::{Replayed, cell_to_change, replayed, understood};
use super::params::{CellId, CellPath, param, path_params};
use super::responses::{AnyProblem, BodyProblem, CrossSite, InvalidJson, NotFound};
use crate::extract::JsonBody;
use crate::identity::Principal;
use crate::jobs;
use crate::motions::{Record, RequestKey, Respond, RespondError, Responded, intervention};
use crate::problem::{Problem, outcome_of_nothing_sent};
use crate::state::{App, Cell, Robot};

/// Who asked for the motions of jobs, in records.
const JOBS: &str = "jobs";
/// The longest reason, in characters.
const MAX_REASON: usize = 500;

/// Lists what waits for a person's answer, the oldest first: motions in doubt, and jobs that cannot go on.
#[utoipa::path(
    get, path = "/api/v1/cells/{cell}/interventions", tag = "interventions",
    params(CellPath),
    responses((status = 200, description = "What waits.", body = InterventionList), NotFound, AnyProblem),
)]
pub(super) async fn list_interventions(
    State(app): State<Arc<App>>,
    CellId(cell): CellId,
) -> Result<Json<InterventionList>, Problem> {
    Ok(Json(InterventionList {
        interventions: waiting(app.cell(&cell)?),
    }))
}

/// What waits in a cell, by id.
pub(super) fn open(cell: &Cell) -> Vec<Uuid> {
    waiting(cell).into_iter().map(|one| one.id).collect()
}

fn waiting(cell: &Cell) -> Vec<Intervention> {
    let work = cell.work.view();
    let mut all: Vec<_> = work
        .interventions()
        .iter()
        .filter(|one| one.open)
        .map(|one| jobs::intervention(&cell.id, &work, one))
        .collect();
    // Of a job's motion in doubt the job itself asks, and knows more to answer. Its answer settles the motion, too.
    let asked: Vec<_> = all.iter().filter_map(|one| one.robot.clone()).collect();
    for robot in &cell.robots {
        let doubts = robot.motions.book.doubts();
        let shown = doubts
            .iter()
            .filter(|doubt| &*doubt.principal != JOBS || !asked.contains(&robot.plan.id));
        all.extend(shown.filter_map(|record| intervention(&robot.plan, record)));
    }
    all.sort_by_key(|one| (one.opened_at, one.id));
    all
}

/// Shows one of them, answered or not.
#[utoipa::path(
    get, path = "/api/v1/cells/{cell}/interventions/{id}", tag = "interventions",
    params(CellPath, ("id" = Uuid, Path, description = "The intervention's id.")),
    responses((status = 200, description = "It.", body = Intervention), NotFound, AnyProblem),
)]
pub(super) async fn get_intervention(
    State(app): State<Arc<App>>,
    InterventionOf { cell, id }: InterventionOf,
) -> Result<Json<Intervention>, Problem> {
    let known = app.cell(&cell)?;
    if let Some(question) = question(known, id) {
        let work = known.work.view();
        return Ok(Json(jobs::intervention(&known.id, &work, &question)));
    }
    let (robot, record) = find(&app, &cell, id).await?;
    shown(&robot, &record).map(Json)
}

/// Answers it, once and for good.
///
/// The answer is kept as a decision before anything follows from it. The same request again, with its key, is
/// answered the same; another answer is refused with what was said.
#[utoipa::path(
    post, path = "/api/v1/cells/{cell}/interventions/{id}/respond", tag = "interventions",
    params(
        CellPath,
        ("id" = Uuid, Path, description = "The intervention's id."),
        ("idempotency-key" = String, Header, description = "The caller's own word for this request."),
    ),
    request_body = RespondBody,
    responses(
        (status = 200, description = "The intervention, answered.", body = Intervention,
            headers(("idempotency-replayed" = bool, description = "Present and `true` where the answer was taken before."))),
        (status = 409, description = "`already-answered`: somebody gave another answer before. `answer-not-possible`: not as things are now; look again.",
            body = api::Problem, content_type = "application/problem+json"),
        (status = 422, description = "`validation`: the answer is none of the allowed ones, or the reason is missing.",
            body = api::Problem, content_type = "application/problem+json"),
        (status = 503, description = "`journal-unavailable`: the answer could not be kept, so it was not taken.",
            body = api::Problem, content_type = "application/problem+json"),
        (status = 507, description = "`journal-full`: the same, for want of room on the disk.",
            body = api::Problem, content_type = "application/problem+json"),
        CrossSite, InvalidJson, NotFound, BodyProblem, AnyProblem,
    ),
)]
pub(super) async fn respond(
    State(app): State<Arc<App>>,
    InterventionOf { cell, id }: InterventionOf,
    caller: Principal,
    headers: HeaderMap,
    JsonBody(body): JsonBody<RespondBody>,
) -> Result<(Replayed, Json<Intervention>), Problem> {
    let key = RequestKey::of(&headers)?;
    let known = cell_to_change(&app, &cell)?;
    if let Some(question) = question(known, id) {
        return answer_question(known, &question, &caller, &key, &body).await;
    }
    if body.mobile_robot.is_some() || body.place.is_some() || body.custody.is_some() {
        let detail = "answer: what became of a motion needs no mobile robot, place or custody";
        return Err(Problem::not_sent(ProblemCode::Validation, detail));
    }
    let principal: Arc<str> = Arc::from(caller.name());
    let (robot, record) = find(&app, &cell, id).await?;
    let answer = check(&shown(&robot, &record)?, &body)?;
    let respond = Respond {
        motion: id,
        answer,
        decision: Respond::name(&key, &principal, id, answer, &body.reason),
        principal,
        reason: body.reason,
    };
    let responded = robot
        .motions
        .respond(respond)
        .await
        .map_err(|error| problem_of(error).robot(&robot.plan.id).motion(Some(id)))?;
    let again = match responded {
        Responded::Now => None,
        Responded::Before => replayed(true),
    };
    let (robot, record) = find(&app, &cell, id).await?;
    Ok((again, Json(shown(&robot, &record)?)))
}

/// The workflows' question with an id.
fn question(cell: &Cell, id: Uuid) -> Option<InterventionView> {
    let all = cell.work.view().interventions();
    all.into_iter().find(|one| one.question.id == id)
}

async fn answer_question(
    cell: &Cell,
    view: &InterventionView,
    caller: &Principal,
    key: &RequestKey,
    body: &RespondBody,
) -> Result<(Replayed, Json<Intervention>), Problem> {
    let id = view.question.id;
    let path = format!("POST /api/v1/cells/{}/interventions/{id}/respond", cell.id);
    let claim = key.claim(caller.name(), &path, &understood(body)?)?;
    jobs::reason(&body.reason)?;
    let (answer, detail) = jobs::answer(view, body)?;
    let input = Input::Respond {
        intervention: id,
        answer,
        detail,
        principal: jobs::principal(caller),
        reason: body.reason.clone(),
    };
    let told = cell.work.ask_with(input, claim).await;
    // Somebody may have been faster.
    let now = question(cell, id);
    let over = now.as_ref().filter(|one| !one.open);
    let code = match over {
        Some(_) => ProblemCode::AlreadyAnswered,
        None => ProblemCode::AnswerNotPossible,
    };
    let told = jobs::told(told, code, "").map_err(|problem| {
        let Some(decided) = over.and_then(|one| one.decided.as_ref()) else {
            return problem;
        };
        let said = format!(
            "{} said `{}`, because \"{}\"",
            decided.principal,
            crate::words::word(&decided.answer),
            crate::state::shown(&decided.reason)
        );
        if problem.code() == ProblemCode::AlreadyAnswered {
            Problem::not_sent(ProblemCode::AlreadyAnswered, said)
        } else {
            problem
        }
    })?;
    let work = cell.work.view();
    let now = now.as_ref().unwrap_or(view);
    Ok((
        replayed(told.replayed),
        Json(jobs::intervention(&cell.id, &work, now)),
    ))
}

async fn find(app: &App, cell: &str, id: Uuid) -> Result<(Arc<Robot>, Record), Problem> {
    for robot in &app.cell(cell)?.robots {
        let found = robot.motions.find(id).await.map_err(|error| {
            Problem::new(ProblemCode::JournalUnavailable, error.to_string()).outcome(Outcome::None)
        })?;
        if let Some(record) = found {
            return Ok((Arc::clone(robot), record));
        }
    }
    Err(no_such(id))
}

fn no_such(id: Uuid) -> Problem {
    Problem::not_found(format!("there is no intervention {id}"))
}

fn shown(robot: &Robot, record: &Record) -> Result<Intervention, Problem> {
    intervention(&robot.plan, record).ok_or_else(|| no_such(record.id))
}

fn check(intervention: &Intervention, body: &RespondBody) -> Result<DoubtAnswer, Problem> {
    let mut violations = Vec::new();
    let mut wrong = |item: &str, message: String| {
        violations.push(Violation {
            item: item.to_owned(),
            message,
            ..Violation::default()
        });
    };
    let answer = match body.answer.as_str() {
        "happened" => Some(DoubtAnswer::Happened),
        "did_not_happen" => Some(DoubtAnswer::DidNotHappen),
        "abort" => Some(DoubtAnswer::Abort),
        other => {
            let allowed: Vec<_> = intervention
                .allowed
                .iter()
                .map(|allowed| allowed.answer.as_str())
                .collect();
            let other = crate::state::shown(other);
            wrong(
                "answer",
                format!("`{other}` is none of {}", allowed.join(", ")),
            );
            None
        }
    };
    let length = body.reason.chars().count();
    if body.reason.trim().is_empty() || length > MAX_REASON {
        wrong(
            "reason",
            format!("{length} characters; say in 1 to {MAX_REASON} why"),
        );
    }
    match (answer, violations.first()) {
        (Some(answer), None) => Ok(answer),
        (_, Some(first)) => {
            let detail = format!("{}: {}", first.item, first.message);
            Err(Problem::not_sent(ProblemCode::Validation, detail).violations(violations))
        }
        (None, None) => Err(Problem::not_sent(ProblemCode::Validation, "no answer")),
    }
}

fn problem_of(error: RespondError) -> Problem {
    match error {
        RespondError::NoSuchMotion | RespondError::NotInDoubt => {
            Problem::not_found(error.to_string()).outcome(Outcome::NotSent)
        }
        RespondError::Answered(decision) => {
            let said = decision.map_or_else(String::new, |decision| {
                format!(
                    ": {} said `{:?}` at {}, because \"{}\"",
                    decision.principal,
                    decision.answer,
                    decision.at,
                    crate::state::shown(&decision.reason)
                )
            });
            Problem::not_sent(
                ProblemCode::AlreadyAnswered,
                format!("it was answered{said}"),
            )
        }
        RespondError::Journal(trouble) => trouble.problem(),
        RespondError::Read(error) => {
            Problem::not_sent(ProblemCode::JournalUnavailable, error.to_string())
        }
    }
}

/// The cell and the intervention a path names.
pub(super) struct InterventionOf {
    cell: String,
    id: Uuid,
}

impl FromRequestParts<Arc<App>> for InterventionOf {
    type Rejection = Problem;

    async fn from_request_parts(parts: &mut Parts, _: &Arc<App>) -> Result<Self, Problem> {
        let outcome = outcome_of_nothing_sent(&parts.method);
        let params = path_params(parts).await?;
        let id = Uuid::parse_str(param(&params, "id")?).map_err(|_| {
            Problem::not_found("the intervention's id is not a UUID").outcome(outcome)
        })?;
        Ok(Self {
            cell: param(&params, "cell")?.to_owned(),
            id,
        })
    }
}
