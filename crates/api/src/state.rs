use jiff::Timestamp;
use serde::{Deserialize, Serialize};
use utoipa::ToSchema;
use uuid::Uuid;

use crate::{PoseBody, ProblemCode, Tier};

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
    /// Commands waiting for the link.
    pub queued: usize,
    /// How many commands may wait.
    pub queue_capacity: usize,
    /// The last motion taken, whatever became of it.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub last_motion: Option<Uuid>,
}

/// Where a reported pose comes from.
#[derive(Clone, Copy, Debug, Deserialize, Eq, PartialEq, Serialize, ToSchema)]
#[serde(rename_all = "snake_case")]
pub enum PoseSource {
    /// No pose is known.
    Unknown,
    /// The target of the last accepted command. The arm may still be on its way, or have been moved by hand.
    LastAcceptedTarget,
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

/// The state of a link. A seed controller takes one connection a command, so between commands nothing is open.
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
    /// The last command was sent and not answered in a way that tells.
    Degraded,
}
