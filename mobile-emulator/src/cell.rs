//! The cell, as the robot reaches it.

use std::time::Duration;

use api::{OutboxMessage, OutboxQuery, SignalBody};
use client::{Client, ClientError, MobileRobotClient, SignalGap, Timeouts};

use crate::outbound::SendOutcome;

/// How long a robot waits for an answer before it counts the cell as away.
const TIMEOUTS: Timeouts = Timeouts {
    connect: Duration::from_secs(2),
    question: Duration::from_secs(5),
    command: Duration::from_secs(5),
};

/// Where a robot's cell is. Cheap to clone.
#[derive(Clone, Debug)]
pub struct CellAddress {
    client: Client,
    cell: String,
}

impl CellAddress {
    /// The cell `cell` of the server at `base_url`, e.g. `http://127.0.0.1:8080`.
    ///
    /// # Errors
    /// [`ClientError::BaseUrl`] if the address is not an `http://` one.
    pub fn new(base_url: &str, cell: &str) -> Result<Self, ClientError> {
        let client = Client::with_timeouts(base_url, TIMEOUTS)?;
        Ok(Self::through(client, cell))
    }

    /// The cell `cell`, through a client that may carry more than an address.
    #[must_use]
    pub fn through(client: Client, cell: &str) -> Self {
        Self {
            client,
            cell: cell.to_owned(),
        }
    }

    pub(crate) fn robot(&self, id: &str) -> MobileRobotClient {
        self.client.mobile_robot(&self.cell, id)
    }
}

/// Posts a signal once.
pub(crate) async fn post(robot: &MobileRobotClient, signal: &SignalBody) -> SendOutcome {
    match robot.post_signal(signal).await {
        Ok(answer) => {
            let (status, word) = match (answer.parked, answer.duplicate) {
                (true, _) => (202, "parked"),
                (false, true) => (200, "duplicate"),
                (false, false) => (200, "accepted"),
            };
            let note = answer.note.map(|note| format!(" ({note})"));
            SendOutcome::Answered {
                status,
                answer: format!("{word}{}", note.unwrap_or_default()),
            }
        }
        Err(error) => refused(&error),
    }
}

/// Asks for messages once.
pub(crate) async fn poll(
    robot: &MobileRobotClient,
    query: OutboxQuery,
) -> Result<Vec<OutboxMessage>, String> {
    match robot.outbox(query).await {
        Ok(outbox) => Ok(outbox.messages),
        Err(error) => Err(sentence(&error)),
    }
}

/// Whether an error is the cell's answer to the signal, or a reason to send it again.
fn refused(error: &ClientError) -> SendOutcome {
    if let Some(SignalGap { expected }) = SignalGap::of(error) {
        return SendOutcome::Gap { expected };
    }
    let reason = sentence(error);
    let answer = match error {
        ClientError::Problem(problem) => problem.code.as_str().to_owned(),
        ClientError::Refused { detail, .. } => detail.clone(),
        // An answer that is none of the API's tells nothing.
        ClientError::Invalid { .. }
        | ClientError::BaseUrl { .. }
        | ClientError::RequestId { .. }
        | ClientError::Token
        | ClientError::Unreachable { .. }
        | ClientError::Timeout { .. }
        | ClientError::Interrupted { .. }
        | ClientError::Protocol { .. } => return SendOutcome::Unanswered { reason },
    };
    match error.status() {
        // It says no to this signal, and would say so again.
        Some(status @ (400 | 405 | 409 | 410 | 413 | 415 | 422)) => {
            SendOutcome::Answered { status, answer }
        }
        // It is not ready for any: starting, too busy, not allowed yet.
        Some(_) | None => SendOutcome::Unanswered { reason },
    }
}

fn sentence(error: &ClientError) -> String {
    let mut text = error.to_string();
    let mut cause = std::error::Error::source(error);
    while let Some(next) = cause {
        text = format!("{text}: {next}");
        cause = next.source();
    }
    text.chars().take(400).collect()
}
