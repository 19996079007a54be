//! Mobile robots: the signals they send, and the messages the cell has for them.
//!
//! A mobile robot posts [`SignalBody`]s and reads [`Outbox`]es; a message may also be pushed to it, as the same
//! [`OutboxMessage`]. Poses are on the floor of the cell: millimeters, and degrees counterclockwise from X.

use jiff::Timestamp;
use serde::{Deserialize, Serialize};
use utoipa::{IntoParams, ToSchema};
use uuid::Uuid;

/// The longest id of a robot, slot, load, or point, in bytes.
pub const MAX_MOBILE_ID: usize = 64;
/// The most slots, and the most errors, one signal tells of.
pub const MAX_SIGNAL_ITEMS: usize = 64;
/// The longest time an outbox request waits for a message, in seconds.
pub const MAX_OUTBOX_WAIT_S: u32 = 30;

/// A pose on the floor of the cell: millimeters, and degrees counterclockwise from X to the front of the robot.
#[derive(Clone, Copy, Debug, Default, Deserialize, PartialEq, Serialize, ToSchema)]
#[serde(deny_unknown_fields)]
#[schema(example = json!({"x_mm": 2000, "y_mm": 1000, "heading_deg": 90}))]
pub struct FloorPoseBody {
    /// Along X of the cell, in millimeters.
    #[schema(minimum = -10_000_000, maximum = 10_000_000)]
    pub x_mm: f64,
    /// Along Y of the cell, in millimeters.
    #[schema(minimum = -10_000_000, maximum = 10_000_000)]
    pub y_mm: f64,
    /// From X of the cell to x of the robot, counterclockwise, in degrees.
    #[schema(minimum = -36_000, maximum = 36_000)]
    pub heading_deg: f64,
}

/// A place a route leads through.
#[derive(Clone, Copy, Debug, Deserialize, PartialEq, Serialize, ToSchema)]
#[serde(deny_unknown_fields)]
#[schema(example = json!({"x_mm": 1000, "y_mm": 0}))]
pub struct RoutePointBody {
    /// Along X of the cell, in millimeters.
    #[schema(minimum = -10_000_000, maximum = 10_000_000)]
    pub x_mm: f64,
    /// Along Y of the cell, in millimeters.
    #[schema(minimum = -10_000_000, maximum = 10_000_000)]
    pub y_mm: f64,
    /// The heading to turn to on the way there, in degrees; absent: the robot keeps the one it has.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schema(minimum = -36_000, maximum = 36_000)]
    pub heading_deg: Option<f64>,
}

/// An upright rectangle on the floor of the cell, in millimeters.
#[derive(Clone, Copy, Debug, Deserialize, PartialEq, Serialize, ToSchema)]
#[serde(deny_unknown_fields)]
#[schema(example = json!({"min_x_mm": 1000, "min_y_mm": -1000, "max_x_mm": 3000, "max_y_mm": 1000}))]
pub struct FloorAreaBody {
    /// The smallest X.
    #[schema(minimum = -10_000_000, maximum = 10_000_000)]
    pub min_x_mm: f64,
    /// The smallest Y.
    #[schema(minimum = -10_000_000, maximum = 10_000_000)]
    pub min_y_mm: f64,
    /// The largest X, above the smallest.
    #[schema(minimum = -10_000_000, maximum = 10_000_000)]
    pub max_x_mm: f64,
    /// The largest Y, above the smallest.
    #[schema(minimum = -10_000_000, maximum = 10_000_000)]
    pub max_y_mm: f64,
}

/// How far from its dock a robot may stand.
#[derive(Clone, Copy, Debug, Deserialize, PartialEq, Serialize, ToSchema)]
#[serde(deny_unknown_fields)]
#[schema(example = json!({"mm": 5, "deg": 0.5}))]
pub struct DockToleranceBody {
    /// Distance, in millimeters.
    #[schema(minimum = 0.1, maximum = 1000)]
    pub mm: f64,
    /// Heading, in degrees.
    #[schema(minimum = 0.01, maximum = 45)]
    pub deg: f64,
}

/// What a signal says.
#[derive(
    Clone, Copy, Debug, Deserialize, Eq, Hash, Ord, PartialEq, PartialOrd, Serialize, ToSchema,
)]
#[serde(rename_all = "SCREAMING_SNAKE_CASE")]
pub enum SignalName {
    /// The order is taken, and the robot sets out for it.
    MrAssigned,
    /// The robot stands at the point, before docking.
    MrArrived,
    /// The robot stands at the dock, within tolerance.
    MrDocked,
    /// The robot stands docked, has seen its permit to move withdrawn, and waits for the transfer.
    MrReady,
    /// The robot has left the point's zone.
    MrClear,
    /// The robot stands at the destination of its order.
    MrDelivered,
    /// What lies in a slot has changed.
    LoadChanged,
    /// The robot is alive.
    MrHeartbeat,
    /// The robot has an error.
    MrFault,
    /// The operating mode has changed.
    MrMode,
    /// An order is refused; `errors` says why.
    MrRejected,
    /// The robot does not stand at the dock within tolerance; it waits for `RETRY` or `SKIP_RETRY`.
    MrDockFailed,
}

impl SignalName {
    /// Every signal.
    pub const ALL: [Self; 12] = [
        Self::MrAssigned,
        Self::MrArrived,
        Self::MrDocked,
        Self::MrReady,
        Self::MrClear,
        Self::MrDelivered,
        Self::LoadChanged,
        Self::MrHeartbeat,
        Self::MrFault,
        Self::MrMode,
        Self::MrRejected,
        Self::MrDockFailed,
    ];

    /// The signal as it is written.
    #[must_use]
    pub fn as_str(self) -> &'static str {
        match self {
            Self::MrAssigned => "MR_ASSIGNED",
            Self::MrArrived => "MR_ARRIVED",
            Self::MrDocked => "MR_DOCKED",
            Self::MrReady => "MR_READY",
            Self::MrClear => "MR_CLEAR",
            Self::MrDelivered => "MR_DELIVERED",
            Self::LoadChanged => "LOAD_CHANGED",
            Self::MrHeartbeat => "MR_HEARTBEAT",
            Self::MrFault => "MR_FAULT",
            Self::MrMode => "MR_MODE",
            Self::MrRejected => "MR_REJECTED",
            Self::MrDockFailed => "MR_DOCK_FAILED",
        }
    }
}

/// The operating mode of a mobile robot, in the words of VDA 5050.
#[derive(Clone, Copy, Debug, Default, Deserialize, Eq, PartialEq, Serialize, ToSchema)]
#[serde(rename_all = "SCREAMING_SNAKE_CASE")]
pub enum OperatingMode {
    /// It follows its orders.
    #[default]
    Automatic,
    /// It follows its orders, with a speed set by a person.
    Semiautomatic,
    /// A person has stopped it; its order is kept.
    Intervened,
    /// A person drives it; its order is gone.
    Manual,
    /// It is being repaired; its order is gone.
    Service,
}

/// What lies in one slot.
#[derive(Clone, Debug, Deserialize, Eq, PartialEq, Serialize, ToSchema)]
#[serde(deny_unknown_fields)]
#[schema(example = json!({"slot": "a", "load": "box-1"}))]
pub struct SlotLoadBody {
    /// The slot.
    #[schema(min_length = 1, max_length = 64)]
    pub slot: String,
    /// The load in it, if there is one.
    #[schema(required, min_length = 1, max_length = 64)]
    pub load: Option<String>,
}

/// How bad an error is.
#[derive(Clone, Copy, Debug, Deserialize, Eq, PartialEq, Serialize, ToSchema)]
#[serde(rename_all = "SCREAMING_SNAKE_CASE")]
pub enum MobileErrorLevel {
    /// It goes on.
    Warning,
    /// It does not go on without help.
    Fatal,
}

/// An error of a mobile robot.
#[derive(Clone, Debug, Deserialize, Eq, PartialEq, Serialize, ToSchema)]
#[serde(deny_unknown_fields)]
#[schema(example = json!({"level": "WARNING", "type": "BATTERY_LOW", "description": "18 % of 20 %"}))]
pub struct MobileErrorBody {
    /// How bad.
    pub level: MobileErrorLevel,
    /// Which kind, in capitals.
    #[serde(rename = "type")]
    #[schema(min_length = 1, max_length = 64)]
    pub error_type: String,
    /// What happened: the item, the value, the limit.
    #[schema(max_length = 400)]
    pub description: String,
}

/// What a mobile robot knows of itself when it sends a signal.
#[derive(Clone, Debug, Deserialize, PartialEq, Serialize, ToSchema)]
#[serde(deny_unknown_fields)]
pub struct SignalData {
    /// Where it says it is.
    pub pose: FloorPoseBody,
    /// Whether it drives.
    pub driving: bool,
    /// Whether it knows where it is.
    pub localized: bool,
    /// The charge that is left.
    #[schema(minimum = 0, maximum = 100)]
    pub battery_percent: f64,
    /// The operating mode.
    pub mode: OperatingMode,
    /// Each slot and what lies in it, in the sense of VDA 5050: absent, the robot cannot tell; empty, it is known to
    /// carry nothing.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schema(max_items = 64)]
    pub loads: Option<Vec<SlotLoadBody>>,
    /// The order it works on.
    #[schema(required)]
    pub order: Option<Uuid>,
    /// The load handling point it stands at, as `station/point`.
    #[schema(required, max_length = 129)]
    pub at_point: Option<String>,
    /// What is wrong with it.
    #[schema(max_items = 64)]
    pub errors: Vec<MobileErrorBody>,
}

/// A signal of a mobile robot.
///
/// The same (boot, seq) again is answered as before and has no second effect.
#[derive(Clone, Debug, Deserialize, PartialEq, Serialize, ToSchema)]
#[serde(deny_unknown_fields)]
#[schema(example = json!({
    "session": null, "seq": 1, "boot": 1, "signal": "MR_HEARTBEAT", "at": "2026-01-01T00:00:00Z",
    "data": {
        "pose": {"x_mm": 0, "y_mm": 0, "heading_deg": 0}, "driving": false, "localized": true,
        "battery_percent": 90, "mode": "AUTOMATIC", "loads": [{"slot": "a", "load": "box-1"}],
        "order": null, "at_point": null, "errors": []
    }
}))]
pub struct SignalBody {
    /// The hand-over session it belongs to, as the cell named it in its message; none for what concerns no hand-over.
    #[schema(required)]
    pub session: Option<Uuid>,
    /// Counts from 1 in each `boot`, without holes.
    #[schema(minimum = 1)]
    pub seq: u64,
    /// Grows with each start of the robot.
    pub boot: u64,
    /// What it says.
    pub signal: SignalName,
    /// With `MR_HEARTBEAT` only: whatever of this boot has a lower number and did not arrive is lost for ever. Counting
    /// goes on from here; what is lost is recorded if it comes after all, and has no effect.
    #[serde(default, skip_serializing_if = "std::ops::Not::not")]
    pub resync: bool,
    /// When, by the robot's clock. For the record only: what counts is the order of arrival.
    #[serde(deserialize_with = "crate::moment::required")]
    pub at: Timestamp,
    /// What the robot knows of itself.
    pub data: SignalData,
}

/// The answer to a signal that was taken: status 200, or 202 where it is parked.
#[derive(Clone, Debug, Default, Deserialize, PartialEq, Serialize, ToSchema)]
#[schema(example = json!({"accepted": true, "duplicate": false, "parked": false}))]
pub struct SignalAnswer {
    /// It is recorded.
    pub accepted: bool,
    /// It was known already, and has no second effect.
    pub duplicate: bool,
    /// It came before its predecessor, and waits for it.
    #[serde(default)]
    pub parked: bool,
    /// Why it was recorded without an effect, e.g. because it is late.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub note: Option<String>,
}

/// What a mobile robot asks its outbox.
#[derive(Clone, Copy, Debug, Default, Deserialize, IntoParams, PartialEq, Serialize)]
#[serde(deny_unknown_fields)]
#[into_params(parameter_in = Query)]
pub struct OutboxQuery {
    /// The last message it has; those up to here are acknowledged and not sent again.
    #[serde(default)]
    pub after: u64,
    /// How long to wait for a message if there is none, in seconds.
    #[serde(default)]
    #[param(minimum = 0, maximum = 30)]
    pub wait_s: u32,
}

/// Messages for a mobile robot, oldest first.
#[derive(Clone, Debug, Default, Deserialize, PartialEq, Serialize, ToSchema)]
pub struct Outbox {
    /// The messages after the one that was named.
    pub messages: Vec<OutboxMessage>,
    /// Ask with this as `after` next time.
    pub next: u64,
}

/// A message for a mobile robot.
#[derive(Clone, Debug, Deserialize, PartialEq, Serialize, ToSchema)]
#[schema(example = json!({
    "n": 4, "at": "2026-01-01T00:00:00Z", "session": null, "kind": "MOVE_PERMIT", "granted": true
}))]
pub struct OutboxMessage {
    /// Counts up for each mobile robot.
    pub n: u64,
    /// When the cell wrote it.
    pub at: Timestamp,
    /// The hand-over session it belongs to.
    #[serde(default)]
    pub session: Option<Uuid>,
    /// What it says.
    #[serde(flatten)]
    pub message: MobileMessage,
}

/// What a message to a mobile robot says.
#[derive(Clone, Debug, Deserialize, PartialEq, Serialize, ToSchema)]
#[serde(tag = "kind", rename_all = "SCREAMING_SNAKE_CASE")]
pub enum MobileMessage {
    /// Drive to a point and dock. The same order and update again is the same order.
    TransportOrder(Box<TransportOrderBody>),
    /// Whether the robot may move in the zone of its session's point (`MR_MOVE_PERMIT`).
    MovePermit {
        /// Whether it may.
        granted: bool,
    },
    /// The cell is ready for the transfer.
    CellReady,
    /// All loads are moved.
    TransferDone,
    /// The loads will not be moved.
    TransferFailed,
    /// The robot may leave, as soon as it also has its permit to move.
    ExitGranted,
    /// Give an order up. A docked robot stays until it may leave.
    CancelOrder {
        /// The order.
        order: Uuid,
    },
    /// Stand still.
    StartPause,
    /// Go on.
    StopPause,
    /// Dock once more.
    Retry,
    /// Give docking up, and leave the zone.
    SkipRetry,
    /// Say all that is so now, with an `MR_HEARTBEAT`.
    StateRequest,
}

impl MobileMessage {
    /// The kind as it is written.
    #[must_use]
    pub fn kind(&self) -> &'static str {
        match self {
            Self::TransportOrder(_) => "TRANSPORT_ORDER",
            Self::MovePermit { .. } => "MOVE_PERMIT",
            Self::CellReady => "CELL_READY",
            Self::TransferDone => "TRANSFER_DONE",
            Self::TransferFailed => "TRANSFER_FAILED",
            Self::ExitGranted => "EXIT_GRANTED",
            Self::CancelOrder { .. } => "CANCEL_ORDER",
            Self::StartPause => "START_PAUSE",
            Self::StopPause => "STOP_PAUSE",
            Self::Retry => "RETRY",
            Self::SkipRetry => "SKIP_RETRY",
            Self::StateRequest => "STATE_REQUEST",
        }
    }
}

/// An order to drive to a point, dock there, and perhaps go on to another.
#[derive(Clone, Debug, Deserialize, PartialEq, Serialize, ToSchema)]
pub struct TransportOrderBody {
    /// The order: one id whatever becomes of it.
    pub order: Uuid,
    /// Grows when the order changes.
    pub update: u32,
    /// Where to dock, as `station/point`.
    #[schema(max_length = 129)]
    pub goal: String,
    /// Where the robot is to stand there.
    pub dock: FloorPoseBody,
    /// How exactly; absent: the robot's own tolerance.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub dock_tolerance: Option<DockToleranceBody>,
    /// The zone of the point, which needs the permit; absent: as the robot's own map has it.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub zone: Option<FloorAreaBody>,
    /// The places to drive through on the way.
    #[serde(default)]
    #[schema(max_items = 900)]
    pub route: Vec<RoutePointBody>,
    /// Where to go afterwards, as `station/point`. It is in the horizon: not before `EXIT_GRANTED` and the permit.
    #[serde(default)]
    #[schema(required, max_length = 129)]
    pub then_to: Option<String>,
    /// Where to stand there; absent: as the robot's own map has it.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub then_pose: Option<FloorPoseBody>,
    /// The places to drive through on the way there.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    #[schema(max_items = 900)]
    pub then_route: Vec<RoutePointBody>,
    /// The loads to take off where the order ends, and no others (VDA 5050: an action `drop` for each, with slot and
    /// load); absent: as is the custom there. An order with it and without `then_to` only drives to its goal, gives the
    /// loads there, and needs no permit and no hand-over.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schema(max_items = 64)]
    pub unload: Option<Vec<SlotLoadBody>>,
}

/// What a person has a mobile robot do at once: the instant actions of VDA 5050.
#[derive(Clone, Copy, Debug, Deserialize, Eq, PartialEq, Serialize, ToSchema)]
#[serde(rename_all = "SCREAMING_SNAKE_CASE")]
pub enum InstantActionName {
    /// Stand still.
    StartPause,
    /// Go on.
    StopPause,
    /// Give an order up that is of no job.
    CancelOrder,
    /// Do again what failed.
    Retry,
    /// Give up what failed.
    SkipRetry,
    /// Say all that is so now.
    StateRequest,
}

/// An instant action.
#[derive(Clone, Debug, Deserialize, PartialEq, Serialize, ToSchema)]
#[serde(deny_unknown_fields)]
#[schema(example = json!({"action": "START_PAUSE", "reason": "a person is in the aisle"}))]
pub struct InstantActionBody {
    /// What.
    pub action: InstantActionName,
    /// For `CANCEL_ORDER`: which; absent, the one the robot reports.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub order: Option<Uuid>,
    /// Why, for the record.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schema(min_length = 1, max_length = 500)]
    pub reason: Option<String>,
}

/// An instant action that was taken: it is in the robot's outbox.
#[derive(Clone, Debug, Deserialize, PartialEq, Serialize, ToSchema)]
#[schema(example = json!({"mobile_robot": "mr1", "action": "START_PAUSE", "unacknowledged": 1}))]
pub struct InstantActionAnswer {
    /// The robot.
    pub mobile_robot: String,
    /// What.
    pub action: InstantActionName,
    /// How many messages the robot has not acknowledged, this one among them unless it was quick.
    pub unacknowledged: usize,
}

/// A mobile robot in a list.
#[derive(Clone, Debug, Deserialize, PartialEq, Serialize, ToSchema)]
pub struct MobileRobotSummary {
    /// The robot's id.
    pub id: String,
    /// Whether its heartbeats come.
    pub connected: bool,
    /// The operating mode it last told.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub mode: Option<OperatingMode>,
    /// The order it works on, as it last told.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub order: Option<Uuid>,
}

/// What the cell knows of a mobile robot.
#[derive(Clone, Debug, Deserialize, PartialEq, Serialize, ToSchema)]
pub struct MobileRobotState {
    /// The robot's id.
    pub id: String,
    /// The cell.
    pub cell: String,
    /// Whether its heartbeats come.
    pub connected: bool,
    /// When its last signal came.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub last_signal_at: Option<Timestamp>,
    /// The number of its last start.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub boot: Option<u64>,
    /// The number of its last signal in that start.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub seq: Option<u64>,
    /// What it last told of itself.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub data: Option<SignalData>,
    /// The hand-over session it takes part in.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub session: Option<Uuid>,
    /// Whether it may move in the zone of that session's point.
    pub move_permit: bool,
    /// How many messages it has not acknowledged.
    pub unacknowledged: usize,
}

#[cfg(test)]
mod tests {
    use super::*;

    const MESSAGE: &str = r#"{"n":7,"at":"2026-01-01T00:00:00Z","session":null,"kind":"TRANSPORT_ORDER",
        "order":"0190f3a2-0000-7000-8000-000000000001","update":2,"goal":"s1/p1",
        "dock":{"x_mm":1.0,"y_mm":2.0,"heading_deg":90.0},"route":[{"x_mm":0.5,"y_mm":0.0}],"then_to":null}"#;

    #[test]
    fn a_message_keeps_its_shape() {
        let message: OutboxMessage = serde_json::from_str(MESSAGE).unwrap();
        assert_eq!(message.n, 7);
        assert_eq!(message.message.kind(), "TRANSPORT_ORDER");
        let again = serde_json::to_value(&message).unwrap();
        let wanted: serde_json::Value = serde_json::from_str(MESSAGE).unwrap();
        assert_eq!(again, wanted);
    }

    #[test]
    fn every_kind_is_written_as_it_is_named() {
        let order = Uuid::nil();
        let kinds = [
            MobileMessage::MovePermit { granted: true },
            MobileMessage::CellReady,
            MobileMessage::TransferDone,
            MobileMessage::TransferFailed,
            MobileMessage::ExitGranted,
            MobileMessage::CancelOrder { order },
            MobileMessage::StartPause,
            MobileMessage::StopPause,
            MobileMessage::Retry,
            MobileMessage::SkipRetry,
            MobileMessage::StateRequest,
        ];
        for message in kinds {
            assert_eq!(
                serde_json::to_value(&message).unwrap()["kind"],
                message.kind()
            );
        }
        for signal in SignalName::ALL {
            assert_eq!(serde_json::to_value(signal).unwrap(), signal.as_str());
        }
    }

    #[test]
    fn a_signal_with_a_key_too_many_or_too_few_is_refused() {
        let data = r#"{"pose":{"x_mm":0,"y_mm":0,"heading_deg":0},"driving":false,"localized":true,
            "battery_percent":90,"mode":"AUTOMATIC","loads":[],"order":null,"at_point":null,"errors":[]}"#;
        let good = format!(
            r#"{{"session":null,"seq":1,"boot":1,"signal":"MR_MODE","at":"2026-01-01T00:00:00Z","data":{data}}}"#
        );
        assert!(serde_json::from_str::<SignalBody>(&good).is_ok());
        for (from, to) in [
            ("\"seq\":1", "\"seq\":1,\"sequence\":1"),
            ("\"seq\":1,", ""),
            ("\"driving\":false", "\"driving\":false,\"moving\":false"),
            ("MR_MODE", "MR_MODUS"),
            ("AUTOMATIC", "automatic"),
        ] {
            let bad = good.replace(from, to);
            assert!(serde_json::from_str::<SignalBody>(&bad).is_err(), "{bad}");
        }
    }

    #[test]
    fn no_loads_told_is_not_no_loads() {
        let data = |loads: &str| {
            let text = format!(
                r#"{{"pose":{{"x_mm":0,"y_mm":0,"heading_deg":0}},"driving":false,"localized":true,
                "battery_percent":90,"mode":"AUTOMATIC",{loads}"order":null,"at_point":null,"errors":[]}}"#
            );
            serde_json::from_str::<SignalData>(&text).unwrap()
        };
        assert_eq!(data("").loads, None);
        assert_eq!(data(r#""loads":[],"#).loads, Some(Vec::new()));
        for same in ["", r#""loads":[],"#] {
            let again = serde_json::to_value(data(same)).unwrap();
            assert_eq!(again.get("loads").is_some(), !same.is_empty());
        }
    }
}
