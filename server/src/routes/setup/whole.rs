use std::sync::Arc;

use api::setup::{SetupFile, SetupRevision};
use axum::Json;
use axum::extract::{Request, State};
use axum::http::{HeaderMap, header};
use axum::response::Response;

use super::body::{JSON, TOML, based_on, document, tagged, wanted};
use super::problems::ChangeProblem;
use crate::problem::Problem;
use crate::routes::params::{CellId, CellPath};
use crate::routes::responses::{AnyProblem, BodyProblem, CrossSite, NotFound};
use crate::setup::{Edit, Form, Resource, parse_setup, write_setup};
use crate::state::App;

/// Exports the set-up: JSON, or TOML where `Accept` asks for `application/toml`.
///
/// What is exported can be imported: it reads back as the same.
#[utoipa::path(
    get, path = "/api/v1/cells/{cell}/setup", tag = "setup",
    params(CellPath),
    responses(
        (status = 200, description = "The set-up.",
            content((SetupFile = "application/json"), (String = "application/toml")),
            headers(("etag" = String, description = "Of the whole set-up; for `If-Match`."))),
        NotFound, AnyProblem,
    ),
)]
pub(super) async fn get_setup(
    State(app): State<Arc<App>>,
    CellId(cell): CellId,
    headers: HeaderMap,
) -> Result<Response, Problem> {
    let kept = app.cell(&cell)?.setup.current();
    let form = wanted(&headers);
    let media_type = match form {
        Form::Json => JSON,
        Form::Toml => TOML,
    };
    let text = write_setup(&kept.file, form);
    let answer = ([(header::CONTENT_TYPE, media_type)], text);
    Ok(tagged(&kept.etag, answer))
}

/// Imports a set-up in the place of the one before: all of it, or nothing.
#[utoipa::path(
    put, path = "/api/v1/cells/{cell}/setup", tag = "setup",
    params(CellPath, ("if-match" = String, Header, description = "The entity tag the change is based on.")),
    request_body(content((SetupFile = "application/json"), (String = "application/toml"))),
    responses(
        (status = 200, description = "It holds now.", body = SetupRevision,
            headers(("etag" = String, description = "Of the whole set-up now."))),
        (status = 400, description = "`invalid-json` or `invalid-toml`.", body = api::Problem, content_type = "application/problem+json"),
        ChangeProblem, CrossSite, NotFound, BodyProblem, AnyProblem,
    ),
)]
pub(super) async fn put_setup(
    State(app): State<Arc<App>>,
    CellId(cell): CellId,
    headers: HeaderMap,
    request: Request,
) -> Result<Response, Problem> {
    let book = Arc::clone(&app.cell(&cell)?.setup);
    let based_on = based_on(&headers)?;
    let sent = document(request, &app).await?;
    let imported = parse_setup(&sent.text, sent.form)?;
    let changed = book.change(based_on, Resource::Header, move |file| {
        *file = imported;
        Ok(Edit::Put)
    });
    let changed = changed.await?;
    Ok(tagged(&changed.etag.clone(), Json(changed)))
}
