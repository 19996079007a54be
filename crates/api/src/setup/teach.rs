use serde::{Deserialize, Serialize};
use utoipa::ToSchema;

use super::{CalibrationRecord, PlanarPoseBody, PoseFrame, TaughtPoseBody};
use crate::{JointsBody, PoseBody};

/// Teaches a pose: the arm's actual one, or the one given.
#[derive(Clone, Debug, Deserialize, PartialEq, Serialize, ToSchema)]
#[serde(deny_unknown_fields)]
pub struct TeachBody {
    /// The approach begins this far before the pose, in millimeters; as before where absent, 100 for a new pose.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schema(minimum = 1, maximum = 1000)]
    pub approach_mm: Option<f64>,
    /// A gripped load is lifted by this much, in millimeters; as before where absent.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schema(minimum = 1, maximum = 1000)]
    pub lift_mm: Option<f64>,
    /// The frame the pose is kept in; the cell frame where absent.
    #[serde(default)]
    pub frame: PoseFrame,
    /// Where the mobile robot was measured to be docked meanwhile, for a place on one; the nominal pose where absent.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub measured_dock: Option<PlanarPoseBody>,
    /// Where the arm is, said by the caller. Absent: the arm's actual pose, as its controller reports it.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub at: Option<ExplicitPose>,
}

/// Where the arm is, said by the caller: joint values, or a pose with its configuration.
#[derive(Clone, Debug, Deserialize, PartialEq, Serialize, ToSchema)]
#[serde(deny_unknown_fields)]
pub struct ExplicitPose {
    /// Joint values as on the pendant.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub joints: Option<JointsBody>,
    /// The tool center point, in `frame` of the request.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub pose: Option<PoseBody>,
    /// The configuration that goes with `pose`, e.g. `N U T, 0, 0, 0`.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub configuration: Option<String>,
}

/// What was taught.
#[derive(Clone, Debug, Deserialize, PartialEq, Serialize, ToSchema)]
pub struct TeachResult {
    /// The revision of the whole set-up after it.
    pub revision: u64,
    /// The entity tag of the whole set-up.
    pub etag: String,
    /// The pose as it is kept.
    pub taught: TaughtPoseBody,
}

/// Postures of an arm that all hold the tip of the tool at one point: the four-point method.
#[derive(Clone, Debug, Deserialize, PartialEq, Serialize, ToSchema)]
#[serde(deny_unknown_fields)]
pub struct CalibrationBody {
    /// The postures, 4 to 100, with the flange turned about at least two axes.
    pub points: Vec<CalibrationPoint>,
    /// The largest distance between a posture's tip and their mean that is taken, in millimeters; 1 where absent.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schema(minimum = 0.001, maximum = 10)]
    pub max_residual_mm: Option<f64>,
}

/// One posture. Exactly one of the two is given.
#[derive(Clone, Debug, Deserialize, PartialEq, Serialize, ToSchema)]
#[serde(deny_unknown_fields)]
pub struct CalibrationPoint {
    /// Joint values as on the pendant.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub joints: Option<JointsBody>,
    /// The flange (tool 0) in the arm's own world frame.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub flange: Option<PoseBody>,
}

/// The tool center point that fits the postures. Nothing is kept: put it into the tool.
#[derive(Clone, Debug, Deserialize, PartialEq, Serialize, ToSchema)]
pub struct CalibrationResult {
    /// `X_FT`: the center point measured; the orientation of the tool as it is in the set-up, else the flange's.
    pub frame: PoseBody,
    /// How well it fits; what belongs into the tool's `calibration`.
    pub calibration: CalibrationRecord,
    /// Each posture's distance from the mean tip, in millimeters, in the order of the request.
    pub residuals_mm: Vec<f64>,
    /// How far the center point may be off, in millimeters: three times the standard error in its worst direction.
    pub uncertainty_mm: f64,
}
