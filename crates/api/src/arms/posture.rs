use serde::{Deserialize, Serialize};
use utoipa::ToSchema;

use super::{ArmSolver, ArmTask};
use crate::PoseBody;

/// The frames that poses are written in. Both are the identity where they are absent; for a robot of a cell, its own.
#[derive(Clone, Debug, Default, Deserialize, PartialEq, Serialize, ToSchema)]
#[serde(deny_unknown_fields)]
pub struct ArmFrames {
    /// `X_WU`: the user frame in the arm's world.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub user_frame: Option<PoseBody>,
    /// `X_FT`: the tool on the flange.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub tool: Option<PoseBody>,
}

impl ArmFrames {
    /// Is nothing said?
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.user_frame.is_none() && self.tool.is_none()
    }
}

/// Joint values whose pose is asked for.
#[derive(Clone, Debug, Deserialize, PartialEq, Serialize, ToSchema)]
#[serde(deny_unknown_fields)]
#[schema(example = json!({"joints_deg_mm": [0, 0, 0, 0, -90, 0]}))]
pub struct ArmForwardBody {
    /// The joints, base first.
    pub joints_deg_mm: Vec<f64>,
    /// The frames of the answer.
    #[serde(default, skip_serializing_if = "ArmFrames::is_empty")]
    pub frames: ArmFrames,
}

/// ZYZ Euler angles: `R = Rz(phi) Ry(theta) Rz(psi)`, textbook (1.11).
#[derive(Clone, Copy, Debug, Deserialize, PartialEq, Serialize, ToSchema)]
pub struct ZyzBody {
    /// The first turn.
    pub phi_deg: f64,
    /// The second, from 0 to 180.
    pub theta_deg: f64,
    /// The third; 0 where theta leaves only the sum or the difference of the other two determined.
    pub psi_deg: f64,
    /// Whether the three are determined: not where theta is 0 or 180.
    pub regular: bool,
}

/// The arm at given joint values. Values outside the ranges have a pose too.
#[derive(Clone, Debug, Deserialize, PartialEq, Serialize, ToSchema)]
pub struct ArmForwardResult {
    /// The tool in the user frame.
    pub tcp: PoseBody,
    /// The tool's rotation in the user frame by ZYZ angles.
    pub tcp_zyz: ZyzBody,
    /// The flange in the user frame.
    pub flange: PoseBody,
    /// The frames 0 to n of the table in the user frame, then the flange and the tool: what a drawing needs.
    pub link_frames: Vec<PoseBody>,
    /// The points that have names in the source (A to F of the five-link arm); empty for other arms.
    pub points: Vec<ArmPoint>,
    /// The arm's shape in the user frame.
    pub capsules: Vec<PlacedCapsule>,
    /// The configuration, such as `N U T, 0, 0, 0`, of an arm that the closed form covers.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub configuration: Option<String>,
    /// Joints outside their ranges; none if the arm can stand so.
    pub outside: Vec<ArmOutside>,
}

/// A point with a name.
#[derive(Clone, Debug, Deserialize, PartialEq, Serialize, ToSchema)]
pub struct ArmPoint {
    /// Its name.
    pub name: String,
    /// Where it is.
    pub at_mm: [f64; 3],
}

/// A capsule of the arm where it is.
#[derive(Clone, Debug, Deserialize, PartialEq, Serialize, ToSchema)]
pub struct PlacedCapsule {
    /// One end of its axis.
    pub from_mm: [f64; 3],
    /// The other end.
    pub to_mm: [f64; 3],
    /// Its radius.
    pub radius_mm: f64,
}

/// A joint beyond its range.
#[derive(Clone, Debug, Deserialize, PartialEq, Serialize, ToSchema)]
pub struct ArmOutside {
    /// Which.
    pub joint: String,
    /// Where it is or would be.
    pub value_deg_mm: f64,
    /// The lowest legal value.
    pub min_deg_mm: f64,
    /// The highest legal value.
    pub max_deg_mm: f64,
}

/// A pose whose joint values are asked for. Exactly one of `pose` and `points` is given.
#[derive(Clone, Debug, Default, Deserialize, PartialEq, Serialize, ToSchema)]
#[serde(deny_unknown_fields)]
#[schema(example = json!({"pose": {"x_mm": 985, "y_mm": 0, "z_mm": 940, "w_deg": 180, "p_deg": 0, "r_deg": 0}}))]
pub struct ArmInverseBody {
    /// The tool in the user frame.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub pose: Option<PoseBody>,
    /// The five-link arm's E and F, as the paper asks for them.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub points: Option<FiveLinkPoints>,
    /// How to solve; the first of the model's solvers where absent.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub method: Option<ArmSolver>,
    /// What of the pose is asked for, by damped least squares only; the model's own where absent.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub task: Option<ArmTask>,
    /// The present joints: branches are ordered by their distance from them, and what a singularity leaves free stays
    /// near them. Home where absent.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub near_deg_mm: Option<Vec<f64>>,
    /// When the search of damped least squares ends.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub search: Option<ArmSearch>,
    /// The frames of the pose.
    #[serde(default, skip_serializing_if = "ArmFrames::is_empty")]
    pub frames: ArmFrames,
}

/// E and F of the five-link arm.
#[derive(Clone, Copy, Debug, Deserialize, PartialEq, Serialize, ToSchema)]
#[serde(deny_unknown_fields)]
pub struct FiveLinkPoints {
    /// E: the last joint.
    pub e_mm: [f64; 3],
    /// F: the end, one link from E.
    pub f_mm: [f64; 3],
}

/// When a search by damped least squares ends.
#[derive(Clone, Copy, Debug, Default, Deserialize, PartialEq, Serialize, ToSchema)]
#[serde(deny_unknown_fields)]
pub struct ArmSearch {
    /// As near as this is there; a nanometer where absent.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schema(minimum = 1e-9, maximum = 100)]
    pub position_tolerance_mm: Option<f64>,
    /// As near as this is there; 6e-8 where absent.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schema(minimum = 1e-10, maximum = 90)]
    pub rotation_tolerance_deg: Option<f64>,
    /// Steps from each start; 200 where absent.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schema(minimum = 1, maximum = 10_000)]
    pub max_steps: Option<u32>,
    /// Starts: `near_deg_mm` first, then points spread over the ranges; 20 where absent.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schema(minimum = 1, maximum = 1000)]
    pub starts: Option<u32>,
}

/// Every joint set that was found for a pose.
#[derive(Clone, Debug, Deserialize, PartialEq, Serialize, ToSchema)]
pub struct ArmInverseResult {
    /// How it was solved.
    pub method: ArmSolver,
    /// What of the pose was asked for.
    pub task: ArmTask,
    /// The joint sets, those inside the ranges first, nearest first.
    pub branches: Vec<ArmBranch>,
    /// Index of the nearest one inside the ranges; absent if there is none.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub nearest: Option<usize>,
    /// Why none is inside the ranges, if so.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub reason: Option<String>,
}

/// One joint set.
#[derive(Clone, Debug, Deserialize, PartialEq, Serialize, ToSchema)]
pub struct ArmBranch {
    /// The joints, base first.
    pub joints_deg_mm: Vec<f64>,
    /// Whether every joint is inside its range.
    pub within_ranges: bool,
    /// Joints beyond their ranges.
    pub outside: Vec<ArmOutside>,
    /// The configuration, such as `N U T, 0, 0, 0`, of an arm that the closed form covers.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub configuration: Option<String>,
    /// The singularities it is at (`wrist`, `shoulder`, `elbow`, `any-d`): there a family of joint sets reaches the pose.
    pub singular: Vec<String>,
    /// How far the forward kinematics of these joints are from the pose, as far as it was asked for.
    pub position_error_mm: f64,
    /// The same for the rotation.
    pub rotation_error_deg: f64,
    /// The largest difference of a joint to the present joints.
    pub distance_deg_mm: f64,
    /// Steps of a search.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub steps: Option<usize>,
}
