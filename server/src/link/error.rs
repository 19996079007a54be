use std::io;
use std::time::Duration;

use api::{Outcome, ProblemCode};
use thiserror::Error;

use crate::motions::End;

/// Why a command got no answer that tells.
///
/// The variants fall in two groups that must never be confused: those that prove that nothing was sent, and those
/// after which the arm may be moving.
#[derive(Debug, Error)]
pub(crate) enum LinkError {
    #[error("it waited for its turn until its deadline")]
    DeadlinePassed,
    #[error("it was taken back before its turn came")]
    TakenBack,
    #[error("connecting to the controller at {address}")]
    Connect {
        address: String,
        #[source]
        source: io::Error,
    },
    #[error("the controller at {address} did not take the connection within {} ms", after.as_millis())]
    ConnectTimeout { address: String, after: Duration },
    #[error("writing the command failed before its first byte")]
    WriteNothing(#[source] io::Error),
    #[error("no more commands are sent")]
    Stopping,

    #[error("writing the command failed after {written} of {len} bytes")]
    WritePart {
        written: usize,
        len: usize,
        #[source]
        source: io::Error,
    },
    #[error("reading the reply")]
    Read(#[source] io::Error),
    #[error("the controller closed the connection after {received} bytes of a reply")]
    ClosedEarly { received: usize },
    #[error("no whole reply within {} ms of the command ({received} bytes came)", after.as_millis())]
    NoReply { after: Duration, received: usize },
    #[error("the reply \"{text}\" is none of the protocol's")]
    UnknownReply { text: String },
}

impl LinkError {
    /// The labels of [`Self::metric_label`].
    pub(crate) const METRIC_LABELS: [&'static str; 9] = [
        "deadline_passed",
        "taken_back",
        "not_connected",
        "not_written",
        "stopping",
        "written_in_part",
        "closed_early",
        "no_reply",
        "unknown_reply",
    ];

    pub(crate) fn metric_label(&self) -> &'static str {
        match self {
            Self::DeadlinePassed => "deadline_passed",
            Self::TakenBack => "taken_back",
            Self::Connect { .. } | Self::ConnectTimeout { .. } => "not_connected",
            Self::WriteNothing(_) => "not_written",
            Self::Stopping => "stopping",
            Self::WritePart { .. } => "written_in_part",
            Self::Read(_) | Self::ClosedEarly { .. } => "closed_early",
            Self::NoReply { .. } => "no_reply",
            Self::UnknownReply { .. } => "unknown_reply",
        }
    }

    pub(crate) fn outcome(&self) -> Outcome {
        match self {
            Self::DeadlinePassed
            | Self::TakenBack
            | Self::Connect { .. }
            | Self::ConnectTimeout { .. }
            | Self::WriteNothing(_)
            | Self::Stopping => Outcome::NotSent,
            Self::WritePart { .. }
            | Self::Read(_)
            | Self::ClosedEarly { .. }
            | Self::NoReply { .. }
            | Self::UnknownReply { .. } => Outcome::Unknown,
        }
    }

    pub(crate) fn code(&self) -> ProblemCode {
        match self {
            Self::DeadlinePassed => ProblemCode::DeadlinePassed,
            Self::TakenBack => ProblemCode::MotionCanceled,
            Self::Connect { .. } | Self::ConnectTimeout { .. } | Self::WriteNothing(_) => {
                ProblemCode::ControllerDisconnected
            }
            Self::Stopping => ProblemCode::ShuttingDown,
            Self::WritePart { .. }
            | Self::Read(_)
            | Self::ClosedEarly { .. }
            | Self::NoReply { .. } => ProblemCode::ControllerTimeout,
            Self::UnknownReply { .. } => ProblemCode::ControllerProtocol,
        }
    }

    /// The controller's words, where it said anything.
    pub(crate) fn controller_text(&self) -> Option<&str> {
        match self {
            Self::UnknownReply { text } => Some(text),
            Self::DeadlinePassed
            | Self::TakenBack
            | Self::Connect { .. }
            | Self::ConnectTimeout { .. }
            | Self::WriteNothing(_)
            | Self::Stopping
            | Self::WritePart { .. }
            | Self::Read(_)
            | Self::ClosedEarly { .. }
            | Self::NoReply { .. } => None,
        }
    }

    /// What the motion's record says.
    pub(crate) fn end(&self) -> End {
        match self.outcome() {
            Outcome::NotSent | Outcome::None => End::NotExecuted {
                code: self.code(),
                why: Some(self.chain().into()),
            },
            Outcome::Rejected | Outcome::Unknown => End::InDoubt {
                code: self.code(),
                text: self.controller_text().map(str::to_owned),
                why: Some(self.chain().into()),
                seen: None,
            },
        }
    }

    /// The step that failed and its causes, in one line.
    pub(crate) fn chain(&self) -> String {
        use std::error::Error as _;
        use std::fmt::Write as _;
        let mut text = self.to_string();
        let mut cause = self.source();
        while let Some(error) = cause {
            // Writing to a string cannot fail.
            let _ = write!(text, ": {error}");
            cause = error.source();
        }
        text
    }
}
