//! Jobs of the group workflows: asking for one, steering it, and what became of it.

use jiff::Timestamp;
use serde::{Deserialize, Serialize};
use utoipa::ToSchema;
use uuid::Uuid;

/// The group workflows.
#[derive(Clone, Copy, Debug, Deserialize, Eq, PartialEq, Serialize, ToSchema)]
#[serde(rename_all = "kebab-case")]
pub enum WorkflowName {
    /// A: a mobile robot brings loads, an arm unloads and places them.
    DeliveryAndPlacement,
    /// B: an arm loads a mobile robot, which takes the loads away.
    PickupAndDelivery,
}

/// A new job.
#[derive(Clone, Debug, Deserialize, PartialEq, Serialize, ToSchema)]
#[serde(deny_unknown_fields)]
#[schema(example = json!({
    "workflow": "delivery-and-placement",
    "params": {
        "point": "handover/front",
        "items": [{"load_id": "load-1", "type": "crate", "mr_slot": "left", "place": "rack/a"}],
        "on_cancel_with_load": "RETURN_TO_MR"
    },
    "priority": 5
}))]
pub struct JobBody {
    /// Which workflow.
    pub workflow: WorkflowName,
    /// Its parameters.
    pub params: JobParams,
    /// Higher first: -100 to 100; 0 where absent.
    #[serde(default)]
    #[schema(minimum = -100, maximum = 100)]
    pub priority: i32,
    /// When the job has to have started: one that has not by then is stopped, and nothing moves.
    #[serde(
        default,
        deserialize_with = "crate::moment::optional",
        skip_serializing_if = "Option::is_none"
    )]
    pub deadline: Option<Timestamp>,
}

/// The parameters of both workflows.
#[derive(Clone, Debug, Deserialize, PartialEq, Serialize, ToSchema)]
#[serde(deny_unknown_fields)]
pub struct JobParams {
    /// The mobile robot; absent or `any`: any that has the slots and is free.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub mobile_robot: Option<String>,
    /// The arm; absent: any arm of the point that was taught all places.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub arm: Option<String>,
    /// Where the mobile robot docks: `station/point`.
    pub point: String,
    /// What is moved, in this order: 1 to 32.
    #[schema(min_items = 1, max_items = 32)]
    pub items: Vec<JobItemBody>,
    /// A: the mobile robot may go as soon as the last load was lifted.
    #[serde(default)]
    pub early_release: bool,
    /// B: the arm picks the first load while the mobile robot is on its way.
    #[serde(default)]
    pub prefetch: bool,
    /// What to do with a load in the gripper where the job is canceled.
    #[serde(default)]
    pub on_cancel_with_load: OnCancelWithLoad,
    /// The place for loads that are rejected.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub reject_slot: Option<String>,
    /// How often a grip is tried, 1 to 10; 2 where absent.
    #[serde(default = "two")]
    #[schema(minimum = 1, maximum = 10)]
    pub max_attempts: u8,
    /// B: where the mobile robot takes the loads.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub destination: Option<String>,
    /// B: when the job is complete.
    #[serde(default)]
    pub complete_on: CompleteOn,
    /// How long the mobile robot is expected to drive to the point, in seconds: it is late after 1.5 times that.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schema(minimum = 0, maximum = 86_400)]
    pub expected_arrival_s: Option<f64>,
    /// B: how long it is expected to drive to the destination, in seconds: it is late after twice that.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schema(minimum = 0, maximum = 86_400)]
    pub expected_transport_s: Option<f64>,
}

const fn two() -> u8 {
    2
}

/// One load to move.
#[derive(Clone, Debug, Deserialize, PartialEq, Serialize, ToSchema)]
#[serde(deny_unknown_fields)]
pub struct JobItemBody {
    /// The load, if it is known by name.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub load_id: Option<String>,
    /// Its type.
    #[serde(rename = "type")]
    pub load_type: String,
    /// The slot of the mobile robot: A from there, B to there.
    pub mr_slot: String,
    /// The fixed place: A to there (also called `target_slot`), B from there (also called `source_slot`).
    #[serde(alias = "target_slot", alias = "source_slot")]
    pub place: String,
    /// A: other fixed places that do as well.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub alternates: Vec<String>,
}

/// What to do with a load in the gripper where the job is canceled.
#[derive(Clone, Copy, Debug, Default, Deserialize, Eq, PartialEq, Serialize, ToSchema)]
#[serde(rename_all = "SCREAMING_SNAKE_CASE")]
pub enum OnCancelWithLoad {
    /// Place it where it was going, then stop.
    Complete,
    /// Put it back where it came from.
    ReturnToMr,
    /// Into the job's reject slot.
    RejectBin,
    /// Ask a person.
    #[default]
    Hold,
}

/// When workflow B is complete.
#[derive(Clone, Copy, Debug, Default, Deserialize, Eq, PartialEq, Serialize, ToSchema)]
#[serde(rename_all = "SCREAMING_SNAKE_CASE")]
pub enum CompleteOn {
    /// When the mobile robot has left with the loads.
    #[default]
    Departed,
    /// When it has delivered them.
    Delivered,
}

/// The state of a job, in the words of `PackML`.
#[derive(Clone, Copy, Debug, Deserialize, Eq, PartialEq, Serialize, ToSchema)]
#[serde(rename_all = "SCREAMING_SNAKE_CASE")]
pub enum JobState {
    /// It waits for what it needs.
    Idle,
    /// It claims and plans.
    Starting,
    /// It works.
    Execute,
    /// It closes.
    Completing,
    /// Done.
    Complete,
    /// On its way to HELD.
    Holding,
    /// A person or a fault of the cell's own holds it.
    Held,
    /// On its way out of HELD.
    Unholding,
    /// On its way to SUSPENDED.
    Suspending,
    /// It waits for somebody outside.
    Suspended,
    /// On its way out of SUSPENDED.
    Unsuspending,
    /// It is being stopped, and undone as far as it can be.
    Stopping,
    /// Stopped.
    Stopped,
    /// It is being aborted.
    Aborting,
    /// Aborted: a person has to clear it.
    Aborted,
    /// It is being cleared.
    Clearing,
    /// It is being reset.
    Resetting,
}

impl JobState {
    /// Every state.
    pub const ALL: [Self; 17] = [
        Self::Idle,
        Self::Starting,
        Self::Execute,
        Self::Completing,
        Self::Complete,
        Self::Holding,
        Self::Held,
        Self::Unholding,
        Self::Suspending,
        Self::Suspended,
        Self::Unsuspending,
        Self::Stopping,
        Self::Stopped,
        Self::Aborting,
        Self::Aborted,
        Self::Clearing,
        Self::Resetting,
    ];

    /// Whether nothing more happens by itself.
    #[must_use]
    pub fn is_final(self) -> bool {
        matches!(self, Self::Complete | Self::Stopped)
    }
}

/// Why a job is in its state.
#[derive(Clone, Copy, Debug, Deserialize, Eq, PartialEq, Serialize, ToSchema)]
#[serde(rename_all = "snake_case")]
pub enum JobReason {
    /// The workflow's own course.
    Course,
    /// It waits for somebody outside, as planned.
    Awaiting,
    /// A fault: see `fault`.
    Fault,
    /// The server was started again, and finds out what became of everything.
    Recovering,
    /// A person's command.
    Person,
    /// Its deadline passed before it could start.
    DeadlinePassed,
}

/// A job.
#[derive(Clone, Debug, Deserialize, PartialEq, Serialize, ToSchema)]
pub struct Job {
    /// Its id.
    pub id: Uuid,
    /// The cell.
    pub cell: String,
    /// Its number in the order of creation.
    pub number: u64,
    /// When it was created.
    pub created_at: Timestamp,
    /// Which workflow.
    pub workflow: WorkflowName,
    /// What was asked for.
    pub params: JobParams,
    /// Higher first.
    pub priority: i32,
    /// When it has to have started.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub deadline: Option<Timestamp>,
    /// The trigger that created it, where no caller did.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub trigger: Option<String>,
    /// Its state.
    pub state: JobState,
    /// Why it is in its state.
    pub reason: JobReason,
    /// The same in words; empty where there is nothing to say.
    pub text: String,
    /// The fault behind the state.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub fault: Option<FaultName>,
    /// The person behind the state.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub principal: Option<String>,
    /// Its place in the queue while it waits, from 1.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub queue_position: Option<usize>,
    /// The phase it is at, e.g. `PLACE_APPROACH`. The list grows.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub phase: Option<String>,
    /// Its row in the workflow's table, `A1` to `B16`; `undo` for what is only there to undo.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub code: Option<String>,
    /// The arm that does it, once there is one.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub arm: Option<String>,
    /// The mobile robot, once there is one.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub mobile_robot: Option<String>,
    /// Its hand-over session.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub session: Option<Uuid>,
    /// Its loads as they are known now.
    pub items: Vec<JobItem>,
    /// Its steps; empty until it starts.
    pub steps: Vec<JobStep>,
    /// How far the undoing is.
    pub compensation: Compensation,
    /// The open question about it: answer it at `interventions/{id}/respond`.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub intervention: Option<Uuid>,
    /// What went wrong so far.
    pub faults: Vec<JobFault>,
    /// What only this job may use now.
    pub claims: Vec<ClaimBody>,
    /// Waits that run.
    pub timers: Vec<TimerBody>,
    /// What may be commanded now; anything else is refused.
    pub commands: Vec<JobCommand>,
}

/// One load of a job.
#[derive(Clone, Debug, Deserialize, PartialEq, Serialize, ToSchema)]
pub struct JobItem {
    /// The load, once it is known.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub load: Option<String>,
    /// Its type.
    #[serde(rename = "type")]
    pub load_type: String,
    /// The slot of the mobile robot.
    pub mr_slot: String,
    /// The fixed place.
    pub place: String,
    /// Other places that were not tried yet.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub alternates: Vec<String>,
}

/// The state of a step.
#[derive(Clone, Copy, Debug, Deserialize, Eq, PartialEq, Serialize, ToSchema)]
#[serde(rename_all = "SCREAMING_SNAKE_CASE")]
pub enum StepState {
    /// What it needs is not done.
    Pending,
    /// It runs.
    Running,
    /// It failed in a way that may be tried again.
    Retriable,
    /// Done.
    Succeeded,
    /// A person skipped it.
    Skipped,
    /// It failed.
    Failed,
    /// The plan was changed: it is not needed any more.
    Dropped,
}

/// A step of a job.
#[derive(Clone, Debug, Deserialize, PartialEq, Serialize, ToSchema)]
pub struct JobStep {
    /// Its number in the job.
    pub number: usize,
    /// What it does, e.g. `GRIP`. The list grows.
    pub phase: String,
    /// Its row in the workflow's table, `A1` to `B16`, or `undo`.
    pub code: String,
    /// The index of its item.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub item: Option<usize>,
    /// Where: a fixed place, or `slot at station/point`.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub place: Option<String>,
    /// How far it is.
    pub state: StepState,
    /// 1 for the first time, 0 before.
    pub attempt: u8,
    /// It belongs to the undoing.
    pub undo: bool,
    /// What may be done where nobody saw its end: RETRY, RECONCILE, COMPENSATE, `FORWARD_ONLY` or OPERATOR.
    pub recovery: String,
    /// Numbers of the steps that have to be done before.
    pub needs: Vec<usize>,
    /// What an arm does for it now.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub operation: Option<JobOperation>,
    /// What is left of its time, in milliseconds of the cell's clock.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub left_ms: Option<u64>,
}

/// What an arm does for a step.
#[derive(Clone, Debug, Deserialize, PartialEq, Serialize, ToSchema)]
pub struct JobOperation {
    /// Its id.
    pub id: Uuid,
    /// The arm.
    pub arm: String,
    /// What, in words.
    pub action: String,
    /// `RUNNING`; `DOUBT`: nobody knows how it ended; `RECONCILING`: it is being found out.
    pub state: String,
    /// What is left of its time, in milliseconds of the cell's clock.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub left_ms: Option<u64>,
}

/// How far the undoing of a job is.
#[derive(Clone, Copy, Debug, Deserialize, Eq, PartialEq, Serialize, ToSchema)]
#[serde(rename_all = "SCREAMING_SNAKE_CASE")]
pub enum Compensation {
    /// Nothing to undo.
    None,
    /// It runs.
    Running,
    /// Done.
    Done,
    /// A person has to say how.
    Blocked,
}

/// A fault by its number in the fault matrix and its name.
#[derive(Clone, Debug, Deserialize, Eq, PartialEq, Serialize, ToSchema)]
pub struct FaultName {
    /// `F1` to `F24`.
    pub code: String,
    /// E.g. `heartbeat-lost`.
    pub name: String,
}

/// A fault that happened to a job.
#[derive(Clone, Debug, Deserialize, PartialEq, Serialize, ToSchema)]
pub struct JobFault {
    /// Which.
    #[serde(flatten)]
    pub fault: FaultName,
    /// What was seen.
    pub text: String,
}

/// Something that only one job uses at a time.
#[derive(Clone, Debug, Deserialize, Eq, PartialEq, Serialize, ToSchema)]
pub struct ClaimBody {
    /// `point`, `arm`, `place`, `mobile_robot` or `load`.
    pub resource: String,
    /// Its id.
    pub id: String,
}

/// A wait that runs.
#[derive(Clone, Debug, Deserialize, PartialEq, Serialize, ToSchema)]
pub struct TimerBody {
    /// What is waited for, e.g. `step`, `heartbeat`, `session`. The list grows.
    pub timer: String,
    /// What it belongs to: a step's number, an id.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub of: Option<String>,
    /// What is left, in milliseconds of the cell's clock.
    pub left_ms: u64,
    /// All of it.
    pub total_ms: u64,
}

/// A page of jobs, the newest first.
#[derive(Clone, Debug, Deserialize, PartialEq, Serialize, ToSchema)]
pub struct JobList {
    /// They.
    pub jobs: Vec<JobSummary>,
    /// Where the next page begins, where there is one.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub next_cursor: Option<String>,
}

/// A job in a list.
#[derive(Clone, Debug, Deserialize, PartialEq, Serialize, ToSchema)]
pub struct JobSummary {
    /// Its id.
    pub id: Uuid,
    /// Its number in the order of creation.
    pub number: u64,
    /// When it was created.
    pub created_at: Timestamp,
    /// Which workflow.
    pub workflow: WorkflowName,
    /// Where the mobile robot docks.
    pub point: String,
    /// Its state.
    pub state: JobState,
    /// Why it is in its state.
    pub reason: JobReason,
    /// The same in words.
    pub text: String,
    /// Its phase's row in the workflow's table.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub code: Option<String>,
    /// The phase it is at.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub phase: Option<String>,
    /// Steps that are done, and all that are needed.
    pub steps_done: usize,
    /// See there.
    pub steps: usize,
    /// The arm.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub arm: Option<String>,
    /// The mobile robot.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub mobile_robot: Option<String>,
    /// The open question about it.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub intervention: Option<Uuid>,
    /// Its place in the queue while it waits, from 1.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub queue_position: Option<usize>,
}

/// What may be done with a job.
#[derive(Clone, Copy, Debug, Deserialize, Eq, PartialEq, Serialize, ToSchema)]
#[serde(rename_all = "kebab-case")]
pub enum JobCommand {
    /// Hold it where it is safe.
    Hold,
    /// Let it go on.
    Unhold,
    /// Stop it, and undo what can be undone.
    Stop,
    /// Stop the arm at once and leave everything as it is.
    Abort,
    /// Do the failed step again.
    RetryStep,
    /// Go on without a check.
    SkipStep,
    /// The step was done by hand.
    CompleteManually,
    /// As `stop`.
    Compensate,
    /// An aborted job: everything is safe again.
    Clear,
    /// A stopped job: into the queue again.
    Reset,
}

/// A command to a job.
#[derive(Clone, Debug, Deserialize, PartialEq, Serialize, ToSchema)]
#[serde(deny_unknown_fields)]
#[schema(example = json!({"command": "hold", "reason": "a visitor in the aisle"}))]
pub struct JobCommandBody {
    /// Which.
    pub command: JobCommand,
    /// Why, for the record: 1 to 500 characters.
    #[schema(min_length = 1, max_length = 500)]
    pub reason: String,
}
