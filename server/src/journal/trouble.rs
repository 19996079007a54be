use std::error::Error as _;
use std::fmt::Write as _;

use api::ProblemCode;
use journal::{AppendError, Refusal};
use thiserror::Error;

use crate::problem::Problem;

/// Why a record was not kept. Whatever was to follow from it does not happen.
#[derive(Clone, Debug, Error)]
pub(crate) enum Trouble {
    /// It breaks a rule of the journal; the journal goes on.
    #[error("{0}")]
    Refused(Refusal),
    /// Too many records wait; the journal goes on.
    #[error("{0}")]
    Busy(String),
    /// The disk is full, and the journal keeps what ends or tells in its reserve: this would begin something. It goes
    /// on by itself when there is room.
    #[error("{0}")]
    NoRoom(String),
    /// The disk is full, and there is no reserve, or it is used up.
    #[error("{0}")]
    Full(String),
    /// Anything else that keeps it from being written.
    #[error("{0}")]
    Unavailable(String),
}

impl Trouble {
    pub(super) fn of(error: &AppendError) -> Self {
        match error {
            AppendError::Refused(refusal) => Self::Refused(refusal.clone()),
            AppendError::Busy { .. } => Self::Busy(error.to_string()),
            AppendError::NoRoom { .. } => Self::NoRoom(error.to_string()),
            _ if error.is_disk_full() => Self::Full(chain(error)),
            AppendError::Failed { .. } | AppendError::Poisoned(_) | AppendError::Closed { .. } => {
                Self::Unavailable(chain(error))
            }
        }
    }

    /// The problem of a command that was not sent for this reason.
    pub(crate) fn problem(&self) -> Problem {
        match self {
            Self::Refused(Refusal::KeyReused { .. }) => Problem::not_sent(
                ProblemCode::IdempotencyMismatch,
                "the key was used for another request",
            ),
            Self::Refused(Refusal::KeyInFlight { .. }) => Problem::not_sent(
                ProblemCode::IdempotencyInFlight,
                "the first request with this key has no answer yet",
            ),
            // Of the server's own making, unlike the two above.
            Self::Refused(refusal) => Problem::not_sent(
                ProblemCode::Internal,
                format!("the journal says: {refusal}"),
            ),
            Self::Busy(text) => {
                Problem::not_sent(ProblemCode::JournalUnavailable, text).retry_after_a_second()
            }
            Self::NoRoom(text) => Problem::not_sent(ProblemCode::JournalFull, text)
                .hint("Make room on the disk of the journal; then the server goes on by itself."),
            Self::Full(text) => Problem::not_sent(ProblemCode::JournalFull, text)
                .hint("Make room on the disk of the journal, then start the server again."),
            Self::Unavailable(text) => Problem::not_sent(ProblemCode::JournalUnavailable, text)
                .hint("Look at the disk of the journal, then start the server again."),
        }
    }
}

fn chain(error: &AppendError) -> String {
    let mut text = error.to_string();
    let mut cause = error.source();
    while let Some(source) = cause {
        // Writing to a string cannot fail.
        let _ = write!(text, ": {source}");
        cause = source.source();
    }
    text
}
