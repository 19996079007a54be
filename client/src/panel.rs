//! What a virtual controller's panel tells, as it is written there. Keys this client does not know are ignored.

use api::PoseBody;
use serde::{Deserialize, Serialize};

/// A virtual controller as it stands.
#[derive(Clone, Debug, Deserialize, PartialEq, Serialize)]
pub struct EmulatorState {
    /// The controller's name.
    pub controller: String,
    /// The arm model.
    pub model: String,
    /// Controller time since power-on, in seconds.
    pub time_s: f64,
    /// The joints as on the pendant.
    pub joints_deg: EmulatorJoints,
    /// The limits of the joints, J1 first.
    pub limits_deg: Vec<JointLimit>,
    /// The tool center point in the active user frame.
    pub pose: PoseBody,
    /// The configuration, e.g. `N U T, 0, 0, 0`.
    pub configuration: String,
    /// Whether the arm is moving now.
    pub moving: bool,
    /// Whether a motion is held on its way.
    #[serde(default)]
    pub held: bool,
    /// The mode switch: `T1`, `T2` or `AUTO`.
    #[serde(default)]
    pub mode: String,
    /// Whether the emergency stop is pressed.
    #[serde(default)]
    pub emergency_stop: bool,
    /// Whether the servos have power; `None` if the controller does not tell.
    #[serde(default)]
    pub servo_power: Option<bool>,
    /// `faithful`, as silent as a real controller, or `kind`, which explains itself.
    #[serde(default)]
    pub fidelity: String,
    /// `any`, `v7` or `v9`.
    #[serde(default)]
    pub generation: String,
    /// Number of the newest note.
    #[serde(default)]
    pub note_seq: u64,
    /// How many injected faults are active.
    #[serde(default)]
    pub faults: u64,
    /// The general override in percent.
    pub override_percent: i32,
    /// How many motions run or wait.
    pub motion_queue: u64,
    /// The programs that run.
    pub tasks: Vec<Task>,
    /// The socket tags and who is connected to them.
    pub tags: Vec<Tag>,
    /// How many alarms wait for a reset.
    pub active_alarms: u64,
    /// Number of the newest ledger entry.
    pub ledger_seq: u64,
}

impl EmulatorState {
    /// Whether the arm stands still and will stay so: no motion, none waiting, and nobody connected whose command
    /// could still start one (the seed program answers before it starts the motion).
    #[must_use]
    pub fn is_still(&self) -> bool {
        !self.moving && self.motion_queue == 0 && self.tags.iter().all(|tag| tag.peer.is_none())
    }
}

/// The limits of one joint.
#[derive(Clone, Debug, Deserialize, PartialEq, Serialize)]
pub struct JointLimit {
    /// `J1` to `J6`.
    pub joint: String,
    /// Lower limit in degrees.
    pub min_deg: f64,
    /// Upper limit in degrees.
    pub max_deg: f64,
}

/// Joint values in degrees, as on the pendant.
#[derive(Clone, Copy, Debug, Deserialize, PartialEq, Serialize)]
pub struct EmulatorJoints {
    /// J1 in degrees.
    pub j1: f64,
    /// J2 in degrees.
    pub j2: f64,
    /// J3 in degrees.
    pub j3: f64,
    /// J4 in degrees.
    pub j4: f64,
    /// J5 in degrees.
    pub j5: f64,
    /// J6 in degrees.
    pub j6: f64,
}

impl From<EmulatorJoints> for [f64; 6] {
    fn from(joints: EmulatorJoints) -> Self {
        let EmulatorJoints {
            j1,
            j2,
            j3,
            j4,
            j5,
            j6,
        } = joints;
        [j1, j2, j3, j4, j5, j6]
    }
}

/// A program that runs on the controller.
#[derive(Clone, Debug, Deserialize, PartialEq, Serialize)]
pub struct Task {
    /// The task's name.
    pub name: String,
    /// The program it runs.
    pub program: String,
    /// `running`, `waiting`, `ended` or `aborted`.
    pub state: String,
    /// The source line it stands at.
    pub line: Option<u32>,
    /// What it waits for, or the error that ended it.
    pub detail: Option<String>,
    /// Of a kind controller: why that may take long.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub hint: Option<String>,
}

/// What a kind controller has said about itself.
#[derive(Clone, Debug, Deserialize, PartialEq, Serialize)]
pub struct Notes {
    /// Oldest first.
    pub notes: Vec<Note>,
    /// The cursor for what comes after these.
    #[serde(default)]
    pub next: u64,
}

/// One thing that a kind controller has said.
#[derive(Clone, Debug, Deserialize, PartialEq, Serialize)]
pub struct Note {
    /// Counts from 1.
    pub seq: u64,
    /// Controller time since power-on, in seconds.
    pub time_s: f64,
    /// The program it is about.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub program: Option<String>,
    /// Its source line.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub line: Option<u32>,
    /// One sentence.
    pub text: String,
    /// How often it was said in a row.
    pub times: u64,
}

/// A socket tag of the controller.
#[derive(Clone, Debug, Deserialize, PartialEq, Serialize)]
pub struct Tag {
    /// The tag, e.g. `S3`.
    pub tag: String,
    /// The port the program set.
    pub port: Option<u16>,
    /// `idle`, `listening`, `connected` or `failed`.
    pub state: String,
    /// Who is connected.
    pub peer: Option<String>,
}

/// A log of the controller, as far as it is kept.
#[derive(Clone, Debug, Deserialize, PartialEq, Serialize)]
pub struct Log<T> {
    /// How many older entries are not kept any more.
    pub dropped: u64,
    /// The entries, oldest first.
    pub entries: Vec<T>,
}

/// What the ledger tells of a motion.
#[derive(Clone, Copy, Debug, Deserialize, Eq, Hash, PartialEq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum LedgerEvent {
    /// The arm set out.
    Started,
    /// The arm arrived.
    Finished,
    /// It went around the corner there without standing still; the next motion has taken over.
    Passed,
    /// The controller refused it with an alarm.
    Refused,
    /// It was stopped on its way.
    Cancelled,
    /// The arm stands still on its way, and the motion waits.
    Held,
    /// The motion that was held goes on.
    Resumed,
    /// The gripper closed on a part.
    Gripped,
    /// The gripper let a part go.
    Released,
    /// The part fell out of the gripper.
    Lost,
    /// A person moved the arm with the pendant.
    Jogged,
}

/// One line of the controller's ledger: what it did, whatever it answered.
#[derive(Clone, Debug, Deserialize, PartialEq, Serialize)]
pub struct LedgerEntry {
    /// Counts up by one.
    pub seq: u64,
    /// Controller time since power-on, in seconds.
    pub time_s: f64,
    /// What happened.
    pub event: LedgerEvent,
    /// The motion's number.
    pub motion: u64,
    /// How the arm moves, e.g. `joint`.
    pub kind: String,
    /// The joints at the start, in degrees.
    pub from_deg: Option<EmulatorJoints>,
    /// The joints at the target, or where the arm came to rest, in degrees.
    pub to_deg: Option<EmulatorJoints>,
    /// The target as the program gave it, in the user frame, for the tool.
    pub target_pose: Option<PoseBody>,
    /// Programmed speed in mm/s.
    pub speed_mm_s: f64,
    /// The general override in percent.
    pub override_percent: i32,
    /// The program that asked for it.
    pub program: String,
    /// The source line that asked for it.
    pub line: Option<u32>,
    /// The TCP peer whose command this was.
    pub peer: Option<String>,
    /// The HTTP request whose command this was, where server and emulator run in one process.
    pub request_id: Option<String>,
    /// Why it was refused or cancelled.
    pub alarm: Option<String>,
    /// Seconds from the start to this entry; for `started`, the planned duration.
    pub duration_s: Option<f64>,
}

/// An alarm of the controller.
#[derive(Clone, Debug, Deserialize, PartialEq, Serialize)]
pub struct Alarm {
    /// Counts from 1.
    pub seq: u64,
    /// Controller time since power-on, in seconds.
    pub time_s: f64,
    /// Four letters, e.g. `MOTN`.
    pub facility: String,
    /// The number within the facility.
    pub number: u32,
    /// What is wrong, with names, values and limits.
    pub text: String,
    /// `warn`, `pause` or `abort`.
    pub severity: String,
    /// The program that caused it.
    pub program: Option<String>,
    /// Its source line.
    pub line: Option<u32>,
    /// Not yet reset.
    pub active: bool,
}
