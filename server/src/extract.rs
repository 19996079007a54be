//! What a request says, checked: JSON bodies and query parameters.
//!
//! Stricter than axum's own extractors: the content type must be JSON, the body has a size and a time limit, nothing
//! may follow the value, and each error names the field.

use std::sync::Arc;

use api::{ProblemCode, Violation};
use axum::extract::{FromRequest, FromRequestParts, Request};
use axum::http::request::Parts;
use axum::http::{HeaderMap, header};
use bytes::Bytes;
use http_body_util::{BodyExt as _, LengthLimitError, Limited};
use serde::de::DeserializeOwned;
use thiserror::Error;
use tokio::time::timeout;

use crate::config::ServerPlan;
use crate::problem::Problem;
use crate::request_id::RequestId;
use crate::state::App;

/// A JSON body.
#[derive(Clone, Copy, Debug)]
pub(crate) struct JsonBody<T>(pub(crate) T);

impl<T: DeserializeOwned> FromRequest<Arc<App>> for JsonBody<T> {
    type Rejection = Problem;

    async fn from_request(request: Request, app: &Arc<App>) -> Result<Self, Problem> {
        let body = read_json(request, &app.server).await?;
        Ok(Self(body))
    }
}

/// Why a body was not taken.
#[derive(Debug, Error)]
pub(crate) enum BodyError {
    #[error("the content type is {found}; it must be application/json")]
    ContentType { found: String },
    #[error("the body is larger than {limit} bytes")]
    TooLarge { limit: usize },
    #[error("the body did not arrive within {limit_ms} ms")]
    TooSlow { limit_ms: u128 },
    #[error("the body broke off")]
    Broken,
    #[error("{message} (line {line}, column {column})")]
    Syntax {
        message: String,
        line: usize,
        column: usize,
    },
    #[error("{item}: {message}")]
    Shape { item: String, message: String },
}

impl From<BodyError> for Problem {
    fn from(error: BodyError) -> Self {
        let code = match &error {
            BodyError::ContentType { .. } => ProblemCode::UnsupportedMediaType,
            BodyError::TooLarge { .. } => ProblemCode::PayloadTooLarge,
            BodyError::TooSlow { .. } => ProblemCode::RequestTimeout,
            BodyError::Broken | BodyError::Syntax { .. } => ProblemCode::InvalidJson,
            BodyError::Shape { .. } => ProblemCode::Validation,
        };
        let problem = Self::not_sent(code, error.to_string());
        match error {
            BodyError::Shape { item, message } => problem.violations(vec![Violation {
                item,
                message,
                ..Violation::default()
            }]),
            BodyError::ContentType { .. }
            | BodyError::TooLarge { .. }
            | BodyError::TooSlow { .. }
            | BodyError::Broken
            | BodyError::Syntax { .. } => problem,
        }
    }
}

/// Reads a whole body as JSON.
pub(crate) async fn read_json<T: DeserializeOwned>(
    request: Request,
    limits: &ServerPlan,
) -> Result<T, BodyError> {
    check_content_type(request.headers())?;
    let body = read_body(request, limits).await?;
    parse_json(&body)
}

fn check_content_type(headers: &HeaderMap) -> Result<(), BodyError> {
    let Some(value) = headers.get(header::CONTENT_TYPE) else {
        return Err(BodyError::ContentType {
            found: "absent".to_owned(),
        });
    };
    let essence = value
        .to_str()
        .ok()
        .and_then(|text| text.split(';').next())
        .map(str::trim);
    match essence {
        Some(essence) if essence.eq_ignore_ascii_case("application/json") => Ok(()),
        _ => Err(BodyError::ContentType {
            found: format!("`{}`", value.as_bytes().escape_ascii()),
        }),
    }
}

async fn read_body(request: Request, limits: &ServerPlan) -> Result<Bytes, BodyError> {
    let limit = limits.max_body_bytes;
    let announced = request
        .headers()
        .get(header::CONTENT_LENGTH)
        .and_then(|value| value.to_str().ok())
        .and_then(|text| text.parse::<usize>().ok());
    if announced.is_some_and(|announced| announced > limit) {
        return Err(BodyError::TooLarge { limit });
    }
    let whole = Limited::new(request.into_body(), limit).collect();
    match timeout(limits.body_timeout, whole).await {
        Ok(Ok(body)) => Ok(body.to_bytes()),
        Ok(Err(error)) if error.is::<LengthLimitError>() => Err(BodyError::TooLarge { limit }),
        Ok(Err(_)) => Err(BodyError::Broken),
        Err(_) => Err(BodyError::TooSlow {
            limit_ms: limits.body_timeout.as_millis(),
        }),
    }
}

fn parse_json<T: DeserializeOwned>(body: &[u8]) -> Result<T, BodyError> {
    let mut json = serde_json::Deserializer::from_slice(body);
    // The path is tracked only where there is an error to report: tracking it allocates for every field.
    let value = T::deserialize(&mut json).map_err(|_| explain::<T>(body))?;
    json.end().map_err(|error| syntax(&error))?;
    // serde takes an array for an object, its values in the order of the fields. No body here holds an array.
    if holds_array(body) {
        return Err(BodyError::Shape {
            item: "body".to_owned(),
            message: "invalid type: array, expected objects with named values".to_owned(),
        });
    }
    Ok(value)
}

/// Whether valid JSON has an array anywhere.
fn holds_array(json: &[u8]) -> bool {
    let mut in_string = false;
    let mut escaped = false;
    for byte in json {
        match byte {
            _ if escaped => escaped = false,
            b'\\' => escaped = true,
            b'"' => in_string = !in_string,
            b'[' if !in_string => return true,
            _ => {}
        }
    }
    false
}

/// Reads the body once more, to say where it does not fit.
fn explain<T: DeserializeOwned>(body: &[u8]) -> BodyError {
    let mut json = serde_json::Deserializer::from_slice(body);
    match serde_path_to_error::deserialize::<_, T>(&mut json) {
        Ok(_) => BodyError::Broken,
        Err(error) if error.inner().is_data() => BodyError::Shape {
            item: item_of(&error.path().to_string(), &message_of(error.inner())),
            message: message_of(error.inner()),
        },
        Err(error) => syntax(error.inner()),
    }
}

fn syntax(error: &serde_json::Error) -> BodyError {
    BodyError::Syntax {
        message: message_of(error),
        line: error.line(),
        column: error.column(),
    }
}

/// The path of the field an error is about. serde's path ends at the object a field is missing from, or twice in;
/// the message has its name. The path of the whole value is a dot.
fn item_of(path: &str, message: &str) -> String {
    let named = ["missing field `", "duplicate field `"]
        .iter()
        .find_map(|begin| message.strip_prefix(begin))
        .and_then(|rest| rest.split('`').next());
    match (path, named) {
        (".", None) => "body".to_owned(),
        (".", Some(name)) => name.to_owned(),
        (path, Some(name)) if path != name && !path.ends_with(&format!(".{name}")) => {
            format!("{path}.{name}")
        }
        (path, _) => path.to_owned(),
    }
}

/// The error's text without the position `serde_json` puts behind it.
fn message_of(error: &serde_json::Error) -> String {
    let text = error.to_string();
    match text.rfind(" at line ") {
        Some(end) => text.get(..end).unwrap_or(&text).to_owned(),
        None => text,
    }
}

/// The id of the request, as the edge made it.
impl FromRequestParts<Arc<App>> for RequestId {
    type Rejection = Problem;

    async fn from_request_parts(parts: &mut Parts, _: &Arc<App>) -> Result<Self, Problem> {
        parts
            .extensions
            .get::<Self>()
            .cloned()
            .ok_or_else(|| Problem::new(ProblemCode::Internal, "the request passed no edge layer"))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn explained(body: &str) -> String {
        parse_json::<api::MotionBody>(body.as_bytes())
            .unwrap_err()
            .to_string()
    }

    #[test]
    fn an_array_is_not_an_object_whose_keys_were_left_out() {
        let text =
            r#"{"type": "JOINT", "speed_mm_s": 200, "target": {"pose": [985, 0, 940, 180, 0, 0]}}"#;
        assert!(explained(text).starts_with("body: invalid type: array"));
        let text = r#"{"type": "HOME", "speed_mm_s": 200, "reason": "\"[1]"}"#;
        assert!(parse_json::<api::MotionBody>(text.as_bytes()).is_ok());
    }

    #[test]
    fn a_field_that_is_missing_deep_inside_is_named_with_its_path() {
        let text = r#"{"type": "JOINT", "speed_mm_s": 200, "target": {"joints": {"j1_deg": 1}}}"#;
        let message = explained(text);
        assert!(
            message.starts_with("target.joints.j2_deg: missing field"),
            "{message}"
        );
    }
}
