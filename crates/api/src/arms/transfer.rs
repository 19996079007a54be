use serde::{Deserialize, Serialize};
use utoipa::ToSchema;

use super::{ArmCapsule, ArmFrames, PlacedCapsule};
use crate::PoseBody;

/// A solid in the arm's world, or a space where it must not be.
#[derive(Clone, Debug, Deserialize, PartialEq, Serialize, ToSchema)]
#[serde(tag = "kind", rename_all = "kebab-case", deny_unknown_fields)]
pub enum ArmObstacle {
    /// A box about the middle of its frame.
    Box {
        /// Of its middle.
        pose: PoseBody,
        /// Its full sizes along x, y and z of its frame.
        size_mm: [f64; 3],
    },
    /// A cylinder about the z of its frame.
    Cylinder {
        /// Of its middle.
        pose: PoseBody,
        /// Of its round.
        radius_mm: f64,
        /// From end to end.
        height_mm: f64,
    },
    /// A box along the axes of the world.
    KeepOut {
        /// The corner with the least coordinates.
        min_mm: [f64; 3],
        /// The corner with the greatest.
        max_mm: [f64; 3],
    },
}

/// A way from one joint set to another, or to a pose, that touches nothing. Exactly one of `goal_deg_mm` and `goal_pose`
/// is given.
#[derive(Clone, Debug, Default, Deserialize, PartialEq, Serialize, ToSchema)]
#[serde(deny_unknown_fields)]
#[schema(example = json!({
    "start_deg_mm": [45, 20, -20, 0, -70, 0], "goal_deg_mm": [-45, 20, -20, 0, -70, 0],
    "obstacles": [{"kind": "keep-out", "min_mm": [700, -100, -500], "max_mm": [1000, 100, 500]}]
}))]
pub struct ArmTransferBody {
    /// The joints at the start.
    #[serde(alias = "start_deg")]
    pub start_deg_mm: Vec<f64>,
    /// The joints at the goal.
    #[serde(alias = "goal_deg", default, skip_serializing_if = "Vec::is_empty")]
    pub goal_deg_mm: Vec<f64>,
    /// The tool at the goal, in the user frame. Of the joint sets that reach it the nearest to the start is tried first;
    /// the answer's last point is the one that was taken.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub goal_pose: Option<PoseBody>,
    /// The frames of `goal_pose`.
    #[serde(default, skip_serializing_if = "ArmFrames::is_empty")]
    pub frames: ArmFrames,
    /// What is in the way; at most 100.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub obstacles: Vec<ArmObstacle>,
    /// The arm's shape, at most 32 capsules. The model's own where absent; where it has none, capsules along the lengths
    /// of its table.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub capsules: Option<Vec<ArmCapsule>>,
    /// More capsules, such as those of a tool on the last link.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub tool_capsules: Vec<ArmCapsule>,
    /// How far from an obstacle the arm stays wherever it was looked at; 20 where absent.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schema(minimum = 5, maximum = 1000)]
    pub margin_mm: Option<f64>,
    /// The same seed gives the same way; 0 where absent.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub seed: Option<u64>,
    /// After so many the search is given up; 5000 where absent.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schema(minimum = 1, maximum = 10_000)]
    pub samples: Option<u32>,
}

/// A way that touches nothing: straight pieces of joint space.
#[derive(Clone, Debug, Deserialize, PartialEq, Serialize, ToSchema)]
pub struct ArmTransferResult {
    /// The joint sets between which the joints move evenly, start and goal included.
    pub points_deg_mm: Vec<Vec<f64>>,
    /// The sum of the ways in the space of the joints that turn.
    pub length_deg: f64,
    /// The same of the joints that slide; absent where none does.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub length_mm: Option<f64>,
    /// The flange along the way, in the arm's world, sixteen points for each piece.
    pub flange_mm: Vec<[f64; 3]>,
    /// The arm's shape at each of `points_deg_mm`.
    pub capsules: Vec<Vec<PlacedCapsule>>,
}
