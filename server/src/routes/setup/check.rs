use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};

use api::ProblemCode;
use api::setup::{SetupCheck, SetupFile};
use axum::Json;
use axum::extract::{Request, State};
use axum::http::header;

use super::body::document;
use crate::problem::Problem;
use crate::routes::params::{CellId, CellPath};
use crate::routes::responses::{AnyProblem, BodyProblem, CrossSite, NotFound};
use crate::setup::parse_setup;
use crate::state::App;

/// Whoever waits for an answer; gone once this is dropped.
#[derive(Debug, Default)]
struct Caller {
    gone: Arc<AtomicBool>,
}

impl Drop for Caller {
    fn drop(&mut self) {
        self.gone.store(true, Ordering::Relaxed);
    }
}

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
    // Thousands of inverse kinematics: one check at a time, and not on a thread that answers others. Who goes away
    // while waiting is not waited for, and nobody goes on computing for them.
    let Ok(place) = Arc::clone(&app.computing).acquire_owned().await else {
        unreachable!("the place for computing is never closed");
    };
    let caller = Caller::default();
    let given_up = Arc::clone(&caller.gone);
    let checking = tokio::task::spawn_blocking(move || {
        let _until_the_end = place;
        if let Some(sent) = text {
            let file = parse_setup(&sent.text, sent.form)?;
            return Ok(book.checked(&file)?.check_for(&given_up));
        }
        let kept = book.current();
        Ok(SetupCheck {
            revision: Some(kept.revision),
            ..kept.setup.check_for(&given_up)
        })
    });
    match checking.await {
        Ok(checked) => checked.map(Json),
        Err(_) => Err(Problem::new(
            ProblemCode::Internal,
            "the check ended early; the server's log says more",
        )),
    }
}
