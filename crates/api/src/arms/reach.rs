use serde::{Deserialize, Serialize};
use utoipa::ToSchema;

use super::{ArmFrames, ArmSolver, ArmTask};
use crate::PoseBody;

/// The poses whose reachability is asked for. Exactly one of `poses` and `grid` is given.
#[derive(Clone, Debug, Default, Deserialize, PartialEq, Serialize, ToSchema)]
#[serde(deny_unknown_fields)]
#[schema(example = json!({"grid": {"plane": "XZ", "across_mm": 0, "u_mm": [0, 1800], "v_mm": [-800, 1800], "step_mm": 200, "w_deg": 180, "p_deg": 0, "r_deg": 0}}))]
pub struct ReachBody {
    /// Poses of the tool in the user frame. At most 250,000 by the closed form, 20,000 by the quartic and the textbook's
    /// or five-link's formulas, 2000 by damped least squares; the same for the points of a grid.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub poses: Option<Vec<PoseBody>>,
    /// A slice of space.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub grid: Option<ReachGrid>,
    /// How to solve; the first of the model's solvers where absent.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub method: Option<ArmSolver>,
    /// What of the poses is asked for, by damped least squares only; the model's own where absent.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub task: Option<ArmTask>,
    /// The frames of the poses.
    #[serde(default, skip_serializing_if = "ArmFrames::is_empty")]
    pub frames: ArmFrames,
}

/// A plane of the user frame.
#[derive(Clone, Copy, Debug, Deserialize, Eq, PartialEq, Serialize, ToSchema)]
pub enum ReachPlane {
    /// u is x, v is y, across is z.
    #[serde(rename = "XY")]
    Xy,
    /// u is x, v is z, across is y.
    #[serde(rename = "XZ")]
    Xz,
    /// u is y, v is z, across is x.
    #[serde(rename = "YZ")]
    Yz,
}

/// A slice of space, with the tool turned alike everywhere.
#[derive(Clone, Debug, Deserialize, PartialEq, Serialize, ToSchema)]
#[serde(deny_unknown_fields)]
pub struct ReachGrid {
    /// Which plane.
    pub plane: ReachPlane,
    /// Where it is on the third axis.
    pub across_mm: f64,
    /// The least and the greatest u.
    pub u_mm: [f64; 2],
    /// The least and the greatest v.
    pub v_mm: [f64; 2],
    /// From point to point, the greatest u and v only if they are whole steps away.
    #[schema(exclusive_minimum = 0)]
    pub step_mm: f64,
    /// The tool's W.
    pub w_deg: f64,
    /// The tool's P.
    pub p_deg: f64,
    /// The tool's R.
    pub r_deg: f64,
}

/// How the arm reaches each pose, in the order of the request; of a grid row by row, v rising, u rising in each row.
#[derive(Clone, Debug, Deserialize, PartialEq, Serialize, ToSchema)]
pub struct ReachResult {
    /// How it was solved.
    pub method: ArmSolver,
    /// What of the poses was asked for.
    pub task: ArmTask,
    /// The u of each column of a grid.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub u_mm: Vec<f64>,
    /// The v of each row of a grid.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub v_mm: Vec<f64>,
    /// Joint sets that reach each pose, inside the ranges or not. By damped least squares 1 if one was found inside.
    pub solutions: Vec<u8>,
    /// Of these, the ones inside the ranges.
    pub inside: Vec<u8>,
    /// How many poses are reached inside the ranges.
    pub reachable: usize,
}
