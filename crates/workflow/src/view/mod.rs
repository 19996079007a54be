//! What can be shown: everything an operator or a program needs to know, as plain data.

mod cell;

use serde::Serialize;
use uuid::Uuid;

use crate::book::OpState;
use crate::claims::{Holder, Resource};
use crate::custody::Load;
use crate::effect::Action;
use crate::faults::Fault;
use crate::ids::Millis;
use crate::intervention::{Allowed, Decided, Question};
use crate::job::params::NewJob;
use crate::job::phase::{Phase, Recovery};
use crate::job::{Compensation, FaultNote, Item, JobState, StepState, Why};
use crate::session::SessionState;
use crate::setup::{BasePose, PlaceRef};
use crate::signal::MobileState;
use crate::timers::TimerKey;

/// A running wait.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct TimerView {
    /// Its name.
    pub timer: TimerKey,
    /// What is left of it.
    pub left_ms: Millis,
    /// All of it.
    pub total_ms: Millis,
}

/// A step of a job.
#[derive(Debug, Clone, PartialEq, Serialize)]
#[expect(missing_docs, reason = "the words of SM-6")]
pub struct StepView {
    pub number: usize,
    pub phase: Phase,
    /// Its row, `A1` to `B16`.
    pub code: &'static str,
    pub item: Option<usize>,
    pub place: Option<PlaceRef>,
    pub state: StepState,
    pub attempt: u8,
    pub undo: bool,
    pub recovery: Recovery,
    pub needs: Vec<usize>,
    /// The operation that runs, and what it is.
    pub operation: Option<OperationView>,
    pub left_ms: Option<Millis>,
}

/// An operation of an arm.
#[derive(Debug, Clone, PartialEq, Serialize)]
#[expect(missing_docs, reason = "the names say it")]
pub struct OperationView {
    pub op: Uuid,
    pub arm: String,
    pub action: Action,
    pub state: OpState,
    pub left_ms: Option<Millis>,
}

/// A job.
#[derive(Debug, Clone, PartialEq, Serialize)]
#[expect(missing_docs, reason = "the words of SM-5")]
pub struct JobView {
    pub id: Uuid,
    /// Order of creation.
    pub number: u64,
    pub spec: NewJob,
    pub trigger: Option<String>,
    pub state: JobState,
    pub why: Why,
    pub text: String,
    pub arm: Option<String>,
    pub mobile_robot: Option<String>,
    pub session: Option<Uuid>,
    pub items: Vec<Item>,
    /// What it is at.
    pub phase: Option<Phase>,
    pub code: Option<&'static str>,
    pub steps: Vec<StepView>,
    pub compensation: Compensation,
    /// The open question.
    pub intervention: Option<Uuid>,
    pub faults: Vec<FaultNote>,
    pub claims: Vec<Resource>,
    pub timers: Vec<TimerView>,
}

/// A session.
#[derive(Debug, Clone, PartialEq, Serialize)]
#[expect(missing_docs, reason = "the words of SM-7")]
pub struct SessionView {
    pub id: Uuid,
    pub point: String,
    pub job: Uuid,
    pub mobile_robot: String,
    pub state: SessionState,
    pub faulted_from: Option<SessionState>,
    pub fault: Option<Fault>,
    pub arm_entry_permit: bool,
    pub mr_move_permit: bool,
    pub order: Option<Uuid>,
    pub order_update: u32,
    pub docked: Option<BasePose>,
    pub intervention: Option<Uuid>,
    pub timers: Vec<TimerView>,
}

/// A load.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct LoadView {
    /// Its id.
    pub id: String,
    /// Type and place.
    #[serde(flatten)]
    pub load: Load,
    /// Who works with it.
    pub claimed_by: Option<Holder>,
}

/// A question.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct InterventionView {
    /// Its number in the order of asking.
    pub number: u64,
    /// The question itself.
    #[serde(flatten)]
    pub question: Question,
    /// The fault's number, `F1` to `F24`.
    pub code: String,
    /// Each answer with what it would do.
    pub allowed: Vec<Allowed>,
    /// It waits for a decision.
    pub open: bool,
    /// The decision.
    pub decided: Option<Decided>,
    /// Why it is not asked any more.
    pub withdrawn: Option<String>,
}

/// A mobile robot.
#[derive(Debug, Clone, PartialEq, Serialize)]
#[expect(missing_docs, reason = "the names say it")]
pub struct MobileRobotView {
    pub id: String,
    pub slots: Vec<String>,
    /// It was heard lately.
    pub heard: bool,
    pub state: Option<MobileState>,
    pub boot: u64,
    pub last_seq: u64,
    pub session: Option<Uuid>,
    /// Its drive with loads.
    pub destination: Option<String>,
    /// Messages it has not fetched.
    pub waiting_messages: usize,
}

/// A claim.
#[derive(Debug, Clone, PartialEq, Eq, Serialize)]
pub struct ClaimView {
    /// What.
    pub resource: Resource,
    /// By whom.
    pub by: Holder,
}
