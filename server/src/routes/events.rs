//! What happens in a cell, live.

use std::sync::Arc;

use api::{CellEvent, CellStatus, EventGap, EventsQuery, ProblemCode, Violation};
use axum::extract::{FromRequestParts, Query, State};
use axum::http::request::Parts;
use axum::http::{HeaderName, HeaderValue, header};
use axum::response::{IntoResponse, Response};
use tokio::sync::mpsc;

use super::params::{CellId, CellPath};
use super::responses::{AnyProblem, NotFound};
use crate::events::{self, CHUNKS, EventId, Filter};
use crate::problem::Problem;
use crate::state::{App, shown};

const LAST_EVENT_ID: HeaderName = HeaderName::from_static("last-event-id");
/// The longest text that names an event, and the most types that are named.
const MAX_ID: usize = 64;
const MAX_TYPES: usize = 32;
const MAX_TYPE: usize = 64;

/// Streams what happens in a cell, as server-sent events.
///
/// Each event is data in the form of `CloudEvents` 1.0 and is sent with an `id`, `<epoch>-<position>`: where its record
/// stands in the journal. A caller that comes back with the last id in `Last-Event-ID` gets what followed, over a
/// restart of the server too; events of one record may come twice, each with the same `id` in its data. `event: gap`
/// says that events are missing: they are not kept any more, the id is of another journal, or the caller reads too
/// slowly. `:hb` comes after 15 s of silence. There is room for a number of streams, and no more (`server-busy`).
#[utoipa::path(
    get, path = "/api/v1/cells/{cell}/events", tag = "events",
    params(
        CellPath, EventsQuery,
        ("last-event-id" = Option<String>, Header, description = "The id of the last event the caller has."),
    ),
    responses(
        (status = 200, description = "Events: `CellEvent`, `EventGap` with `event: gap`, `CellStatus` with `event: status`.",
            content((CellEvent = "text/event-stream"), (EventGap = "text/event-stream; event=gap"),
                (CellStatus = "text/event-stream; event=status"))),
        (status = 422, description = "`validation`: a parameter does not fit.",
            body = api::Problem, content_type = "application/problem+json"),
        (status = 503, description = "`server-busy`: as many streams are open as may be.",
            body = api::Problem, content_type = "application/problem+json",
            headers(("retry-after" = u32, description = "Seconds after which to try again."))),
        NotFound, AnyProblem,
    ),
)]
pub(super) async fn get_events(
    State(app): State<Arc<App>>,
    CellId(id): CellId,
    Asked { query, from }: Asked,
) -> Result<Response, Problem> {
    let cell = app.cell(&id)?;
    let asked = events::Asked {
        cell: Arc::from(&*cell.id),
        from,
        filter: Filter {
            types: types(query.types.as_deref())?,
            job: query.job,
        },
        status: query.status.then(|| cell.work.clone()),
    };
    let (chunks, body) = mpsc::channel(CHUNKS);
    // It ends with the connection, or with the server.
    drop(tokio::spawn(app.events.clone().send(asked, chunks)));
    let headers = [
        (
            header::CONTENT_TYPE,
            HeaderValue::from_static("text/event-stream"),
        ),
        (header::CACHE_CONTROL, HeaderValue::from_static("no-store")),
    ];
    Ok((headers, events::stream_body(body)).into_response())
}

fn types(text: Option<&str>) -> Result<Vec<String>, Problem> {
    let types: Vec<_> = text.into_iter().flat_map(|text| text.split(',')).collect();
    let legal = |byte: u8| byte.is_ascii_lowercase() || byte == b'-' || byte == b'.';
    let wrong = types
        .iter()
        .find(|text| text.is_empty() || text.len() > MAX_TYPE || !text.bytes().all(legal));
    if let Some(wrong) = wrong {
        let message = format!("`{}` is no type of events", shown(wrong));
        return Err(invalid("types", message));
    }
    if types.len() > MAX_TYPES {
        let message = format!("has {} entries; at most {MAX_TYPES} are taken", types.len());
        return Err(invalid("types", message));
    }
    Ok(types.into_iter().map(str::to_owned).collect())
}

/// The query, and where to begin.
pub(super) struct Asked {
    query: EventsQuery,
    from: Option<EventId>,
}

impl FromRequestParts<Arc<App>> for Asked {
    type Rejection = Problem;

    async fn from_request_parts(parts: &mut Parts, _: &Arc<App>) -> Result<Self, Problem> {
        let Query(query) = Query::<EventsQuery>::try_from_uri(&parts.uri)
            .map_err(|error| invalid("query", error.body_text()))?;
        let header = parts.headers.get(LAST_EVENT_ID);
        let header = header.map(|value| String::from_utf8_lossy(value.as_bytes()).into_owned());
        // A browser sends an empty one where it has none.
        let header = header.filter(|text| !text.is_empty());
        let (item, text) = match (header, &query.from) {
            (Some(header), _) => ("last-event-id", header),
            (None, Some(from)) => ("from", from.clone()),
            (None, None) => return Ok(Self { query, from: None }),
        };
        let from = Some(&text).filter(|text| text.len() <= MAX_ID);
        let from = from.and_then(|text| EventId::parse(text));
        let Some(from) = from else {
            let message = format!(
                "`{}` is no id of an event: <epoch>-<position>",
                shown(&text)
            );
            return Err(invalid(item, message));
        };
        Ok(Self {
            query,
            from: Some(from),
        })
    }
}

fn invalid(item: &str, message: String) -> Problem {
    Problem::new(ProblemCode::Validation, format!("{item}: {message}")).violations(vec![
        Violation {
            item: item.to_owned(),
            message,
            ..Violation::default()
        },
    ])
}
