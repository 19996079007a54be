use std::io;
use std::time::Duration;

use api::{Outcome, ProblemCode, StopEffect};
use protocol::v2::{DecodeError, MotionNumber};
use thiserror::Error;

use super::readiness::NotReady;

/// What goes wrong between the server and a tier-2 controller.
#[derive(Debug, Error)]
pub(crate) enum LinkError {
    // Proven not executed.
    #[error("it waited for its turn until its deadline")]
    DeadlinePassed,
    #[error("the server is stopping")]
    Stopping,
    #[error("a stop was asked for before it was sent")]
    StoppedBeforeSent,
    /// Its nonce had run out when the controller read it: the network or the server was slow. Nothing was stored.
    #[error("it came too late after the controller's greeting, and the controller did not take it")]
    GreetingTooOld,
    #[error("it was taken back before its turn came")]
    TakenBack,
    #[error("it was numbered in epoch {order}, and the link is in epoch {}", shown(.current.as_ref()))]
    WrongEpoch { order: u32, current: Option<u32> },
    #[error("{0}")]
    NotReady(NotReady),
    #[error("connecting to the controller at {address}")]
    Connect {
        address: String,
        #[source]
        source: io::Error,
    },
    #[error("the controller at {address} did not take the connection within {} ms", after.as_millis())]
    ConnectTimeout { address: String, after: Duration },
    #[error("the controller at {address} sent no greeting within {} ms", after.as_millis())]
    NoGreeting { address: String, after: Duration },
    #[error("reading the greeting of the controller at {address}")]
    ReadGreeting {
        address: String,
        #[source]
        source: ReadError,
    },
    #[error("the controller was started again since its last status: boot {was}, now {is}")]
    RestartedBefore { was: u32, is: u32 },
    #[error("the controller has already accepted {accepted}, not below {number}")]
    NumberUsed {
        number: MotionNumber,
        accepted: MotionNumber,
    },
    #[error("what was sent before could not be shown to have been read")]
    SeedFence(#[source] ReadError),
    #[error("writing the command failed before its first byte")]
    WriteNothing(#[source] io::Error),
    #[error("the controller did not take it: behind a fence its last command is {accepted}")]
    NotTaken { accepted: MotionNumber },

    // A verb on the status port.
    #[error("the controller's status port at {address} is not connected")]
    StatusDown { address: String },
    #[error("the controller did not confirm `{verb}` within {} ms", after.as_millis())]
    Unconfirmed { verb: &'static str, after: Duration },
    #[error("the controller did not understand `{verb}`")]
    NotUnderstood { verb: &'static str },
    #[error("too many requests wait for the controller's status port")]
    Busy,
    #[error("all {limit} link generations of this start are used up")]
    GenerationsUsedUp { limit: u32 },
    #[error("the stop is not confirmed; {}", effect_text(*.effect))]
    StopUnconfirmed {
        effect: StopEffect,
        #[source]
        source: Box<LinkError>,
    },

    // In doubt.
    #[error("the controller was lost, and not back within {} ms", after.as_millis())]
    Lost { after: Duration },
    #[error(
        "the controller was started again while the motion was in flight: boot {was}, now {is}"
    )]
    Restarted { was: u32, is: u32 },
    #[error(
        "the controller had accepted {number}, and now says that its last command is {accepted}"
    )]
    Forgotten {
        number: MotionNumber,
        accepted: MotionNumber,
    },
    #[error("the motion was accepted, and the arm stands still without its having finished")]
    Unfinished,
    #[error("the controller said that it moves, and the arm has not begun to")]
    NotBegun,
    #[error(
        "no answer tells whether the controller took the motion; {}, the arm stands {}",
        fence_text(*.fenced),
        place_text(*.at_start)
    )]
    Unanswered {
        /// Whether the controller has since read everything that was sent before.
        fenced: bool,
        /// Whether the arm stands where it stood when the motion was sent; absent where that is not known.
        at_start: Option<bool>,
    },
    #[error(
        "the controller says arrived, {apart_mm:.3} mm and {apart_deg:.3} degrees from the target"
    )]
    PoseMismatch { apart_mm: f64, apart_deg: f64 },
    #[error("the controller says done, and output {output} has not the level it was set to")]
    OutputMismatch { output: u8 },
    #[error("the controller accepted {accepted} after {number}")]
    Overtaken {
        number: MotionNumber,
        accepted: MotionNumber,
    },
    #[error("the controller had accepted {number} before it was sent")]
    Duplicate { number: MotionNumber },
}

/// Why bytes from the controller are not a line of its protocol.
#[derive(Debug, Error)]
pub(crate) enum ReadError {
    #[error("the connection broke")]
    Io(#[source] io::Error),
    #[error("the controller closed the connection")]
    Closed,
    #[error("a line is too long")]
    TooLong,
    #[error("the reply \"{text}\" is none of the protocol's")]
    UnknownReply { text: String },
    #[error("the line \"{text}\" is not understood")]
    Line {
        text: String,
        #[source]
        source: DecodeError,
    },
}

fn shown(epoch: Option<&u32>) -> String {
    epoch.map_or_else(|| "none yet".to_owned(), u32::to_string)
}

fn fence_text(fenced: bool) -> &'static str {
    if fenced {
        "it has read all that was sent, and"
    } else {
        "it may still have it to read, and"
    }
}

fn place_text(at_start: Option<bool>) -> &'static str {
    match at_start {
        Some(true) => "where it stood before",
        Some(false) => "neither where it stood before nor at the target",
        None => "elsewhere than at the target",
    }
}

fn effect_text(effect: StopEffect) -> &'static str {
    match effect {
        StopEffect::IssuesNothingMore => {
            "nothing more is sent, and a motion the controller has taken may run on"
        }
        StopEffect::HaltsMotion => "it was sent",
    }
}

impl LinkError {
    /// The labels of [`Self::metric_label`].
    pub(crate) const METRIC_LABELS: [&'static str; 8] = [
        "deadline_passed",
        "not_connected",
        "not_written",
        "stopping",
        "stopped",
        "not_ready",
        "not_taken",
        "in_doubt",
    ];

    pub(crate) fn metric_label(&self) -> &'static str {
        match self {
            Self::DeadlinePassed => "deadline_passed",
            Self::GreetingTooOld => "greeting_too_old",
            Self::Connect { .. }
            | Self::ConnectTimeout { .. }
            | Self::NoGreeting { .. }
            | Self::ReadGreeting { .. }
            | Self::StatusDown { .. } => "not_connected",
            Self::WriteNothing(_) | Self::SeedFence(_) => "not_written",
            Self::Stopping => "stopping",
            Self::StoppedBeforeSent | Self::TakenBack => "stopped",
            Self::WrongEpoch { .. }
            | Self::NotReady(_)
            | Self::RestartedBefore { .. }
            | Self::NumberUsed { .. }
            | Self::GenerationsUsedUp { .. } => "not_ready",
            Self::NotTaken { .. } => "not_taken",
            Self::Unconfirmed { .. }
            | Self::NotUnderstood { .. }
            | Self::Busy
            | Self::StopUnconfirmed { .. }
            | Self::Lost { .. }
            | Self::Restarted { .. }
            | Self::Forgotten { .. }
            | Self::Unfinished
            | Self::NotBegun
            | Self::Unanswered { .. }
            | Self::PoseMismatch { .. }
            | Self::OutputMismatch { .. }
            | Self::Overtaken { .. }
            | Self::Duplicate { .. } => "in_doubt",
        }
    }

    /// What is known of the effect on the robot, where this is the end of an order.
    pub(crate) fn outcome(&self) -> Outcome {
        match self {
            Self::DeadlinePassed
            | Self::GreetingTooOld
            | Self::Stopping
            | Self::StoppedBeforeSent
            | Self::TakenBack
            | Self::WrongEpoch { .. }
            | Self::NotReady(_)
            | Self::Connect { .. }
            | Self::ConnectTimeout { .. }
            | Self::NoGreeting { .. }
            | Self::ReadGreeting { .. }
            | Self::RestartedBefore { .. }
            | Self::NumberUsed { .. }
            | Self::WriteNothing(_)
            | Self::SeedFence(_)
            | Self::NotTaken { .. }
            | Self::StatusDown { .. }
            | Self::Busy
            | Self::GenerationsUsedUp { .. } => Outcome::NotSent,
            Self::NotUnderstood { .. } => Outcome::Rejected,
            Self::StopUnconfirmed { source, .. } => source.outcome(),
            Self::Unconfirmed { .. }
            | Self::Lost { .. }
            | Self::Restarted { .. }
            | Self::Forgotten { .. }
            | Self::Unfinished
            | Self::NotBegun
            | Self::Unanswered { .. }
            | Self::PoseMismatch { .. }
            | Self::OutputMismatch { .. }
            | Self::Overtaken { .. }
            | Self::Duplicate { .. } => Outcome::Unknown,
        }
    }

    pub(crate) fn code(&self) -> ProblemCode {
        match self {
            Self::DeadlinePassed | Self::GreetingTooOld => ProblemCode::DeadlinePassed,
            Self::Stopping => ProblemCode::ShuttingDown,
            Self::StoppedBeforeSent => ProblemCode::StoppedBeforeSent,
            Self::TakenBack => ProblemCode::MotionCanceled,
            Self::WrongEpoch { .. } | Self::NumberUsed { .. } => ProblemCode::StaleEpoch,
            Self::NotReady(NotReady::Disconnected)
            | Self::Connect { .. }
            | Self::ConnectTimeout { .. }
            | Self::NoGreeting { .. }
            | Self::WriteNothing(_)
            | Self::StatusDown { .. } => ProblemCode::ControllerDisconnected,
            Self::NotReady(_) | Self::GenerationsUsedUp { .. } => ProblemCode::ControllerNotReady,
            Self::ReadGreeting { .. } | Self::SeedFence(_) | Self::NotUnderstood { .. } => {
                ProblemCode::ControllerProtocol
            }
            Self::Busy => ProblemCode::ControllerBusy,
            Self::NotTaken { .. } => ProblemCode::ControllerRejected,
            Self::RestartedBefore { .. } | Self::Restarted { .. } | Self::Forgotten { .. } => {
                ProblemCode::ControllerRestarted
            }
            Self::Unconfirmed { .. } | Self::Lost { .. } | Self::Unanswered { .. } => {
                ProblemCode::ControllerTimeout
            }
            Self::StopUnconfirmed { .. } => ProblemCode::StopUnconfirmed,
            Self::Unfinished | Self::NotBegun => ProblemCode::MotionUnfinished,
            Self::PoseMismatch { .. } | Self::OutputMismatch { .. } => ProblemCode::PoseMismatch,
            Self::Overtaken { .. } | Self::Duplicate { .. } => ProblemCode::MotionOvertaken,
        }
    }

    /// What a stop that failed with this does all the same.
    pub(crate) fn stop_effect(&self) -> Option<StopEffect> {
        if let Self::StopUnconfirmed { effect, .. } = self {
            Some(*effect)
        } else {
            None
        }
    }

    /// The step that failed and its causes, in one line.
    pub(crate) fn chain(&self) -> String {
        chain(self)
    }
}

/// An error and its causes, in one line.
pub(super) fn chain(error: &dyn std::error::Error) -> String {
    let mut text = error.to_string();
    let mut cause = error.source();
    while let Some(error) = cause {
        text.push_str(": ");
        text.push_str(&error.to_string());
        cause = error.source();
    }
    text
}
