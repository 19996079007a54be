//! From what a caller asks for to what the wire carries: rounding, inverse kinematics, limits, singularities.
//!
//! The wire rounds to thousandths, so the pose that is checked is the rounded one: the one that is sent.

use api::{MotionType, ProblemCode, Violation};
use kinematics::{
    Axis, Configuration, IkError, LimitViolations, Obstacle, PendantJoints, Pose, PoseError, Seed,
    Singularity, Solution, Xyzwpr,
};
use protocol::{CommandError, Item, MAX_SPEED, MIN_SPEED, MoveCommand, WireMove};
use thiserror::Error;
use units::{Degrees, Millimeters, MmPerSec};

use crate::config::RobotPlan;
use crate::wire_bodies::shown;

/// A move that passed every check: only such a move reaches a link.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Prepared {
    pub(crate) motion_type: MotionType,
    pub(crate) wire: WireMove,
    /// Where the joints are expected to end, in the configuration the controller keeps.
    pub(crate) joints: PendantJoints,
}

/// How far the joints a caller asked for may differ from the ones the controller would choose, in degrees. The
/// pose is rounded to thousandths on its way, which moves a joint by a few hundredths near a singularity.
const SAME_JOINTS_DEG: f64 = 0.1;

/// The largest joint value that is read, in degrees: a hundred turns, as for the angles of a pose.
const MAX_JOINT_DEG: f64 = 36_000.0;

impl RobotPlan {
    /// A move of the tool center point to a point in the user frame.
    pub(crate) fn prepare_point(
        &self,
        point: &Xyzwpr,
        speed: MmPerSec,
    ) -> Result<Prepared, Refusal> {
        let (wire, solution) = self.solve(point, speed)?;
        Ok(Prepared {
            motion_type: MotionType::Joint,
            wire,
            joints: solution.joints,
        })
    }

    /// A move to joint values. The wire carries a pose, so the controller must choose the same joint values for it.
    pub(crate) fn prepare_joints(
        &self,
        degrees: [f64; 6],
        speed: MmPerSec,
    ) -> Result<Prepared, Refusal> {
        let joints = joints_of(degrees)?;
        self.model
            .check_limits(&joints)
            .map_err(Refusal::JointLimits)?;
        let (wire, solution) = self.solve(&self.point_at(&joints).xyzwpr(), speed)?;
        let chosen = solution.joints.degrees();
        let same = degrees
            .iter()
            .zip(chosen)
            .all(|(asked, chosen)| (asked - chosen).abs() <= SAME_JOINTS_DEG);
        if !same {
            return Err(Refusal::OtherBranch {
                asked: self.model.configuration(&joints),
                kept: self.configuration,
                chosen: solution.joints,
            });
        }
        Ok(Prepared {
            motion_type: MotionType::Joint,
            wire,
            joints: solution.joints,
        })
    }

    /// A move to the home joints of the arm model.
    pub(crate) fn prepare_home(&self, speed: MmPerSec) -> Result<Prepared, Refusal> {
        let home = self.model.home().degrees();
        self.prepare_joints(home, speed).map(|prepared| Prepared {
            motion_type: MotionType::Home,
            ..prepared
        })
    }

    /// The tool center point in the user frame at joint values.
    pub(crate) fn point_at(&self, joints: &PendantJoints) -> Pose {
        self.frames.tcp_in_user_frame(&self.model.forward(joints))
    }

    /// A target as the wire carries it, in thousandths, and the joints there, checked.
    pub(crate) fn solve_point(&self, point: &Xyzwpr) -> Result<([i32; 6], Solution), Refusal> {
        let slowest = MmPerSec(f64::from(MIN_SPEED));
        let (wire, solution) = self.solve(point, slowest)?;
        Ok((wire.thousandths(), solution))
    }

    fn solve(&self, point: &Xyzwpr, speed: MmPerSec) -> Result<(WireMove, Solution), Refusal> {
        let range = f64::from(MIN_SPEED)..=f64::from(self.max_speed);
        if !range.contains(&speed.0) || speed.0.fract() != 0.0 {
            return Err(Refusal::Speed {
                value: speed,
                max: self.max_speed,
            });
        }
        let wire = MoveCommand {
            x: point.x,
            y: point.y,
            z: point.z,
            w: point.w,
            p: point.p,
            r: point.r,
            speed,
        }
        .to_wire()
        .map_err(Refusal::Command)?;
        let pose = Pose::try_from_xyzwpr(&sent_point(&wire)).map_err(Refusal::Pose)?;
        let solution = self
            .model
            .inverse(
                &self.frames.flange_in_world(&pose),
                Seed::InConfiguration(self.configuration),
            )
            .map_err(Refusal::Kinematics)?;
        if solution.singularity.near().next().is_some() {
            return Err(Refusal::Singular {
                singularity: solution.singularity,
            });
        }
        Ok((wire, solution))
    }
}

/// Joint values a caller gave, which may be beyond the arm's limits.
pub(crate) fn joints_of(degrees: [f64; 6]) -> Result<PendantJoints, Refusal> {
    for (axis, value) in Axis::ALL.into_iter().zip(degrees) {
        // A NaN is in no range.
        if !(-MAX_JOINT_DEG..=MAX_JOINT_DEG).contains(&value) {
            return Err(Refusal::Joint { axis, value });
        }
    }
    Ok(PendantJoints::from_degrees(degrees))
}

/// The point the controller will compute from the thousandths of the wire.
pub(crate) fn sent_point(wire: &WireMove) -> Xyzwpr {
    let MoveCommand {
        x,
        y,
        z,
        w,
        p,
        r,
        speed: _,
    } = wire.command();
    Xyzwpr { x, y, z, w, p, r }
}

/// The point that lies so far from one that was sent, number by number.
pub(crate) fn moved_by(sent: &WireMove, change: [f64; 6]) -> Xyzwpr {
    let from = sent_point(sent);
    let [x, y, z, w, p, r] = change;
    Xyzwpr {
        x: from.x + Millimeters(x),
        y: from.y + Millimeters(y),
        z: from.z + Millimeters(z),
        w: from.w + Degrees(w),
        p: from.p + Degrees(p),
        r: from.r + Degrees(r),
    }
}

/// Why a move is not sent. Every variant is the caller's to correct.
#[derive(Clone, Debug, Error, PartialEq)]
pub(crate) enum Refusal {
    #[error("the speed is {}; it must be a whole number of {MIN_SPEED} to {max} mm/s", number(value.0))]
    Speed { value: MmPerSec, max: u16 },
    #[error("{0}")]
    Command(CommandError),
    #[error("{0}")]
    Pose(PoseError),
    #[error("{axis} is {}; it must be from -{MAX_JOINT_DEG} to {MAX_JOINT_DEG} degrees", number(*value))]
    Joint { axis: Axis, value: f64 },
    #[error("{0}")]
    JointLimits(LimitViolations),
    #[error("{}", kinematics_text(.0))]
    Kinematics(IkError),
    #[error("{}", near_singularities(singularity))]
    Singular { singularity: Singularity },
    #[error(
        "the wire carries a pose, and for the pose of these joints (branch {asked}) the controller, which keeps \
         {kept}, would take {chosen}"
    )]
    OtherBranch {
        asked: Configuration,
        kept: Configuration,
        chosen: PendantJoints,
    },
}

fn near_singularities(singularity: &Singularity) -> String {
    measures(singularity)
        .into_iter()
        .filter(|(_, measure, threshold)| measure < threshold)
        .map(|(name, measure, threshold)| near_singularity(name, measure, threshold))
        .collect::<Vec<_>>()
        .join(", ")
}

fn near_singularity(name: &str, measure: f64, threshold: f64) -> String {
    format!(
        "its distance from the {name} singularity is {measure:.4} on a scale of 0 to 1; {threshold} is needed"
    )
}

/// The error in words that follow a title like "The pose is out of reach".
fn kinematics_text(error: &IkError) -> String {
    match error {
        IkError::OutOfReach { excess, bound } => {
            format!("the wrist center would be {excess:.3} {bound}")
        }
        IkError::JointLimit { .. }
        | IkError::NoSolutionInConfiguration { .. }
        | IkError::NotFinite(_) => error.to_string(),
    }
}

/// A number from outside in a message: no row of three hundred digits.
fn number(value: f64) -> String {
    if value.abs() < 1e15 {
        value.to_string()
    } else {
        format!("{value:e}")
    }
}

fn measures(singularity: &Singularity) -> [(&'static str, f64, f64); 3] {
    [
        ("wrist", singularity.wrist, Singularity::NEAR_WRIST),
        ("shoulder", singularity.shoulder, Singularity::NEAR_SHOULDER),
        ("elbow", singularity.elbow, Singularity::NEAR_ELBOW),
    ]
}

/// What a refusal is about.
#[derive(Clone, Copy, Debug, Eq, PartialEq)]
pub(crate) enum Concern {
    /// The speed of the request.
    Speed,
    /// A number of the point: 0 is X, 5 is R.
    Point(usize),
    /// The request's values are legal one by one; the arm cannot do it.
    Arm,
}

/// What a request calls the things a refusal is about.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Paths {
    pub(crate) speed: &'static str,
    /// X to R.
    pub(crate) point: [&'static str; 6],
    pub(crate) joints: &'static str,
}

impl Refusal {
    /// Tells whoever follows the log of a command that was not sent.
    pub(crate) fn log(&self, robot: &str, request_id: &str) {
        tracing::info!(
            robot.id = robot,
            request_id,
            reason = %self,
            "the command was refused and not sent"
        );
    }

    pub(crate) fn code(&self) -> ProblemCode {
        match self {
            Self::Speed { .. }
            | Self::Command(_)
            | Self::Pose(_)
            | Self::Joint { .. }
            | Self::Kinematics(IkError::NotFinite(_)) => ProblemCode::Validation,
            Self::JointLimits(_) | Self::Kinematics(IkError::JointLimit { .. }) => {
                ProblemCode::JointLimitExceeded
            }
            Self::Kinematics(IkError::OutOfReach { .. }) => ProblemCode::OutOfWorkspace,
            Self::Kinematics(IkError::NoSolutionInConfiguration { obstacle, .. }) => match obstacle
            {
                Obstacle::Limits(_) => ProblemCode::JointLimitExceeded,
                Obstacle::OutOfReach => ProblemCode::NoSolutionInConfiguration,
            },
            Self::OtherBranch { .. } => ProblemCode::NoSolutionInConfiguration,
            Self::Singular { .. } => ProblemCode::Singularity,
        }
    }

    pub(crate) fn concern(&self) -> Concern {
        match self {
            Self::Speed { .. } => Concern::Speed,
            Self::Command(error) => match error.item() {
                Item::X => Concern::Point(0),
                Item::Y => Concern::Point(1),
                Item::Z => Concern::Point(2),
                Item::W => Concern::Point(3),
                Item::P => Concern::Point(4),
                Item::R => Concern::Point(5),
                Item::Speed | Item::Last => Concern::Speed,
            },
            Self::Pose(PoseError::Coordinate { name, .. } | PoseError::Angle { name, .. }) => {
                ["x", "y", "z", "w", "p", "r"]
                    .iter()
                    .position(|known| known == name)
                    .map_or(Concern::Arm, Concern::Point)
            }
            Self::Pose(PoseError::Rotation { .. })
            | Self::Joint { .. }
            | Self::JointLimits(_)
            | Self::Kinematics(_)
            | Self::Singular { .. }
            | Self::OtherBranch { .. } => Concern::Arm,
        }
    }

    /// Each thing wrong, in the words of the API.
    pub(crate) fn violations(&self, paths: &Paths) -> Vec<Violation> {
        let Paths {
            speed,
            point,
            joints,
        } = *paths;
        let whole = |item: &str, value: Option<f64>| Violation {
            item: item.to_owned(),
            message: self.to_string(),
            value,
            ..Violation::default()
        };
        match self {
            Self::Speed { value, max } => vec![Violation {
                min: Some(f64::from(MIN_SPEED)),
                max: Some(f64::from(*max.min(&MAX_SPEED))),
                ..whole(speed, Some(value.0))
            }],
            Self::Command(_) | Self::Pose(_) => match self.concern() {
                Concern::Point(index) => point
                    .get(index)
                    .map(|item| self.with_wire_limits(whole(item, self.value())))
                    .into_iter()
                    .collect(),
                Concern::Speed | Concern::Arm => vec![whole(speed, self.value())],
            },
            Self::Joint { axis, value } => vec![Violation {
                min: Some(-MAX_JOINT_DEG),
                max: Some(MAX_JOINT_DEG),
                ..whole(
                    &format!("{joints}.{}_deg", axis.to_string().to_lowercase()),
                    Some(*value),
                )
            }],
            Self::OtherBranch { .. } => vec![whole(joints, None)],
            Self::JointLimits(violations)
            | Self::Kinematics(
                IkError::JointLimit { violations, .. }
                | IkError::NoSolutionInConfiguration {
                    obstacle: Obstacle::Limits(violations),
                    ..
                },
            ) => violations.iter().map(limit_violation).collect(),
            Self::Singular { singularity } => measures(singularity)
                .into_iter()
                .filter(|(_, measure, threshold)| measure < threshold)
                .map(|(name, measure, threshold)| Violation {
                    item: name.to_owned(),
                    message: near_singularity(name, measure, threshold),
                    value: Some(measure),
                    min: Some(threshold),
                    max: None,
                })
                .collect(),
            Self::Kinematics(
                IkError::OutOfReach { .. }
                | IkError::NoSolutionInConfiguration { .. }
                | IkError::NotFinite(_),
            ) => Vec::new(),
        }
    }

    /// The violation with the limits of the wire, where they are the ones exceeded.
    fn with_wire_limits(&self, violation: Violation) -> Violation {
        if matches!(self, Self::Command(CommandError::OutOfRange { .. })) {
            Violation {
                min: Some(f64::from(i32::MIN) / 1000.0),
                max: Some(f64::from(i32::MAX) / 1000.0),
                ..violation
            }
        } else {
            violation
        }
    }

    fn value(&self) -> Option<f64> {
        match self {
            Self::Command(error) => Some(error.value()),
            Self::Pose(PoseError::Coordinate { value, .. }) => Some(value.0),
            Self::Pose(PoseError::Angle { value, .. }) => Some(value.0),
            Self::Speed { value, .. } => Some(value.0),
            Self::Joint { value, .. } => Some(*value),
            Self::Pose(PoseError::Rotation { .. })
            | Self::JointLimits(_)
            | Self::Kinematics(_)
            | Self::Singular { .. }
            | Self::OtherBranch { .. } => None,
        }
    }
}

fn limit_violation(violation: &kinematics::LimitViolation) -> Violation {
    Violation {
        item: violation.joint.to_string(),
        message: violation.to_string(),
        value: Some(shown(violation.value.0)),
        min: Some(violation.limits.min.0),
        max: Some(violation.limits.max.0),
    }
}

/// The six margins of joint values, J1 first.
pub(crate) fn margins(plan: &RobotPlan, joints: &PendantJoints) -> Vec<api::JointMargin> {
    Axis::ALL
        .into_iter()
        .map(|axis| {
            let limits = plan.model.limits(axis);
            let value: Degrees = joints.of(axis);
            api::JointMargin {
                joint: axis.to_string(),
                value_deg: shown(value.0),
                min_deg: limits.min.0,
                max_deg: limits.max.0,
                margin_deg: shown(limits.margin(value).0),
            }
        })
        .collect()
}
