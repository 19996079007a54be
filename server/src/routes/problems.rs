//! What the `type` of a problem leads to.

use std::sync::Arc;

use api::{ProblemCode, ProblemKind};
use axum::Json;
use axum::extract::FromRequestParts;
use axum::http::request::Parts;

use super::params::{param, path_params};
use super::responses::{AnyProblem, NotFound};
use crate::problem::Problem;
use crate::state::App;

/// Lists the kinds of problems.
#[utoipa::path(
    get, path = "/problems", tag = "problems",
    responses((status = 200, description = "Every kind.", body = Vec<ProblemKind>), AnyProblem),
)]
pub(super) async fn list_problems() -> Json<Vec<ProblemKind>> {
    Json(ProblemCode::ALL.iter().copied().map(kind).collect())
}

/// Shows a kind of problem.
#[utoipa::path(
    get, path = "/problems/{code}", tag = "problems",
    params(("code" = ProblemCode, Path, description = "The problem's code.")),
    responses((status = 200, description = "The kind.", body = ProblemKind), NotFound, AnyProblem),
)]
pub(super) async fn get_problem(Code(code): Code) -> Json<ProblemKind> {
    Json(kind(code))
}

fn kind(code: ProblemCode) -> ProblemKind {
    ProblemKind {
        code,
        title: code.title().to_owned(),
        status: code.status(),
    }
}

/// The code a path names.
pub(super) struct Code(ProblemCode);

impl FromRequestParts<Arc<App>> for Code {
    type Rejection = Problem;

    async fn from_request_parts(parts: &mut Parts, _: &Arc<App>) -> Result<Self, Problem> {
        let params = path_params(parts).await?;
        ProblemCode::of_str(param(&params, "code")?)
            .map(Self)
            .ok_or_else(|| Problem::not_found("there is no such kind of problem"))
    }
}
