use serde::{Deserialize, Serialize};
use utoipa::ToSchema;

use super::ArmInertia;
use crate::PoseBody;

/// The arm models that are known.
#[derive(Clone, Debug, Deserialize, PartialEq, Serialize, ToSchema)]
pub struct ArmList {
    /// The models.
    pub arms: Vec<ArmSummary>,
}

/// An arm model in a line.
#[derive(Clone, Debug, Deserialize, PartialEq, Serialize, ToSchema)]
pub struct ArmSummary {
    /// Its name, as in the path of every question about it.
    pub model: String,
    /// Who builds it, or where it is described.
    pub manufacturer: String,
    /// How many joints it has.
    pub degrees_of_freedom: usize,
    /// The ways in which its inverse kinematics are solved, the one that is taken by itself first.
    pub solvers: Vec<ArmSolver>,
}

/// A way of solving the inverse kinematics.
#[derive(Clone, Copy, Debug, Deserialize, Eq, PartialEq, Serialize, ToSchema)]
#[serde(rename_all = "kebab-case")]
pub enum ArmSolver {
    /// The closed form of ortho-parallel arms with a spherical wrist: every branch.
    ClosedForm,
    /// Six revolute joints with a spherical wrist, by the quartic (15) of the thesis: every branch.
    Quartic,
    /// The geometric solution of the textbook, (1.34) to (1.57), of its own arm: every branch.
    Textbook,
    /// The five-link arm of the paper, (3) and (4): up to two sets.
    FiveLink,
    /// Damped least squares inside the ranges: any arm, one set, or how near it got.
    DampedLeastSquares,
}

/// What of the tool's pose is asked for. Arms with fewer than six joints cannot do all of it.
#[derive(Clone, Copy, Debug, Deserialize, Eq, PartialEq, Serialize, ToSchema)]
#[serde(rename_all = "kebab-case")]
pub enum ArmTask {
    /// Position and rotation: six numbers.
    Pose,
    /// Position and the direction of the tool's Z: five numbers.
    PositionAndAxis,
    /// Position and the rotation about Z: four numbers, a SCARA's.
    PositionAndHeading,
    /// The position only.
    Position,
}

/// Whether a joint turns or slides.
#[derive(Clone, Copy, Debug, Deserialize, Eq, PartialEq, Serialize, ToSchema)]
#[serde(rename_all = "kebab-case")]
pub enum ArmJointKind {
    /// It turns: values in degrees.
    Revolute,
    /// It slides: values in millimeters.
    Prismatic,
}

/// All that is known of an arm model.
#[derive(Clone, Debug, Deserialize, PartialEq, Serialize, ToSchema)]
pub struct ArmDescription {
    /// Its name.
    pub model: String,
    /// Who builds it, or where it is described.
    pub manufacturer: String,
    /// How many joints it has.
    pub degrees_of_freedom: usize,
    /// The ways in which its inverse kinematics are solved, the one that is taken by itself first.
    pub solvers: Vec<ArmSolver>,
    /// What is asked of a pose where a question does not say.
    pub task: ArmTask,
    /// The sum of all lengths: the flange is never farther from the base.
    pub span_mm: f64,
    /// `X_W0`: where the chain begins.
    pub base: PoseBody,
    /// `X_nF`: the flange behind the last frame of the table.
    pub flange: PoseBody,
    /// The joints, base first, each with its row of the Denavit-Hartenberg table (standard convention).
    pub joints: Vec<ArmJoint>,
    /// Where it stands when nobody said otherwise.
    pub home_deg_mm: Vec<f64>,
    /// The arm's shape, as collisions are checked.
    pub capsules: Vec<ArmCapsule>,
}

/// A joint and its row of the table: `Rz(theta) Tz(d) Tx(a) Rx(alpha)`, with
/// `q = sign * J + offset + sum(factor * other J)` in the place of theta (revolute) or added to d (prismatic).
#[derive(Clone, Debug, Deserialize, PartialEq, Serialize, ToSchema)]
pub struct ArmJoint {
    /// Its name.
    pub name: String,
    /// Whether it turns or slides.
    pub kind: ArmJointKind,
    /// Along the common normal.
    pub a_mm: f64,
    /// About the common normal.
    pub alpha_deg: f64,
    /// Along the axis.
    pub d_mm: f64,
    /// About the axis, what does not move.
    pub theta_deg: f64,
    /// 1 or -1: the direction in which the display counts.
    pub sign: f64,
    /// The chain's value where the display shows 0.
    pub offset_deg_mm: f64,
    /// Other joints whose displayed values are added.
    pub couplings: Vec<ArmJointCoupling>,
    /// The lowest legal value.
    pub min_deg_mm: f64,
    /// The highest legal value.
    pub max_deg_mm: f64,
    /// The highest speed.
    pub max_speed_deg_mm_s: f64,
    /// The highest acceleration.
    pub max_acceleration_deg_mm_s2: f64,
    /// What its link weighs, in the link's frame, if the model says so: behind this row of the table.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub inertia: Option<ArmInertia>,
}

/// Another joint that moves a joint's link too.
#[derive(Clone, Debug, Deserialize, PartialEq, Serialize, ToSchema)]
pub struct ArmJointCoupling {
    /// Whose displayed value.
    pub joint: String,
    /// How much of it.
    pub factor: f64,
}

/// A cylinder with round ends, fixed to a link.
#[derive(Clone, Debug, Deserialize, PartialEq, Serialize, ToSchema)]
#[serde(deny_unknown_fields)]
pub struct ArmCapsule {
    /// The frame of the table that it moves with: 0 is the base.
    pub link: usize,
    /// One end of its axis, in that frame.
    pub from_mm: [f64; 3],
    /// The other end.
    pub to_mm: [f64; 3],
    /// Its radius.
    pub radius_mm: f64,
}
