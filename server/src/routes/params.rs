//! What paths and queries say, checked.

use std::sync::Arc;

use api::{ProblemCode, Violation};
use axum::extract::{FromRequestParts, RawPathParams};
use axum::http::request::Parts;
use utoipa::IntoParams;
use uuid::Uuid;

use crate::problem::{Problem, outcome_of_nothing_sent};
use crate::state::{App, Cell, Robot};

/// The cell in a path, for the OpenAPI document.
#[derive(IntoParams)]
#[into_params(parameter_in = Path)]
#[expect(dead_code, reason = "the fields exist for their descriptions only")]
pub(super) struct CellPath {
    /// The cell's id.
    #[param(example = "demo")]
    cell: String,
}

/// The robot in a path, for the OpenAPI document.
#[derive(IntoParams)]
#[into_params(parameter_in = Path)]
#[expect(dead_code, reason = "the fields exist for their descriptions only")]
pub(super) struct RobotPath {
    /// The cell's id.
    #[param(example = "demo")]
    cell: String,
    /// The robot's id.
    #[param(example = "r1")]
    robot: String,
}

/// The header that says on whose behalf a robot is moved, for the OpenAPI document.
#[derive(IntoParams)]
#[into_params(parameter_in = Header)]
#[expect(dead_code, reason = "the fields exist for their descriptions only")]
pub(super) struct ControlHeader {
    /// The `token` of the caller's control authority over the cell: `<lease>.<epoch>`.
    #[param(rename = "Control-Token")]
    control_token: String,
}

/// The robot a path names: `…/cells/{cell}/robots/{robot}…`.
pub(super) struct RobotOf(pub(super) Arc<Robot>);

impl FromRequestParts<Arc<App>> for RobotOf {
    type Rejection = Problem;

    async fn from_request_parts(parts: &mut Parts, app: &Arc<App>) -> Result<Self, Problem> {
        let params = path_params(parts).await?;
        let cell = param(&params, "cell")?;
        let robot = param(&params, "robot")?;
        let found = app.robot(cell, robot);
        found
            .map(|robot| Self(Arc::clone(robot)))
            .map_err(|problem| problem.outcome(outcome_of_nothing_sent(&parts.method)))
    }
}

/// The cell a path names.
pub(crate) async fn cell_of<'a>(parts: &mut Parts, app: &'a App) -> Result<&'a Cell, Problem> {
    let params = path_params(parts).await?;
    app.cell(param(&params, "cell")?)
}

/// The cell id a path names.
pub(super) struct CellId(pub(super) String);

impl FromRequestParts<Arc<App>> for CellId {
    type Rejection = Problem;

    async fn from_request_parts(parts: &mut Parts, _: &Arc<App>) -> Result<Self, Problem> {
        let params = path_params(parts).await?;
        param(&params, "cell").map(|cell| Self(cell.to_owned()))
    }
}

/// The motion id a path names. What is no id cannot be the id of a motion.
pub(super) struct MotionId(pub(super) Uuid);

impl FromRequestParts<Arc<App>> for MotionId {
    type Rejection = Problem;

    async fn from_request_parts(parts: &mut Parts, _: &Arc<App>) -> Result<Self, Problem> {
        let params = path_params(parts).await?;
        let id = Uuid::parse_str(param(&params, "id")?);
        id.map(Self)
            .map_err(|_| Problem::not_found("the motion's id is not a UUID"))
    }
}

pub(super) async fn path_params(parts: &mut Parts) -> Result<RawPathParams, Problem> {
    RawPathParams::from_request_parts(parts, &())
        .await
        .map_err(|_| Problem::not_found("the path is not UTF-8"))
}

pub(super) fn param<'a>(params: &'a RawPathParams, name: &str) -> Result<&'a str, Problem> {
    params
        .iter()
        .find(|(key, _)| *key == name)
        .map(|(_, value)| value)
        .ok_or_else(|| Problem::new(ProblemCode::Internal, format!("the route has no `{name}`")))
}

pub(super) fn invalid(item: &str, message: String, value: Option<f64>) -> Problem {
    Problem::new(ProblemCode::Validation, format!("{item}: {message}")).violations(vec![
        Violation {
            item: item.to_owned(),
            message,
            value: value.filter(|value| value.is_finite()),
            ..Violation::default()
        },
    ])
}
