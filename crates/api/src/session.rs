//! Hand-over sessions: who may be in the zone of a point, and what is waited for.

use serde::{Deserialize, Serialize};
use utoipa::ToSchema;
use uuid::Uuid;

use crate::{FaultName, FloorPoseBody, TimerBody};

/// The state of a hand-over session.
#[derive(Clone, Copy, Debug, Deserialize, Eq, PartialEq, Serialize, ToSchema)]
#[serde(rename_all = "SCREAMING_SNAKE_CASE")]
pub enum SessionState {
    /// The point is claimed.
    Reserved,
    /// The mobile robot took the order.
    AccessPending,
    /// It may come: `MR_MOVE_PERMIT`.
    AccessGranted,
    /// It is at the point and docks.
    Positioned,
    /// It stands at the right pose.
    Docked,
    /// It waits, and its loads are right.
    TransferReady,
    /// The arm works: `ARM_ENTRY_PERMIT`.
    Transferring,
    /// The arm is out.
    TransferDone,
    /// It may go: `MR_MOVE_PERMIT`.
    ExitGranted,
    /// It is out.
    Exited,
    /// Closed.
    Released,
    /// Something is wrong: no permit.
    Faulted,
    /// The order was taken back.
    Canceling,
    /// Closed without a transfer.
    Canceled,
}

/// A hand-over session: one for each point at a time.
#[derive(Clone, Debug, Deserialize, PartialEq, Serialize, ToSchema)]
pub struct Session {
    /// Its id.
    pub id: Uuid,
    /// Where: `station/point`.
    pub point: String,
    /// The job it is for.
    pub job: Uuid,
    /// Who docks.
    pub mobile_robot: String,
    /// How far it is.
    pub state: SessionState,
    /// It is over.
    pub closed: bool,
    /// While FAULTED: where it was.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub faulted_from: Option<SessionState>,
    /// While FAULTED: why.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub fault: Option<FaultName>,
    /// The arm may enter the zone. Never together with the other permit.
    pub arm_entry_permit: bool,
    /// The mobile robot may move in the zone.
    pub mr_move_permit: bool,
    /// The transport order.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub order: Option<Uuid>,
    /// The order's update.
    pub order_update: u32,
    /// Where it docked.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub docked: Option<FloorPoseBody>,
    /// The open question about it.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub intervention: Option<Uuid>,
    /// Waits that run.
    pub timers: Vec<TimerBody>,
}

/// Sessions, the newest first.
#[derive(Clone, Debug, Deserialize, PartialEq, Serialize, ToSchema)]
pub struct SessionList {
    /// They.
    pub sessions: Vec<Session>,
}

/// Who may move in the zone of a point: never both.
#[derive(Clone, Debug, Deserialize, PartialEq, Serialize, ToSchema)]
pub struct PointPermits {
    /// `station/point`.
    pub point: String,
    /// The arm may enter.
    pub arm_entry_permit: bool,
    /// The mobile robot may move.
    pub mr_move_permit: bool,
    /// The session that is open there.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub session: Option<Uuid>,
}
