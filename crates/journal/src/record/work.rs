//! Jobs, signals, decisions, and who did what.

use jiff::Timestamp;
use serde::{Deserialize, Serialize};

use crate::{Claim, DecisionId, Digest, Epoch, JobId, KeyRetention, MotionId, SignalId};

/// The journal was opened for writing.
#[derive(Clone, Debug, Eq, PartialEq, Serialize, Deserialize)]
pub struct ServerStarted {
    /// The epoch that begins.
    pub epoch: Epoch,
    /// The program and its version.
    pub program: String,
    /// How long keys are remembered from here on.
    pub keys: KeyRetention,
}

/// A job is to be done.
#[derive(Clone, Debug, Eq, PartialEq, Serialize, Deserialize)]
pub struct JobCreated {
    /// Its name.
    pub job: JobId,
    /// The cell.
    pub cell: String,
    /// The workflow.
    pub workflow: String,
    /// The workflow's version.
    pub version: u32,
    /// The digest of the plan; a job whose plan cannot be made again is held.
    pub plan: Digest,
    /// Its parameters, JSON as text.
    pub params: String,
    /// When it is no longer wanted.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub deadline: Option<Timestamp>,
    /// Who wants it.
    pub principal: String,
    /// The HTTP request behind it.
    pub request_id: String,
    /// The caller's key, where one was given.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub claim: Option<Claim>,
}

/// A step of a job changed its state.
#[derive(Clone, Debug, Eq, PartialEq, Serialize, Deserialize)]
pub struct JobStep {
    /// The job.
    pub job: JobId,
    /// The step's name in the workflow.
    pub step: String,
    /// 1 at the first attempt.
    pub attempt: u32,
    /// The new state.
    pub state: StepState,
    /// The motion behind it.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub motion: Option<MotionId>,
    /// More, for people.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub detail: Option<String>,
}

/// How far a step has come.
#[derive(Clone, Copy, Debug, Eq, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum StepState {
    /// It waits for what it needs.
    Claiming,
    /// It runs.
    Running,
    /// It is done.
    Succeeded,
    /// It may be tried again.
    Retriable,
    /// It failed.
    Failed,
    /// Its effect is being undone.
    Compensating,
    /// Its effect is undone.
    Compensated,
    /// What became of it is not known.
    InDoubt,
    /// A person left it out.
    Skipped,
}

/// A job came to its end.
#[derive(Clone, Debug, Eq, PartialEq, Serialize, Deserialize)]
pub struct JobEnded {
    /// The job.
    pub job: JobId,
    /// How.
    pub end: JobEnd,
    /// Why, for people.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub reason: Option<String>,
}

/// How a job ended.
#[derive(Clone, Copy, Debug, Eq, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum JobEnd {
    /// Everything was done.
    Complete,
    /// It was stopped in order.
    Stopped,
    /// It was broken off.
    Aborted,
}

/// A mobile robot said something.
#[derive(Clone, Debug, Eq, PartialEq, Serialize, Deserialize)]
pub struct SignalReceived {
    /// The signal's own name, the same at each repetition.
    pub signal: SignalId,
    /// The mobile robot.
    pub robot: String,
    /// What it says, for example `MR_ARRIVED`.
    pub name: String,
    /// The job it is about.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub job: Option<JobId>,
    /// The step token it carried.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub token: Option<String>,
    /// The digest of its body.
    pub body: Digest,
}

/// A person decided about something in doubt.
#[derive(Clone, Debug, Eq, PartialEq, Serialize, Deserialize)]
pub struct Decision {
    /// Its name: applied once.
    pub decision: DecisionId,
    /// What it is about.
    pub subject: Subject,
    /// What the person says.
    pub answer: Answer,
    /// Who.
    pub principal: String,
    /// Why.
    pub reason: String,
}

/// What a decision is about.
#[derive(Clone, Copy, Debug, Eq, PartialEq, Serialize, Deserialize)]
#[serde(tag = "of", content = "id", rename_all = "snake_case")]
pub enum Subject {
    /// A motion in doubt.
    Motion(MotionId),
    /// A job.
    Job(JobId),
}

/// What a person says about something in doubt.
#[derive(Clone, Copy, Debug, Eq, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Answer {
    /// It was executed.
    Happened,
    /// It was not executed.
    DidNotHappen,
    /// Whatever it was, the job ends.
    AbortJob,
}

/// The state machines of a cell decided something: facts that belong together, kept or not as one.
#[derive(Clone, Debug, Eq, PartialEq, Serialize, Deserialize)]
pub struct CellDecided {
    /// The cell.
    pub cell: String,
    /// The facts, JSON as text. The journal does not look into it.
    pub facts: String,
    /// The key of the request that led to them, where it has one.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub claim: Option<Claim>,
}

/// Someone did, or tried to do, something.
#[derive(Clone, Debug, Eq, PartialEq, Serialize, Deserialize)]
pub struct Audit {
    /// Who.
    pub principal: String,
    /// What, for example `limits.update`.
    pub action: String,
    /// To what.
    pub object: String,
    /// Whether it was done.
    pub result: AuditResult,
    /// The HTTP request behind it.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub request_id: Option<String>,
    /// The cell it is about; none where it is about the whole server.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub cell: Option<String>,
    /// The role in which it was done.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub role: Option<String>,
    /// The address it came from.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub source: Option<String>,
    /// The epoch of the lease of control it is about.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub lease: Option<u64>,
    /// What it was, JSON as text.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub before: Option<String>,
    /// What it is now, JSON as text.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub after: Option<String>,
}

/// Whether an action was carried out.
#[derive(Clone, Copy, Debug, Eq, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum AuditResult {
    /// It was.
    Done,
    /// It was not allowed.
    Denied,
    /// It did not work.
    Failed,
}
