//! Loads and their custody.

use std::sync::Arc;

use api::{CustodyBody, Load, LoadDetail, LoadList, Outcome, ProblemCode};
use axum::Json;
use axum::extract::{FromRequestParts, State};
use axum::http::request::Parts;
use workflow::Input;

use super::params::{CellId, CellPath, param, path_params};
use super::responses::{AnyProblem, BodyProblem, CrossSite, InvalidJson, KeptProblem, NotFound};
use crate::extract::JsonBody;
use crate::identity::Principal;
use crate::jobs;
use crate::problem::Problem;
use crate::state::{App, Cell, shown};

/// Lists the loads of a cell and where each one is.
#[utoipa::path(
    get, path = "/api/v1/cells/{cell}/loads", tag = "loads",
    params(CellPath),
    responses((status = 200, description = "The loads.", body = LoadList), NotFound, AnyProblem),
)]
pub(super) async fn list_loads(
    State(app): State<Arc<App>>,
    CellId(cell): CellId,
) -> Result<Json<LoadList>, Problem> {
    let custody = app.cell(&cell)?.work.view().custody();
    Ok(Json(LoadList {
        loads: custody.iter().map(jobs::load).collect(),
    }))
}

/// Shows a load, where it is, and how it came there.
#[utoipa::path(
    get, path = "/api/v1/cells/{cell}/loads/{load}", tag = "loads",
    params(CellPath, ("load" = String, Path, description = "The load's id.")),
    responses(
        (status = 200, description = "The load.", body = LoadDetail),
        (status = 503, description = "`journal-unavailable`: the journal cannot be read.", body = api::Problem, content_type = "application/problem+json"),
        NotFound, AnyProblem,
    ),
)]
pub(super) async fn get_load(
    State(app): State<Arc<App>>,
    LoadOf { cell, load }: LoadOf,
) -> Result<Json<LoadDetail>, Problem> {
    let cell = app.cell(&cell)?;
    let now = find(cell, &load)?;
    let history = jobs::history_of_load(&app.journal, &cell.id, &load).await?;
    Ok(Json(LoadDetail { load: now, history }))
}

/// Says where a load is, after somebody has looked. The load's id is said twice.
///
/// The place has to be known and free, and no job may be working with the load. Saying the same again changes nothing.
#[utoipa::path(
    put, path = "/api/v1/cells/{cell}/loads/{load}/custody", tag = "loads",
    params(CellPath, ("load" = String, Path, description = "The load's id.")),
    request_body = CustodyBody,
    responses(
        (status = 200, description = "The load.", body = Load),
        (status = 409, description = "`custody-conflict`: another load is booked there, or a job is working with this one.", body = api::Problem, content_type = "application/problem+json"),
        (status = 422, description = "`validation`: the place is none of the cell, `confirm` is another load, or the reason is missing.", body = api::Problem, content_type = "application/problem+json"),
        KeptProblem, CrossSite, InvalidJson, NotFound, BodyProblem, AnyProblem,
    ),
)]
pub(super) async fn put_custody(
    State(app): State<Arc<App>>,
    LoadOf { cell, load }: LoadOf,
    caller: Principal,
    JsonBody(body): JsonBody<CustodyBody>,
) -> Result<Json<Load>, Problem> {
    let cell = app.cell(&cell)?;
    jobs::reason(&body.reason).map_err(nothing_to_send)?;
    let input = Input::SetCustody {
        load: load.clone(),
        location: jobs::location(&body.location),
        confirm: body.confirm,
        principal: jobs::principal(&caller),
        reason: body.reason,
    };
    let reply = cell.work.ask(input).await;
    let _reply = reply
        .map_err(|no| jobs::problem(no, ProblemCode::CustodyConflict, ""))
        .map_err(nothing_to_send)?;
    find(cell, &load).map(Json)
}

/// A booking is no command to a robot.
fn nothing_to_send(problem: Problem) -> Problem {
    problem.outcome(Outcome::None)
}

fn find(cell: &Cell, load: &str) -> Result<Load, Problem> {
    let custody = cell.work.view().custody();
    let found = custody.iter().find(|view| view.id == load);
    found.map(jobs::load).ok_or_else(|| {
        let load = shown(load);
        Problem::not_found(format!("cell `{}` has no load `{load}`", cell.id))
    })
}

/// The cell and the load a path names.
pub(super) struct LoadOf {
    cell: String,
    load: String,
}

impl FromRequestParts<Arc<App>> for LoadOf {
    type Rejection = Problem;

    async fn from_request_parts(parts: &mut Parts, _: &Arc<App>) -> Result<Self, Problem> {
        let params = path_params(parts).await?;
        Ok(Self {
            cell: param(&params, "cell")?.to_owned(),
            load: param(&params, "load")?.to_owned(),
        })
    }
}
