//! Hand-over sessions.

use std::sync::Arc;

use api::{Session, SessionList};
use axum::Json;
use axum::extract::{FromRequestParts, State};
use axum::http::request::Parts;
use uuid::Uuid;

use super::params::{CellId, CellPath, param, path_params};
use super::responses::{AnyProblem, NotFound};
use crate::jobs;
use crate::problem::Problem;
use crate::state::{App, shown};

/// Lists the hand-over sessions of a cell, the newest first: those that are open, and the last of the others.
#[utoipa::path(
    get, path = "/api/v1/cells/{cell}/sessions", tag = "hand-over",
    params(CellPath),
    responses((status = 200, description = "The sessions.", body = SessionList), NotFound, AnyProblem),
)]
pub(super) async fn list_sessions(
    State(app): State<Arc<App>>,
    CellId(cell): CellId,
) -> Result<Json<SessionList>, Problem> {
    Ok(Json(sessions(&app, &cell, None)?))
}

/// Shows a hand-over session: its state, both permits, the waits that run.
#[utoipa::path(
    get, path = "/api/v1/cells/{cell}/sessions/{session}", tag = "hand-over",
    params(CellPath, ("session" = Uuid, Path, description = "The session's id.")),
    responses((status = 200, description = "The session.", body = Session), NotFound, AnyProblem),
)]
pub(super) async fn get_session(
    State(app): State<Arc<App>>,
    SessionOf { cell, session }: SessionOf,
) -> Result<Json<Session>, Problem> {
    let all = sessions(&app, &cell, None)?.sessions;
    let found = all.into_iter().find(|one| one.id == session);
    let no_such = || Problem::not_found(format!("cell `{cell}` has no session {session}"));
    found.map(Json).ok_or_else(no_such)
}

/// Lists the sessions of a point, the newest first: the one that is open, if any, is the first.
#[utoipa::path(
    get, path = "/api/v1/cells/{cell}/stations/{station}/points/{point}/sessions", tag = "hand-over",
    params(
        CellPath,
        ("station" = String, Path, description = "The station's id."),
        ("point" = String, Path, description = "The point's id in the station."),
    ),
    responses((status = 200, description = "The sessions.", body = SessionList), NotFound, AnyProblem),
)]
pub(super) async fn list_point_sessions(
    State(app): State<Arc<App>>,
    PointOf { cell, point }: PointOf,
) -> Result<Json<SessionList>, Problem> {
    let known = app.cell(&cell)?.work.view();
    if known.setup().point(&point).is_none() {
        let point = shown(&point);
        return Err(Problem::not_found(format!(
            "cell `{cell}` has no point `{point}`"
        )));
    }
    Ok(Json(sessions(&app, &cell, Some(&point))?))
}

fn sessions(app: &App, cell: &str, point: Option<&str>) -> Result<SessionList, Problem> {
    let work = &app.cell(cell)?.work;
    let mut all = work.view().sessions(work.clock().now());
    all.retain(|one| point.is_none_or(|point| one.point == point));
    all.reverse();
    // A sort that keeps the order of what is equal: open ones first.
    all.sort_by_key(|one| one.state.is_closed());
    Ok(SessionList {
        sessions: all.iter().map(jobs::session).collect(),
    })
}

/// The cell and the session a path names.
pub(super) struct SessionOf {
    cell: String,
    session: Uuid,
}

impl FromRequestParts<Arc<App>> for SessionOf {
    type Rejection = Problem;

    async fn from_request_parts(parts: &mut Parts, _: &Arc<App>) -> Result<Self, Problem> {
        let params = path_params(parts).await?;
        let session = Uuid::parse_str(param(&params, "session")?)
            .map_err(|_| Problem::not_found("the session's id is not a UUID"))?;
        Ok(Self {
            cell: param(&params, "cell")?.to_owned(),
            session,
        })
    }
}

/// The cell and the point a path names.
pub(super) struct PointOf {
    cell: String,
    point: String,
}

impl FromRequestParts<Arc<App>> for PointOf {
    type Rejection = Problem;

    async fn from_request_parts(parts: &mut Parts, _: &Arc<App>) -> Result<Self, Problem> {
        let params = path_params(parts).await?;
        Ok(Self {
            cell: param(&params, "cell")?.to_owned(),
            point: format!(
                "{}/{}",
                param(&params, "station")?,
                param(&params, "point")?
            ),
        })
    }
}
