//! What can be wrong with a change to a set-up.

#![expect(dead_code, reason = "the variants exist for their descriptions only")]

use api::{Outcome, ProblemCode};
use utoipa::IntoResponses;

use crate::problem::Problem;
use crate::setup::{ChangeError, DocumentError, Form, SetupErrors, StoreError};

/// The problems of a change, for the OpenAPI document.
#[derive(IntoResponses)]
pub(crate) enum ChangeProblem {
    /// `still-referenced`: other parts refer to it. `resource-in-use`: running work uses it.
    #[response(status = 409, content_type = "application/problem+json")]
    Conflict(api::Problem),
    /// `precondition-failed`: the set-up was changed since the entity tag in `If-Match`.
    #[response(status = 412, content_type = "application/problem+json")]
    Stale(api::Problem),
    /// `validation`: something does not fit; all of it is listed.
    #[response(status = 422, content_type = "application/problem+json")]
    Validation(api::Problem),
    /// `precondition-required`: `If-Match` is missing.
    #[response(status = 428, content_type = "application/problem+json")]
    NoPrecondition(api::Problem),
    /// `setup-not-kept`: the change could not be written; nothing was changed.
    #[response(status = 503, content_type = "application/problem+json")]
    NotKept(api::Problem),
}

impl From<SetupErrors> for Problem {
    fn from(errors: SetupErrors) -> Self {
        validation(errors)
    }
}

impl From<DocumentError> for Problem {
    fn from(error: DocumentError) -> Self {
        match error {
            DocumentError::Syntax { form, .. } => {
                let code = match form {
                    Form::Json => ProblemCode::InvalidJson,
                    Form::Toml => ProblemCode::InvalidToml,
                };
                Self::new(code, error.to_string())
            }
            DocumentError::Shape(errors) => validation(errors),
        }
    }
}

impl From<ChangeError> for Problem {
    fn from(error: ChangeError) -> Self {
        let detail = error.to_string();
        match error {
            ChangeError::Stale { .. } => Self::new(ProblemCode::PreconditionFailed, detail).hint(
                "GET it again, look at what has changed, and repeat the change on top of that",
            ),
            ChangeError::NotThere { .. } => Self::not_found(detail),
            ChangeError::Invalid(errors) => validation(errors),
            ChangeError::Referenced { by, .. } => {
                Self::new(ProblemCode::StillReferenced, detail).violations(by.into_violations())
            }
            ChangeError::InUse { .. } => Self::new(ProblemCode::ResourceInUse, detail).retryable(),
            ChangeError::NotKept(error) => {
                tracing::error!(
                    error = &error as &dyn std::error::Error,
                    "the set-up could not be kept"
                );
                let outcome = match error {
                    StoreError::InDoubt { .. } => Outcome::Unknown,
                    StoreError::Read { .. }
                    | StoreError::Unfit { .. }
                    | StoreError::Write { .. } => Outcome::None,
                };
                // Paths of this machine are for its log.
                Self::new(
                    ProblemCode::SetupNotKept,
                    "the file of the set-up could not be written; the log of the server says why",
                )
                .outcome(outcome)
                .retryable()
            }
        }
    }
}

fn validation(errors: SetupErrors) -> Problem {
    let count = errors.violations().len();
    let detail = match errors.violations() {
        [only] => format!("{}: {}", only.item, only.message),
        [first, ..] => format!(
            "{count} things do not fit; the first is {}: {}",
            first.item, first.message
        ),
        [] => "it does not fit".to_owned(),
    };
    Problem::new(ProblemCode::Validation, detail).violations(errors.into_violations())
}
