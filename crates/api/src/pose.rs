use serde::{Deserialize, Serialize};
use utoipa::ToSchema;

/// A pose: millimeters, and degrees about the fixed X, Y and Z axes, R = Rz(r) · Ry(p) · Rx(w).
#[derive(Clone, Copy, Debug, Deserialize, PartialEq, Serialize, ToSchema)]
#[serde(deny_unknown_fields)]
#[schema(example = json!({"x_mm": 985, "y_mm": 0, "z_mm": 940, "w_deg": -180, "p_deg": 0, "r_deg": 0}))]
pub struct PoseBody {
    /// X in millimeters.
    #[schema(minimum = -1_000_000, maximum = 1_000_000)]
    pub x_mm: f64,
    /// Y in millimeters.
    #[schema(minimum = -1_000_000, maximum = 1_000_000)]
    pub y_mm: f64,
    /// Z in millimeters.
    #[schema(minimum = -1_000_000, maximum = 1_000_000)]
    pub z_mm: f64,
    /// W, the rotation about the fixed X axis, in degrees.
    #[schema(minimum = -36_000, maximum = 36_000)]
    pub w_deg: f64,
    /// P, the rotation about the fixed Y axis, in degrees.
    #[schema(minimum = -36_000, maximum = 36_000)]
    pub p_deg: f64,
    /// R, the rotation about the fixed Z axis, in degrees.
    #[schema(minimum = -36_000, maximum = 36_000)]
    pub r_deg: f64,
}

/// X, Y, Z, W, P, R.
impl From<[f64; 6]> for PoseBody {
    fn from([x_mm, y_mm, z_mm, w_deg, p_deg, r_deg]: [f64; 6]) -> Self {
        Self {
            x_mm,
            y_mm,
            z_mm,
            w_deg,
            p_deg,
            r_deg,
        }
    }
}

impl From<PoseBody> for [f64; 6] {
    fn from(pose: PoseBody) -> Self {
        let PoseBody {
            x_mm,
            y_mm,
            z_mm,
            w_deg,
            p_deg,
            r_deg,
        } = pose;
        [x_mm, y_mm, z_mm, w_deg, p_deg, r_deg]
    }
}

/// Joint values as the teach pendant shows them, in degrees (J3 against the horizontal).
#[derive(Clone, Copy, Debug, Deserialize, PartialEq, Serialize, ToSchema)]
#[serde(deny_unknown_fields)]
#[schema(example = json!({"j1_deg": 0, "j2_deg": 0, "j3_deg": 0, "j4_deg": 0, "j5_deg": -90, "j6_deg": 0}))]
pub struct JointsBody {
    /// J1 in degrees.
    #[schema(minimum = -36_000, maximum = 36_000)]
    pub j1_deg: f64,
    /// J2 in degrees.
    #[schema(minimum = -36_000, maximum = 36_000)]
    pub j2_deg: f64,
    /// J3 in degrees.
    #[schema(minimum = -36_000, maximum = 36_000)]
    pub j3_deg: f64,
    /// J4 in degrees.
    #[schema(minimum = -36_000, maximum = 36_000)]
    pub j4_deg: f64,
    /// J5 in degrees.
    #[schema(minimum = -36_000, maximum = 36_000)]
    pub j5_deg: f64,
    /// J6 in degrees.
    #[schema(minimum = -36_000, maximum = 36_000)]
    pub j6_deg: f64,
}

impl From<[f64; 6]> for JointsBody {
    fn from([j1_deg, j2_deg, j3_deg, j4_deg, j5_deg, j6_deg]: [f64; 6]) -> Self {
        Self {
            j1_deg,
            j2_deg,
            j3_deg,
            j4_deg,
            j5_deg,
            j6_deg,
        }
    }
}

impl From<JointsBody> for [f64; 6] {
    fn from(joints: JointsBody) -> Self {
        let JointsBody {
            j1_deg,
            j2_deg,
            j3_deg,
            j4_deg,
            j5_deg,
            j6_deg,
        } = joints;
        [j1_deg, j2_deg, j3_deg, j4_deg, j5_deg, j6_deg]
    }
}
