//! What requests about a set-up say: the form of the text, and the revision a change is based on.

use std::sync::Arc;

use api::ProblemCode;
use axum::extract::Request;
use axum::http::{HeaderMap, HeaderValue, header};
use axum::response::{IntoResponse, Response};
use bytes::Bytes;
use tokio::sync::OwnedSemaphorePermit;

use crate::config::ServerPlan;
use crate::extract::{media_type, read_body};
use crate::problem::Problem;
use crate::setup::{BasedOn, Form};
use crate::state::App;

/// A set-up may be larger than other bodies: a thousand places with a thousand taught poses.
const MAX_SETUP_BYTES: usize = 1024 * 1024;

pub(super) const TOML: &str = "application/toml";
pub(super) const JSON: &str = "application/json";

/// A whole set-up as it was sent.
#[derive(Debug)]
pub(super) struct Document {
    pub(super) text: Bytes,
    pub(super) form: Form,
    /// Of a large one, until it has been worked on.
    _place: Option<OwnedSemaphorePermit>,
}

/// Reads a whole set-up. There are few places for large ones: with one on each of the server's connections, their
/// memory would be the server's.
pub(super) async fn document(request: Request, app: &App) -> Result<Document, Problem> {
    let limits = &app.server;
    let form = match media_type(request.headers(), &[JSON, TOML])? {
        TOML => Form::Toml,
        _ => Form::Json,
    };
    let announced = request
        .headers()
        .get(header::CONTENT_LENGTH)
        .and_then(|value| value.to_str().ok())
        .and_then(|text| text.parse::<usize>().ok());
    let (limit, place) = match announced {
        Some(length) if length <= limits.max_body_bytes => (limits.max_body_bytes, None),
        Some(_) | None => {
            let place = Arc::clone(&app.large_bodies).try_acquire_owned();
            let place = place.map_err(|_taken| {
                let detail = "other large set-ups are being read and checked";
                Problem::not_sent(ProblemCode::ServerBusy, detail).retry_after_a_second()
            })?;
            (limits.max_body_bytes.max(MAX_SETUP_BYTES), Some(place))
        }
    };
    let text = read_body(request, limits, limit).await?;
    Ok(Document {
        text,
        form,
        _place: place,
    })
}

/// A part of one, in JSON.
pub(super) async fn part(request: Request, limits: &ServerPlan) -> Result<Bytes, Problem> {
    let _json = media_type(request.headers(), &[JSON])?;
    Ok(read_body(request, limits, limits.max_body_bytes).await?)
}

/// The form an answer is wanted in: TOML where the request asks for it, else JSON.
pub(super) fn wanted(headers: &HeaderMap) -> Form {
    let asks = headers
        .get_all(header::ACCEPT)
        .iter()
        .filter_map(|value| value.to_str().ok())
        .flat_map(|value| value.split(','))
        .filter_map(|range| range.split(';').next())
        .any(|range| range.trim().eq_ignore_ascii_case(TOML));
    if asks { Form::Toml } else { Form::Json }
}

/// The entity tags of `If-Match`.
pub(super) fn based_on(headers: &HeaderMap) -> Result<BasedOn, Problem> {
    let tags: Vec<String> = headers
        .get_all(header::IF_MATCH)
        .iter()
        .filter_map(|value| value.to_str().ok())
        .flat_map(|value| value.split(','))
        .map(|tag| tag.trim().to_owned())
        .filter(|tag| !tag.is_empty() && tag != "*")
        .collect();
    if tags.is_empty() {
        return Err(Problem::new(
            ProblemCode::PreconditionRequired,
            "If-Match must name the entity tag of the set-up that the change is based on; `*` names none",
        )
        .hint("GET the set-up, or the part, and send its ETag in If-Match"));
    }
    Ok(BasedOn(tags))
}

/// An answer with the entity tag of the set-up.
pub(super) fn tagged(etag: &str, answer: impl IntoResponse) -> Response {
    let mut response = answer.into_response();
    // A tag is made of digits, quotes and a dash.
    if let Ok(value) = HeaderValue::from_str(etag) {
        let _none = response.headers_mut().insert(header::ETAG, value);
    }
    response
}
