//! Errors in the shapes the seed's own clients know.

use api::{LegacyRefusal, LegacyValidation, LegacyValidationItem, ProblemCode};
use axum::Json;
use axum::http::StatusCode;
use axum::response::{IntoResponse, Response};

use crate::authority::Refused;
use crate::extract::BodyError;
use crate::motions::{CommandFailure, no_base};
use crate::problem::Problem;
use crate::target::{Concern, Refusal};

/// An error of one of the seed's routes.
#[derive(Debug)]
pub(crate) enum LegacyError {
    /// 422: what is wrong, and where.
    Validation(LegacyValidationItem),
    /// 409: begins with `ERROR:`.
    Refused(String),
    /// What the seed had no answer for.
    Problem(Problem),
}

impl LegacyError {
    pub(crate) fn validation(loc: &[&str], kind: &'static str, msg: impl Into<String>) -> Self {
        Self::Validation(LegacyValidationItem {
            loc: loc.iter().copied().map(str::to_owned).collect(),
            msg: msg.into(),
            kind: kind.to_owned(),
        })
    }

    /// A refusal by the server's own checks; `names` are those of the body's numbers in the order of the wire, none
    /// where the body has no number of the point. A number that cannot be sent is named; what the arm cannot do reads like
    /// the controller's refusal, because the seed's clients know no other.
    pub(crate) fn of_refusal(refusal: &Refusal, names: &[&str]) -> Self {
        let message = refusal.to_string();
        match refusal.concern() {
            Concern::Speed => Self::validation(&["query", "velocity"], "value_error", message),
            Concern::Point(index) => match names.get(index) {
                Some(name) => Self::validation(&["body", name], "value_error", message),
                None => Self::unreachable(&message),
            },
            Concern::Arm => Self::unreachable(&message),
        }
    }

    pub(crate) fn of_failure(failure: CommandFailure) -> Self {
        match failure {
            CommandFailure::Rejected(reply) => Self::Refused(reply.text().to_owned()),
            // The target of a relative move is a sum, so no single number of the body is to blame.
            CommandFailure::Refused(refusal) => Self::of_refusal(&refusal, &[]),
            CommandFailure::NoBase(base) => {
                Self::Refused(format!("ERROR: NO ACCEPTED TARGET: {}", no_base(base)))
            }
            CommandFailure::Problem(problem) => Self::of_problem(problem),
        }
    }

    /// A problem in the seed's words, where it has some.
    pub(crate) fn of_problem(problem: Problem) -> Self {
        let code = problem.code();
        if code == ProblemCode::ControlHeld {
            // A legacy caller has no token to lose: somebody took control while the command waited.
            Self::Refused(format!("ERROR: NO CONTROL: {}", problem.detail()))
        } else if matches!(
            code,
            ProblemCode::ZoneViolation | ProblemCode::InterlockViolation
        ) {
            Self::unreachable(problem.detail())
        } else {
            Self::Problem(problem)
        }
    }

    /// Somebody has control of the cell, which the seed's clients know nothing of.
    pub(crate) fn of_control(refused: &Refused) -> Self {
        Self::Refused(format!("ERROR: NO CONTROL: {refused}"))
    }

    pub(crate) fn unreachable(reason: &str) -> Self {
        Self::Refused(format!("{}: {reason}", protocol::Reply::Unreachable))
    }
}

impl From<BodyError> for LegacyError {
    fn from(error: BodyError) -> Self {
        match &error {
            BodyError::Syntax { .. } | BodyError::Broken => Self::validation(
                &["body"],
                "json_invalid",
                format!("the body is not valid JSON: {error}"),
            ),
            BodyError::Shape { item, message } => {
                let loc: Vec<&str> = match item.as_str() {
                    "body" => vec!["body"],
                    item => std::iter::once("body").chain(item.split('.')).collect(),
                };
                Self::validation(&loc, kind_of(message), message.clone())
            }
            BodyError::ContentType { .. }
            | BodyError::ContentEncoding { .. }
            | BodyError::TooLarge { .. }
            | BodyError::TooSlow { .. } => Self::Problem(error.into()),
        }
    }
}

/// The words the seed's clients know, from serde's message.
fn kind_of(message: &str) -> &'static str {
    const KINDS: [(&str, &str); 3] = [
        ("missing field", "missing"),
        ("unknown field", "extra_forbidden"),
        ("duplicate field", "duplicate"),
    ];
    let known = KINDS.iter().find(|(begin, _)| message.starts_with(begin));
    match known {
        Some((_, kind)) => kind,
        None if message.ends_with("expected a number") => "float_type",
        None => "type_error",
    }
}

impl IntoResponse for LegacyError {
    fn into_response(self) -> Response {
        match self {
            Self::Validation(item) => {
                let body = LegacyValidation { detail: vec![item] };
                (StatusCode::UNPROCESSABLE_ENTITY, Json(body)).into_response()
            }
            Self::Refused(detail) => {
                (StatusCode::CONFLICT, Json(LegacyRefusal { detail })).into_response()
            }
            Self::Problem(problem) => problem.into_response(),
        }
    }
}
