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
    /// Where to; absent for `HOME`, and with a `plan_id`.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub target: Option<TargetBody>,
    /// What the target of a `RELATIVE` motion counts from; it must say so.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub relative_to: Option<RelativeTo>,
    /// Programmed speed, 1 to 1999 mm/s, a whole number (the controller's wire format has no fractions).
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schema(minimum = 1, maximum = 1999, multiple_of = 1)]
    pub speed_mm_s: Option<f64>,
    /// Speed of the joints in percent of their fastest, a whole number: for motions that are no straight line, where
    /// the controller takes percent (tier 2).
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schema(minimum = 1, maximum = 100, multiple_of = 1)]
    pub speed_percent: Option<f64>,
    /// The plan of a preview, which this motion then is, or it is refused. `target` and the speed are the plan's.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub plan_id: Option<Uuid>,
    /// What must still hold when the motion is taken.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub expect: Option<ExpectBody>,
    /// A motion that has not begun by then is not begun: it ends `expired`, with no effect. 5 s from now where absent.
    #[serde(
        default,
        deserialize_with = "crate::moment::optional",
        skip_serializing_if = "Option::is_none"
    )]
    pub not_after: Option<Timestamp>,
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

impl MotionBody {
    /// A motion of this type, with nothing else said.
    #[must_use]
    pub const fn new(motion_type: MotionType) -> Self {
        Self {
            motion_type,
            target: None,
            relative_to: None,
            speed_mm_s: None,
            speed_percent: None,
            plan_id: None,
            expect: None,
            not_after: None,
            deadline_ms: None,
            reason: None,
        }
    }
}

/// How the arm gets to the target.
#[derive(Clone, Copy, Debug, Deserialize, Eq, PartialEq, Serialize, ToSchema)]
#[serde(rename_all = "SCREAMING_SNAKE_CASE")]
pub enum MotionType {
    /// All joints start and stop together.
    Joint,
    /// To the home joints of the arm model, all joints together.
    Home,
    /// The tool center point on a straight line. Needs a controller that can (tier 2).
    Linear,
    /// A change to the pose the controller reports, number by number, all joints together. Needs a controller that
    /// reports it (tier 2). What is sent is the absolute target it comes to.
    Relative,
    /// No motion: a level of a digital output, such as the gripper's. Only the cell's jobs ask for one.
    Output,
}

/// What a relative target counts from.
#[derive(Clone, Copy, Debug, Deserialize, Eq, PartialEq, Serialize, ToSchema)]
#[serde(rename_all = "SCREAMING_SNAKE_CASE")]
pub enum RelativeTo {
    /// The pose the controller reports, read afresh.
    Actual,
}

/// What must still hold when a motion is taken; else it is refused with `stale-state` and not sent.
#[derive(Clone, Debug, Deserialize, PartialEq, Serialize, ToSchema)]
#[serde(deny_unknown_fields)]
pub struct ExpectBody {
    /// The `revision` of the robot's state the caller looked at.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub state_revision: Option<u64>,
    /// Where the joints must be; those of the plan where a `plan_id` is given.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub start_joints: Option<JointsBody>,
    /// How far each joint may be from there, in degrees; 0.5 where absent.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schema(minimum = 0, maximum = 180)]
    pub start_tolerance_deg: Option<f64>,
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
    /// The controller has taken the command. This says nothing about its end, and at tier 0 nothing more is known.
    Accepted,
    /// The arm moves.
    Executing,
    /// It is held, and goes on when it is resumed.
    Paused,
    /// The controller says it is there; standstill and pose are being checked.
    Settling,
    /// Seen at the target, standing still.
    Succeeded,
    /// It began and did not get to its target.
    Failed,
    /// Taken back: before it began, or by a stop.
    Canceled,
    /// It could not begin in time: proven not sent.
    Expired,
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
    /// The controller reports it.
    Observable,
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
    /// Programmed speed in mm/s, where it was given so.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub speed_mm_s: Option<f64>,
    /// Speed of the joints in percent of their fastest, where it was given so.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub speed_percent: Option<u8>,
    /// The pose a relative motion was counted from, as the controller reported it.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub counted_from: Option<PoseBody>,
    /// Who asked for it.
    #[serde(default)]
    pub principal: String,
    /// When the request was taken.
    pub created_at: Timestamp,
    /// When it was no longer to be begun.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub not_after: Option<Timestamp>,
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
    /// What the controller reported at the end.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub evidence: Option<Evidence>,
    /// What a person said about it, where it was in doubt.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub decision: Option<DecisionBody>,
}

/// What the controller reported of an arm: two readings of the same pose.
#[derive(Clone, Debug, Deserialize, PartialEq, Serialize, ToSchema)]
pub struct Evidence {
    /// The tool center point read, in the active user frame.
    pub pose: PoseBody,
    /// The distance of that pose from the target, in millimeters.
    pub distance_mm: f64,
    /// The angle between that pose and the target, in degrees.
    pub angle_deg: f64,
    /// Whether the arm stood still.
    pub standing: bool,
    /// Whether a motion was held; absent where that could not be read.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub held: Option<bool>,
    /// The operating mode, `T1`, `T2` or `AUTO`; absent where that could not be read.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub mode: Option<String>,
    /// Which start of the controller it was.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub boot: Option<u64>,
    /// The active alarm.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub alarm: Option<String>,
    /// When everything sent before had been answered.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub fence_at: Option<Timestamp>,
    /// When it was read, the second time.
    pub read_at: Timestamp,
}

/// A person's word about something in doubt.
#[derive(Clone, Debug, Deserialize, PartialEq, Serialize, ToSchema)]
pub struct DecisionBody {
    /// What the person says.
    pub answer: DoubtAnswer,
    /// Who.
    pub principal: String,
    /// Why.
    pub reason: String,
    /// When.
    pub at: Timestamp,
}

/// What a person may say about a motion in doubt.
#[derive(Clone, Copy, Debug, Deserialize, Eq, Hash, PartialEq, Serialize, ToSchema)]
#[serde(rename_all = "snake_case")]
pub enum DoubtAnswer {
    /// The arm was seen at the target: the motion ends `succeeded`.
    Happened,
    /// The arm did not move: the motion ends `not_executed`.
    DidNotHappen,
    /// Somewhere between, or nobody knows: the motion ends `failed`. The arm is where it is.
    Abort,
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
