//! A job in virtual time: what would become of it, and how long it would take.

use serde::{Deserialize, Serialize};
use utoipa::ToSchema;

use crate::{FaultName, JobReport, JobState, Load, LoadLocation};

/// What became of a job that was simulated. All times but `wall_ms` are simulated ones, and count from the job's
/// creation.
///
/// It began where the cell is now, with nothing else going on in it; `assumptions` says what had to be supposed.
/// Nothing of the cell itself has changed, and no robot of it was asked or told anything.
#[derive(Clone, Debug, Deserialize, PartialEq, Serialize, ToSchema)]
pub struct JobSimulation {
    /// The state the job ended in: `COMPLETE`, `STOPPED`, or the one in which nothing more happens by itself.
    pub outcome: JobState,
    /// Why the simulation ended there.
    pub ended: SimulationEnd,
    /// Why the job is in its state, in words; empty where there is nothing to say.
    pub text: String,
    /// The fault behind its state.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub fault: Option<FaultName>,
    /// From the job's creation to the end, in seconds.
    pub simulated_s: f64,
    /// How long the simulation itself took, in milliseconds.
    pub wall_ms: u64,
    /// Phases, attempts, states and faults, as the report of a real job has them.
    pub report: JobReport,
    /// What the arms did, in the order of beginning.
    pub motions: Vec<SimulatedMotion>,
    /// Each change of the permits of a point. Never are both given.
    pub permits: Vec<SimulatedPermit>,
    /// Each load that came to another place.
    pub custody: Vec<SimulatedCustody>,
    /// What a person would have been asked. Nobody answered.
    pub interventions: Vec<SimulatedQuestion>,
    /// What must not happen and would have: a mobile robot that moves in a zone without a permit, a motion that the
    /// controller refuses, a load that falls. Empty is good.
    pub violations: Vec<SimulatedViolation>,
    /// Where every load is at the end.
    pub loads: Vec<Load>,
    /// What was supposed, because it is not known, or because another job is at it now.
    pub assumptions: Vec<String>,
}

/// Why a simulation ended.
#[derive(Clone, Copy, Debug, Deserialize, Eq, PartialEq, Serialize, ToSchema)]
#[serde(rename_all = "SCREAMING_SNAKE_CASE")]
pub enum SimulationEnd {
    /// The job is over.
    JobOver,
    /// It goes on only when a person decides.
    AsksAPerson,
    /// It took longer than a simulation may in simulated time.
    SimulatedTimeLimit,
    /// It took longer than a simulation may in real time.
    WallTimeLimit,
}

/// What an arm did.
#[derive(Clone, Debug, Deserialize, PartialEq, Serialize, ToSchema)]
pub struct SimulatedMotion {
    /// The arm.
    pub arm: String,
    /// The step it belongs to, as in `report.phases`.
    pub step: usize,
    /// What, in words.
    pub action: String,
    /// When it began.
    pub begin_ms: u64,
    /// How long it took, from the command to the confirmed end.
    pub duration_ms: u64,
    /// How it ended, in words; absent while it runs.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub end: Option<String>,
}

/// The permits of a point changed.
#[derive(Clone, Debug, Deserialize, PartialEq, Serialize, ToSchema)]
pub struct SimulatedPermit {
    /// When.
    pub at_ms: u64,
    /// `station/point`.
    pub point: String,
    /// The arm may enter.
    pub arm_entry_permit: bool,
    /// The mobile robot may move.
    pub mr_move_permit: bool,
}

/// A load came to another place.
#[derive(Clone, Debug, Deserialize, PartialEq, Serialize, ToSchema)]
pub struct SimulatedCustody {
    /// When.
    pub at_ms: u64,
    /// The load.
    pub load: String,
    /// Where it came to.
    pub to: LoadLocation,
}

/// A person would have been asked.
#[derive(Clone, Debug, Deserialize, PartialEq, Serialize, ToSchema)]
pub struct SimulatedQuestion {
    /// When.
    pub at_ms: u64,
    /// The fault behind it.
    pub fault: FaultName,
    /// What is asked.
    pub question: String,
    /// What could be answered.
    pub answers: Vec<String>,
}

/// Something that must not happen.
#[derive(Clone, Debug, Deserialize, PartialEq, Serialize, ToSchema)]
pub struct SimulatedViolation {
    /// When.
    pub at_ms: u64,
    /// The arm, mobile robot or load.
    pub source: String,
    /// What, in words.
    pub text: String,
}
