//! What happens in a cell, as a stream of server-sent events.

use jiff::Timestamp;
use serde::{Deserialize, Serialize};
use serde_json::{Map, Value};
use utoipa::{IntoParams, ToSchema};
use uuid::Uuid;

/// What a stream of events is asked for.
#[derive(Clone, Debug, Default, Deserialize, IntoParams, PartialEq, Serialize)]
#[serde(deny_unknown_fields)]
#[into_params(parameter_in = Query)]
pub struct EventsQuery {
    /// The id of the last event the caller has, `<epoch>-<position>`; `0-0`: everything that is kept. Absent: only what
    /// happens from now on. The header `Last-Event-ID` counts before it.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub from: Option<String>,
    /// Only events of these types, with a comma between; `robocell.job` stands for all that begin with `robocell.job.`.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub types: Option<String>,
    /// Only events that belong to this job.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub job: Option<Uuid>,
    /// Also the state of the cell each time it changes, as `event: status`: the newest only, some times a second.
    #[serde(default)]
    pub status: bool,
}

/// Something that happened, in the form of `CloudEvents` 1.0.
#[derive(Clone, Debug, Deserialize, PartialEq, Serialize, ToSchema)]
#[schema(example = json!({
    "specversion": "1.0", "id": "3-120-1", "source": "/api/v1/cells/demo", "type": "robocell.session.state",
    "time": "2026-01-01T00:00:00Z", "subject": "jobs/0190f3a2-0000-7000-8000-000000000001",
    "datacontenttype": "application/json",
    "data": {"text": "the hand-over at handover/front is DOCKED", "job": "0190f3a2-0000-7000-8000-000000000001"}
}))]
pub struct CellEvent {
    /// `1.0`.
    pub specversion: String,
    /// Its place in the journal, `<epoch>-<position>`, and its number in the record there. The same event has the same
    /// id whenever it is sent.
    pub id: String,
    /// The cell.
    pub source: String,
    /// What kind: `robocell.job.state`, for example. There may be more kinds later.
    #[serde(rename = "type")]
    pub event_type: String,
    /// When it was recorded.
    pub time: Timestamp,
    /// What it is about, e.g. `jobs/<id>`.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub subject: Option<String>,
    /// `application/json`.
    pub datacontenttype: String,
    /// What happened.
    pub data: CellEventData,
}

/// What an event says.
#[derive(Clone, Debug, Deserialize, PartialEq, Serialize, ToSchema)]
pub struct CellEventData {
    /// A sentence for people.
    pub text: String,
    /// The job it belongs to.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub job: Option<Uuid>,
    /// What was recorded, by name.
    #[serde(flatten)]
    #[schema(value_type = Object)]
    pub more: Map<String, Value>,
}

/// Events are missing: `event: gap`. What is known of the cell has to be fetched anew.
#[derive(Clone, Debug, Deserialize, Eq, PartialEq, Serialize, ToSchema)]
#[schema(example = json!({"reason": "SLOW", "from": "3-120", "to": "3-9000"}))]
pub struct EventGap {
    /// Why.
    pub reason: GapReason,
    /// The last event before the gap, as the caller named it or was sent it.
    pub from: String,
    /// Events follow from behind this one.
    pub to: String,
}

/// Why events are missing.
#[derive(Clone, Copy, Debug, Deserialize, Eq, PartialEq, Serialize, ToSchema)]
#[serde(rename_all = "SCREAMING_SNAKE_CASE")]
pub enum GapReason {
    /// They are no longer kept.
    Forgotten,
    /// The id is of another journal, or of none.
    OtherJournal,
    /// The caller read too slowly.
    Slow,
}

/// The state of a cell in short: `event: status`.
#[derive(Clone, Debug, Default, Deserialize, PartialEq, Serialize, ToSchema)]
pub struct CellStatus {
    /// Jobs that are not over, oldest first.
    pub jobs: Vec<JobStatus>,
    /// The load-handling points where arms work.
    pub points: Vec<PointStatus>,
    /// Where each load is.
    pub loads: Vec<LoadStatus>,
    /// Questions that wait for a person.
    pub questions: Vec<String>,
}

/// A job in short.
#[derive(Clone, Debug, Deserialize, PartialEq, Serialize, ToSchema)]
pub struct JobStatus {
    /// The job.
    pub job: Uuid,
    /// Its number in the order of creation.
    pub number: u64,
    /// Its state, e.g. `EXECUTE`.
    pub state: String,
    /// What it is at, e.g. `APPROACH`.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub phase: Option<String>,
    /// The phase's row, e.g. `A8`.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub code: Option<String>,
    /// The waits that run.
    pub timers: Vec<TimerStatus>,
}

/// A wait that runs.
#[derive(Clone, Debug, Deserialize, PartialEq, Serialize, ToSchema)]
pub struct TimerStatus {
    /// Which.
    pub timer: String,
    /// What is left of it, in milliseconds of the cell's time.
    pub left_ms: u64,
    /// All of it.
    pub total_ms: u64,
}

/// A load-handling point in short.
#[derive(Clone, Debug, Deserialize, Eq, PartialEq, Serialize, ToSchema)]
pub struct PointStatus {
    /// `station/point`.
    pub point: String,
    /// Whether the arm may enter its zone (`ARM_ENTRY_PERMIT`).
    pub arm_entry_permit: bool,
    /// Whether the mobile robot may move in it (`MR_MOVE_PERMIT`). Never both.
    pub mr_move_permit: bool,
    /// The state of the hand-over that is going on there, e.g. `DOCKED`.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub session: Option<String>,
}

/// A load in short.
#[derive(Clone, Debug, Deserialize, Eq, PartialEq, Serialize, ToSchema)]
pub struct LoadStatus {
    /// The load.
    pub load: String,
    /// Where it is, for people; `UNKNOWN` where nobody knows.
    pub at: String,
}
