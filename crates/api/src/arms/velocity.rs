use serde::{Deserialize, Serialize};
use utoipa::ToSchema;

use super::{ArmFrames, ArmOutside, ArmTask};
use crate::PoseBody;

/// Joint values whose Jacobians are asked for.
#[derive(Clone, Debug, Deserialize, PartialEq, Serialize, ToSchema)]
#[serde(deny_unknown_fields)]
#[schema(example = json!({"joints_deg_mm": [0, 0, 0, 0, -90, 0]}))]
pub struct ArmJacobianBody {
    /// The joints, base first.
    pub joints_deg_mm: Vec<f64>,
    /// What of the tool's motion counts for rank and manipulability; the model's own where absent.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub task: Option<ArmTask>,
    /// The frames of the answer.
    #[serde(default, skip_serializing_if = "ArmFrames::is_empty")]
    pub frames: ArmFrames,
}

/// A velocity of the tool in the user frame.
#[derive(Clone, Copy, Debug, Deserialize, PartialEq, Serialize, ToSchema)]
#[serde(deny_unknown_fields)]
pub struct ArmTwist {
    /// Of the tool center point.
    pub linear_mm_s: [f64; 3],
    /// About the axes of the user frame.
    pub angular_deg_s: [f64; 3],
}

/// Jacobians and what they say. Rows: x, y, z in millimeters, then the rotation in degrees; columns: the joints, for each
/// degree or millimeter of the displayed value. A matrix is a list of its rows.
#[derive(Clone, Debug, Deserialize, PartialEq, Serialize, ToSchema)]
pub struct ArmJacobianResult {
    /// The geometric one, textbook (1.78): angular velocity about the user frame's axes.
    pub geometric: Vec<Vec<f64>>,
    /// The analytic one with the rates of phi, theta, psi, (1.84) to (1.89); absent where these have none.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub analytic_zyz: Option<Vec<Vec<f64>>>,
    /// Why `analytic_zyz` is absent.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub zyz_singular: Option<String>,
    /// The analytic one with the rates of W, P, R; absent where these have none.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub analytic_wpr: Option<Vec<Vec<f64>>>,
    /// Why `analytic_wpr` is absent.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub wpr_singular: Option<String>,
    /// What of the tool's motion counts below.
    pub task: ArmTask,
    /// The rank of the task's Jacobian.
    pub rank: usize,
    /// The rank of a regular posture.
    pub full_rank: usize,
    /// Singular values of the task's Jacobian without units (lengths as parts of the arm's span, angles in radians),
    /// largest first.
    pub singular_values: Vec<f64>,
    /// Yoshikawa's measure: their product.
    pub manipulability: f64,
    /// The largest divided by the smallest; absent at a singularity.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub condition: Option<f64>,
    /// Of an arm with a spherical wrist: whether its first three joints or its wrist is singular.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub decomposition: Option<ArmDecomposition>,
    /// Motions of the tool that are lost here.
    pub lost: Vec<ArmTwist>,
    /// Joint motions that do not move the tool, in the task.
    pub free_deg_mm_s: Vec<Vec<f64>>,
}

/// The Jacobian of an arm with a spherical wrist, taken apart: `det J = det J11 det J22`, textbook 1.4.5.
#[derive(Clone, Copy, Debug, Deserialize, PartialEq, Serialize, ToSchema)]
pub struct ArmDecomposition {
    /// Of J11, the wrist center's velocity for the first three joints: below 3 the arm is singular (elbow, shoulder).
    pub arm_rank: usize,
    /// Of J22, the flange's angular velocity for the last three joints: below 3 the wrist is.
    pub wrist_rank: usize,
    /// `det J11`, for each radian of the joints.
    pub arm_determinant_mm3: f64,
    /// `det J22`, for each radian of the joints.
    pub wrist_determinant: f64,
}

/// A velocity of the tool whose joint rates are asked for.
#[derive(Clone, Debug, Deserialize, PartialEq, Serialize, ToSchema)]
#[serde(deny_unknown_fields)]
#[schema(example = json!({"joints_deg_mm": [0, 0, 0, 0, -90, 0], "velocity": {"linear_mm_s": [100, 0, 0], "angular_deg_s": [0, 0, 0]}}))]
pub struct ArmRatesBody {
    /// The joints, base first.
    pub joints_deg_mm: Vec<f64>,
    /// The tool's velocity in the user frame.
    pub velocity: ArmTwist,
    /// Rates that the joints should have besides, as far as they do not move the tool: rho of (1.93).
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub null_motion_deg_mm_s: Option<Vec<f64>>,
    /// What of the velocity counts; the model's own where absent.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub task: Option<ArmTask>,
    /// The frames of the velocity.
    #[serde(default, skip_serializing_if = "ArmFrames::is_empty")]
    pub frames: ArmFrames,
}

/// Joint rates.
#[derive(Clone, Debug, Deserialize, PartialEq, Serialize, ToSchema)]
pub struct ArmRatesResult {
    /// The rates, base first.
    pub rates_deg_mm_s: Vec<f64>,
    /// The largest share of a joint's highest speed: above 1 the arm cannot do it.
    pub load: f64,
    /// What of the velocity counted.
    pub task: ArmTask,
    /// The rank of the task's Jacobian.
    pub rank: usize,
}

/// A motion of the tool with a constant velocity. Exactly one of `velocity_mm_s` and `along_tool_mm_s` is given.
#[derive(Clone, Debug, Default, Deserialize, PartialEq, Serialize, ToSchema)]
#[serde(deny_unknown_fields)]
#[schema(example = json!({"start_deg_mm": [0, 0, 0, 0, -90, 0], "velocity_mm_s": [0, 50, -20], "time_s": 2, "steps": 20}))]
pub struct ArmVelocityMotionBody {
    /// The joints at the start, base first.
    pub start_deg_mm: Vec<f64>,
    /// V: in the user frame.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub velocity_mm_s: Option<[f64; 3]>,
    /// The speed along the tool's Z as it is at the start.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schema(exclusive_minimum = 0, maximum = 100_000)]
    pub along_tool_mm_s: Option<f64>,
    /// T: how long.
    #[schema(exclusive_minimum = 0, maximum = 3600)]
    pub time_s: f64,
    /// In how many steps; 100 where absent.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schema(minimum = 1, maximum = 5000)]
    pub steps: Option<u32>,
    /// What of the tool's pose is kept; the model's own where absent.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub task: Option<ArmTask>,
    /// The frames of the velocity and of the answer.
    #[serde(default, skip_serializing_if = "ArmFrames::is_empty")]
    pub frames: ArmFrames,
}

/// A motion with a constant velocity, as far as it goes.
#[derive(Clone, Debug, Deserialize, PartialEq, Serialize, ToSchema)]
pub struct ArmVelocityMotionResult {
    /// The arm from the start to where it ended, all inside the ranges.
    pub samples: Vec<ArmMotionSample>,
    /// Why it ended there.
    pub end: ArmMotionEnd,
    /// The same in words; absent if the whole time was moved.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub detail: Option<String>,
    /// The joint at its range's end, if that is why.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub outside: Option<ArmOutside>,
    /// How long it moved.
    pub moved_s: f64,
}

/// One moment of a motion.
#[derive(Clone, Debug, Deserialize, PartialEq, Serialize, ToSchema)]
pub struct ArmMotionSample {
    /// From the start.
    pub time_s: f64,
    /// The joints, base first.
    pub joints_deg_mm: Vec<f64>,
    /// The tool center point in the user frame.
    pub tcp_mm: [f64; 3],
}

/// Why a motion with a constant velocity ended.
#[derive(Clone, Copy, Debug, Deserialize, Eq, PartialEq, Serialize, ToSchema)]
#[serde(rename_all = "kebab-case")]
pub enum ArmMotionEnd {
    /// All of its time was moved.
    Completed,
    /// A joint would leave its range.
    Limit,
    /// A joint would have to be faster than it can.
    TooFast,
    /// A singular posture, or the end of the reach.
    Singular,
}

/// Taught postures out of which a tool is computed.
#[derive(Clone, Debug, Default, Deserialize, PartialEq, Serialize, ToSchema)]
#[serde(deny_unknown_fields)]
#[schema(example = json!({"tip": [
    {"flange": {"x_mm": 490, "y_mm": 0, "z_mm": 200, "w_deg": 0, "p_deg": 0, "r_deg": 0}},
    {"flange": {"x_mm": 490, "y_mm": 0, "z_mm": 400, "w_deg": 180, "p_deg": 0, "r_deg": 0}},
    {"flange": {"x_mm": 400, "y_mm": 0, "z_mm": 310, "w_deg": 0, "p_deg": 90, "r_deg": 0}}
]}))]
pub struct ArmCalibrationBody {
    /// Three or more, at most 1000, with the tool's tip at one place, the flange turned between them.
    pub tip: Vec<ArmCalibrationPoint>,
    /// The tip at the orient origin: of the six-point method, with the two below.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub orient_origin: Option<ArmCalibrationPoint>,
    /// From the orient origin along the tool's X.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub along_x: Option<ArmCalibrationPoint>,
    /// From the orient origin along the tool's Z.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub along_z: Option<ArmCalibrationPoint>,
}

/// A taught posture. Exactly one of the two is given.
#[derive(Clone, Debug, Default, Deserialize, PartialEq, Serialize, ToSchema)]
#[serde(deny_unknown_fields)]
pub struct ArmCalibrationPoint {
    /// The joints, base first.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub joints_deg_mm: Option<Vec<f64>>,
    /// The flange in the arm's world.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub flange: Option<PoseBody>,
}

/// How a tool was computed.
#[derive(Clone, Copy, Debug, Deserialize, Eq, PartialEq, Serialize, ToSchema)]
#[serde(rename_all = "kebab-case")]
pub enum ArmCalibrationMethod {
    /// The tip only; the tool is turned as the flange is.
    ThreePoint,
    /// The tip and the directions.
    SixPoint,
}

/// The tool that fits the postures.
#[derive(Clone, Debug, Deserialize, PartialEq, Serialize, ToSchema)]
pub struct ArmCalibrationResult {
    /// How it was computed.
    pub method: ArmCalibrationMethod,
    /// `X_FT`: the tool on the flange.
    pub tool: PoseBody,
    /// The place in the arm's world at which the tip stood.
    pub place_mm: [f64; 3],
    /// How far the farthest posture's tip is from it.
    pub worst_mm: f64,
    /// The mean square root of these distances.
    pub mean_mm: f64,
}
