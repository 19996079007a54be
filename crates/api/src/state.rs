use jiff::Timestamp;
use serde::{Deserialize, Serialize};
use utoipa::ToSchema;
use uuid::Uuid;

use crate::{JointsBody, PoseBody, ProblemCode, Tier};

/// What the server knows of a robot now.
#[derive(Clone, Debug, Deserialize, PartialEq, Serialize, ToSchema)]
pub struct RobotState {
    /// The robot's id.
    pub id: String,
    /// The cell.
    pub cell: String,
    /// What its controller can promise.
    pub tier: Tier,
    /// The link to the controller.
    pub link: LinkStatus,
    /// The tool center point, where it is known.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub pose: Option<PoseBody>,
    /// Where `pose` comes from.
    pub pose_source: PoseSource,
    /// What the controller says of itself, where its program reports it.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub controller: Option<ControllerState>,
    /// Commands waiting for the link.
    pub queued: usize,
    /// How many commands may wait.
    pub queue_capacity: usize,
    /// The last motion taken, whatever became of it.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub last_motion: Option<Uuid>,
    /// Counts the changes of what the server knows of the robot's motions: what a motion may `expect`.
    #[serde(default)]
    pub revision: u64,
}

/// Where a reported pose comes from.
#[derive(Clone, Copy, Debug, Deserialize, Eq, PartialEq, Serialize, ToSchema)]
#[serde(rename_all = "snake_case")]
pub enum PoseSource {
    /// No pose is known.
    Unknown,
    /// The target of the last accepted command. The arm may still be on its way, or have been moved by hand.
    LastAcceptedTarget,
    /// The controller's own report. `controller.age_ms` says how old it is.
    Controller,
}

/// What a controller last said of itself.
#[derive(Clone, Debug, Deserialize, PartialEq, Serialize, ToSchema)]
#[expect(
    clippy::struct_excessive_bools,
    reason = "these are the controller's flags, one for one"
)]
pub struct ControllerState {
    /// How long ago it said so, in milliseconds.
    pub age_ms: u64,
    /// The joint values, as on the pendant.
    pub joints: JointsBody,
    /// The arm moves.
    pub moving: bool,
    /// A motion is on hold.
    pub held: bool,
    /// The key switch.
    pub mode: OperationalMode,
    /// The teach pendant is enabled.
    pub pendant_enabled: bool,
    /// The alarm, e.g. `11-050` (facility and number), where there is one.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub alarm: Option<String>,
    /// The general override in percent.
    pub speed_override_percent: u8,
    /// The active user frame's number.
    pub user_frame: u8,
    /// The active tool's number.
    pub tool: u8,
    /// The dead-man stopped a motion, because the server's heartbeat failed to come.
    pub dead_man: bool,
    /// The levels of DO1 to DO8.
    pub outputs: [bool; 8],
    /// The levels of DI1 to DI8.
    pub inputs: [bool; 8],
    /// Counts the starts of the controller.
    pub boot: u32,
    /// Why no motion would be sent now, in words.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub not_ready: Option<String>,
}

/// The operational mode of a robot, in the words of ISO 10218 and OPC UA Robotics.
#[derive(Clone, Copy, Debug, Deserialize, Eq, PartialEq, Serialize, ToSchema)]
#[serde(rename_all = "SCREAMING_SNAKE_CASE")]
pub enum OperationalMode {
    /// T1: by hand, at most 250 mm/s.
    ManualReducedSpeed,
    /// T2: by hand, at full speed.
    ManualHighSpeed,
    /// AUTO.
    Automatic,
}

/// The link to a controller.
#[derive(Clone, Debug, Deserialize, PartialEq, Serialize, ToSchema)]
pub struct LinkStatus {
    /// The link's state.
    pub state: LinkState,
    /// When the controller last answered.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub last_answer_at: Option<Timestamp>,
    /// What went wrong last, if the last command failed.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub last_failure: Option<ProblemCode>,
}

/// The state of a link.
///
/// A seed controller takes one connection a command, so between commands nothing is open: `untried`, `busy`,
/// `answering`. A `cell_server` controller is watched all the time: `connecting`, `monitor`, `control`.
#[derive(Clone, Copy, Debug, Deserialize, Eq, PartialEq, Serialize, ToSchema)]
#[serde(rename_all = "snake_case")]
pub enum LinkState {
    /// No command has been sent yet.
    Untried,
    /// A command is on its way.
    Busy,
    /// The last command was answered.
    Answering,
    /// The last connection was refused or timed out.
    Disconnected,
    /// The last command was sent and not answered in a way that tells; or the controller answers late.
    Degraded,
    /// A connection is being made.
    Connecting,
    /// The controller is watched, and no motion would be sent now.
    Monitor,
    /// The controller is watched and takes motions.
    Control,
}
