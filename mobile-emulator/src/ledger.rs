//! The ledger: what the robot did and what it was told, the truth that tests and operators look at.
//!
//! It is written beside the robot's own signals and never sent: poses here are where the robot truly is, whatever it
//! believes or tells.

use std::collections::VecDeque;
use std::time::Duration;

use api::{FloorPoseBody, OperatingMode, SignalName};
use serde::Serialize;
use uuid::Uuid;

use crate::fault::Fault;

/// Entries that are kept; older ones are dropped and counted.
pub const LEDGER_ENTRIES: usize = 20_000;

/// One line of the ledger.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct LedgerEntry {
    /// Counts from 1, without holes while nothing is dropped.
    pub n: u64,
    /// The robot's time since its first start.
    pub time_s: f64,
    /// Where it truly was.
    pub pose: FloorPoseBody,
    /// What happened.
    #[serde(flatten)]
    pub event: LedgerEvent,
}

/// What happened.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[serde(tag = "event", rename_all = "SCREAMING_SNAKE_CASE")]
#[expect(missing_docs, reason = "the fields say what their names say")]
pub enum LedgerEvent {
    /// It started.
    Booted { boot: u64 },
    /// It lost power, with everything it had not written down.
    Crashed { boot: u64 },
    /// A message was taken from the outbox.
    Message {
        n: u64,
        kind: &'static str,
        session: Option<Uuid>,
    },
    /// A message had no effect.
    MessageIgnored { n: u64, reason: String },
    /// An order was taken.
    OrderTaken {
        order: Uuid,
        update: u32,
        goal: String,
        session: Option<Uuid>,
    },
    /// An order that is known came again.
    OrderRepeated { order: Uuid, update: u32 },
    /// An order was refused.
    OrderRefused { order: Uuid, reason: String },
    /// An order is over.
    OrderEnded { order: Uuid, outcome: OrderOutcome },
    /// It set out.
    DriveStarted { purpose: Purpose, to: FloorPoseBody },
    /// It stands.
    DriveEnded {
        purpose: Purpose,
        driven_mm: f64,
        reason: DriveEnd,
    },
    /// It goes on.
    DriveResumed { purpose: Purpose },
    /// A permit was seen.
    Permit {
        granted: bool,
        session: Option<Uuid>,
    },
    /// It touches a point's zone.
    ZoneEntered { point: String },
    /// It does not touch it any more.
    ZoneLeft { point: String },
    /// It stands docked: how far it truly is from the ordered dock.
    Docked {
        point: String,
        off_mm: f64,
        off_deg: f64,
    },
    /// It stands before or beside the dock.
    DockFailed {
        point: String,
        off_mm: f64,
        off_deg: f64,
    },
    /// A load was put into a slot.
    LoadPut { slot: String, load: String },
    /// A load was taken out of a slot.
    LoadTaken { slot: String, load: String },
    /// A signal left.
    SignalSent {
        signal: SignalName,
        boot: u64,
        seq: u64,
        attempt: u32,
    },
    /// The cell answered.
    SignalAnswered {
        signal: SignalName,
        boot: u64,
        seq: u64,
        status: u16,
        answer: String,
    },
    /// The cell did not answer.
    SignalUnanswered {
        signal: SignalName,
        boot: u64,
        seq: u64,
        reason: String,
    },
    /// The cell waited for a number that is lost: the robot says so, and counts on.
    Resynchronized { boot: u64, expected: u64 },
    /// A fault took a signal, or a transmission of it.
    SignalLost {
        signal: SignalName,
        seq: Option<u64>,
    },
    /// The cell cannot be reached.
    CellAway { reason: String },
    /// The cell answers again.
    CellBack,
    /// The operating mode changed.
    Mode { mode: OperatingMode },
    /// A fault was set.
    FaultSet { id: u64, fault: Fault },
    /// Faults were cleared.
    FaultsCleared { count: usize },
    /// It slid.
    Slipped { noticed: bool },
    /// An error came up.
    Error { error: String },
    /// The robot caught itself.
    Violation { what: Violation, detail: String },
}

impl LedgerEvent {
    /// It tells of nothing but that the robot is there.
    pub(crate) fn is_heartbeat(&self) -> bool {
        matches!(
            self,
            Self::SignalSent { signal, .. }
                | Self::SignalAnswered { signal, .. }
                | Self::SignalUnanswered { signal, .. }
                | Self::SignalLost { signal, .. }
                if *signal == SignalName::MrHeartbeat
        )
    }
}

/// What a robot must never do.
#[derive(Clone, Copy, Debug, Eq, PartialEq, Serialize)]
#[serde(rename_all = "SCREAMING_SNAKE_CASE")]
pub enum Violation {
    /// It moved while it touched a zone it had no permit for.
    MovedInZoneWithoutPermit,
    /// It told that it was docked, and was not at the ordered dock.
    ToldDockedOffDock,
    /// A load was moved while the robot drove.
    LoadMovedWhileDriving,
    /// A load was moved while the robot had a permit to move.
    LoadMovedUnderMovePermit,
    /// A wheel turned faster than it can.
    WheelTooFast,
}

/// Why it drives.
#[derive(Clone, Copy, Debug, Eq, PartialEq, Serialize)]
#[serde(rename_all = "SCREAMING_SNAKE_CASE")]
pub enum Purpose {
    /// To a point.
    Approach,
    /// The last of the way to a dock.
    Dock,
    /// Out of a point's zone.
    Leave,
    /// To the destination.
    Deliver,
    /// To a point, without an order.
    Visit,
}

/// Why it stands.
#[derive(Clone, Copy, Debug, Eq, PartialEq, Serialize)]
#[serde(rename_all = "SCREAMING_SNAKE_CASE")]
pub enum DriveEnd {
    /// It is there.
    Arrived,
    /// A zone it has no permit for.
    NoPermit,
    /// Something in the way.
    Obstacle,
    /// It was paused, or its mode does not let it drive.
    Paused,
    /// Too far from its path.
    OffPath,
    /// Its order is gone, or replaced.
    GivenUp,
    /// It cannot: empty battery, no localization, no power.
    Disabled,
}

/// How an order ended.
#[derive(Clone, Copy, Debug, Eq, PartialEq, Serialize)]
#[serde(rename_all = "SCREAMING_SNAKE_CASE")]
pub enum OrderOutcome {
    /// All of it is done.
    Finished,
    /// It was cancelled.
    Cancelled,
    /// Docking was given up.
    Failed,
    /// Lost in a crash, or to a person's hands.
    Lost,
}

#[derive(Clone, Debug, Default)]
pub(crate) struct Ledger {
    entries: VecDeque<LedgerEntry>,
    count: u64,
}

impl Ledger {
    pub(crate) fn push(&mut self, time: Duration, pose: FloorPoseBody, event: LedgerEvent) {
        self.count += 1;
        if self.entries.len() >= LEDGER_ENTRIES {
            let _oldest = self.entries.pop_front();
        }
        self.entries.push_back(LedgerEntry {
            n: self.count,
            time_s: time.as_secs_f64(),
            pose,
            event,
        });
    }

    /// Entries above a number, oldest first.
    pub(crate) fn after(&self, n: u64) -> Vec<LedgerEntry> {
        let newer = self.entries.iter().filter(|entry| entry.n > n);
        newer.cloned().collect()
    }

    pub(crate) fn dropped(&self) -> u64 {
        self.entries
            .front()
            .map_or(0, |first| first.n.saturating_sub(1))
    }
}
