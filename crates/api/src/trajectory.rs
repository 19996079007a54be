//! Trajectories of joints, and paths of the tool.

use serde::{Deserialize, Serialize};
use utoipa::ToSchema;

use crate::PoseBody;
use crate::arms::{ArmFrames, ArmOutside, ArmTask};

/// How joints get from start to goal.
#[derive(Clone, Copy, Debug, Deserialize, Eq, PartialEq, Serialize, ToSchema)]
pub enum TrajectoryKind {
    /// A polynomial of fifth degree over a given time, textbook (2.16) to (2.23).
    #[serde(rename = "quintic")]
    Quintic,
    /// Polynomials of degree 4, 3 and 4 through two via points, (2.24) to (2.42).
    #[serde(rename = "4-3-4")]
    FourThreeFour,
    /// Polynomials of degree 3, 5 and 3 through two via points.
    #[serde(rename = "3-5-3")]
    ThreeFiveThree,
    /// The shortest time within speed, acceleration and jerk, all joints arriving together; or exactly a given time.
    #[serde(rename = "jerk-limited")]
    JerkLimited,
    /// Past via points with rounded corners, at rest at both ends.
    #[serde(rename = "blended")]
    Blended,
}

/// Where the joints are and how they move.
#[derive(Clone, Debug, Default, Deserialize, PartialEq, Serialize, ToSchema)]
#[serde(deny_unknown_fields)]
pub struct JointStates {
    /// Base first.
    pub position_deg_mm: Vec<f64>,
    /// At rest where absent.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub velocity_deg_mm_s: Option<Vec<f64>>,
    /// None where absent.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub acceleration_deg_mm_s2: Option<Vec<f64>>,
}

/// A trajectory of the joints of a model.
#[derive(Clone, Debug, Deserialize, PartialEq, Serialize, ToSchema)]
#[serde(deny_unknown_fields)]
#[schema(example = json!({
    "kind": "jerk-limited", "start": {"position_deg_mm": [0, 0, 0, 0, -90, 0]},
    "goal": {"position_deg_mm": [60, 20, -20, 0, -70, 0]}, "period_s": 0.05
}))]
pub struct TrajectoryBody {
    /// How.
    pub kind: TrajectoryKind,
    /// From where.
    pub start: JointStates,
    /// To where.
    pub goal: JointStates,
    /// Joint sets on the way: two for `4-3-4` and `3-5-3`, up to 998 for `blended`.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub via_deg_mm: Vec<Vec<f64>>,
    /// How long each polynomial lasts: one for `quintic`, three for `4-3-4` and `3-5-3`; one, if any, for `jerk-limited`.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub durations_s: Vec<f64>,
    /// The joints' highest speeds; the model's where absent.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub max_velocity_deg_mm_s: Option<Vec<f64>>,
    /// The joints' highest accelerations; the model's where absent.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub max_acceleration_deg_mm_s2: Option<Vec<f64>>,
    /// The joints' highest jerks; ten times the highest acceleration a second where absent.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub max_jerk_deg_mm_s3: Option<Vec<f64>>,
    /// From sample to sample; a hundredth of the whole time where absent. At most 5000 samples.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schema(minimum = 0.0005, maximum = 10)]
    pub period_s: Option<f64>,
    /// The frames of the tool's positions.
    #[serde(default, skip_serializing_if = "ArmFrames::is_empty")]
    pub frames: ArmFrames,
}

/// A trajectory, sampled.
#[derive(Clone, Debug, Deserialize, PartialEq, Serialize, ToSchema)]
pub struct TrajectoryResult {
    /// How.
    pub kind: TrajectoryKind,
    /// The names of the joints, base first.
    pub joints: Vec<String>,
    /// How long it takes.
    pub duration_s: f64,
    /// The joints along it, the first at the start, the last at the end.
    pub samples: Vec<TrajectorySample>,
    /// What it asks of each joint, beside what the joint can do.
    pub peaks: Vec<TrajectoryPeaks>,
    /// Whether all joints keep their ranges, speeds, accelerations and jerks; a polynomial knows no limits.
    pub within_limits: bool,
    /// The joint that the others wait for, of a jerk-limited trajectory.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub slowest: Option<String>,
    /// Via points: when they are passed, and how far away.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub via: Vec<TrajectoryVia>,
}

/// The joints at one moment, base first.
#[derive(Clone, Debug, Deserialize, PartialEq, Serialize, ToSchema)]
pub struct TrajectorySample {
    /// From the start.
    pub time_s: f64,
    /// Positions.
    pub position_deg_mm: Vec<f64>,
    /// Velocities.
    pub velocity_deg_mm_s: Vec<f64>,
    /// Accelerations.
    pub acceleration_deg_mm_s2: Vec<f64>,
    /// Jerks; where one jumps, the mean of both sides. Absent for what is sampled from a tool path.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub jerk_deg_mm_s3: Vec<f64>,
    /// The tool center point in the user frame.
    pub tcp_mm: [f64; 3],
    /// Its speed.
    pub tcp_speed_mm_s: f64,
}

/// What a trajectory asks of a joint at most, and what the joint can do.
#[derive(Clone, Debug, Deserialize, PartialEq, Serialize, ToSchema)]
pub struct TrajectoryPeaks {
    /// Which joint.
    pub joint: String,
    /// The least position.
    pub min_deg_mm: f64,
    /// The greatest position.
    pub max_deg_mm: f64,
    /// The joint's range.
    pub range_deg_mm: [f64; 2],
    /// The highest speed.
    pub velocity_deg_mm_s: f64,
    /// What it may be.
    pub max_velocity_deg_mm_s: f64,
    /// The highest acceleration.
    pub acceleration_deg_mm_s2: f64,
    /// What it may be.
    pub max_acceleration_deg_mm_s2: f64,
    /// The highest jerk.
    pub jerk_deg_mm_s3: f64,
    /// What it may be; absent for a tool path, which keeps speeds and accelerations only.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub max_jerk_deg_mm_s3: Option<f64>,
}

/// How a via point is passed.
#[derive(Clone, Debug, Deserialize, PartialEq, Serialize, ToSchema)]
pub struct TrajectoryVia {
    /// When it is passed most nearly.
    pub time_s: f64,
    /// How far each joint is from it then.
    pub deviation_deg_mm: Vec<f64>,
}

/// The shape of a tool's path.
#[derive(Clone, Copy, Debug, Deserialize, Eq, PartialEq, Serialize, ToSchema)]
#[serde(rename_all = "kebab-case")]
pub enum ToolPathKind {
    /// Straight from the first pose to the second.
    Line,
    /// The arc from the first pose through the second to the third.
    Arc,
    /// The whole circle through three poses, back to the first.
    Circle,
    /// A natural cubic spline through all poses.
    Spline,
}

/// A path of the tool.
///
/// Arms that the closed form covers are solved by it, others by damped least squares, each step from the one before.
#[derive(Clone, Debug, Deserialize, PartialEq, Serialize, ToSchema)]
#[serde(deny_unknown_fields)]
#[schema(example = json!({
    "kind": "line", "speed_mm_s": 300, "period_s": 0.05,
    "poses": [
        {"x_mm": 985, "y_mm": 0, "z_mm": 940, "w_deg": 180, "p_deg": 0, "r_deg": 0},
        {"x_mm": 985, "y_mm": 300, "z_mm": 700, "w_deg": 180, "p_deg": 0, "r_deg": 0}
    ]
}))]
pub struct ToolPathBody {
    /// Its shape.
    pub kind: ToolPathKind,
    /// The tool in the user frame: two poses for a line, three for an arc or a circle, 2 to 1000 for a spline.
    pub poses: Vec<PoseBody>,
    /// The joints at the first pose; where absent, those nearest to home.
    #[serde(default, alias = "start_deg", skip_serializing_if = "Option::is_none")]
    pub start_deg_mm: Option<Vec<f64>>,
    /// What of the poses counts; the model's own where absent. Less than the whole pose is looked for by damped least
    /// squares.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub task: Option<ArmTask>,
    /// The tool's highest speed.
    #[schema(minimum = 1e-6, maximum = 1e6)]
    pub speed_mm_s: f64,
    /// The highest acceleration along the path; five times the speed a second where absent.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schema(minimum = 1e-6, maximum = 1e6)]
    pub acceleration_mm_s2: Option<f64>,
    /// The highest jerk along the path; ten times the acceleration a second where absent.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schema(minimum = 1e-6, maximum = 1e6)]
    pub jerk_mm_s3: Option<f64>,
    /// How fast the tool turns at most; 90 where absent.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub turning_deg_s: Option<f64>,
    /// From sample to sample; 0.02 where absent. At most 5000 samples.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schema(minimum = 0.0005, maximum = 1)]
    pub period_s: Option<f64>,
    /// The frames of the poses.
    #[serde(default, skip_serializing_if = "ArmFrames::is_empty")]
    pub frames: ArmFrames,
}

/// A path of the tool in time, or where the arm cannot follow it.
#[derive(Clone, Debug, Deserialize, PartialEq, Serialize, ToSchema)]
pub struct ToolPathResult {
    /// Whether the arm can follow the whole path.
    pub feasible: bool,
    /// Where and why it cannot.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub failure: Option<ToolPathFailure>,
    /// The names of the joints, base first.
    pub joints: Vec<String>,
    /// How long it takes.
    pub duration_s: f64,
    /// How many times longer it takes because of the joints; 1 if the tool's own limits decide.
    pub slowed: f64,
    /// The joint that slows it.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub limited_by: Option<String>,
    /// The joints along it, one set a period.
    pub samples: Vec<TrajectorySample>,
    /// What it asks of each joint, beside what the joint can do; the jerks as they come.
    pub peaks: Vec<TrajectoryPeaks>,
    /// The path itself, a hundred and one points: where the tool would go, also if the arm cannot follow.
    pub path_mm: Vec<[f64; 3]>,
}

/// Where the arm cannot follow a path, and why.
#[derive(Clone, Debug, Deserialize, PartialEq, Serialize, ToSchema)]
pub struct ToolPathFailure {
    /// How much of the path lies before it, from 0 to 1.
    pub parameter: f64,
    /// Where the tool would be.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub pose: Option<PoseBody>,
    /// Why, with joint, value and limit.
    pub reason: String,
    /// The joints beyond their ranges, if that is why.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub outside: Vec<ArmOutside>,
}

/// How a motion would go: joints and tool in time, sampled.
#[derive(Clone, Debug, Deserialize, PartialEq, Serialize, ToSchema)]
pub struct MotionProfile {
    /// How long it takes, within the model's speeds and accelerations.
    pub duration_s: f64,
    /// How many times longer a straight line takes because of the joints; 1 if its own speed decides.
    pub slowed: f64,
    /// The joint that decides how long it takes, if one does.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub limited_by: Option<String>,
    /// Joints and tool along it; none where the arm cannot follow.
    pub samples: Vec<TrajectorySample>,
    /// What it asks of each joint, beside what the joint can do.
    pub peaks: Vec<TrajectoryPeaks>,
    /// Where the arm cannot follow a straight line between start and target, and why.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub failure: Option<ToolPathFailure>,
}
