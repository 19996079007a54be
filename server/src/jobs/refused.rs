//! Why a cell said no, as a problem.

use api::{Outcome, ProblemCode, Violation};
use workflow::Refusal;

use crate::cell::{Refused, Told};
use crate::problem::Problem;

/// The problem of a request that a cell refused. Nothing has changed, and nothing was sent.
///
/// `conflict` is the code where the state of things does not allow it; `prefix` is where in the body the workflows'
/// items are.
pub(crate) fn problem(refused: Refused, conflict: ProblemCode, prefix: &str) -> Problem {
    match refused {
        Refused::Cell(refusal) => of_refusal(refusal, conflict, prefix),
        Refused::NotKept(trouble) => trouble.problem(),
        Refused::Busy => Problem::not_sent(
            ProblemCode::CellNotReady,
            "too many requests wait for the cell",
        )
        .retry_after_a_second(),
        Refused::Stopping => {
            Problem::not_sent(ProblemCode::ShuttingDown, "the server is stopping").retryable()
        }
    }
}

fn of_refusal(refusal: Refusal, conflict: ProblemCode, prefix: &str) -> Problem {
    match refusal {
        Refusal::NotRecovered => Problem::not_sent(
            ProblemCode::CellNotReady,
            "the cell is finding out what became of its last run",
        )
        .retry_after_a_second(),
        Refusal::JournalUnavailable => Problem::not_sent(
            ProblemCode::JournalUnavailable,
            "the journal cannot be written: nothing new is begun",
        )
        .retryable(),
        Refusal::Unknown { what, id } => {
            let id = crate::state::shown(&id);
            Problem::not_found(format!("there is no {what} `{id}`")).outcome(Outcome::NotSent)
        }
        Refusal::Invalid { item, problem } => {
            let item = if item == "deadline" {
                item
            } else {
                format!("{prefix}{item}")
            };
            Problem::not_sent(ProblemCode::Validation, format!("{item}: {problem}")).violations(
                vec![Violation {
                    item,
                    message: problem,
                    ..Violation::default()
                }],
            )
        }
        Refusal::Conflict { command, text } => {
            let code = if command == "create-job" {
                ProblemCode::QueueFull
            } else {
                conflict
            };
            Problem::not_sent(code, format!("{command} is not possible: {text}"))
        }
        interlock @ Refusal::Interlock { .. } => {
            Problem::not_sent(ProblemCode::InterlockViolation, interlock.to_string())
        }
        Refusal::Forbidden { command, needed } => {
            let needed = format!("{needed:?}").to_lowercase();
            Problem::not_sent(
                ProblemCode::Forbidden,
                format!("{command} needs the role {needed}"),
            )
        }
    }
}

/// What a cell answered, or the problem.
pub(crate) fn told(
    answered: Result<Told, Refused>,
    conflict: ProblemCode,
    prefix: &str,
) -> Result<Told, Problem> {
    answered.map_err(|refused| problem(refused, conflict, prefix))
}
