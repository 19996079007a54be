use std::error::Error;
use std::time::Duration;

use api::{LegacyValidationItem, Outcome, Problem};

/// Why a call brought no answer, or an answer that says no.
#[derive(Debug, thiserror::Error)]
pub enum ClientError {
    /// The server, or the controller behind it, refused or failed, in the form of RFC 9457.
    #[error("{}: {}", .0.title, .0.detail)]
    Problem(Box<Problem>),
    /// A refusal or failure in a sentence only: the thesis's own routes and the virtual controller's panel know no
    /// more, and of a problem whose code is newer than this client no more is understood.
    #[error("{detail}")]
    Refused {
        /// The HTTP status.
        status: u16,
        /// The sentence; on the thesis's routes it begins with `ERROR:`.
        detail: String,
        /// What is known of the command's effect.
        outcome: Outcome,
        /// The id of the request, as in the server's log.
        request_id: String,
    },
    /// The request to one of the thesis's own routes does not fit.
    #[error("the request does not fit: {}", sentences(.items))]
    Invalid {
        /// Each thing wrong.
        items: Vec<LegacyValidationItem>,
        /// The id of the request, as in the server's log.
        request_id: String,
    },
    /// The address given to [`crate::Client::new`] or [`crate::EmulatorClient::new`] is of no use.
    #[error("`{url}` is not the address of a server: {reason}")]
    BaseUrl {
        /// The address as given.
        url: String,
        /// What is wrong with it.
        reason: String,
    },
    /// The id given to [`crate::Client::with_request_id`] is none.
    #[error("`{id}` is no request id: 1 to 64 of A-Z, a-z, 0-9, `.`, `_` and `-`")]
    RequestId {
        /// The id as given.
        id: String,
    },
    /// The token given to [`crate::Client::with_token`] is none. It is not repeated here.
    #[error("this is no token of a server: it must look like `cell_<id>_<secret>`")]
    Token,
    /// No connection: nothing was sent.
    #[error("{url} cannot be reached")]
    Unreachable {
        /// The address of the request.
        url: String,
        /// The cause, as the transport tells it.
        #[source]
        source: Box<dyn Error + Send + Sync>,
    },
    /// No answer in time. A command may have been sent, and a motion may be under way.
    #[error("{url} did not answer within {} ms", after.as_millis())]
    Timeout {
        /// The address of the request.
        url: String,
        /// How long this client waited.
        after: Duration,
        /// [`Outcome::Unknown`] for a command, [`Outcome::None`] for a question.
        outcome: Outcome,
        /// The id of the request, as in the server's log.
        request_id: String,
    },
    /// The connection ended before the answer did. A command may have been sent, and a motion may be under way.
    #[error("the connection to {url} ended before the answer")]
    Interrupted {
        /// The address of the request.
        url: String,
        /// [`Outcome::Unknown`] for a command, [`Outcome::None`] for a question.
        outcome: Outcome,
        /// The id of the request, as in the server's log.
        request_id: String,
        /// The cause, as the transport tells it.
        #[source]
        source: Box<dyn Error + Send + Sync>,
    },
    /// An answer that is not one of this API's.
    #[error("{url} answered with status {status} and {reason}: {excerpt}")]
    Protocol {
        /// The address of the request.
        url: String,
        /// The HTTP status.
        status: u16,
        /// What is wrong with the answer.
        reason: String,
        /// The beginning of the body, at most 200 characters, control characters replaced.
        excerpt: String,
        /// [`Outcome::Unknown`] for a command, [`Outcome::None`] for a question.
        outcome: Outcome,
        /// The id of the request, as in the server's log.
        request_id: String,
    },
}

impl ClientError {
    /// What is known of the command's effect on the robot.
    ///
    /// [`Outcome::Unknown`] means that the robot may have moved, or may be moving: look at it before sending anything
    /// else.
    #[must_use]
    pub fn outcome(&self) -> Outcome {
        match self {
            Self::Problem(problem) => problem.outcome,
            Self::Refused { outcome, .. }
            | Self::Timeout { outcome, .. }
            | Self::Interrupted { outcome, .. }
            | Self::Protocol { outcome, .. } => *outcome,
            Self::Invalid { .. }
            | Self::BaseUrl { .. }
            | Self::RequestId { .. }
            | Self::Token
            | Self::Unreachable { .. } => Outcome::NotSent,
        }
    }

    /// The HTTP status, where there was an answer.
    #[must_use]
    pub fn status(&self) -> Option<u16> {
        match self {
            Self::Problem(problem) => Some(problem.status),
            Self::Refused { status, .. } | Self::Protocol { status, .. } => Some(*status),
            Self::Invalid { .. } => Some(422),
            Self::BaseUrl { .. }
            | Self::RequestId { .. }
            | Self::Token
            | Self::Unreachable { .. }
            | Self::Timeout { .. }
            | Self::Interrupted { .. } => None,
        }
    }

    /// The id of the request, as in the logs of server and emulator; absent where nothing was sent.
    #[must_use]
    pub fn request_id(&self) -> Option<&str> {
        match self {
            Self::Problem(problem) => problem.request_id.as_deref(),
            Self::Refused { request_id, .. }
            | Self::Invalid { request_id, .. }
            | Self::Timeout { request_id, .. }
            | Self::Interrupted { request_id, .. }
            | Self::Protocol { request_id, .. } => Some(request_id),
            Self::BaseUrl { .. }
            | Self::RequestId { .. }
            | Self::Token
            | Self::Unreachable { .. } => None,
        }
    }

    /// The problem as the server sent it, where it sent one.
    #[must_use]
    pub fn problem(&self) -> Option<&Problem> {
        match self {
            Self::Problem(problem) => Some(problem),
            Self::Refused { .. }
            | Self::Invalid { .. }
            | Self::BaseUrl { .. }
            | Self::RequestId { .. }
            | Self::Token
            | Self::Unreachable { .. }
            | Self::Timeout { .. }
            | Self::Interrupted { .. }
            | Self::Protocol { .. } => None,
        }
    }
}

fn sentences(items: &[LegacyValidationItem]) -> String {
    let each: Vec<String> = items
        .iter()
        .map(|item| format!("{}: {}", item.loc.join("."), item.msg))
        .collect();
    each.join("; ")
}
