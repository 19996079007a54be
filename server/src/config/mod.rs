//! The sections of the configuration file that concern the server, as they are written.
//!
//! These structs take what TOML can say; [`Plan::try_new`] checks it and makes what the server runs on.

mod plan;
mod robot;

use std::collections::BTreeMap;
use std::path::PathBuf;

use serde::de::Error as _;
use serde::{Deserialize, Deserializer};

use crate::journal::upkeep;

pub(crate) use plan::MAX_DEADLINE_MS;
pub use plan::{ConfigError, Plan, ServerPlan};
pub use robot::{CellPlan, RobotPlan};
pub(crate) use robot::{FrameNumbers, Tolerance};

/// `[server]`: the listener and its limits.
#[derive(Clone, Debug, Deserialize, PartialEq)]
#[serde(deny_unknown_fields, default)]
pub struct ServerSection {
    /// Where to listen, `address:port`. Port 0 takes any free port.
    pub listen: String,
    /// Whether everybody may do everything without a token. Only where `listen` is a loopback address.
    pub demo: bool,
    /// Whether `listen` may be an address other machines reach. The server speaks plain HTTP: end TLS in front of it.
    pub allow_remote: bool,
    /// Host names callers may use for this server, besides its addresses and `localhost`.
    pub allowed_hosts: Vec<String>,
    /// The robot the seed's own routes drive, `cell/robot`. Where there is only one robot it is that one.
    pub legacy_robot: Option<String>,
    /// The largest request body read, in bytes.
    pub max_body_bytes: u64,
    /// How long the head of a request may take to arrive, in milliseconds.
    pub header_timeout_ms: u64,
    /// How long a connection may idle between two requests, in milliseconds. It may be long: an idle connection gives
    /// way where somebody needs its place.
    pub idle_timeout_ms: u64,
    /// How long a request's body may take to arrive, in milliseconds.
    pub body_timeout_ms: u64,
    /// How long a caller may take nothing of its answer, in milliseconds.
    pub write_timeout_ms: u64,
    /// How long a request may take in all, in milliseconds.
    pub request_timeout_ms: u64,
    /// How long requests may still run after the server was told to stop, in milliseconds.
    pub shutdown_timeout_ms: u64,
    /// How many connections may be open at once, event streams not counted. For a further one, a connection is closed
    /// whose peer keeps the server waiting for a head, a body or for taking its answer; else one that idles; else one
    /// whose request has taken more than a second, and whose command goes on. Each time it is one of the address that
    /// has most of them. Where the process may not open enough files, there are fewer places, and the log says so.
    pub max_connections: u64,
    /// How many connections of one address may keep the server waiting at a time; a further one takes the place of the
    /// oldest of them. Connections that are served, or idle after they were, do not count: behind one address there
    /// may be a whole plant, and on loopback there is everybody.
    pub max_waiting_per_address: u64,
    /// How many streams of events may be open at once; who asks for a further one is told to come back.
    pub max_event_streams: u64,
}

impl Default for ServerSection {
    fn default() -> Self {
        Self {
            listen: "127.0.0.1:8080".to_owned(),
            demo: false,
            allow_remote: false,
            allowed_hosts: Vec::new(),
            legacy_robot: None,
            max_body_bytes: 64 * 1024,
            header_timeout_ms: 5_000,
            idle_timeout_ms: 30_000,
            body_timeout_ms: 10_000,
            write_timeout_ms: 10_000,
            request_timeout_ms: 75_000,
            shutdown_timeout_ms: 10_000,
            max_connections: 256,
            max_waiting_per_address: 32,
            max_event_streams: 64,
        }
    }
}

/// `[identity]`: who may call.
#[derive(Clone, Debug, Deserialize, Eq, PartialEq)]
#[serde(deny_unknown_fields)]
pub struct IdentitySection {
    /// The file of tokens, relative to the configuration file. The first start makes it.
    pub path: PathBuf,
}

/// `[journal]`: what was meant to be done and what became of it.
#[derive(Clone, Debug, Deserialize, PartialEq)]
#[serde(deny_unknown_fields, default)]
pub struct JournalSection {
    /// The file, relative to the configuration's folder. Absent: a journal in memory, of which nothing survives.
    pub path: Option<std::path::PathBuf>,
    /// Whether the file may be on a filesystem that forgets at a power loss, as one in memory.
    pub allow_volatile_filesystem: bool,
    /// Whether the file may be older than one that was open at its place before: a person has put back a backup, and
    /// looks at every robot before it moves.
    pub restored: bool,
    /// MiB held back on the disk beside the file, so that on a full disk what runs gets its end and doubts can be
    /// decided while nothing new begins: 1 to 4096, or 0 for none. 16 where absent.
    #[serde(deserialize_with = "reserve_mib")]
    pub reserve_mib: u16,
    /// Decisions of a cell after which what they amount to is kept, so that a start reads only what came after: 1 to
    /// 1000000. 1000 where absent.
    #[serde(deserialize_with = "upkeep::snapshot_after")]
    pub snapshot_after: u32,
    /// Records older than so many days are removed, 1 to 36500. Absent: none is. What an open job or question, a
    /// motion in doubt or an idempotency key still needs stays in any case.
    #[serde(deserialize_with = "upkeep::keep_days")]
    pub keep_days: Option<u32>,
    /// The newest so many records stay, whatever their age: 1000 to 1000000000. 100000 where absent.
    #[serde(deserialize_with = "upkeep::keep_records")]
    pub keep_records: u32,
    /// The folder, relative to the configuration's, that records are written out to before they are removed. Absent:
    /// they are removed for good.
    pub archive: Option<std::path::PathBuf>,
}

impl Default for JournalSection {
    fn default() -> Self {
        Self {
            path: None,
            allow_volatile_filesystem: false,
            restored: false,
            reserve_mib: 16,
            snapshot_after: upkeep::default_snapshot_after(),
            keep_days: None,
            keep_records: upkeep::default_keep_records(),
            archive: None,
        }
    }
}

const MAX_RESERVE_MIB: u16 = 4_096;

fn reserve_mib<'de, D: Deserializer<'de>>(deserializer: D) -> Result<u16, D::Error> {
    let value = i64::deserialize(deserializer)?;
    u16::try_from(value)
        .ok()
        .filter(|value| *value <= MAX_RESERVE_MIB)
        .ok_or_else(|| {
            D::Error::custom(format!(
                "journal.reserve_mib: {value} is not 0 to {MAX_RESERVE_MIB} MiB"
            ))
        })
}

/// `[[cells]]`: a cell and its robots.
#[derive(Clone, Debug, Deserialize, PartialEq)]
#[serde(deny_unknown_fields)]
pub struct CellSection {
    /// The cell's id: `[a-z0-9][a-z0-9_-]{0,63}`, unique.
    pub id: String,
    /// A name for people; the id where absent.
    pub name: Option<String>,
    /// The robots in it.
    #[serde(default)]
    pub robots: Vec<RobotSection>,
    /// Where the operator's set-up is kept; nothing is set up, and changes are lost at the end, where absent.
    #[serde(default)]
    pub setup: Option<SetupSource>,
    /// Where messages to mobile robots are pushed, `http://host:port/path` by the robot's id. Only here: a URL that
    /// arrived over the API would make the server call whatever its sender likes.
    #[serde(default)]
    pub push_urls: BTreeMap<String, String>,
}

/// Where a cell's set-up is kept.
#[derive(Clone, Debug, Deserialize, PartialEq)]
#[serde(from = "PathBuf")]
pub enum SetupSource {
    /// In a TOML file, which the server rewrites at each change.
    File(PathBuf),
    /// In memory; the TOML text is what it begins with.
    Memory(String),
}

impl From<PathBuf> for SetupSource {
    fn from(path: PathBuf) -> Self {
        Self::File(path)
    }
}

/// `[[cells.robots]]`: a robot and the way to its controller.
#[derive(Clone, Debug, Deserialize, PartialEq)]
#[serde(deny_unknown_fields)]
pub struct RobotSection {
    /// The robot's id: `[a-z0-9][a-z0-9_-]{0,63}`, unique in its cell.
    pub id: String,
    /// A name for people; the id where absent.
    pub name: Option<String>,
    /// The arm model, e.g. `fanuc-m20ia`.
    pub model: String,
    /// Where the controller's socket server listens, `host:port`.
    pub controller: String,
    /// What the program on the controller can promise: `seed`, `seed_status` (with the status program beside it), or
    /// `cell_server`.
    #[serde(default = "seed_tier")]
    pub tier: api::Tier,
    /// Where the controller's status program listens, `host:port`; `controller` with the next port where absent.
    /// A seed controller has none.
    #[serde(default)]
    pub status_controller: Option<String>,
    /// How far from its target a motion may end, in millimeters.
    #[serde(default = "position_tolerance_mm")]
    pub position_tolerance_mm: f64,
    /// How far turned from its target, and how far from its joint values, a motion may end, in degrees.
    #[serde(default = "rotation_tolerance_deg")]
    pub rotation_tolerance_deg: f64,
    /// The number of the user frame that must be active on the controller; any where absent.
    #[serde(default)]
    pub user_frame_number: Option<u8>,
    /// The number of the tool that must be active on the controller; any where absent.
    #[serde(default)]
    pub tool_number: Option<u8>,
    /// How much faster than real time the controller's clock runs: more than 1 for an emulator in fast motion only.
    #[serde(default = "time_scale")]
    pub time_scale: f64,
    /// The configuration the controller's program keeps.
    #[serde(default = "front_flip_up")]
    pub configuration: String,
    /// The tool center point in the flange frame.
    #[serde(default)]
    pub tool: FrameSection,
    /// The user frame in the world frame.
    #[serde(default)]
    pub user_frame: FrameSection,
    /// The fastest programmed speed allowed, in mm/s.
    #[serde(default = "fastest")]
    pub max_speed_mm_s: u64,
    /// How many commands may wait.
    #[serde(default = "queue_capacity")]
    pub queue_capacity: u64,
    /// How long connecting may take, in milliseconds.
    #[serde(default = "connect_timeout_ms")]
    pub connect_timeout_ms: u64,
    /// How long the controller may take to answer once the command is written, in milliseconds.
    #[serde(default = "reply_timeout_ms")]
    pub reply_timeout_ms: u64,
    /// How long a command may take in all, waiting in the queue included, in milliseconds.
    #[serde(default = "deadline_ms")]
    pub deadline_ms: u64,
}

impl RobotSection {
    /// A robot with every optional key at its default.
    pub fn new(
        id: impl Into<String>,
        model: impl Into<String>,
        controller: impl Into<String>,
    ) -> Self {
        Self {
            id: id.into(),
            name: None,
            model: model.into(),
            controller: controller.into(),
            tier: seed_tier(),
            status_controller: None,
            position_tolerance_mm: position_tolerance_mm(),
            rotation_tolerance_deg: rotation_tolerance_deg(),
            user_frame_number: None,
            tool_number: None,
            time_scale: time_scale(),
            configuration: front_flip_up(),
            tool: FrameSection::default(),
            user_frame: FrameSection::default(),
            max_speed_mm_s: fastest(),
            queue_capacity: queue_capacity(),
            connect_timeout_ms: connect_timeout_ms(),
            reply_timeout_ms: reply_timeout_ms(),
            deadline_ms: deadline_ms(),
        }
    }
}

/// A frame: millimeters, and degrees about the fixed X, Y and Z axes. Absent keys are zero.
#[derive(Clone, Copy, Debug, Default, Deserialize, PartialEq)]
#[serde(deny_unknown_fields, default)]
pub struct FrameSection {
    /// X in millimeters.
    pub x_mm: f64,
    /// Y in millimeters.
    pub y_mm: f64,
    /// Z in millimeters.
    pub z_mm: f64,
    /// W in degrees.
    pub w_deg: f64,
    /// P in degrees.
    pub p_deg: f64,
    /// R in degrees.
    pub r_deg: f64,
}

fn seed_tier() -> api::Tier {
    api::Tier::Seed
}

fn position_tolerance_mm() -> f64 {
    0.5
}

fn rotation_tolerance_deg() -> f64 {
    0.1
}

fn time_scale() -> f64 {
    1.0
}

fn front_flip_up() -> String {
    "N U T, 0, 0, 0".to_owned()
}

fn fastest() -> u64 {
    u64::from(protocol::MAX_SPEED)
}

fn queue_capacity() -> u64 {
    16
}

fn connect_timeout_ms() -> u64 {
    1_000
}

fn reply_timeout_ms() -> u64 {
    5_000
}

fn deadline_ms() -> u64 {
    10_000
}
