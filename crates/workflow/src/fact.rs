//! What happened. Facts are append-only: a variant or field is never removed or given another meaning.

use serde::{Deserialize, Serialize};
use uuid::Uuid;

use crate::claims::{Holder, Resource};
use crate::custody::{Evidence, Location};
use crate::definition::Definition;
use crate::effect::Action;
use crate::faults::Fault;
use crate::ids::Millis;
use crate::input::{ArmSeen, OpResult};
use crate::intervention::{Decided, Question};
use crate::job::params::NewJob;
use crate::job::{Compensation, Item, JobState, PlannedStep, StepState, Why};
use crate::session::SessionState;
use crate::setup::{PlaceRef, Setup};
use crate::signal::{InstantAction, Message, Signal, SignalAnswer};
use crate::timers::TimerKey;

/// How far a session is taken back, so that a part of it is done again.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Rewind {
    /// A new order: nothing the mobile robot said counts any more.
    Order,
    /// It has to dock again.
    Dock,
}

/// One fact.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(tag = "fact", rename_all = "snake_case")]
#[expect(missing_docs, reason = "the fields are explained by their types")]
pub enum Fact {
    /// The process started: permits are 0, every wait is armed anew.
    Recovered,
    /// The configuration is this from now on.
    SetupChanged { setup: Box<Setup> },
    /// A job was taken into the queue.
    JobCreated {
        job: Uuid,
        spec: Box<NewJob>,
        trigger: Option<String>,
        #[serde(default, skip_serializing_if = "Option::is_none")]
        origin: Option<String>,
        items: Vec<Item>,
    },
    /// A job got its arm and mobile robot.
    JobAssigned {
        job: Uuid,
        arm: String,
        mobile_robot: String,
    },
    /// A job changed its state.
    JobMoved {
        job: Uuid,
        to: JobState,
        why: Why,
        text: String,
    },
    /// A fault of the matrix happened to a job.
    FaultNoted {
        job: Uuid,
        fault: Fault,
        text: String,
    },
    /// Steps were appended; those in `drop` are not needed any more.
    Planned {
        job: Uuid,
        steps: Vec<PlannedStep>,
        drop: Vec<usize>,
        /// What the plan is of, from here on.
        #[serde(default, skip_serializing_if = "Option::is_none")]
        definition: Option<Definition>,
    },
    /// A step changed its state.
    StepMoved {
        job: Uuid,
        step: usize,
        to: StepState,
        attempt: u8,
        text: String,
    },
    /// A step goes to another place.
    StepRedirected {
        job: Uuid,
        step: usize,
        place: PlaceRef,
    },
    /// A request of a step was sent again, or its wait was extended.
    StepResent { job: Uuid, step: usize },
    /// A step needs one more step to be done before.
    StepNeeds { job: Uuid, step: usize, need: usize },
    /// An item became known better, or goes elsewhere.
    ItemChanged { job: Uuid, item: usize, to: Item },
    /// How far the undoing is.
    CompensationMoved { job: Uuid, to: Compensation },
    /// A human accepted loads that do not match.
    LoadsAccepted { job: Uuid },
    /// A job is dispatched again.
    Redispatched { job: Uuid },
    /// Resources were claimed, all of them.
    Claimed {
        by: Holder,
        resources: Vec<Resource>,
    },
    /// Everything a holder had, or only `resources`, is free.
    Released {
        by: Holder,
        resources: Option<Vec<Resource>>,
    },
    /// An operation is intended. Durable before anything is sent.
    OpStarted {
        op: Uuid,
        job: Uuid,
        step: usize,
        arm: String,
        action: Action,
    },
    /// Nobody knows what became of an operation.
    OpDoubted { op: Uuid, text: String },
    /// The truth is being read.
    OpReconciling { op: Uuid },
    /// What became of it is known.
    OpEnded { op: Uuid, result: OpResult },
    /// An arm was told to stop. Not kept: a stop needs no journal.
    ArmStopped { arm: String, text: String },
    /// An arm has to be out of the zone or still within `T_safe`. Not kept.
    SafeDue { arm: String },
    /// A hand-over session of a point.
    SessionOpened {
        session: Uuid,
        point: String,
        job: Uuid,
        mobile_robot: String,
    },
    /// Another mobile robot serves the session.
    SessionHandedOn { session: Uuid, mobile_robot: String },
    /// A session changed its state.
    SessionMoved {
        session: Uuid,
        to: SessionState,
        fault: Option<Fault>,
    },
    /// An order of the session was sent, or sent again.
    SessionOrdered {
        session: Uuid,
        order: Uuid,
        update: u32,
    },
    /// A request of the session was sent again.
    SessionResent { session: Uuid },
    /// A part of the session has to be done again.
    SessionRewound { session: Uuid, to: Rewind },
    /// A mobile robot that could not dock was told to give up and to drive out.
    SessionBacksOut { session: Uuid },
    /// An integrator accepted the measured dock pose.
    MeasuredAccepted { session: Uuid },
    /// A mobile robot drives out.
    SessionLeft { session: Uuid },
    /// Something was put into the outbox of a mobile robot.
    Told {
        mobile_robot: String,
        session: Option<Uuid>,
        message: Message,
    },
    /// Messages were fetched.
    OutboxTaken { mobile_robot: String, n: u64 },
    /// A signal arrived and was answered. Acted on only if it was accepted.
    Signaled {
        signal: Box<Signal>,
        answer: SignalAnswer,
    },
    /// Signals that will not come any more: if they do, they are not acted on.
    SignalsLost {
        mobile_robot: String,
        boot: u64,
        from: u64,
        to: u64,
    },
    /// A heartbeat arrived. Not kept.
    Beat { signal: Box<Signal> },
    /// A mobile robot drives with loads to a destination.
    TransportBegun {
        mobile_robot: String,
        job: Uuid,
        order: Uuid,
        destination: String,
        /// The hand-over session that it follows, and the update of its order.
        #[serde(default)]
        session: Option<Uuid>,
        #[serde(default)]
        update: u32,
    },
    /// That drive is over.
    TransportEnded { mobile_robot: String },
    /// A trigger was meant and started no job.
    TriggerSkipped {
        trigger: String,
        mobile_robot: String,
        boot: u64,
        seq: u64,
        text: String,
    },
    /// A human had something done by a mobile robot.
    InstantActed {
        mobile_robot: String,
        action: InstantAction,
        principal: String,
        reason: Option<String>,
    },
    /// A load that was not configured.
    LoadRegistered {
        load: String,
        kind: String,
        location: Location,
    },
    /// A human had the arm between two steps, and moved it or not: nothing moves until one says how to go on (C10).
    ArmByHand { job: Uuid, displaced: bool },
    /// One said how.
    ArmByHandDecided { job: Uuid },
    /// A load is somewhere else now.
    CustodyMoved {
        load: String,
        to: Location,
        by: Evidence,
    },
    /// A human is asked.
    Asked { question: Box<Question> },
    /// A human decided.
    Answered {
        intervention: Uuid,
        decided: Decided,
    },
    /// The question has no meaning any more.
    Withdrawn { intervention: Uuid, text: String },
    /// A wait ended without what was waited for. Not kept: what was done about it is.
    TimerExpired { timer: TimerKey },
    /// An arm was looked at. Not kept.
    ArmSeen(ArmSeen),
    /// Nothing was seen of an arm for too long. Not kept.
    ArmLost { arm: String },
    /// Nothing was heard of a mobile robot for too long. Not kept.
    MobileLost { mobile_robot: String },
    /// How long an operation will take. Not kept.
    OpPlanned { op: Uuid, expected_ms: Millis },
    /// Whether jobs have control. Not kept.
    ControlChanged { jobs_may_act: bool },
    /// Whether the journal can be written. Not kept.
    JournalChanged { writable: bool },
}

impl Fact {
    /// Whether it belongs into the journal. The others describe what is seen at this moment, many times a second;
    /// the state after a replay does not depend on them.
    #[must_use]
    pub fn is_durable(&self) -> bool {
        !matches!(
            self,
            Self::Beat { .. }
                | Self::ArmSeen(_)
                | Self::ArmStopped { .. }
                | Self::SafeDue { .. }
                | Self::ArmLost { .. }
                | Self::MobileLost { .. }
                | Self::OpPlanned { .. }
                | Self::ControlChanged { .. }
                | Self::JournalChanged { .. }
                | Self::TimerExpired { .. }
        )
    }
}
