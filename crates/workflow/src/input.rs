//! What can happen to a cell, and why it may say no.

use serde::{Deserialize, Serialize};
use uuid::Uuid;

use crate::custody::Location;
use crate::fact::Fact;
use crate::ids::Millis;
use crate::intervention::{Answer, Detail};
use crate::job::params::NewJob;
use crate::setup::Setup;
use crate::signal::{InstantAction, Signal, SignalAnswer};

/// Safety state of an arm, as reported.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "SCREAMING_SNAKE_CASE")]
#[expect(missing_docs, reason = "the words of SM-2")]
pub enum Safety {
    #[default]
    Normal,
    Reduced,
    ProtectiveStop,
    EmergencyStop,
    Fault,
    Unknown,
}

/// What was seen of an arm. Send one whenever something changes and at least every half of
/// [`crate::Timers::arm_silence_ms`].
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
#[expect(
    clippy::struct_excessive_bools,
    reason = "each is one thing that is seen"
)]
pub struct ArmSeen {
    /// Which arm.
    pub arm: String,
    /// The controller answers.
    pub link: bool,
    /// It takes motions: AUTO, pendant off, no alarm, not held, control is ours.
    pub ready: bool,
    /// Nothing moves.
    pub still: bool,
    /// A human has it: the pendant is enabled, or the mode is not AUTO.
    #[serde(default)]
    pub manual: bool,
    /// It stands elsewhere than where the last motion of a job left it: somebody else moved it (C10).
    #[serde(default)]
    pub displaced: bool,
    /// Safety state.
    pub safety: Safety,
    /// Zones its tool center point is in.
    pub zones: Vec<String>,
    /// The part sensor.
    pub part_present: Option<bool>,
}

/// A role that a principal has.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
#[expect(missing_docs, reason = "the four roles")]
pub enum Role {
    Viewer,
    Operator,
    Integrator,
    Admin,
}

/// A human, or a program on behalf of one.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
pub struct Principal {
    /// Name.
    pub name: String,
    /// Highest role.
    pub role: Role,
}

/// How an operation ended.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
#[serde(tag = "result", rename_all = "snake_case")]
pub enum OpResult {
    /// Observed at the target and still.
    Arrived,
    /// The gripper's inputs after the level was set and had time to act.
    Gripped {
        /// Fully closed or closed on a part.
        closed: bool,
        /// Fully open.
        open: bool,
        /// The part sensor.
        part_present: bool,
    },
    /// Every pose was planned; empty: all of them can be reached.
    Prechecked {
        /// What cannot.
        failures: Vec<PoseFailure>,
    },
    /// Proven that nothing happened: it may be done again.
    NotExecuted {
        /// The proof, in words.
        text: String,
    },
    /// The controller refused it, or raised an alarm.
    Rejected {
        /// Its words.
        text: String,
    },
    /// It began and ended somewhere else, and the arm stands still at a known pose.
    Interrupted {
        /// What stopped it.
        text: String,
    },
    /// Nobody knows yet.
    InDoubt {
        /// Why.
        text: String,
    },
}

/// A pose that cannot be planned.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
pub struct PoseFailure {
    /// Index into the targets of the precheck.
    pub target: usize,
    /// Joint and margin, or what is in the way.
    pub reason: String,
}

/// What an operator may do with a job.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
#[expect(missing_docs, reason = "the words of PackML and of the resource tree")]
pub enum Command {
    Hold,
    Unhold,
    Stop,
    Abort,
    RetryStep,
    SkipStep,
    CompleteManually,
    Compensate,
    Clear,
    Reset,
}

/// Everything that can happen.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(tag = "input", rename_all = "snake_case")]
pub enum Input {
    /// The first input after every start of the process, after the facts were replayed.
    Recover,
    /// A job is asked for.
    CreateJob {
        /// What.
        job: Box<NewJob>,
    },
    /// A human commands a job.
    JobCommand {
        /// Which.
        job: Uuid,
        /// What.
        command: Command,
        /// Who.
        principal: Principal,
        /// Why.
        reason: String,
    },
    /// A mobile robot said something.
    Signal(Box<Signal>),
    /// A human has something done by a mobile robot.
    InstantAction {
        /// By whom.
        mobile_robot: String,
        /// What.
        action: InstantAction,
        /// Who.
        principal: Principal,
        /// Why.
        reason: Option<String>,
    },
    /// A mobile robot fetched its messages up to this number.
    OutboxTaken {
        /// Who.
        mobile_robot: String,
        /// Up to and including.
        n: u64,
    },
    /// How long an operation is planned to take.
    OperationPlanned {
        /// Which.
        op: Uuid,
        /// The plan's duration.
        expected_ms: Millis,
    },
    /// An operation ended, or was reconciled.
    OperationEnded {
        /// Which.
        op: Uuid,
        /// How.
        result: OpResult,
    },
    /// An arm was looked at.
    ArmObserved(ArmSeen),
    /// A human answers a question.
    Respond {
        /// Which.
        intervention: Uuid,
        /// The answer.
        answer: Answer,
        /// What it needs besides.
        detail: Detail,
        /// Who.
        principal: Principal,
        /// Why.
        reason: String,
    },
    /// A human says where a load is.
    SetCustody {
        /// Which load.
        load: String,
        /// Where it is.
        location: Location,
        /// The load's id a second time.
        confirm: String,
        /// Who.
        principal: Principal,
        /// Why.
        reason: String,
    },
    /// Whether jobs have control of the cell (F22).
    Control {
        /// They have.
        jobs_may_act: bool,
    },
    /// Whether the journal can be written (F24).
    Journal {
        /// It can.
        writable: bool,
    },
    /// The configuration changed.
    SetupChanged(Box<Setup>),
    /// Time passed.
    Tick,
}

/// What an input led to. All facts are one record of the journal.
#[derive(Debug, Clone, PartialEq)]
pub struct Decision {
    /// In this order. Those that are not [`Fact::is_durable`] are applied, but not kept.
    pub facts: Vec<Fact>,
    /// What the caller is told.
    pub reply: Reply,
}

/// What the caller is told.
#[derive(Debug, Clone, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Reply {
    /// It was done.
    Done,
    /// It had been done before, or had no effect.
    Unchanged,
    /// A new job.
    Created(Uuid),
    /// The answer to a signal.
    Signal(SignalAnswer),
}

/// Why an input was refused. Nothing changed.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
pub enum Refusal {
    /// [`Input::Recover`] has to come first.
    #[error("the cell has not been recovered yet")]
    NotRecovered,
    /// 503: the journal cannot be written; nothing new is begun.
    #[error("the journal cannot be written")]
    JournalUnavailable,
    /// 404.
    #[error("unknown {what} {id}")]
    Unknown {
        /// Kind of thing.
        what: &'static str,
        /// The id.
        id: String,
    },
    /// 422, naming the item.
    #[error("{item}: {problem}")]
    Invalid {
        /// The item, as a path.
        item: String,
        /// Value and limit.
        problem: String,
    },
    /// 409: not in this state.
    #[error("{command} is not possible: {text}")]
    Conflict {
        /// What was asked for.
        command: String,
        /// Why not.
        text: String,
    },
    /// 409: it would bring an arm and a mobile robot together.
    #[error("{command} is not safe: {text}")]
    Interlock {
        /// What was asked for.
        command: String,
        /// What is in the way.
        text: String,
    },
    /// 403.
    #[error("{command} needs the role {needed:?}")]
    Forbidden {
        /// What was asked for.
        command: String,
        /// Who may.
        needed: Role,
    },
}
