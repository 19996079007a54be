//! Jobs (SM-5) and their steps (SM-6).

pub(crate) mod command;
mod docking;
mod elsewhere;
pub(crate) mod operations;
mod orders;
pub(crate) mod params;
pub(crate) mod phase;
pub(crate) mod plan;
mod results;
mod resume;
pub(crate) mod run;
pub(crate) mod undo;
pub(crate) mod validate;
mod verify;

use serde::{Deserialize, Serialize};
use uuid::Uuid;

use crate::faults::Fault;
use crate::setup::PlaceRef;
use params::NewJob;
use phase::Phase;

/// `PackML` states of a job.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
#[serde(rename_all = "SCREAMING_SNAKE_CASE")]
#[expect(missing_docs, reason = "the words of PackML")]
pub enum JobState {
    Idle,
    Starting,
    Execute,
    Completing,
    Complete,
    Holding,
    Held,
    Unholding,
    Suspending,
    Suspended,
    Unsuspending,
    Stopping,
    Stopped,
    Aborting,
    Aborted,
    Clearing,
    Resetting,
}

impl JobState {
    /// Nothing more happens by itself, and nothing is claimed.
    #[must_use]
    pub const fn is_final(self) -> bool {
        matches!(self, Self::Complete | Self::Stopped)
    }

    /// The states in which something is on its way to a wait state.
    #[must_use]
    pub const fn is_acting(self) -> bool {
        matches!(
            self,
            Self::Holding
                | Self::Unholding
                | Self::Suspending
                | Self::Unsuspending
                | Self::Stopping
                | Self::Aborting
                | Self::Clearing
                | Self::Resetting
        )
    }

    /// The states in which steps make progress (SUSPENDED only while merely waiting).
    pub(crate) const fn runs(self) -> bool {
        matches!(
            self,
            Self::Starting | Self::Execute | Self::Completing | Self::Stopping
        )
    }
}

/// Why a job is in its state.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
#[serde(tag = "why", rename_all = "snake_case")]
pub enum Why {
    /// The workflow's own course.
    Course,
    /// It waits for somebody outside, as planned.
    Awaiting,
    /// A fault of the matrix.
    Fault {
        /// Which one.
        fault: Fault,
    },
    /// After a restart (F21).
    Recovering,
    /// A human's command.
    Human {
        /// Who.
        principal: String,
    },
    /// Its deadline passed before it could start.
    DeadlinePassed,
}

/// State of a step.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "SCREAMING_SNAKE_CASE")]
pub enum StepState {
    /// Its predecessors are not done.
    Pending,
    /// It runs.
    Running,
    /// It failed in a way that may be tried again.
    Retriable,
    /// Done.
    Succeeded,
    /// A human skipped it.
    Skipped,
    /// It failed.
    Failed,
    /// The plan was changed; it is not needed any more.
    Dropped,
}

impl StepState {
    pub(crate) const fn is_done(self) -> bool {
        matches!(self, Self::Succeeded | Self::Skipped | Self::Dropped)
    }
}

/// A step as it was planned. The plan is part of the facts: a later version replays the old plan.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
pub struct PlannedStep {
    /// What.
    pub phase: Phase,
    /// For which item.
    pub item: Option<usize>,
    /// At which place.
    pub place: Option<PlaceRef>,
    /// Steps that have to be done before.
    pub needs: Vec<usize>,
    /// It belongs to a compensation.
    #[serde(default)]
    pub undo: bool,
}

/// A step.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
pub(crate) struct Step {
    pub plan: PlannedStep,
    pub state: StepState,
    /// 1 for the first time.
    pub attempt: u8,
    /// How many of its operations are done.
    pub done_ops: usize,
    /// The operation that runs or is in doubt.
    pub op: Option<Uuid>,
    /// How often its request was sent again, or its wait extended.
    pub resends: u8,
}

impl Step {
    pub(crate) const fn new(plan: PlannedStep) -> Self {
        Self {
            plan,
            state: StepState::Pending,
            attempt: 0,
            done_ops: 0,
            op: None,
            resends: 0,
        }
    }
}

/// An item while the job runs.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
pub struct Item {
    /// The load, once it is known.
    pub load: Option<String>,
    /// Its type.
    #[serde(rename = "type")]
    pub kind: String,
    /// Slot of the mobile robot.
    pub slot: String,
    /// Fixed place.
    pub place: String,
    /// Alternates not tried yet.
    pub alternates: Vec<String>,
}

/// How far the undoing is.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "SCREAMING_SNAKE_CASE")]
pub enum Compensation {
    /// Nothing to undo.
    #[default]
    None,
    /// It runs.
    Running,
    /// Done.
    Done,
    /// A human has to say how.
    Blocked,
}

/// A fault that happened to a job.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
pub struct FaultNote {
    /// Which.
    pub fault: Fault,
    /// What was seen.
    pub text: String,
}

/// A human had the arm of a job between two of its steps (C10).
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
pub(crate) struct ByHand {
    /// The arm is not where the job left it: its first way is to the safe pose.
    pub displaced: bool,
    /// A human said how to go on.
    pub decided: bool,
}

/// A job.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub(crate) struct Job {
    pub id: Uuid,
    /// Order of creation.
    pub number: u64,
    pub spec: NewJob,
    pub trigger: Option<String>,
    /// The signal that fired it: mobile robot, boot, number.
    pub origin: Option<String>,
    /// What its plan was made by; `None`: by a program that did not say so.
    #[serde(default)]
    pub definition: Option<crate::definition::Definition>,
    pub state: JobState,
    pub why: Why,
    pub text: String,
    pub arm: Option<String>,
    pub mobile_robot: Option<String>,
    pub session: Option<Uuid>,
    pub items: Vec<Item>,
    pub steps: Vec<Step>,
    /// The place the arm may be near; `None`: outside, at its safe pose.
    pub near: Option<PlaceRef>,
    pub by_hand: Option<ByHand>,
    pub compensation: Compensation,
    pub redispatches: u8,
    /// A human accepted loads that do not match.
    pub loads_accepted: bool,
    pub faults: Vec<FaultNote>,
}

impl Job {
    /// A job that has just been asked for.
    pub(crate) fn new(id: Uuid, number: u64, spec: NewJob, items: Vec<Item>) -> Self {
        Self {
            id,
            number,
            spec,
            trigger: None,
            origin: None,
            definition: None,
            state: JobState::Idle,
            why: Why::Course,
            text: String::new(),
            arm: None,
            mobile_robot: None,
            session: None,
            items,
            steps: Vec::new(),
            near: None,
            by_hand: None,
            compensation: Compensation::None,
            redispatches: 0,
            loads_accepted: false,
            faults: Vec::new(),
        }
    }

    /// Whether a signal of this mobile robot started it.
    pub(crate) fn signaled_by(&self, mobile_robot: &str) -> bool {
        let who = self
            .origin
            .as_deref()
            .and_then(|origin| origin.split('/').next());
        who == Some(mobile_robot)
    }

    /// The step by which the arm leaves the zone, while it does.
    pub(crate) fn backing_out(&self) -> Option<usize> {
        let leaves = |s: &Step| s.plan.phase == Phase::BackOut && s.state == StepState::Running;
        self.steps.iter().position(leaves)
    }

    pub(crate) fn step(&self, index: usize) -> Option<&Step> {
        self.steps.get(index)
    }

    /// The first step that is not done, which is what the job is at.
    pub(crate) fn current(&self) -> Option<usize> {
        let running = |s: &Step| matches!(s.state, StepState::Running | StepState::Retriable);
        self.steps
            .iter()
            .position(running)
            .or_else(|| self.steps.iter().position(|s| !s.state.is_done()))
    }

    pub(crate) fn find(&self, phase: Phase) -> Option<usize> {
        self.steps
            .iter()
            .position(|s| s.plan.phase == phase && s.state != StepState::Dropped)
    }

    pub(crate) fn is_done(&self, phase: Phase) -> bool {
        self.steps.iter().any(|s| {
            s.plan.phase == phase && matches!(s.state, StepState::Succeeded | StepState::Skipped)
        })
    }

    /// The arm is not where the job left it.
    pub(crate) fn is_displaced(&self) -> bool {
        self.by_hand.is_some_and(|by| by.displaced)
    }

    /// A human had the arm, and nobody has said yet how to go on.
    pub(crate) fn waits_for_hand(&self) -> bool {
        self.by_hand.is_some_and(|by| !by.decided)
    }

    /// It has moved its arm, and is not done with it. Before, wherever the arm stands is where the job begins.
    pub(crate) fn is_between_motions(&self) -> bool {
        let moves = |s: &&Step| s.plan.phase.is_arm_work() && s.plan.phase != Phase::Precheck;
        let begun = self
            .steps
            .iter()
            .filter(moves)
            .any(|s| s.done_ops > 0 || s.state == StepState::Succeeded);
        let left = self.steps.iter().filter(moves).any(|s| !s.state.is_done());
        (begun || self.near.is_some()) && left
    }

    /// Whether steps may make progress.
    pub(crate) fn runs(&self) -> bool {
        self.state.runs() || (self.state == JobState::Suspended && self.why == Why::Awaiting)
    }

    pub(crate) fn item_of(&self, step: usize) -> Option<(usize, &Item)> {
        let index = self.steps.get(step)?.plan.item?;
        Some((index, self.items.get(index)?))
    }
}
