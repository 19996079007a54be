//! What is really so: with each arm and each mobile robot.

use std::collections::{BTreeMap, BTreeSet, VecDeque};

use uuid::Uuid;
use workflow::{Message, MobileState, OpResult, Safety, Signal, Target};

#[derive(Debug, Clone)]
pub struct ArmTruth {
    pub at: Option<Target>,
    pub moving: Option<(Uuid, Target, u64)>,
    pub holds: Option<String>,
    pub link: bool,
    pub ready: bool,
    /// The pendant is enabled.
    pub manual: bool,
    /// A human moved it since its last motion.
    pub displaced: bool,
    pub safety: Safety,
    /// What the controller remembers of operations.
    pub done: BTreeMap<Uuid, OpResult>,
    /// Operations it was ever asked for: never one twice.
    pub asked: BTreeSet<Uuid>,
    pub grip_fails: u32,
    pub release_sticks: bool,
    pub doubt_next: bool,
    pub doubt_for_good: bool,
    pub alarm_next: bool,
    pub swallow_next: bool,
    pub not_executed_next: bool,
    pub blocked: BTreeSet<String>,
    /// It lost its memory: what is not in `done` may have happened.
    pub forgot: bool,
}

#[derive(Debug, Clone)]
pub struct MobileTruth {
    pub boot: u64,
    pub seq: u64,
    pub state: MobileState,
    pub session: Option<Uuid>,
    /// Signals on their way, oldest first; the head is sent until it is answered.
    pub sending: VecDeque<Signal>,
    pub next_send: u64,
    pub next_beat: u64,
    pub permit: bool,
    pub docked: bool,
    pub paused: bool,
    /// What it does next, and when.
    pub plan: VecDeque<(u64, Do)>,
    pub onward: bool,
    // Knobs.
    pub acks: bool,
    pub rejects: bool,
    pub arrives: bool,
    pub docks: bool,
    pub obeys_retry: bool,
    pub dock_error_mm: f64,
    pub dock_errors: u32,
    pub says_ready: bool,
    pub leaves: bool,
    pub delivers: bool,
    pub beats: bool,
    pub reports_loads: bool,
    pub lies_slot: Option<(String, Option<String>)>,
    pub got: Vec<Message>,
    /// The last message it has read; the others wait in its outbox.
    pub read: u64,
}

#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Do {
    Assigned,
    Rejected,
    Depart,
    Arrive,
    Dock,
    Ready,
    Leave,
    Clear,
    Deliver,
}
