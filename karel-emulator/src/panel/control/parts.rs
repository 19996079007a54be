//! What the routes share: bodies and queries that are read strictly, and problems.

use std::time::Duration;

use axum::body::Bytes;
use axum::extract::rejection::BytesRejection;
use axum::extract::{FromRequest, FromRequestParts, Query, Request};
use axum::http::request::Parts;
use axum::http::{StatusCode, header};
use axum::response::{IntoResponse, Response};
use serde::de::DeserializeOwned;
use serde::{Deserialize, Serialize};
use utoipa::{IntoResponses, ToSchema};

use crate::clock::TimeError;
use crate::controller::{DataError, OperateError, TaskError, TraceError};
use crate::error::ControllerStopped;
use crate::faults::FaultError;
use crate::json::{JsonError, from_json, of_query};
use crate::panel::{Visitors, problem};
use crate::ports::SetInputError;
use crate::state::State;

/// What went wrong, as `application/problem+json`.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, ToSchema)]
pub struct ProblemBody {
    /// The status in words.
    pub title: String,
    /// The status.
    pub status: u16,
    /// One sentence with item, value and limit.
    pub detail: String,
}

/// Every refusal of these routes.
#[derive(IntoResponses)]
#[expect(dead_code, reason = "for the document only")]
pub(super) enum AnyProblem {
    /// The request cannot be read.
    #[response(status = 400, content_type = "application/problem+json")]
    BadRequest(ProblemBody),
    /// A page of another origin, or a panel that can look and not touch.
    #[response(status = 403, content_type = "application/problem+json")]
    Forbidden(ProblemBody),
    /// There is no such item.
    #[response(status = 404, content_type = "application/problem+json")]
    NotFound(ProblemBody),
    /// Not possible in the present state.
    #[response(status = 409, content_type = "application/problem+json")]
    Conflict(ProblemBody),
    /// A value beyond its limits.
    #[response(status = 422, content_type = "application/problem+json")]
    Unprocessable(ProblemBody),
    /// The controller has stopped.
    #[response(status = 503, content_type = "application/problem+json")]
    Stopped(ProblemBody),
}

/// The longest wait for something new, in seconds.
const WAIT_S: f64 = 30.0;

impl Visitors {
    /// Waits until the controller has news, at most `wait_s` seconds. Nothing new in time, or nothing ever any more: what
    /// is asked afterwards says which.
    pub(super) async fn wait(
        &mut self,
        wait_s: f64,
        news: impl FnMut(&State) -> bool,
    ) -> Result<(), Refusal> {
        if !(0.0..=WAIT_S).contains(&wait_s) {
            return Err(Refusal::range("wait_s", wait_s, "0 to 30"));
        }
        let limit = Duration::from_secs_f64(wait_s);
        let _waited = tokio::time::timeout(limit, self.states.wait_for(news))
            .await
            .map(|news| news.map(drop));
        Ok(())
    }
}

/// A refusal on its way out.
#[derive(Debug)]
pub(super) struct Refusal {
    status: StatusCode,
    detail: String,
}

impl Refusal {
    pub(super) fn new(status: StatusCode, detail: impl Into<String>) -> Self {
        Self {
            status,
            detail: detail.into(),
        }
    }

    /// A number beyond its limits.
    pub(super) fn range(item: &str, value: impl std::fmt::Display, limits: &str) -> Self {
        let detail = format!("{item} is {value}, it must be {limits}");
        Self::new(StatusCode::UNPROCESSABLE_ENTITY, detail)
    }
}

impl IntoResponse for Refusal {
    fn into_response(self) -> Response {
        problem(self.status, &self.detail)
    }
}

/// A JSON body.
#[derive(Debug)]
pub(super) struct Body<T>(pub(super) T);

impl<S: Send + Sync, T: DeserializeOwned> FromRequest<S> for Body<T> {
    type Rejection = Refusal;

    async fn from_request(request: Request, state: &S) -> Result<Self, Refusal> {
        let kind = request.headers().get(header::CONTENT_TYPE);
        let kind = kind.and_then(|kind| kind.to_str().ok()).unwrap_or_default();
        let media = kind.split(';').next().unwrap_or_default().trim();
        if !media.eq_ignore_ascii_case("application/json") {
            let text = format!("the content type is {media:?}, it must be application/json");
            return Err(Refusal::new(StatusCode::BAD_REQUEST, text));
        }
        let bytes = Bytes::from_request(request, state).await.map_err(unread)?;
        from_json(&bytes, "the body").map(Self).map_err(|error| {
            let status = match &error {
                JsonError::Syntax(_) => StatusCode::BAD_REQUEST,
                JsonError::Shape(_) => StatusCode::UNPROCESSABLE_ENTITY,
            };
            Refusal::new(status, error.to_string())
        })
    }
}

#[expect(clippy::needless_pass_by_value, reason = "for `map_err`")]
fn unread(rejection: BytesRejection) -> Refusal {
    if rejection.status() == StatusCode::PAYLOAD_TOO_LARGE {
        let text = "the body is longer than 65536 bytes";
        return Refusal::new(StatusCode::PAYLOAD_TOO_LARGE, text);
    }
    Refusal::new(StatusCode::BAD_REQUEST, rejection.body_text())
}

/// A query without keys that nobody knows.
#[derive(Debug)]
pub(super) struct Asked<T>(pub(super) T);

impl<S: Send + Sync, T: DeserializeOwned> FromRequestParts<S> for Asked<T> {
    type Rejection = Refusal;

    async fn from_request_parts(parts: &mut Parts, state: &S) -> Result<Self, Refusal> {
        match Query::<T>::from_request_parts(parts, state).await {
            Ok(Query(value)) => Ok(Self(value)),
            Err(rejection) => {
                let query = parts.uri.query().unwrap_or_default();
                let text = of_query(query, &rejection.body_text());
                Err(Refusal::new(StatusCode::BAD_REQUEST, text))
            }
        }
    }
}

impl From<ControllerStopped> for Refusal {
    fn from(stopped: ControllerStopped) -> Self {
        Self::new(StatusCode::SERVICE_UNAVAILABLE, stopped.to_string())
    }
}

impl From<TaskError> for Refusal {
    fn from(error: TaskError) -> Self {
        let status = match &error {
            TaskError::NoProgram { .. } | TaskError::NoTask { .. } => StatusCode::NOT_FOUND,
            TaskError::Cannot(_) | TaskError::Option { .. } => StatusCode::CONFLICT,
            TaskError::Stopped(_) => StatusCode::SERVICE_UNAVAILABLE,
        };
        Self::new(status, error.to_string())
    }
}

impl From<TraceError> for Refusal {
    fn from(error: TraceError) -> Self {
        Self::new(StatusCode::NOT_FOUND, error.to_string())
    }
}

impl From<DataError> for Refusal {
    fn from(error: DataError) -> Self {
        let status = match &error {
            DataError::Missing { .. } => StatusCode::NOT_FOUND,
            DataError::Syntax { .. } => StatusCode::BAD_REQUEST,
            DataError::Value { .. } => StatusCode::UNPROCESSABLE_ENTITY,
            DataError::Input(error) => return Self::new(input_status(error), error.to_string()),
            DataError::Stopped(_) => StatusCode::SERVICE_UNAVAILABLE,
        };
        Self::new(status, error.to_string())
    }
}

fn input_status(error: &SetInputError) -> StatusCode {
    match error {
        SetInputError::NotAnInput { .. } | SetInputError::Value { .. } => {
            StatusCode::UNPROCESSABLE_ENTITY
        }
        SetInputError::NoSuchPort { .. } => StatusCode::NOT_FOUND,
        SetInputError::Stopped(_) => StatusCode::SERVICE_UNAVAILABLE,
    }
}

impl From<OperateError> for Refusal {
    fn from(error: OperateError) -> Self {
        let status = match &error {
            OperateError::CannotStart { .. }
            | OperateError::CannotJog { .. }
            | OperateError::KeyboardFull { .. }
            | OperateError::Missing { .. } => StatusCode::CONFLICT,
            OperateError::Facility { .. }
            | OperateError::AlarmNumber { .. }
            | OperateError::Override { .. }
            | OperateError::Key { .. }
            | OperateError::JogLimits { .. } => StatusCode::UNPROCESSABLE_ENTITY,
            OperateError::Stopped(_) => StatusCode::SERVICE_UNAVAILABLE,
        };
        Self::new(status, error.to_string())
    }
}

impl From<TimeError> for Refusal {
    fn from(error: TimeError) -> Self {
        let status = match &error {
            TimeError::Scale(_) | TimeError::Step(_) => StatusCode::UNPROCESSABLE_ENTITY,
            TimeError::NotPaused | TimeError::Busy | TimeError::Stepped => StatusCode::CONFLICT,
            TimeError::Stopped(_) => StatusCode::SERVICE_UNAVAILABLE,
        };
        Self::new(status, error.to_string())
    }
}

impl From<FaultError> for Refusal {
    fn from(error: FaultError) -> Self {
        let status = match &error {
            FaultError::NoSuchFault { .. } => StatusCode::NOT_FOUND,
            FaultError::TooMany | FaultError::Active { .. } => StatusCode::CONFLICT,
            FaultError::Range { .. }
            | FaultError::Tag { .. }
            | FaultError::NotForDevices { .. }
            | FaultError::NoEnd { .. }
            | FaultError::NoTimes
            | FaultError::Frame { .. } => StatusCode::UNPROCESSABLE_ENTITY,
            FaultError::Stopped(_) => StatusCode::SERVICE_UNAVAILABLE,
        };
        Self::new(status, error.to_string())
    }
}
