use serde::{Deserialize, Serialize};
use utoipa::ToSchema;

/// What a check of a set-up found: every taught pose planned, every route measured.
#[derive(Clone, Debug, Deserialize, PartialEq, Serialize, ToSchema)]
pub struct SetupCheck {
    /// Whether nothing is wrong. Warnings do not count.
    pub passed: bool,
    /// The revision that was checked; absent where the request brought its own set-up.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub revision: Option<u64>,
    /// A line for each taught pose, in the order of the set-up.
    pub taught_poses: Vec<TaughtPoseCheck>,
    /// A line for each route, in the order of the set-up.
    pub routes: Vec<RouteCheck>,
    /// What belongs to none of them.
    pub findings: Vec<CheckFinding>,
}

/// How much a finding weighs.
#[derive(Clone, Copy, Debug, Deserialize, Eq, PartialEq, Serialize, ToSchema)]
#[serde(rename_all = "SCREAMING_SNAKE_CASE")]
pub enum Severity {
    /// It will not work.
    Error,
    /// It works; somebody should look at it.
    Warning,
}

/// Something a check found.
#[derive(Clone, Debug, Deserialize, PartialEq, Serialize, ToSchema)]
pub struct CheckFinding {
    /// How much it weighs.
    pub severity: Severity,
    /// What it is about, e.g. `taught-poses/r1/rack/a approach`.
    pub item: String,
    /// What was found, with value and limit.
    pub message: String,
}

/// A taught pose, planned: for a place on a mobile robot at the nominal dock pose and at every corner of the tolerance.
#[derive(Clone, Debug, Deserialize, PartialEq, Serialize, ToSchema)]
pub struct TaughtPoseCheck {
    /// The arm's id.
    pub arm: String,
    /// The place's id.
    pub place: String,
    /// Whether the pose, its approach, its lift and the ways from and to the safe pose are all possible.
    pub passed: bool,
    /// How many dock poses were tried; 1 for a place that stands still.
    pub dock_poses: u32,
    /// How many samples of the paths were checked.
    pub samples: u32,
    /// The joint that comes closest to a limit, over all samples.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub joint: Option<JointMarginBody>,
    /// The smallest distance from a singularity over all samples of the straight paths, 0 to 1; below the threshold is
    /// an error.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub singularity: Option<f64>,
    /// The keep-out zone the arm comes closest to; absent where there is none.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub keep_out: Option<ZoneMargin>,
    /// How far inside the arm's work areas its tool center point stays; absent where it has none.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub work: Option<ZoneMargin>,
    /// What is wrong, or close to it.
    pub findings: Vec<CheckFinding>,
}

/// The joint closest to its limit.
#[derive(Clone, Debug, Deserialize, PartialEq, Serialize, ToSchema)]
pub struct JointMarginBody {
    /// `J1` to `J6`.
    pub joint: String,
    /// The value there, in degrees.
    pub value_deg: f64,
    /// The distance to the nearer limit, in degrees; negative outside.
    pub margin_deg: f64,
}

/// A zone and the distance to it.
#[derive(Clone, Debug, Deserialize, PartialEq, Serialize, ToSchema)]
pub struct ZoneMargin {
    /// The zone's id.
    pub zone: String,
    /// The margin in millimeters; negative where the zone is violated.
    pub margin_mm: f64,
}

/// A route, measured.
#[derive(Clone, Debug, Deserialize, PartialEq, Serialize, ToSchema)]
pub struct RouteCheck {
    /// Its id.
    pub route: String,
    /// Whether every mobile robot that may take it stays out of its keep-out zones.
    pub passed: bool,
    /// Its length, in millimeters.
    pub length_mm: f64,
    /// The keep-out zone the footprint comes closest to, whichever way the robot faces; absent where there is none.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub keep_out: Option<ZoneMargin>,
    /// What is wrong, or close to it.
    pub findings: Vec<CheckFinding>,
}
