//! What a request says, checked: JSON bodies and query parameters.
//!
//! Stricter than axum's own extractors: the content type must be JSON, the body has a size and a time limit, nothing
//! may follow the value, and each error names the field.

use std::sync::Arc;

use api::{ProblemCode, Violation};
use axum::extract::{FromRequest, FromRequestParts, Request};
use axum::http::request::Parts;
use axum::http::{HeaderMap, HeaderValue, header};
use bytes::Bytes;
use http_body_util::{BodyExt as _, LengthLimitError, Limited};
use serde::Serialize;
use serde::de::DeserializeOwned;
use serde_json::Value;
use thiserror::Error;
use tokio::time::timeout;

use crate::config::ServerPlan;
use crate::problem::Problem;
use crate::request_id::RequestId;
use crate::state::{App, shown};

/// The longest message about a body, and the longest path in it, in characters: both may repeat what the caller sent.
const MAX_MESSAGE: usize = 250;
const MAX_ITEM: usize = 100;

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

/// A JSON body in which some values are lists.
#[derive(Clone, Copy, Debug)]
pub(crate) struct ListJson<T>(pub(crate) T);

impl<T: DeserializeOwned + Serialize> FromRequest<Arc<App>> for ListJson<T> {
    type Rejection = Problem;

    async fn from_request(request: Request, app: &Arc<App>) -> Result<Self, Problem> {
        check_content_type(request.headers())?;
        let limits = &app.server;
        let body = read_body(request, limits, limits.max_body_bytes).await?;
        Ok(Self(parse_with_lists(&body)?))
    }
}

/// A JSON body that may be left out.
#[derive(Clone, Copy, Debug)]
pub(crate) struct OptionalJson<T>(pub(crate) Option<T>);

impl<T: DeserializeOwned> FromRequest<Arc<App>> for OptionalJson<T> {
    type Rejection = Problem;

    async fn from_request(request: Request, app: &Arc<App>) -> Result<Self, Problem> {
        let none = hyper::body::Body::is_end_stream(request.body());
        if none {
            return Ok(Self(None));
        }
        let body = read_json(request, &app.server).await?;
        Ok(Self(Some(body)))
    }
}

/// Why a body was not taken.
#[derive(Debug, Error)]
pub(crate) enum BodyError {
    #[error("the content type is {found}; it must be {}", legal.join(" or "))]
    ContentType {
        found: String,
        legal: &'static [&'static str],
    },
    #[error("the body is larger than {limit} bytes")]
    TooLarge { limit: usize },
    #[error("the body did not arrive within {limit_ms} ms")]
    TooSlow { limit_ms: u128 },
    #[error("the body broke off")]
    Broken,
    #[error("the content encoding is {found}; a body must be sent as it is")]
    ContentEncoding { found: String },
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
            BodyError::ContentType { .. } | BodyError::ContentEncoding { .. } => {
                ProblemCode::UnsupportedMediaType
            }
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
            | BodyError::ContentEncoding { .. }
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
    let body = read_body(request, limits, limits.max_body_bytes).await?;
    parse_json(&body)
}

fn check_content_type(headers: &HeaderMap) -> Result<(), BodyError> {
    media_type(headers, &["application/json"]).map(|_| ())
}

/// The content type of a body, one of `legal`.
pub(crate) fn media_type(
    headers: &HeaderMap,
    legal: &'static [&'static str],
) -> Result<&'static str, BodyError> {
    let Some(value) = headers.get(header::CONTENT_TYPE) else {
        return Err(BodyError::ContentType {
            found: "absent".to_owned(),
            legal,
        });
    };
    let essence = value
        .to_str()
        .ok()
        .and_then(|text| text.split(';').next())
        .map(str::trim);
    let found = legal
        .iter()
        .find(|legal| essence.is_some_and(|essence| essence.eq_ignore_ascii_case(legal)));
    let Some(found) = found else {
        return Err(BodyError::ContentType {
            found: quoted(value),
            legal,
        });
    };
    match headers.get(header::CONTENT_ENCODING) {
        Some(value) if value != "identity" => Err(BodyError::ContentEncoding {
            found: quoted(value),
        }),
        Some(_) | None => Ok(found),
    }
}

fn quoted(value: &HeaderValue) -> String {
    format!("`{}`", shown(&String::from_utf8_lossy(value.as_bytes())))
}

/// Reads a whole body of at most `limit` bytes.
pub(crate) async fn read_body(
    request: Request,
    limits: &ServerPlan,
    limit: usize,
) -> Result<Bytes, BodyError> {
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
    let value = read_value(body)?;
    // serde takes an array for an object, its values in the order of the fields. No body here holds an array.
    if holds_array(body) {
        return Err(BodyError::Shape {
            item: "body".to_owned(),
            message: "invalid type: array, expected objects with named values".to_owned(),
        });
    }
    Ok(value)
}

/// As [`parse_json`], where arrays are allowed for what is written as one, and nowhere else.
fn parse_with_lists<T: DeserializeOwned + Serialize>(body: &[u8]) -> Result<T, BodyError> {
    let value = read_value(body)?;
    let sent: Value = read_value(body)?;
    let understood = serde_json::to_value(&value).unwrap_or_default();
    match array_for_object(&sent, &understood) {
        None => Ok(value),
        Some(path) => Err(BodyError::Shape {
            item: item_of(path.trim_start_matches('.'), ""),
            message: "invalid type: array, expected an object with named values".to_owned(),
        }),
    }
}

/// The path of the first array that was read as an object.
fn array_for_object(sent: &Value, understood: &Value) -> Option<String> {
    match (sent, understood) {
        (Value::Array(_), Value::Object(_)) => Some(String::new()),
        (Value::Array(sent), Value::Array(understood)) => sent
            .iter()
            .zip(understood)
            .enumerate()
            .find_map(|(index, (sent, understood))| {
                let rest = array_for_object(sent, understood)?;
                Some(format!("[{index}]{rest}"))
            }),
        (Value::Object(sent), Value::Object(understood)) => sent.iter().find_map(|(key, sent)| {
            let rest = array_for_object(sent, understood.get(key)?)?;
            Some(format!(".{key}{rest}"))
        }),
        _ => None,
    }
}

fn read_value<T: DeserializeOwned>(body: &[u8]) -> Result<T, BodyError> {
    let mut json = serde_json::Deserializer::from_slice(body);
    // The path is tracked only where there is an error to report: tracking it allocates for every field.
    let value = T::deserialize(&mut json).map_err(|_| explain::<T>(body))?;
    json.end().map_err(|error| syntax(body, &error))?;
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
        Err(error) => explain_json::<T>(body).unwrap_or_else(|| syntax(body, error.inner())),
    }
}

/// What does not fit in a body that is JSON all the same: `serde_json` calls a value of another kind than an enum's a
/// syntax error.
fn explain_json<T: DeserializeOwned>(body: &[u8]) -> Option<BodyError> {
    let value: serde_json::Value = serde_json::from_slice(body).ok()?;
    let error = serde_path_to_error::deserialize::<_, T>(value).err()?;
    let message = message_of(error.inner());
    Some(BodyError::Shape {
        item: item_of(&error.path().to_string(), &message),
        message,
    })
}

fn syntax(body: &[u8], error: &serde_json::Error) -> BodyError {
    let message = if body.is_empty() {
        "the body is empty".to_owned()
    } else if body.starts_with(b"\xef\xbb\xbf") {
        "a byte order mark stands before the value".to_owned()
    } else {
        message_of(error)
    };
    BodyError::Syntax {
        message,
        line: error.line(),
        column: error.column(),
    }
}

/// The path of the field an error is about. serde's path ends at the object a field is missing from, or twice in;
/// the message has its name. The path of the whole value is a dot.
pub(crate) fn item_of(path: &str, message: &str) -> String {
    let named = ["missing field `", "duplicate field `"]
        .iter()
        .find_map(|begin| message.strip_prefix(begin))
        .and_then(|rest| rest.split('`').next());
    let item = match (path, named) {
        (".", None) => "body".to_owned(),
        (".", Some(name)) => name.to_owned(),
        (path, Some(name)) if path != name && !path.ends_with(&format!(".{name}")) => {
            format!("{path}.{name}")
        }
        (path, _) => path.to_owned(),
    };
    cut(item, MAX_ITEM)
}

/// The error's text without the position `serde_json` puts behind it, in JSON's words instead of Rust's, and no
/// longer than a person reads.
pub(crate) fn message_of(error: &serde_json::Error) -> String {
    const WORDS: [(&str, &str); 6] = [
        (": sequence, ", ": array, "),
        (": map, ", ": object, "),
        (", expected map with", ", expected an object with"),
        (", expected f64", ", expected a number"),
        (", expected u64", ", expected a whole number from 0"),
        (", expected struct ", ", expected an object, "),
    ];
    let mut text = error.to_string();
    if let Some(end) = text.rfind(" at line ") {
        text.truncate(end);
    }
    for (rust, json) in WORDS {
        // Only the first: what follows may be the caller's own text.
        text = text.replacen(rust, json, 1);
    }
    cut(text, MAX_MESSAGE)
}

fn cut(mut text: String, characters: usize) -> String {
    if let Some((end, _)) = text.char_indices().nth(characters) {
        text.truncate(end);
        text.push('…');
    }
    text
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
    fn an_array_is_a_list_only_where_there_is_one() {
        let job = |params: &str| {
            let text = format!(r#"{{"workflow": "delivery-and-placement", "params": {params}}}"#);
            parse_with_lists::<api::JobBody>(text.as_bytes()).map_err(|error| error.to_string())
        };
        let list = r#"{"point": "a/b", "items": [{"type": "t", "mr_slot": "s", "place": "p", "alternates": ["q"]}]}"#;
        assert!(job(list).is_ok());
        let error = job(r#"{"point": "a/b", "items": [[null, "t", "s", "p"]]}"#).unwrap_err();
        assert!(
            error.starts_with("params.items[0]: invalid type: array"),
            "{error}"
        );
        let error = job(r#"[null, null, "a/b", []]"#).unwrap_err();
        assert!(error.starts_with("params: invalid type: array"), "{error}");
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
