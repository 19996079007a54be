//! The story of one motion: intent before the bytes, acceptance, outcome with its evidence.

use jiff::Timestamp;
use serde::{Deserialize, Serialize};

use crate::{Claim, DecisionId, Epoch, JobId, MotionId};

/// A motion is about to be sent. Durable before its first byte leaves.
#[derive(Clone, Debug, Eq, PartialEq, Serialize, Deserialize)]
pub struct Intent {
    /// Its name.
    pub motion: MotionId,
    /// The cell.
    pub cell: String,
    /// The robot in that cell.
    pub robot: String,
    /// The epoch it is sent in; the journal refuses another one than its own.
    pub epoch: Epoch,
    /// Its number among the motions of that robot and epoch, as a controller that keeps numbers gets it.
    pub seq: u64,
    /// Where to.
    pub target: Target,
    /// How fast, in µm/s.
    pub speed_um_s: u32,
    /// Whether it could be sent again.
    pub class: Repeatability,
    /// The HTTP request behind it.
    pub request_id: String,
    /// The caller's key, where one was given.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub claim: Option<Claim>,
    /// The job it is a step of.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub job: Option<JobId>,
    /// The caller's words.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub reason: Option<String>,
    /// What else was asked for, where the writer kept it: what a reader needs to show the motion again.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub asked: Option<Box<Asked>>,
}

/// What was asked for, beyond where to and how fast.
#[derive(Clone, Debug, Eq, PartialEq, Serialize, Deserialize)]
pub struct Asked {
    /// The kind of motion in the words of the API, for example `JOINT`.
    pub motion_type: String,
    /// Who asked.
    pub principal: String,
    /// Where the joints are expected to end, J1 to J6 as on the pendant, in 0.001°.
    pub joints_mdeg: [i32; 6],
    /// Percent of the joints' own speeds, where the speed is given so; `speed_um_s` is zero then.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub speed_percent: Option<u8>,
    /// When it was no longer to be begun.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub not_after: Option<Timestamp>,
    /// Which start of the link within the epoch it was given to, for a controller that keeps numbers; the number it
    /// has on the wire is `seq`.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub wire_epoch: Option<u32>,
    /// Which start of the controller it was sent to, where the controller counts them.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub boot: Option<u32>,
    /// Whether the target is the joint values, and not the pose.
    #[serde(default, skip_serializing_if = "std::ops::Not::not")]
    pub to_joints: bool,
    /// The pose it was counted from, for a motion relative to the actual pose.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub from: Option<Target>,
}

/// A pose as the wire has it: micrometers and millidegrees, in the controller's active frames.
#[derive(Clone, Copy, Debug, Eq, PartialEq, Serialize, Deserialize)]
pub struct Target {
    /// X in µm.
    pub x_um: i32,
    /// Y in µm.
    pub y_um: i32,
    /// Z in µm.
    pub z_um: i32,
    /// W in 0.001°.
    pub w_mdeg: i32,
    /// P in 0.001°.
    pub p_mdeg: i32,
    /// R in 0.001°.
    pub r_mdeg: i32,
}

/// What a second execution would do. Chosen when the motion is made; there is no default.
#[derive(Clone, Copy, Debug, Eq, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Repeatability {
    /// To an absolute pose in free space: harmless while it is the last step.
    AbsoluteFree,
    /// An absolute level with feedback.
    LevelIo,
    /// Two parties, with sensors.
    Handover,
    /// A process (weld, dispense): never repeated without a person.
    Process,
}

/// The controller took the command. Not: the arm is there.
#[derive(Clone, Debug, Eq, PartialEq, Serialize, Deserialize)]
pub struct Accepted {
    /// The motion.
    pub motion: MotionId,
    /// The controller's words.
    pub text: String,
    /// Whether more will be known of it.
    pub completion: Completion,
}

/// Whether anyone can see the end of a motion.
#[derive(Clone, Copy, Debug, Eq, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Completion {
    /// No: the acceptance is the last word, and the motion's story ends here.
    NotObservable,
    /// Yes: an outcome follows.
    Observable,
}

/// What became of a motion.
///
/// One for each motion, or two where the first one was a doubt.
#[derive(Clone, Debug, Eq, PartialEq, Serialize, Deserialize)]
pub struct Outcome {
    /// The motion.
    pub motion: MotionId,
    /// How it ended.
    pub end: End,
}

/// How a motion ended, with what proves it: there is no `done` without evidence.
#[derive(Clone, Debug, Eq, PartialEq, Serialize, Deserialize)]
#[serde(tag = "is", rename_all = "snake_case")]
pub enum End {
    /// The arm was seen at the target, standing still.
    Done {
        /// What shows it.
        evidence: Arrival,
    },
    /// The controller said no.
    Rejected {
        /// The controller's words.
        text: String,
    },
    /// Proven not executed.
    NotExecuted {
        /// What shows it.
        evidence: NoMotion,
    },
    /// It may have been executed, in whole, in part, or not at all.
    InDoubt {
        /// The stable code of what went wrong, for example `controller-timeout`.
        code: String,
        /// What the controller said, if anything.
        #[serde(default, skip_serializing_if = "Option::is_none")]
        text: Option<String>,
        /// What was seen afterwards, if anything.
        #[serde(default, skip_serializing_if = "Option::is_none")]
        seen: Option<Observation>,
    },
    /// It began and did not reach its target: known, not a doubt.
    Interrupted {
        /// The stable code of what ended it, for example `stopped`.
        reason: String,
        /// What was seen afterwards, if anything.
        #[serde(default, skip_serializing_if = "Option::is_none")]
        seen: Option<Observation>,
    },
}

/// What shows that a motion was executed.
#[derive(Clone, Debug, Eq, PartialEq, Serialize, Deserialize)]
#[serde(tag = "by", rename_all = "snake_case")]
pub enum Arrival {
    /// The controller's state.
    Observed(Observation),
    /// A person.
    Decided {
        /// The decision.
        decision: DecisionId,
    },
}

/// What shows that a motion was not executed.
#[derive(Clone, Debug, Eq, PartialEq, Serialize, Deserialize)]
#[serde(tag = "by", rename_all = "snake_case")]
pub enum NoMotion {
    /// No byte left, or no connection was made.
    NotSent {
        /// The stable code of the reason, for example `controller-disconnected`.
        code: String,
    },
    /// The controller's state.
    Observed(Observation),
    /// A person.
    Decided {
        /// The decision.
        decision: DecisionId,
    },
}

/// Two readings of the controller after everything sent before was answered.
#[derive(Clone, Debug, Eq, PartialEq, Serialize, Deserialize)]
pub struct Observation {
    /// When the controller had answered everything sent before.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub fence_at: Option<Timestamp>,
    /// The first reading.
    pub first_at: Timestamp,
    /// The second reading, of the same pose.
    pub second_at: Timestamp,
    /// The pose read.
    pub pose: Target,
    /// Whether it moved.
    pub standstill: Standstill,
    /// Whether it was held.
    pub hold: Hold,
    /// The operator's switch.
    pub mode: Mode,
    /// Which start of the controller this was, where it counts them.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub boot: Option<u64>,
    /// Since when the teach pendant was enabled.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub pendant_since: Option<Timestamp>,
    /// The active alarm.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub alarm: Option<String>,
}

/// Whether the arm moved.
#[derive(Clone, Copy, Debug, Eq, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Standstill {
    /// It stood.
    Standing,
    /// It moved.
    Moving,
}

/// Whether a motion was held and may go on later.
#[derive(Clone, Copy, Debug, Eq, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Hold {
    /// Nothing was held.
    Free,
    /// Something was held.
    Held,
    /// It could not be read.
    Unknown,
}

/// The operator's switch.
#[derive(Clone, Copy, Debug, Eq, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Mode {
    /// Manual, reduced speed.
    T1,
    /// Manual, full speed.
    T2,
    /// Automatic.
    Auto,
    /// It could not be read.
    Unknown,
}
