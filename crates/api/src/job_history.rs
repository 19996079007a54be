//! What became of a job: its events, and the report made of them.

use jiff::Timestamp;
use serde::{Deserialize, Serialize};
use utoipa::ToSchema;
use uuid::Uuid;

use crate::{FaultName, JobState, WorkflowName};

/// A page of what happened to a job, the oldest first.
#[derive(Clone, Debug, Deserialize, PartialEq, Serialize, ToSchema)]
pub struct JobEventList {
    /// They.
    pub events: Vec<JobEvent>,
    /// Where the next page begins, where there is one.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub next_cursor: Option<String>,
}

/// Something that happened to a job, as the journal has it.
#[derive(Clone, Debug, Deserialize, PartialEq, Serialize, ToSchema)]
pub struct JobEvent {
    /// Its name within the cell: the place of its record in the journal, and its own in the record. What happened
    /// together has the same first number.
    pub id: String,
    /// When, by the wall clock.
    pub at: Timestamp,
    /// Milliseconds since the job was created.
    pub since_ms: u64,
    /// What kind, e.g. `step_moved`. The list grows.
    pub kind: String,
    /// In a sentence.
    pub text: String,
    /// The step it belongs to.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub step: Option<usize>,
    /// That step's row in the workflow's table.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub code: Option<String>,
    /// The person behind it.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub principal: Option<String>,
}

/// What a job took and what went wrong, from the journal's clocks.
///
/// Within one run of the server the monotonic clock counts; over a restart the wall clock, with the time the server
/// was away.
#[derive(Clone, Debug, Deserialize, PartialEq, Serialize, ToSchema)]
pub struct JobReport {
    /// The job.
    pub job: Uuid,
    /// The cell.
    pub cell: String,
    /// Which workflow.
    pub workflow: WorkflowName,
    /// Its state now.
    pub state: JobState,
    /// When it was created.
    pub created_at: Timestamp,
    /// 1, and one more for each reset. The figures below are of the last run.
    pub run: u32,
    /// When the run began: the creation, or the reset.
    pub begun_at: Timestamp,
    /// When it came to its end.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub ended_at: Option<Timestamp>,
    /// From the beginning of the run to its end, or until now, in milliseconds.
    pub total_ms: u64,
    /// Of these, in the queue.
    pub queued_ms: u64,
    /// The rest: the cycle time.
    pub cycle_ms: u64,
    /// How long it was in each state, in the order of first entering.
    pub states: Vec<StateTime>,
    /// Each step that began, in the order of beginning.
    pub phases: Vec<PhaseReport>,
    /// What went wrong.
    pub faults: Vec<FaultReport>,
    /// What people commanded and answered.
    pub decisions: Vec<DecisionReport>,
    /// How often the server was started again meanwhile.
    pub restarts: u32,
}

/// How long a job was in a state.
#[derive(Clone, Debug, Deserialize, PartialEq, Serialize, ToSchema)]
pub struct StateTime {
    /// Which.
    pub state: JobState,
    /// How long in all, in milliseconds.
    pub duration_ms: u64,
}

/// What kind of work a phase is: for colors and sums.
#[derive(Clone, Copy, Debug, Deserialize, Eq, PartialEq, Serialize, ToSchema)]
#[serde(rename_all = "kebab-case")]
pub enum PhaseKind {
    /// Claims and plans.
    Prepare,
    /// Waiting for a mobile robot.
    MobileRobot,
    /// Permits and checks between the two.
    HandOver,
    /// The arm or its gripper works.
    Arm,
    /// The end.
    Close,
    /// Undoing.
    Undo,
}

/// What a step of a job took.
#[derive(Clone, Debug, Deserialize, PartialEq, Serialize, ToSchema)]
pub struct PhaseReport {
    /// The step's number.
    pub step: usize,
    /// Its row in the workflow's table.
    pub code: String,
    /// What it does.
    pub phase: String,
    /// What kind of work it is.
    pub kind: PhaseKind,
    /// The index of its item.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub item: Option<usize>,
    /// Where.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub place: Option<String>,
    /// Milliseconds from the beginning of the run to its own.
    pub begin_ms: u64,
    /// How long all its attempts took, in milliseconds.
    pub duration_ms: u64,
    /// How it ended; absent while it runs.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub end: Option<String>,
    /// Each attempt.
    pub attempts: Vec<AttemptReport>,
}

/// One attempt at a step.
#[derive(Clone, Debug, Deserialize, PartialEq, Serialize, ToSchema)]
pub struct AttemptReport {
    /// Milliseconds from the beginning of the run.
    pub begin_ms: u64,
    /// How long it took; until now where it runs.
    pub duration_ms: u64,
    /// How it ended; absent while it runs.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub end: Option<String>,
    /// More about the end.
    #[serde(default, skip_serializing_if = "String::is_empty")]
    pub text: String,
}

/// Something that went wrong.
#[derive(Clone, Debug, Deserialize, PartialEq, Serialize, ToSchema)]
pub struct FaultReport {
    /// Milliseconds from the beginning of the run.
    pub at_ms: u64,
    /// Which.
    #[serde(flatten)]
    pub fault: FaultName,
    /// What was seen.
    pub text: String,
}

/// What a person decided.
#[derive(Clone, Debug, Deserialize, PartialEq, Serialize, ToSchema)]
pub struct DecisionReport {
    /// Milliseconds from the beginning of the run.
    pub at_ms: u64,
    /// Who.
    pub principal: String,
    /// What: a command's state, or an answer.
    pub decision: String,
    /// The question that was answered.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub intervention: Option<Uuid>,
    /// How long the question was open, in milliseconds.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub open_ms: Option<u64>,
    /// Why.
    pub reason: String,
}
