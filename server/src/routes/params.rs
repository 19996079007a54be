//! What paths and queries say, checked.

use std::sync::Arc;

use api::{ProblemCode, Violation};
use axum::extract::{FromRequestParts, Query, RawPathParams};
use axum::http::Uri;
use axum::http::request::Parts;
use utoipa::IntoParams;
use uuid::Uuid;

use crate::problem::{Problem, outcome_of_nothing_sent};
use crate::state::{App, Cell, Robot, shown};

/// The most motions of one page.
pub(super) const MAX_PAGE: usize = 200;
const DEFAULT_PAGE: usize = 50;

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

/// The query of a list, `limit=50&cursor=…`.
#[derive(Clone, Copy, Debug, Eq, PartialEq)]
pub(super) struct Page {
    pub(super) limit: usize,
    /// Only what is older than this.
    pub(super) before: Option<Uuid>,
}

impl FromRequestParts<Arc<App>> for Page {
    type Rejection = Problem;

    async fn from_request_parts(parts: &mut Parts, _: &Arc<App>) -> Result<Self, Problem> {
        Self::of(&parts.uri)
    }
}

impl Page {
    fn of(uri: &Uri) -> Result<Self, Problem> {
        let pairs = Query::<Vec<(String, String)>>::try_from_uri(uri)
            .map_err(|error| invalid("query", error.body_text(), None))?;
        let (mut limit, mut before) = (None, None);
        for (key, value) in pairs.0 {
            let twice = match key.as_str() {
                "limit" => limit.replace(page_limit(&value)?).is_some(),
                "cursor" => before.replace(cursor(&value)?).is_some(),
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
            before,
        })
    }
}

pub(super) fn page_limit(text: &str) -> Result<usize, Problem> {
    let value: Option<usize> = text.parse().ok();
    value
        .filter(|value| (1..=MAX_PAGE).contains(value))
        .ok_or_else(|| {
            let text = shown(text);
            let message = format!("`{text}` is not a whole number of 1 to {MAX_PAGE}");
            invalid("limit", message, text.parse().ok())
        })
}

fn cursor(text: &str) -> Result<Uuid, Problem> {
    Uuid::parse_str(text).map_err(|_| {
        let message = format!("`{}` is not a `next_cursor` of this list", shown(text));
        invalid("cursor", message, None)
    })
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

#[cfg(test)]
mod tests {
    use super::*;

    fn page(query: &str) -> Result<Page, Problem> {
        Page::of(&format!("/motions?{query}").parse().unwrap())
    }

    /// Covers: R8.
    #[test]
    fn a_page_has_a_limit_and_a_beginning() {
        assert_eq!(page("").unwrap().limit, DEFAULT_PAGE);
        let id = Uuid::from_u128(7);
        let asked = page(&format!("cursor={id}&limit=200")).unwrap();
        assert_eq!(
            asked,
            Page {
                limit: 200,
                before: Some(id)
            }
        );
    }

    #[test]
    fn a_query_that_does_not_fit_is_refused() {
        for query in [
            "limit=0",
            "limit=201",
            "limit=-1",
            "limit=1.5",
            "limit=",
            "limit=1&limit=2",
            "cursor=x",
            "offset=1",
            "limit=%ff",
        ] {
            assert!(page(query).is_err(), "{query}");
        }
    }
}
