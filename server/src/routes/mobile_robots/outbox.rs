//! What a mobile robot fetches.

use std::sync::Arc;
use std::time::Duration;

use api::{MAX_OUTBOX_WAIT_S, Outbox, OutboxMessage, OutboxQuery, ProblemCode, Violation};
use axum::Json;
use axum::extract::{FromRequestParts, Query, State};
use axum::http::request::Parts;
use tokio::time::{Instant, timeout_at};

use super::super::responses::{AnyProblem, NotFound};
use super::{MobileRobotOf, MobileRobotPath};
use crate::cell::Outboxes;
use crate::problem::Problem;
use crate::state::App;

/// What is left of a request's time when a wait ends, for the answer itself.
const ANSWER_TIME: Duration = Duration::from_millis(500);

/// Fetches the messages for a mobile robot, waiting for one if there is none.
///
/// Messages stay until a later request names them, or a later one, in `after`. A permit that was not fetched before it
/// was taken back is never seen, so numbers may have holes.
#[utoipa::path(
    get, path = "/api/v1/cells/{cell}/mobile-robots/{mobile_robot}/outbox", tag = "mobile-robots",
    params(MobileRobotPath, OutboxQuery),
    responses(
        (status = 200, description = "The messages; none if none came in time.", body = Outbox),
        (status = 422, description = "`validation`: a parameter is unknown or out of its range.",
            body = api::Problem, content_type = "application/problem+json"),
        NotFound, AnyProblem,
    ),
)]
pub(crate) async fn get_outbox(
    State(app): State<Arc<App>>,
    MobileRobotOf { cell, id }: MobileRobotOf,
    Asked(OutboxQuery { after, wait_s }): Asked,
) -> Result<Json<Outbox>, Problem> {
    let cell = app.cell(&cell)?;
    let outboxes = Outboxes::new(cell.work.clone(), Arc::clone(&cell.setup));
    if let Err(refused) = outboxes.acknowledge(&id, after).await {
        // It has them all the same, and says so again with its next request.
        tracing::debug!(
            ?refused,
            mobile_robot.id = id,
            "an acknowledgment was not kept"
        );
    }
    let most = app.server.request_timeout.saturating_sub(ANSWER_TIME);
    let wait = Duration::from_secs(u64::from(wait_s)).min(most);
    let deadline = Instant::now() + wait;
    let mut news = cell.work.watch();
    loop {
        news.mark_unchanged();
        let messages = outboxes.after(&id, after);
        if !messages.is_empty() {
            return Ok(Json(page(messages, after)));
        }
        match timeout_at(deadline, news.changed()).await {
            Ok(Ok(())) => {}
            // Nothing came in time, or the server is stopping.
            Ok(Err(_)) | Err(_) => return Ok(Json(page(messages, after))),
        }
    }
}

fn page(messages: Vec<OutboxMessage>, after: u64) -> Outbox {
    Outbox {
        next: messages.last().map_or(after, |last| last.n),
        messages,
    }
}

/// The query of an outbox, in range.
pub(crate) struct Asked(OutboxQuery);

impl FromRequestParts<Arc<App>> for Asked {
    type Rejection = Problem;

    async fn from_request_parts(parts: &mut Parts, _: &Arc<App>) -> Result<Self, Problem> {
        let Query(query) = Query::<OutboxQuery>::try_from_uri(&parts.uri)
            .map_err(|error| invalid("query", error.body_text(), None))?;
        if query.wait_s > MAX_OUTBOX_WAIT_S {
            let message = format!("{} is not from 0 to {MAX_OUTBOX_WAIT_S}", query.wait_s);
            return Err(invalid("wait_s", message, Some(f64::from(query.wait_s))));
        }
        Ok(Self(query))
    }
}

fn invalid(item: &str, message: String, value: Option<f64>) -> Problem {
    Problem::new(ProblemCode::Validation, format!("{item}: {message}")).violations(vec![
        Violation {
            item: item.to_owned(),
            message,
            value,
            ..Violation::default()
        },
    ])
}
