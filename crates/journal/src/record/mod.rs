//! What a journal says. Changed only by adding.
//!
//! # Evolution
//! A journal outlives the program that wrote it, and its bytes are hashed. So, within version 1:
//! - a kind, a field, or a choice is never renamed, removed, or given another meaning or unit;
//! - a new field is optional (`#[serde(default, skip_serializing_if = ..)]`), so that old records are read;
//! - a new kind or choice may be added; an older program then says which record it cannot read, and does not guess;
//! - a field the reader does not know is left out of what it shows, and stays in the bytes, so the chain holds;
//! - no floating point: lengths are micrometers, angles millidegrees, so that the bytes have one spelling.
//!
//! `testdata/v1` freezes one example of each kind. Anything else needs a new number in the envelope's `v`.

mod motion;
mod upkeep;
mod work;

use serde::{Deserialize, Serialize};

pub use motion::{
    Accepted, Arrival, Asked, Completion, End, Hold, Intent, Mode, NoMotion, Observation, Outcome,
    OutputLevel, Repeatability, Standstill, Target,
};
pub use upkeep::{Pruned, SnapshotTaken};
pub use work::{
    Answer, Audit, AuditResult, CellDecided, Decision, JobCreated, JobEnd, JobEnded, JobStep,
    ServerStarted, SignalReceived, StepState, Subject,
};

use crate::{Claim, JobId, MotionId};

/// One entry, by its kind.
#[derive(Clone, Debug, Eq, PartialEq, Serialize, Deserialize)]
#[serde(tag = "kind", rename_all = "snake_case")]
pub enum Record {
    /// The journal was opened for writing. Written by the journal itself.
    ServerStarted(ServerStarted),
    /// A motion is about to be sent.
    Intent(Box<Intent>),
    /// The controller took a motion.
    Accepted(Accepted),
    /// What became of a motion.
    Outcome(Outcome),
    /// A job is to be done.
    JobCreated(JobCreated),
    /// A step of a job changed its state.
    JobStep(JobStep),
    /// A job came to its end.
    JobEnded(JobEnded),
    /// A mobile robot said something.
    SignalReceived(SignalReceived),
    /// A person decided about something in doubt.
    Decision(Decision),
    /// Someone did, or tried to do, something else worth keeping.
    Audit(Audit),
    /// The state machines of a cell decided something.
    CellDecided(CellDecided),
    /// What the decisions of a cell amount to was kept. Written by the journal itself.
    SnapshotTaken(SnapshotTaken),
    /// The oldest records were removed. Written by the journal itself.
    Pruned(Pruned),
}

impl Record {
    /// The name of the kind, as in the JSON.
    #[must_use]
    pub fn kind(&self) -> &'static str {
        match self {
            Self::ServerStarted(_) => "server_started",
            Self::Intent(_) => "intent",
            Self::Accepted(_) => "accepted",
            Self::Outcome(_) => "outcome",
            Self::JobCreated(_) => "job_created",
            Self::JobStep(_) => "job_step",
            Self::JobEnded(_) => "job_ended",
            Self::SignalReceived(_) => "signal_received",
            Self::Decision(_) => "decision",
            Self::Audit(_) => "audit",
            Self::CellDecided(_) => "cell_decided",
            Self::SnapshotTaken(_) => "snapshot_taken",
            Self::Pruned(_) => "pruned",
        }
    }

    /// The motion the record is part of the story of. A step of a job only refers to its motion.
    #[must_use]
    pub fn motion(&self) -> Option<MotionId> {
        match self {
            Self::Intent(intent) => Some(intent.motion),
            Self::Accepted(accepted) => Some(accepted.motion),
            Self::Outcome(outcome) => Some(outcome.motion),
            Self::Decision(decision) => match decision.subject {
                Subject::Motion(motion) => Some(motion),
                Subject::Job(_) => None,
            },
            Self::ServerStarted(_)
            | Self::JobCreated(_)
            | Self::JobStep(_)
            | Self::JobEnded(_)
            | Self::SignalReceived(_)
            | Self::Audit(_)
            | Self::CellDecided(_)
            | Self::SnapshotTaken(_)
            | Self::Pruned(_) => None,
        }
    }

    /// The job the record is part of the story of.
    #[must_use]
    pub fn job(&self) -> Option<JobId> {
        match self {
            Self::JobCreated(created) => Some(created.job),
            Self::JobStep(step) => Some(step.job),
            Self::JobEnded(ended) => Some(ended.job),
            Self::Decision(decision) => match decision.subject {
                Subject::Job(job) => Some(job),
                Subject::Motion(_) => None,
            },
            Self::ServerStarted(_)
            | Self::Intent(_)
            | Self::Accepted(_)
            | Self::Outcome(_)
            | Self::SignalReceived(_)
            | Self::Audit(_)
            | Self::CellDecided(_)
            | Self::SnapshotTaken(_)
            | Self::Pruned(_) => None,
        }
    }

    /// The cell whose decisions the record is one of.
    #[must_use]
    pub fn decided_cell(&self) -> Option<&str> {
        match self {
            Self::CellDecided(decided) => Some(&decided.cell),
            Self::ServerStarted(_)
            | Self::Intent(_)
            | Self::Accepted(_)
            | Self::Outcome(_)
            | Self::JobCreated(_)
            | Self::JobStep(_)
            | Self::JobEnded(_)
            | Self::SignalReceived(_)
            | Self::Decision(_)
            | Self::Audit(_)
            | Self::SnapshotTaken(_)
            | Self::Pruned(_) => None,
        }
    }

    /// Whether something begins with it. On a full disk only what ends or tells is still kept.
    #[must_use]
    pub fn begins_work(&self) -> bool {
        match self {
            Self::Intent(_) | Self::JobCreated(_) => true,
            // A decision of a cell is one record whether it begins a job or ends one; whoever decides knows which.
            Self::CellDecided(_)
            | Self::ServerStarted(_)
            | Self::Accepted(_)
            | Self::Outcome(_)
            | Self::JobStep(_)
            | Self::JobEnded(_)
            | Self::SignalReceived(_)
            | Self::Decision(_)
            | Self::Audit(_)
            | Self::SnapshotTaken(_)
            | Self::Pruned(_) => false,
        }
    }

    /// Whether only the journal itself writes it.
    #[must_use]
    pub fn is_reserved(&self) -> bool {
        matches!(
            self,
            Self::ServerStarted(_) | Self::SnapshotTaken(_) | Self::Pruned(_)
        )
    }

    /// The key the record takes, where it takes one.
    #[must_use]
    pub fn claim(&self) -> Option<&Claim> {
        match self {
            Self::Intent(intent) => intent.claim.as_ref(),
            Self::JobCreated(created) => created.claim.as_ref(),
            Self::CellDecided(decided) => decided.claim.as_ref(),
            Self::ServerStarted(_)
            | Self::Accepted(_)
            | Self::Outcome(_)
            | Self::JobStep(_)
            | Self::JobEnded(_)
            | Self::SignalReceived(_)
            | Self::Decision(_)
            | Self::Audit(_)
            | Self::SnapshotTaken(_)
            | Self::Pruned(_) => None,
        }
    }
}
