//! Problems in the form of RFC 9457.
//!
//! A handler returns a [`Problem`]; the outermost layer ([`crate::edge`]) adds the request's path and id and writes
//! the body. So a problem is the same wherever in a request it arises, and no body is written twice.

use api::{Outcome, ProblemCode, Violation};
use axum::http::{HeaderName, HeaderValue, Method, StatusCode, header};
use axum::response::{IntoResponse, Response};
use uuid::Uuid;

/// Says that an answer was given before.
pub(crate) const REPLAYED: HeaderName = HeaderName::from_static("idempotency-replayed");
pub(crate) const MEDIA_TYPE: HeaderValue = HeaderValue::from_static("application/problem+json");

/// What goes wrong with a request, on its way to the edge.
#[derive(Clone, Debug)]
pub(crate) struct Problem(Box<Inner>);

#[derive(Clone, Debug)]
struct Inner {
    body: api::Problem,
    retry_after: Option<HeaderValue>,
    /// Whether it was answered before, to the same request.
    replayed: bool,
}

impl Problem {
    /// A problem with its code's own title and status. `detail` names the item, the value and the limit.
    pub(crate) fn new(code: ProblemCode, detail: impl Into<String>) -> Self {
        Self(Box::new(Inner {
            body: api::Problem {
                type_uri: format!("/problems/{}", code.as_str()),
                title: code.title().to_owned(),
                status: code.status(),
                detail: detail.into(),
                instance: None,
                code,
                outcome: Outcome::None,
                retryable: false,
                robot: None,
                motion: None,
                controller_text: None,
                request_id: None,
                violations: Vec::new(),
                hint: None,
            },
            retry_after: None,
            replayed: false,
        }))
    }

    /// A problem with a command that was certainly not sent.
    pub(crate) fn not_sent(code: ProblemCode, detail: impl Into<String>) -> Self {
        Self::new(code, detail).outcome(Outcome::NotSent)
    }

    pub(crate) fn detail(&self) -> &str {
        &self.0.body.detail
    }

    pub(crate) fn list(&self) -> &[Violation] {
        &self.0.body.violations
    }

    pub(crate) fn code(&self) -> ProblemCode {
        self.0.body.code
    }

    pub(crate) fn not_found(detail: impl Into<String>) -> Self {
        Self::new(ProblemCode::NotFound, detail)
    }

    pub(crate) fn outcome(mut self, outcome: Outcome) -> Self {
        self.0.body.outcome = outcome;
        self
    }

    pub(crate) fn robot(mut self, robot: &str) -> Self {
        self.0.body.robot = Some(robot.to_owned());
        self
    }

    pub(crate) fn motion(mut self, motion: Option<Uuid>) -> Self {
        self.0.body.motion = motion;
        self
    }

    pub(crate) fn controller_text(mut self, text: Option<&str>) -> Self {
        self.0.body.controller_text = text.map(str::to_owned);
        self
    }

    pub(crate) fn violations(mut self, violations: Vec<Violation>) -> Self {
        self.0.body.violations = violations;
        self
    }

    pub(crate) fn hint(mut self, hint: &str) -> Self {
        self.0.body.hint = Some(hint.to_owned());
        self
    }

    /// The same request may succeed later.
    pub(crate) fn retryable(mut self) -> Self {
        self.0.body.retryable = true;
        self
    }

    /// The same request may succeed later: in a second, as far as the server can tell.
    pub(crate) fn retry_after_a_second(self) -> Self {
        let mut this = self.retryable();
        this.0.retry_after = Some(HeaderValue::from_static("1"));
        this
    }

    /// It was answered before, to the same request.
    pub(crate) fn replayed(mut self) -> Self {
        self.0.replayed = true;
        self
    }

    /// The answer, complete.
    pub(crate) fn into_answer(self, path: &str, request_id: &str) -> Response {
        let Inner {
            mut body,
            retry_after,
            replayed,
        } = *self.0;
        body.instance = Some(path.to_owned());
        body.request_id = Some(request_id.to_owned());
        let status = StatusCode::from_u16(body.status).unwrap_or(StatusCode::INTERNAL_SERVER_ERROR);
        // A problem is made of strings and numbers that JSON can say.
        let text = serde_json::to_vec(&body).unwrap_or_default();
        let mut response = (status, text).into_response();
        let headers = response.headers_mut();
        let _octets = headers.insert(header::CONTENT_TYPE, MEDIA_TYPE);
        if let Some(seconds) = retry_after {
            let _none = headers.insert(header::RETRY_AFTER, seconds);
        }
        if replayed {
            let _none = headers.insert(REPLAYED, HeaderValue::from_static("true"));
        }
        response
    }
}

/// The outcome of a request that was turned away: what may have been a command was not sent.
pub(crate) fn outcome_of_nothing_sent(method: &Method) -> Outcome {
    if *method == Method::POST {
        Outcome::NotSent
    } else {
        Outcome::None
    }
}

impl IntoResponse for Problem {
    /// An empty answer that carries the problem; the edge writes it out.
    fn into_response(self) -> Response {
        let status = StatusCode::from_u16(self.0.body.status);
        let mut response = status
            .unwrap_or(StatusCode::INTERNAL_SERVER_ERROR)
            .into_response();
        let _none = response.extensions_mut().insert(self);
        response
    }
}
