use serde::{Deserialize, Serialize};
use utoipa::ToSchema;

use crate::{JointsBody, PoseBody};

/// What the program on the controller lets the server promise.
#[derive(Clone, Copy, Debug, Deserialize, Eq, PartialEq, Serialize, ToSchema)]
#[serde(rename_all = "snake_case")]
pub enum Tier {
    /// Tier 0: the seed program. Single motions end `accepted`; completion is not observable.
    Seed,
    /// Tier 1: the seed program and a status program beside it. Completion is read back from where the arm is; a stop ends
    /// the seed program and starts it again.
    SeedStatus,
    /// Tier 2: the `cell_server` program. Motions are numbered, finish observably, and can be stopped.
    CellServer,
}

/// What a stop does on a robot. It is a functional stop and no emergency stop.
#[derive(Clone, Copy, Debug, Deserialize, Eq, PartialEq, Serialize, ToSchema)]
#[serde(rename_all = "snake_case")]
pub enum StopEffect {
    /// The server sends nothing more; a motion the controller has taken runs to its end.
    IssuesNothingMore,
    /// The running motion ends by a controlled deceleration.
    HaltsMotion,
}

/// What the server can do with a robot, by its controller's program.
#[derive(Clone, Copy, Debug, Deserialize, Eq, PartialEq, Serialize, ToSchema)]
#[expect(
    clippy::struct_excessive_bools,
    reason = "each is a capability of its own, as the API shows them"
)]
pub struct Capabilities {
    /// What a stop does.
    pub stop_effect: StopEffect,
    /// Whether the end of a motion is observed, not assumed.
    pub completion_observable: bool,
    /// Whether the controller reports where it stands.
    pub pose_reported: bool,
    /// Whether a running motion can be held and continued.
    pub hold_and_continue: bool,
    /// Whether the speed override can be set.
    pub speed_override: bool,
    /// Whether motions along a straight line can be asked for.
    pub linear_motion: bool,
    /// Whether digital outputs can be set and inputs read.
    pub digital_io: bool,
}

impl Tier {
    /// What this tier can do.
    #[must_use]
    pub fn capabilities(self) -> Capabilities {
        let observes = match self {
            Self::Seed => false,
            Self::SeedStatus | Self::CellServer => true,
        };
        let commands = match self {
            Self::Seed | Self::SeedStatus => false,
            Self::CellServer => true,
        };
        Capabilities {
            stop_effect: if observes {
                StopEffect::HaltsMotion
            } else {
                StopEffect::IssuesNothingMore
            },
            completion_observable: observes,
            pose_reported: observes,
            hold_and_continue: commands,
            speed_override: observes,
            linear_motion: commands,
            digital_io: commands,
        }
    }
}

/// A cell and its robots.
#[derive(Clone, Debug, Deserialize, PartialEq, Serialize, ToSchema)]
pub struct CellSummary {
    /// The cell's id.
    pub id: String,
    /// A name for people.
    pub name: String,
    /// The robots in it.
    pub robots: Vec<RobotSummary>,
}

/// A robot in a list.
#[derive(Clone, Debug, Deserialize, PartialEq, Serialize, ToSchema)]
pub struct RobotSummary {
    /// The robot's id, unique in its cell.
    pub id: String,
    /// A name for people.
    pub name: String,
    /// The arm model.
    pub model: String,
    /// What its controller can promise.
    pub tier: Tier,
}

/// What a robot is and what it can do.
#[derive(Clone, Debug, Deserialize, PartialEq, Serialize, ToSchema)]
pub struct RobotDescription {
    /// The robot's id.
    pub id: String,
    /// The cell.
    pub cell: String,
    /// A name for people.
    pub name: String,
    /// The arm model's name.
    pub model: String,
    /// Who makes the arm.
    pub manufacturer: String,
    /// What its controller can promise.
    pub tier: Tier,
    /// What the server can do with it.
    pub capabilities: Capabilities,
    /// Where the controller's socket server listens.
    pub controller_address: String,
    /// The joints, J1 first.
    pub joints: Vec<JointDescription>,
    /// The largest distance of the wrist center from the shoulder axis, in millimeters.
    pub reach_mm: f64,
    /// The home joints.
    pub home: JointsBody,
    /// The configuration the controller's program keeps, e.g. `N U T, 0, 0, 0`.
    pub configuration: String,
    /// The tool: tool center point in the flange frame.
    pub tool: PoseBody,
    /// The user frame in the world frame.
    pub user_frame: PoseBody,
    /// The fastest programmed speed this cell allows, in mm/s.
    pub max_speed_mm_s: f64,
}

/// A joint and its limits, as on the pendant.
#[derive(Clone, Debug, Deserialize, PartialEq, Serialize, ToSchema)]
pub struct JointDescription {
    /// `J1` to `J6`.
    pub joint: String,
    /// Lower limit in degrees.
    pub min_deg: f64,
    /// Upper limit in degrees.
    pub max_deg: f64,
    /// Fastest speed in degrees a second.
    pub max_speed_deg_s: f64,
}
