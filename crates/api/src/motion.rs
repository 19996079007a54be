use jiff::Timestamp;
use serde::{Deserialize, Serialize};
use utoipa::ToSchema;
use uuid::Uuid;

use crate::{JointsBody, Outcome, PoseBody, ProblemCode, Tier};

/// A motion to carry out.
#[derive(Clone, Debug, Deserialize, PartialEq, Serialize, ToSchema)]
#[serde(deny_unknown_fields)]
#[schema(example = json!({
    "type": "JOINT",
    "speed_mm_s": 300,
    "target": {"pose": {"x_mm": 985, "y_mm": 0, "z_mm": 940, "w_deg": -180, "p_deg": 0, "r_deg": 0}}
}))]
pub struct MotionBody {
    /// How the arm gets there.
    #[serde(rename = "type")]
    pub motion_type: MotionType,
    /// Where to; absent for `HOME`.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub target: Option<TargetBody>,
    /// Programmed speed, 1 to 1999 mm/s, a whole number (the controller's wire format has no fractions).
    #[schema(minimum = 1, maximum = 1999, multiple_of = 1)]
    pub speed_mm_s: f64,
    /// How long the caller is willing to wait for the controller's answer, in milliseconds.
    /// The robot's configured deadline holds where this is absent.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schema(minimum = 1, maximum = 60_000)]
    pub deadline_ms: Option<u64>,
    /// Why, for the record. At most 200 characters.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schema(max_length = 200)]
    pub reason: Option<String>,
}

/// How the arm gets to the target.
#[derive(Clone, Copy, Debug, Deserialize, Eq, PartialEq, Serialize, ToSchema)]
#[serde(rename_all = "SCREAMING_SNAKE_CASE")]
pub enum MotionType {
    /// All joints start and stop together.
    Joint,
    /// To the home joints of the arm model, all joints together.
    Home,
}

/// A target: exactly one of a pose and a set of joint values.
#[derive(Clone, Debug, Deserialize, PartialEq, Serialize, ToSchema)]
#[serde(deny_unknown_fields, rename_all = "snake_case")]
pub enum TargetBody {
    /// The tool center point in the robot's user frame.
    Pose(PoseBody),
    /// Joint values as on the pendant.
    Joints(JointsBody),
}

/// Where a motion is in its life. At tier 0 `accepted` is final: completion cannot be observed.
#[derive(Clone, Copy, Debug, Deserialize, Eq, Hash, PartialEq, Serialize, ToSchema)]
#[serde(rename_all = "snake_case")]
pub enum MotionState {
    /// Waiting for the robot's link.
    Queued,
    /// Bytes may be on their way to the controller.
    Dispatched,
    /// The controller has taken the command. This says nothing about its end.
    Accepted,
    /// The controller refused: proven not executed.
    Rejected,
    /// Proven not sent.
    NotExecuted,
    /// Bytes may have been taken, and no answer came that tells. Never sent again by the server.
    InDoubt,
}

/// What the server can know of a motion's end.
#[derive(Clone, Copy, Debug, Deserialize, Eq, PartialEq, Serialize, ToSchema)]
#[serde(rename_all = "snake_case")]
pub enum Completion {
    /// The controller's program has no way to report it.
    NotObservable,
}

/// A motion and what became of it.
#[derive(Clone, Debug, Deserialize, PartialEq, Serialize, ToSchema)]
pub struct Motion {
    /// The motion's id (UUID version 7: ids sort by creation).
    pub id: Uuid,
    /// The cell.
    pub cell: String,
    /// The robot.
    pub robot: String,
    /// How the arm gets there.
    #[serde(rename = "type")]
    pub motion_type: MotionType,
    /// Where it is in its life.
    pub state: MotionState,
    /// What the server can know of its end.
    pub completion: Completion,
    /// What the controller on this robot can promise.
    pub tier: Tier,
    /// The tool center point sent, in the robot's user frame.
    pub target: PoseBody,
    /// The joint values the server expects at the target, in the configuration the controller keeps.
    pub expected_joints: JointsBody,
    /// Programmed speed in mm/s.
    pub speed_mm_s: f64,
    /// When the request was taken.
    pub created_at: Timestamp,
    /// When the state became final.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub ended_at: Option<Timestamp>,
    /// The controller's own words, as received.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub controller_text: Option<String>,
    /// What went wrong, where the motion was not accepted.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub code: Option<ProblemCode>,
    /// What is known of the command's effect, where the motion was not accepted.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub outcome: Option<Outcome>,
    /// The id of the request, as in the logs of server and emulator.
    pub request_id: String,
    /// Why, in the caller's words.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub reason: Option<String>,
}

/// A page of motions, newest first.
#[derive(Clone, Debug, Deserialize, PartialEq, Serialize, ToSchema)]
pub struct MotionList {
    /// The motions.
    pub motions: Vec<Motion>,
    /// Give this as `cursor` for the page after this one; absent on the last page.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub next_cursor: Option<String>,
}
