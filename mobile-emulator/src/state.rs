//! A robot at one moment.

use api::{FloorAreaBody, FloorPoseBody, MobileErrorBody, OperatingMode, SlotLoadBody};
use serde::Serialize;
use uuid::Uuid;

use crate::fault_book::ActiveFault;
use crate::ledger::DriveEnd;
use crate::mission::Phase;

/// Everything about a robot. The truth, and what it tells, side by side.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[expect(
    clippy::struct_excessive_bools,
    reason = "a snapshot of independent facts, not a state machine"
)]
pub struct State {
    /// The robot's id.
    pub id: String,
    /// Its time since its first start.
    pub time_s: f64,
    /// The number of its last start.
    pub boot: u64,
    /// It has no power.
    pub down: bool,
    /// The operating mode.
    pub mode: OperatingMode,
    /// Where it truly is.
    pub pose: FloorPoseBody,
    /// Where it believes it is.
    pub believed_pose: FloorPoseBody,
    /// Where it says it is.
    pub told_pose: FloorPoseBody,
    /// It has somewhere to go, and nothing holds it back.
    pub driving: bool,
    /// Why it stands although it has somewhere to go.
    pub stands_because: Option<DriveEnd>,
    /// It was told to pause.
    pub paused: bool,
    /// Its speed.
    pub speed_mm_s: f64,
    /// How its wheels turn: front left, front right, rear left, rear right.
    pub wheels_rad_s: [f64; 4],
    /// The fastest that a wheel has ever turned.
    pub fastest_wheel_rad_s: f64,
    /// The fastest that a wheel may turn.
    pub max_wheel_rad_s: f64,
    /// What is left of its drive.
    pub left_mm: f64,
    /// All it has driven.
    pub odometer_mm: f64,
    /// The charge that is left.
    pub battery_percent: f64,
    /// What truly lies in its slots.
    pub slots: Vec<SlotLoadBody>,
    /// The order it works on.
    pub order: Option<Uuid>,
    /// The update of that order.
    pub update: Option<u32>,
    /// The hand-over session of that order.
    pub session: Option<Uuid>,
    /// Where it is in that order.
    pub phase: Option<Phase>,
    /// The point of that order.
    pub goal: Option<String>,
    /// It may move in that point's zone.
    pub move_permit: bool,
    /// It may leave.
    pub exit_granted: bool,
    /// The point it stands at.
    pub at_point: Option<String>,
    /// What is wrong with it, as it tells.
    pub errors: Vec<MobileErrorBody>,
    /// The faults that are set.
    pub faults: Vec<ActiveFault>,
    /// The zones it knows.
    pub zones: Vec<ZoneState>,
    /// The places of its order that are still to come.
    pub stops: Vec<PlannedStop>,
    /// Its length and width.
    pub footprint_mm: [f64; 2],
    /// What stands around: x, y, radius in millimeters.
    pub obstacles: Vec<[f64; 3]>,
    /// Its link to the cell.
    pub cell: CellLink,
}

/// A zone it knows.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct ZoneState {
    /// The point it belongs to.
    pub point: String,
    /// Where it is.
    pub area: FloorAreaBody,
    /// The robot may move in it.
    pub may_move: bool,
    /// The robot touches it.
    pub touched: bool,
}

/// A place it will drive to.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct PlannedStop {
    /// Its name; empty for a place on the way.
    pub name: String,
    /// Where.
    pub pose: FloorPoseBody,
}

/// Its link to the cell.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct CellLink {
    /// The cell did not answer when it last tried.
    pub away: bool,
    /// The number of its last signal in this boot.
    pub last_seq: u64,
    /// Signals that are not answered yet.
    pub waiting_signals: usize,
    /// The last message it has taken.
    pub last_message: u64,
}
