//! What a mobile robot says: numbered, answered once, acted on once.

use serde::{Deserialize, Serialize};
use uuid::Uuid;

use crate::setup::BasePose;

/// The canonical signals.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
#[serde(rename_all = "SCREAMING_SNAKE_CASE")]
#[expect(missing_docs, reason = "the words of the signal table")]
pub enum SignalKind {
    MrAssigned,
    MrArrived,
    MrDocked,
    MrReady,
    MrClear,
    MrDelivered,
    LoadChanged,
    MrHeartbeat,
    MrFault,
    MrMode,
    MrRejected,
    MrDockFailed,
}

/// Operating mode of a mobile robot (VDA 5050).
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "SCREAMING_SNAKE_CASE")]
#[expect(missing_docs, reason = "the words of VDA 5050")]
pub enum MobileMode {
    #[default]
    Automatic,
    Semiautomatic,
    Intervened,
    Manual,
    Service,
}

impl MobileMode {
    /// Whether the cell may rely on what the mobile robot does next.
    #[must_use]
    pub const fn is_automatic(self) -> bool {
        matches!(self, Self::Automatic | Self::Semiautomatic)
    }
}

/// What is in a slot.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct SlotLoad {
    /// The slot.
    pub slot: String,
    /// `None`: something is there that the mobile robot cannot name.
    pub load: Option<String>,
}

/// An error the mobile robot reports.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
pub struct MobileError {
    /// It cannot go on.
    pub fatal: bool,
    /// Its type.
    #[serde(rename = "type")]
    pub kind: String,
    /// For people.
    pub description: String,
}

/// The state that comes with every signal.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
pub struct MobileState {
    /// Pose in the cell frame.
    pub pose: BasePose,
    /// It moves by itself.
    pub driving: bool,
    /// It trusts its own pose.
    pub localized: bool,
    /// Charge.
    pub battery_percent: f64,
    /// Mode.
    pub mode: MobileMode,
    /// Occupied slots; empty: it is known to carry nothing; `None`: it has no sensors to say.
    pub loads: Option<Vec<SlotLoad>>,
    /// The order it works on.
    pub order: Option<Uuid>,
    /// The point it stands at.
    pub at_point: Option<String>,
    /// Its errors.
    #[serde(default)]
    pub errors: Vec<MobileError>,
}

/// One signal as it arrived.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Signal {
    /// Who.
    pub mobile_robot: String,
    /// The session it belongs to, as told by the cell.
    pub session: Option<Uuid>,
    /// Count of the mobile robot's starts.
    pub boot: u64,
    /// Strictly increasing from 1 within one `boot`.
    pub seq: u64,
    /// What.
    pub kind: SignalKind,
    /// When, by its own clock, in milliseconds. It decides nothing but how long the way since its signal before can have
    /// taken at most.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub at_ms: Option<i64>,
    /// A heartbeat that says: whatever of this boot has a lower number and did not arrive is lost for ever.
    #[serde(default, skip_serializing_if = "std::ops::Not::not")]
    pub resync: bool,
    /// The state at that moment.
    pub state: MobileState,
}

/// How a signal was answered.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
#[serde(tag = "answer", rename_all = "kebab-case")]
pub enum SignalAnswer {
    /// 200.
    Accepted {
        /// It had been accepted before; nothing happened this time.
        duplicate: bool,
    },
    /// 202: its predecessor is missing; it is kept until that comes.
    Parked,
    /// 409 `handover-conflict`.
    Conflict {
        /// What would have been legal.
        expected: String,
        /// What came.
        got: String,
        /// This is the stored answer to an earlier copy.
        duplicate: bool,
    },
    /// 409 `handover-conflict`: more than one number before it is missing. Nothing is kept, and its number is not used
    /// up: the mobile robot sends from `expected`, or a heartbeat that says that what is missing is lost.
    Gap {
        /// The boot.
        boot: u64,
        /// The next number.
        expected: u64,
        /// The number that came.
        got: u64,
    },
    /// 200: it was given up as lost before it came. Kept as a record, not acted on.
    Late {
        /// This is the stored answer to an earlier copy.
        duplicate: bool,
    },
    /// 410 `session-closed`: kept as a record, not acted on.
    Closed {
        /// The session it named.
        session: Uuid,
        /// This is the stored answer to an earlier copy.
        duplicate: bool,
    },
}

impl SignalAnswer {
    /// The same answer, marked as given for a copy.
    #[must_use]
    pub fn for_duplicate(mut self) -> Self {
        match &mut self {
            Self::Accepted { duplicate }
            | Self::Late { duplicate }
            | Self::Conflict { duplicate, .. }
            | Self::Closed { duplicate, .. } => *duplicate = true,
            Self::Parked | Self::Gap { .. } => {}
        }
        self
    }
}

/// What a human may have a mobile robot do at once (VDA 5050: instant actions).
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(tag = "action", rename_all = "SCREAMING_SNAKE_CASE")]
pub enum InstantAction {
    /// Stand still.
    StartPause,
    /// Go on.
    StopPause,
    /// Give an order up.
    CancelOrder {
        /// Which; `None`: the one it reports.
        order: Option<Uuid>,
    },
    /// Do again what failed.
    Retry,
    /// Give up what failed.
    SkipRetry,
    /// Say all that is so now.
    StateRequest,
}

/// What the cell tells a mobile robot.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(tag = "kind", rename_all = "SCREAMING_SNAKE_CASE")]
#[expect(missing_docs, reason = "the words of the outbox contract")]
pub enum Message {
    /// The same `order` and `update` sent again are the same order.
    TransportOrder {
        order: Uuid,
        update: u32,
        goal: String,
        dock: Option<BasePose>,
        route: Vec<BasePose>,
        then_to: Option<String>,
        /// What is to be taken off where the order ends; `None` in orders of earlier versions.
        #[serde(default, skip_serializing_if = "Option::is_none")]
        unload: Option<Vec<SlotLoad>>,
    },
    MovePermit {
        granted: bool,
    },
    CellReady,
    TransferDone,
    TransferFailed {
        reason: String,
    },
    ExitGranted,
    CancelOrder {
        order: Uuid,
    },
    StartPause,
    StopPause,
    Retry,
    SkipRetry,
    StateRequest,
}

impl Message {
    /// A message that lets something move. If it was not fetched yet, it dies with the permit.
    #[must_use]
    pub const fn grants(&self) -> bool {
        matches!(
            self,
            Self::MovePermit { granted: true } | Self::CellReady | Self::ExitGranted
        )
    }
}

/// A message in the outbox.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct OutMessage {
    /// Its number, increasing for each mobile robot.
    pub n: u64,
    /// The session it belongs to.
    pub session: Option<Uuid>,
    /// What.
    #[serde(flatten)]
    pub message: Message,
}
