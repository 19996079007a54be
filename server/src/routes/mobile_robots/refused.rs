//! Why the cell took no notice of what a mobile robot sent.

use api::ProblemCode;
use utoipa::IntoResponses;
use workflow::Refusal;

use crate::cell::Refused;
use crate::problem::Problem;

/// What keeps a signal from being recorded, for the OpenAPI document.
#[derive(IntoResponses)]
#[expect(dead_code, reason = "the variants exist for their descriptions only")]
pub(super) enum KeptProblem {
    /// `journal-unavailable`, `server-busy` or `shutting-down`: it was not recorded. Send it again.
    #[response(
        status = 503,
        content_type = "application/problem+json",
        headers(("retry-after" = u32, description = "Seconds after which to try again."))
    )]
    Unavailable(api::Problem),
    /// `journal-full`: it could not be recorded.
    #[response(status = 507, content_type = "application/problem+json")]
    Full(api::Problem),
}

pub(super) fn problem(refused: Refused) -> Problem {
    match refused {
        Refused::Cell(refusal) => of_cell(&refusal),
        Refused::NotKept(trouble) => trouble.problem(),
        Refused::Busy => Problem::not_sent(
            ProblemCode::ServerBusy,
            "too much waits to be decided and recorded",
        )
        .retry_after_a_second(),
        Refused::Stopping => {
            Problem::not_sent(ProblemCode::ShuttingDown, "the server is stopping").retryable()
        }
    }
}

fn of_cell(refusal: &Refusal) -> Problem {
    let detail = refusal.to_string();
    match refusal {
        Refusal::NotRecovered => {
            Problem::not_sent(ProblemCode::ServerBusy, detail).retry_after_a_second()
        }
        Refusal::JournalUnavailable => {
            Problem::not_sent(ProblemCode::JournalUnavailable, detail).retry_after_a_second()
        }
        Refusal::Unknown { .. } => Problem::not_found(detail),
        Refusal::Invalid { .. } => Problem::not_sent(ProblemCode::Validation, detail),
        Refusal::Conflict { .. } => Problem::not_sent(ProblemCode::HandoverConflict, detail),
        Refusal::Interlock { .. } => Problem::not_sent(ProblemCode::InterlockViolation, detail),
        Refusal::Forbidden { .. } => Problem::not_sent(ProblemCode::Forbidden, detail),
    }
}
