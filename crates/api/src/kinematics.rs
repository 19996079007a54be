use serde::{Deserialize, Serialize};
use utoipa::ToSchema;

use crate::{JointsBody, PoseBody};

/// Joint values whose pose is asked for.
#[derive(Clone, Debug, Deserialize, PartialEq, Serialize, ToSchema)]
#[serde(deny_unknown_fields)]
#[schema(example = json!({
    "joints": {"j1_deg": 0, "j2_deg": 0, "j3_deg": 0, "j4_deg": 0, "j5_deg": -90, "j6_deg": 0}
}))]
pub struct ForwardBody {
    /// Joint values as on the pendant.
    pub joints: JointsBody,
}

/// The pose at given joint values.
#[derive(Clone, Debug, Deserialize, PartialEq, Serialize, ToSchema)]
pub struct ForwardResult {
    /// The tool center point in the robot's user frame.
    pub pose: PoseBody,
    /// The configuration, e.g. `N U T, 0, 0, 0`.
    pub configuration: String,
    /// Whether every joint is inside its limits.
    pub within_limits: bool,
    /// Every joint with its margin, J1 first.
    pub margins: Vec<JointMargin>,
    /// How close to a singularity.
    pub singularity: SingularityBody,
}

/// A pose whose joint values are asked for.
#[derive(Clone, Debug, Deserialize, PartialEq, Serialize, ToSchema)]
#[serde(deny_unknown_fields)]
#[schema(example = json!({
    "pose": {"x_mm": 985, "y_mm": 0, "z_mm": 940, "w_deg": -180, "p_deg": 0, "r_deg": 0}
}))]
pub struct InverseBody {
    /// The tool center point in the robot's user frame.
    pub pose: PoseBody,
    /// The present joints: `nearest` is chosen next to them. The home joints where absent.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub near: Option<JointsBody>,
}

/// Every branch that reaches a pose.
#[derive(Clone, Debug, Deserialize, PartialEq, Serialize, ToSchema)]
pub struct InverseResult {
    /// The branches, those inside the limits first, nearest first.
    pub branches: Vec<BranchBody>,
    /// Index of the branch nearest to the present joints and inside the limits.
    pub nearest: usize,
    /// Index of the branch the controller's program would take (its kept configuration), if it is inside the limits.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub controller: Option<usize>,
}

/// One inverse-kinematics solution.
#[derive(Clone, Debug, Deserialize, PartialEq, Serialize, ToSchema)]
pub struct BranchBody {
    /// Joint values as on the pendant.
    pub joints: JointsBody,
    /// The configuration, e.g. `F D B, 0, 0, 0`.
    pub configuration: String,
    /// Whether every joint is inside its limits.
    pub within_limits: bool,
    /// Every joint with its margin, J1 first.
    pub margins: Vec<JointMargin>,
    /// How close to a singularity.
    pub singularity: SingularityBody,
    /// The largest joint difference to the present joints, in degrees.
    pub distance_deg: f64,
}

/// A joint, its limits, and how far inside them it is.
#[derive(Clone, Debug, Deserialize, PartialEq, Serialize, ToSchema)]
pub struct JointMargin {
    /// `J1` to `J6`.
    pub joint: String,
    /// The value in degrees.
    pub value_deg: f64,
    /// Lower limit in degrees.
    pub min_deg: f64,
    /// Upper limit in degrees.
    pub max_deg: f64,
    /// Distance to the nearer limit in degrees; negative outside.
    pub margin_deg: f64,
}

/// Three measures from 0 (singular) to 1 (farthest from it).
#[derive(Clone, Debug, Deserialize, PartialEq, Serialize, ToSchema)]
pub struct SingularityBody {
    /// Joints 4 and 6 in line.
    pub wrist: f64,
    /// The wrist center on joint 1's axis.
    pub shoulder: f64,
    /// The arm stretched out or folded.
    pub elbow: f64,
    /// Whether any of the three is below its threshold.
    pub singular: bool,
}
