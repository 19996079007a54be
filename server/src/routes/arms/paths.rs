//! Paths of a disc-shaped robot among polygons.

use std::sync::Arc;

use api::paths::{CellRouteBody, PlanRouteBody, PlanRouteResult};
use axum::Json;
use axum::extract::State;

use super::super::mobile_robots::{MobileRobotOf, MobileRobotPath};
use super::super::responses::{AnyProblem, BodyProblem, CrossSite, InvalidJson, NotFound};
use super::{computed, refused};
use crate::extract::ListJson;
use crate::problem::Problem;
use crate::state::App;

/// Plans a path of a disc among polygons: exact or approximate cells, potential field, roadmap.
#[utoipa::path(
    post, path = "/api/v1/routes/plan", tag = "paths",
    request_body = PlanRouteBody,
    responses(
        (status = 200, description = "The path.", body = PlanRouteResult),
        (status = 422, description = "`validation`: an item is out of its range, a polygon is none, or start or goal is in an obstacle. `no-way`: there is none, or none was found.",
            body = api::Problem, content_type = "application/problem+json"),
        CrossSite, InvalidJson, BodyProblem, AnyProblem,
    ),
)]
pub(super) async fn plan_route(
    State(app): State<Arc<App>>,
    ListJson(body): ListJson<PlanRouteBody>,
) -> Result<Json<PlanRouteResult>, Problem> {
    computed(&app, move |wanted| {
        robotics::plan_route_while(&body, wanted)
    })
    .await
}

/// Plans a path of a mobile robot around what stands in the cell's set-up. Nothing is sent.
///
/// In its way are the keep-out zones that are for it, and the hand-over zones that neither its start nor its goal is in.
#[utoipa::path(
    post, path = "/api/v1/cells/{cell}/mobile-robots/{mobile_robot}/routes/plan", tag = "mobile-robots",
    params(MobileRobotPath),
    request_body = CellRouteBody,
    responses(
        (status = 200, description = "The path, in the cell frame.", body = PlanRouteResult),
        (status = 422, description = "`validation`: an item is out of its range, there is no such goal, or start or goal is in an obstacle. `no-way`: there is none, or none was found.",
            body = api::Problem, content_type = "application/problem+json"),
        CrossSite, InvalidJson, NotFound, BodyProblem, AnyProblem,
    ),
)]
pub(super) async fn plan_mobile_robot_route(
    State(app): State<Arc<App>>,
    MobileRobotOf { cell, id }: MobileRobotOf,
    ListJson(body): ListJson<CellRouteBody>,
) -> Result<Json<PlanRouteResult>, Problem> {
    let cell = app.cell(&cell)?;
    let views = cell.work.view().mobile_robots();
    let told = views.into_iter().find(|view| view.id == id);
    let at = told
        .and_then(|view| view.state)
        .map(|state| [state.pose.x_mm, state.pose.y_mm]);
    let question = robotics::route_in_cell(&cell.setup.current().file, &id, at, &body);
    let question = question.map_err(refused)?;
    computed(&app, move |wanted| {
        robotics::plan_route_while(&question, wanted)
    })
    .await
}
