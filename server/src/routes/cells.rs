//! The cells and their robots.

use std::sync::Arc;

use api::{CellSummary, RobotSummary};
use axum::Json;
use axum::extract::State;

use super::params::{CellId, CellPath};
use super::responses::{AnyProblem, NotFound};
use crate::identity::Principal;
use crate::problem::Problem;
use crate::state::{App, Cell};

/// Lists the cells.
///
/// Of a token that is limited to one cell, that one.
#[utoipa::path(
    get, path = "/api/v1/cells", tag = "cells",
    responses((status = 200, description = "The cells.", body = Vec<CellSummary>), AnyProblem),
)]
pub(super) async fn list_cells(
    State(app): State<Arc<App>>,
    principal: Principal,
) -> Json<Vec<CellSummary>> {
    let cells = app.cells.iter();
    let seen = cells.filter(|cell| principal.sees_cell(&cell.id));
    Json(seen.map(summary).collect())
}

/// Shows a cell.
#[utoipa::path(
    get, path = "/api/v1/cells/{cell}", tag = "cells",
    params(CellPath),
    responses((status = 200, description = "The cell.", body = CellSummary), NotFound, AnyProblem),
)]
pub(super) async fn get_cell(
    State(app): State<Arc<App>>,
    CellId(cell): CellId,
) -> Result<Json<CellSummary>, Problem> {
    Ok(Json(summary(app.cell(&cell)?)))
}

/// Lists the robots of a cell.
#[utoipa::path(
    get, path = "/api/v1/cells/{cell}/robots", tag = "cells",
    params(CellPath),
    responses((status = 200, description = "Its robots.", body = Vec<RobotSummary>), NotFound, AnyProblem),
)]
pub(super) async fn list_robots(
    State(app): State<Arc<App>>,
    CellId(cell): CellId,
) -> Result<Json<Vec<RobotSummary>>, Problem> {
    Ok(Json(robots(app.cell(&cell)?)))
}

fn summary(cell: &Cell) -> CellSummary {
    CellSummary {
        id: cell.id.clone(),
        name: cell.name.clone(),
        robots: robots(cell),
    }
}

fn robots(cell: &Cell) -> Vec<RobotSummary> {
    cell.robots
        .iter()
        .map(|robot| RobotSummary {
            id: robot.plan.id.clone(),
            name: robot.plan.name.clone(),
            model: robot.plan.model.name().to_owned(),
            tier: robot.plan.tier,
        })
        .collect()
}
