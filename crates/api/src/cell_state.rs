//! A cell as a whole, now.

use jiff::Timestamp;
use serde::{Deserialize, Serialize};
use utoipa::ToSchema;
use uuid::Uuid;

use crate::{ControlView, JobState, LinkState, OperationalMode, PointPermits};

/// What is known of a cell now.
#[derive(Clone, Debug, Deserialize, PartialEq, Serialize, ToSchema)]
pub struct CellState {
    /// The cell.
    pub cell: String,
    /// In one word of `PackML`: that of the job that needs a person most, else of the one that works, else `IDLE`.
    pub state: JobState,
    /// The job the state is of.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub job: Option<Uuid>,
    /// The time of the cell's clock. It runs ahead of the world's where the controllers are virtual and fast.
    pub clock: Timestamp,
    /// Who has control.
    pub control: ControlView,
    /// Whether jobs may move the arms: nobody else has control.
    pub jobs_may_act: bool,
    /// Whether the journal takes records. Without it nothing new is begun.
    pub journal_writable: bool,
    /// The arms.
    pub arms: Vec<ArmState>,
    /// The permits of each point.
    pub permits: Vec<PointPermits>,
    /// Jobs by state, those that are not over.
    pub open_jobs: Vec<JobCount>,
    /// Loads of unknown place.
    pub loads_unknown: Vec<String>,
    /// What waits for a person, the oldest first.
    pub open_interventions: Vec<Uuid>,
    /// What is wrong, in words, the most urgent first.
    pub alarms: Vec<CellAlarm>,
}

/// An arm of the cell.
#[derive(Clone, Debug, Deserialize, PartialEq, Serialize, ToSchema)]
pub struct ArmState {
    /// Its id.
    pub id: String,
    /// The link to its controller.
    pub link: LinkState,
    /// The safety state, as reported: never a safety function.
    pub safety: SafetyState,
    /// Its mode, where it is known.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub mode: Option<OperationalMode>,
    /// The job that has it.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub job: Option<Uuid>,
}

/// The safety state of an arm, as its controller reports it.
#[derive(Clone, Copy, Debug, Deserialize, Eq, PartialEq, Serialize, ToSchema)]
#[serde(rename_all = "SCREAMING_SNAKE_CASE")]
pub enum SafetyState {
    /// Nothing is wrong.
    Normal,
    /// A protective stop: fence, light curtain.
    ProtectiveStop,
    /// An emergency stop.
    EmergencyStop,
    /// Another alarm.
    Fault,
    /// It is not reported.
    Unknown,
}

/// How many jobs are in a state.
#[derive(Clone, Debug, Deserialize, PartialEq, Serialize, ToSchema)]
pub struct JobCount {
    /// The state.
    pub state: JobState,
    /// How many.
    pub jobs: usize,
}

/// Something that is wrong in the cell.
#[derive(Clone, Debug, Deserialize, PartialEq, Serialize, ToSchema)]
pub struct CellAlarm {
    /// How bad.
    pub level: AlarmLevel,
    /// Where it comes from: an arm, a mobile robot, a load, `journal`.
    pub source: String,
    /// What, in words.
    pub text: String,
}

/// How bad an alarm is.
#[derive(Clone, Copy, Debug, Deserialize, Eq, Ord, PartialEq, PartialOrd, Serialize, ToSchema)]
#[serde(rename_all = "snake_case")]
pub enum AlarmLevel {
    /// Nothing goes on without a person.
    Error,
    /// Worth a look.
    Warning,
}
