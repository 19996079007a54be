use jiff::Timestamp;
use serde::{Deserialize, Serialize};
use utoipa::ToSchema;
use uuid::Uuid;

use crate::trajectory::MotionProfile;
use crate::{
    BranchBody, JointMargin, JointsBody, PoseBody, ProblemCode, SingularityBody, StopEffect,
    Violation,
};

/// A functional stop. It is no emergency stop.
#[derive(Clone, Copy, Debug, Default, Deserialize, PartialEq, Serialize, ToSchema)]
#[serde(deny_unknown_fields)]
#[schema(example = json!({"category": "STOP_1"}))]
pub struct StopBody {
    /// How; `STOP_1` where absent.
    #[serde(default)]
    pub category: StopCategory,
}

/// How an arm is stopped, in the words of IEC 60204-1.
#[derive(Clone, Copy, Debug, Default, Deserialize, Eq, PartialEq, Serialize, ToSchema)]
pub enum StopCategory {
    /// A controlled stop. Taking the power away afterwards is the controller's matter.
    #[default]
    #[serde(rename = "STOP_1")]
    Stop1,
    /// A controlled stop that keeps the power on.
    #[serde(rename = "STOP_2")]
    Stop2,
}

/// What a stop did.
#[derive(Clone, Debug, Deserialize, PartialEq, Serialize, ToSchema)]
pub struct StopResult {
    /// The robot.
    pub robot: String,
    /// What a stop does on this robot.
    pub stop_effect: StopEffect,
    /// The same in a sentence.
    pub text: String,
    /// The motions that waited, and were taken back: proven not sent.
    pub canceled: Vec<Uuid>,
}

/// The general speed override of a controller.
#[derive(Clone, Copy, Debug, Deserialize, Eq, PartialEq, Serialize, ToSchema)]
#[serde(deny_unknown_fields)]
#[schema(example = json!({"percent": 50}))]
pub struct SpeedOverride {
    /// Percent of every programmed speed.
    #[schema(minimum = 1, maximum = 100)]
    pub percent: u8,
}

/// What a motion would be, if it were asked for now.
#[derive(Clone, Debug, Deserialize, PartialEq, Serialize, ToSchema)]
pub struct MotionPreview {
    /// Whether it would be taken.
    pub feasible: bool,
    /// A motion with this `plan_id` is this one or is refused; absent where it would be refused.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub plan_id: Option<Uuid>,
    /// Until when the plan is kept.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub expires_at: Option<Timestamp>,
    /// The revision of the robot's state it was made from. The plan holds as long as this does.
    pub state_revision: u64,
    /// The tool center point that would be sent, rounded as the wire carries it.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub target: Option<PoseBody>,
    /// Where the joints would end.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub expected_joints: Option<JointsBody>,
    /// How far each joint would be from its limits.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub margins: Vec<JointMargin>,
    /// How near the target is to a singularity.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub singularity: Option<SingularityBody>,
    /// Every joint set that reaches the target, those inside the limits first.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub solutions: Vec<BranchBody>,
    /// Where the joints are now, if the controller reports it.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub start_joints: Option<JointsBody>,
    /// About how long it would take, in seconds, at full override; absent where the start is not known.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub duration_s: Option<f64>,
    /// How it would go, by the model's speeds and accelerations; absent where the start is not known, or the speed of the
    /// controller's own interpolation. A controller may take another way or another time.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub profile: Option<MotionProfile>,
    /// Why it would be refused.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub code: Option<ProblemCode>,
    /// The same in a sentence.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub detail: Option<String>,
    /// Each thing wrong.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub violations: Vec<Violation>,
}
