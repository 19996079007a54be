//! What the panel and tests see of a controller.

use std::net::SocketAddr;

use serde::{Deserialize, Serialize};

use crate::fidelity::{ControllerGeneration, Fidelity};
use crate::gripper::GripperView;
use crate::hardware::operator::OperatingMode;
use crate::ledger::{JointsDeg, PoseMmDeg};
use crate::ports::PortView;

/// A snapshot of one controller.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, utoipa::ToSchema)]
#[expect(
    clippy::struct_excessive_bools,
    reason = "each is a lamp or a switch of its own, and the JSON names it"
)]
pub struct State {
    /// The controller's name.
    pub controller: String,
    /// The arm's model.
    pub model: String,
    /// Controller time since the first power-on.
    pub time_s: f64,
    /// How often the power was switched off and on.
    pub power_cycles: u32,
    /// Where the joints are.
    pub joints_deg: JointsDeg,
    /// The limits of the joints.
    pub limits_deg: Vec<JointLimit>,
    /// The tool center point in the user frame.
    pub pose: PoseMmDeg,
    /// The branch of the inverse kinematics, such as `N U T, 0, 0, 0`.
    pub configuration: String,
    /// Whether the arm moves.
    pub moving: bool,
    /// Whether a motion is held on its way.
    #[serde(default)]
    pub held: bool,
    /// The mode switch.
    #[serde(default)]
    pub mode: OperatingMode,
    /// Whether the teach pendant is enabled.
    #[serde(default)]
    pub pendant_enabled: bool,
    /// Whether the emergency stop is pressed.
    #[serde(default)]
    pub emergency_stop: bool,
    /// Whether the operator holds everything.
    #[serde(default)]
    pub hold: bool,
    /// The gripper, if there is one.
    #[serde(default)]
    pub gripper: Option<GripperView>,
    /// Whether the power is on.
    #[serde(default)]
    pub power_on: bool,
    /// Whether the servos have power.
    #[serde(default)]
    pub servo_power: bool,
    /// Whether tasks pause after each line.
    #[serde(default)]
    pub single_step: bool,
    /// Whether nothing will happen without something from outside.
    #[serde(default)]
    pub idle: bool,
    /// How many injected faults are active.
    #[serde(default)]
    pub faults: usize,
    /// The general override.
    pub override_percent: i32,
    /// Motions running and waiting: 0 to 2.
    pub motion_queue: usize,
    /// The KAREL tasks.
    pub tasks: Vec<TaskState>,
    /// The server tags that were used.
    pub tags: Vec<TagView>,
    /// The I/O ports that are not off.
    pub ports: Vec<PortView>,
    /// How much the controller says about itself.
    #[serde(default)]
    pub fidelity: Fidelity,
    /// The generation of the controller.
    #[serde(default)]
    pub generation: ControllerGeneration,
    /// Number of the newest note; a faithful controller has none.
    #[serde(default)]
    pub note_seq: u64,
    /// How many alarms wait for a reset.
    pub active_alarms: usize,
    /// Number of the newest ledger entry.
    pub ledger_seq: u64,
}

/// The limits of one joint.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, utoipa::ToSchema)]
pub struct JointLimit {
    /// `J1` to `J6`.
    pub joint: String,
    /// Lower limit.
    pub min_deg: f64,
    /// Upper limit.
    pub max_deg: f64,
}

/// One task.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize, utoipa::ToSchema)]
pub struct TaskState {
    /// The task: its root program.
    pub name: String,
    /// The program whose routine runs now.
    pub program: String,
    /// `running`, `waiting`, `ended` or `aborted`.
    pub state: TaskWord,
    /// The source line.
    pub line: u32,
    /// What it waits for, or the error that ended it.
    pub detail: Option<String>,
    /// Of a kind controller: why that may take long.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub hint: Option<String>,
}

/// What a task does.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, utoipa::ToSchema)]
#[serde(rename_all = "lowercase")]
pub enum TaskWord {
    /// It has statements to execute.
    Running,
    /// It waits.
    Waiting,
    /// It ended.
    Ended,
    /// An error ended it.
    Aborted,
}

/// One server tag.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize, utoipa::ToSchema)]
pub struct TagView {
    /// `S1:` to `S8:`.
    pub tag: String,
    /// The port as the program knows it.
    pub port: Option<u16>,
    /// `idle`, `listening`, `connected` or `failed`.
    pub state: String,
    /// The client.
    #[schema(value_type = Option<String>)]
    pub peer: Option<SocketAddr>,
}
