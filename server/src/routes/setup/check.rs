use std::sync::Arc;

use api::setup::{SetupCheck, SetupFile};
use axum::Json;
use axum::extract::{Request, State};
use axum::http::header;

use super::body::document;
use crate::compute::compute;
use crate::problem::Problem;
use crate::routes::params::{CellId, CellPath};
use crate::routes::responses::{AnyProblem, BodyProblem, CrossSite, NotFound};
use crate::setup::parse_setup;
use crate::state::App;

/// Plans every taught pose and measures every route. Nothing moves, nothing is changed.
///
/// Without a body (and without a content type) the set-up that holds is checked; with one, that one, without importing
/// it. For places on mobile robots the nominal dock pose and every corner of its tolerance are planned.
#[utoipa::path(
    post, path = "/api/v1/cells/{cell}/setup/check", tag = "setup",
    params(CellPath),
    request_body(content((Option<SetupFile> = "application/json"), (String = "application/toml"))),
    responses(
        (status = 200, description = "What was found; `passed` says whether all is well.", body = SetupCheck),
        (status = 400, description = "`invalid-json` or `invalid-toml`.", body = api::Problem, content_type = "application/problem+json"),
        (status = 422, description = "`validation`: it is no set-up that could be planned; everything wrong is listed.",
            body = api::Problem, content_type = "application/problem+json"),
        (status = 503, description = "`server-busy`: other large set-ups are being checked.", body = api::Problem,
            content_type = "application/problem+json"),
        CrossSite, NotFound, BodyProblem, AnyProblem,
    ),
)]
pub(super) async fn check_setup(
    State(app): State<Arc<App>>,
    CellId(cell): CellId,
    request: Request,
) -> Result<Json<SetupCheck>, Problem> {
    let book = Arc::clone(&app.cell(&cell)?.setup);
    let brings_its_own = request.headers().contains_key(header::CONTENT_TYPE)
        || request
            .headers()
            .get(header::CONTENT_LENGTH)
            .is_some_and(|length| length != "0")
        || request.headers().contains_key(header::TRANSFER_ENCODING);
    let text = if brings_its_own {
        Some(document(request, &app).await?)
    } else {
        None
    };
    // Thousands of inverse kinematics: not on a thread that answers others.
    let checked = compute(&app, move |given_up| {
        if let Some(sent) = text {
            let file = parse_setup(&sent.text, sent.form)?;
            return Ok(book.checked(&file)?.check_for(given_up));
        }
        let kept = book.current();
        Ok(SetupCheck {
            revision: Some(kept.revision),
            ..kept.setup.check_for(given_up)
        })
    });
    checked.await.map(Json)
}
