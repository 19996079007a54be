//! From a KAREL position to joints, or to the alarm that says why not.

use karel::{Config, JointPosition, Position, Status, TpTarget, XyzwprExt};
use kinematics::{
    ArmModel, Configuration, Elbow, Flip, Frames, Front, IkError, Obstacle, PendantJoints, Pose,
    PoseError, Seed, Xyzwpr,
};
use units::{Degrees, Millimeters};

use super::linear::{self, LinearTarget};
use super::path::Path;
use crate::ledger::PoseMmDeg;

/// Why a position cannot be moved to: the status for the program and a sentence for people.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Refusal {
    /// `MOTN-017`, `MOTN-018` and their like.
    pub status: Status,
    /// The reason with joint, value and limit.
    pub text: String,
}

impl Refusal {
    /// A refusal with this status and this reason.
    pub fn new(status: Status, text: impl Into<String>) -> Self {
        Self {
            status,
            text: text.into(),
        }
    }

    /// `MOTN-017 text`.
    #[must_use]
    pub fn headline(&self) -> String {
        format!("{} {}", self.status, self.text)
    }
}

/// Inverse kinematics of one arm, in KAREL's terms.
#[derive(Debug)]
pub struct Planner {
    model: ArmModel,
}

impl Planner {
    /// A planner for `model`.
    #[must_use]
    pub fn new(model: ArmModel) -> Self {
        Self { model }
    }

    /// The arm.
    #[must_use]
    pub fn model(&self) -> &ArmModel {
        &self.model
    }

    /// The joints that bring `tool` to `target` in `user_frame`, in the configuration of the target.
    ///
    /// # Errors
    /// Not a pose, not reachable in that configuration, or outside of the joint limits.
    pub fn joints(
        &self,
        target: &XyzwprExt,
        user_frame: &Position,
        tool: &Position,
    ) -> Result<PendantJoints, Refusal> {
        if let Some(axis) = target.ext.iter().position(|&value| value != 0.0) {
            return Err(Refusal::new(
                Status::MOTN_UNREACHABLE,
                format!(
                    "the position uses the extended axis E{}, this arm has none",
                    axis + 1
                ),
            ));
        }
        let unreachable = |what: &str, error: &PoseError| {
            Refusal::new(
                Status::MOTN_UNREACHABLE,
                format!("{what} is not a pose: {error}"),
            )
        };
        let frames = frames(user_frame, tool).map_err(|(what, error)| unreachable(what, &error))?;
        let tcp = pose(&Position::from(*target)).map_err(|e| unreachable("the position", &e))?;
        let flange = frames.flange_in_world(&tcp);
        let wanted = Seed::InConfiguration(configuration(target.config));
        let joints = self
            .model
            .inverse(&flange, wanted)
            .map_err(|error| ik_refusal(&error))?
            .joints;
        // The second look costs nothing and does not trust the first.
        self.model.check_limits(&joints).map_err(|violations| {
            Refusal::new(Status::MOTN_LIMIT, format!("Limit error: {violations}"))
        })?;
        Ok(joints)
    }

    /// The straight way of the tool from `from` to `target`.
    ///
    /// # Errors
    /// As [`linear::plan`]; a target or a frame that is no pose.
    pub fn linear(
        &self,
        from: PendantJoints,
        target: &TpTarget,
        (user_frame, tool): (&Position, &Position),
        speeds: (f64, f64),
    ) -> Result<Path, Refusal> {
        let frames = checked_frames(user_frame, tool)?;
        let target = self.way_point(target, &frames)?;
        linear::plan(&self.model, &frames, from, &target, speeds)
    }

    /// The way of the tool from `from` on the circle through `via` to `target`.
    ///
    /// # Errors
    /// As [`linear::plan_arc`]; a position or a frame that is no pose.
    pub fn circular(
        &self,
        from: PendantJoints,
        (via, target): (&TpTarget, &TpTarget),
        (user_frame, tool): (&Position, &Position),
        speeds: (f64, f64),
    ) -> Result<Path, Refusal> {
        let frames = checked_frames(user_frame, tool)?;
        let via = self.way_point(via, &frames)?;
        let target = self.way_point(target, &frames)?;
        linear::plan_arc(&self.model, &frames, from, (&via.tcp, &target), speeds)
    }

    fn way_point(&self, target: &TpTarget, frames: &Frames) -> Result<LinearTarget, Refusal> {
        Ok(match target {
            TpTarget::Cartesian(position) => LinearTarget {
                tcp: pose(&Position::from(*position))
                    .map_err(|error| not_a_pose("the position", &error))?,
                configuration: configuration(position.config),
            },
            TpTarget::Joints(joints) => {
                let joints = pendant_joints(joints)?;
                LinearTarget {
                    tcp: frames.tcp_in_user_frame(&self.model.forward(&joints)),
                    configuration: self.model.configuration(&joints),
                }
            }
        })
    }

    /// Whether the arm may stand at these joints.
    ///
    /// # Errors
    /// Not six axes, or outside of the joint limits.
    pub fn within_limits(&self, joints: &JointPosition) -> Result<(), Refusal> {
        let joints = pendant_joints(joints)?;
        self.model.check_limits(&joints).map_err(|violations| {
            Refusal::new(Status::MOTN_LIMIT, format!("Limit error: {violations}"))
        })
    }

    /// Where `tool` is in `user_frame` when the arm stands at `joints`, with the configuration filled in.
    ///
    /// # Errors
    /// A frame is not a pose.
    pub fn position(
        &self,
        joints: &PendantJoints,
        user_frame: &Position,
        tool: &Position,
    ) -> Result<XyzwprExt, Refusal> {
        let frames = frames(user_frame, tool).map_err(|(what, error)| {
            Refusal::new(
                Status::MOTN_UNREACHABLE,
                format!("{what} is not a pose: {error}"),
            )
        })?;
        let tcp = frames
            .tcp_in_user_frame(&self.model.forward(joints))
            .xyzwpr();
        let [x, y, z, w, p, r] = components(&tcp).map(to_f32);
        let config = karel_config(self.model.configuration(joints));
        Ok(XyzwprExt {
            x,
            y,
            z,
            w,
            p,
            r,
            config,
            ext: [0.0; 3],
        })
    }

    /// Where `tool` is in the world; the flange, if the tool is no pose.
    #[must_use]
    pub fn tcp_in_world(&self, joints: &PendantJoints, tool: &Position) -> Pose {
        let flange = self.model.forward(joints);
        match pose(tool) {
            Ok(tool) => flange * tool,
            Err(_) => flange,
        }
    }

    /// As [`Self::position`], in full precision, for the panel.
    #[must_use]
    pub fn pose(
        &self,
        joints: &PendantJoints,
        user_frame: &Position,
        tool: &Position,
    ) -> Option<PoseMmDeg> {
        let frames = frames(user_frame, tool).ok()?;
        let tcp = frames
            .tcp_in_user_frame(&self.model.forward(joints))
            .xyzwpr();
        Some(components(&tcp).into())
    }
}

/// A pose as the ledger writes it.
#[must_use]
pub fn pose_mm_deg(pose: &Pose) -> PoseMmDeg {
    components(&pose.xyzwpr()).into()
}

/// KAREL's joints as the arm's.
///
/// # Errors
/// Not six axes, or an angle that is no number.
pub fn pendant_joints(joints: &JointPosition) -> Result<PendantJoints, Refusal> {
    let refused = |text: String| Refusal::new(Status::MOTN_LIMIT, text);
    let axes = <[f32; 6]>::try_from(joints.axes.as_slice()).map_err(|_| {
        refused(format!(
            "the joint position has {} axes, this arm has 6",
            joints.axes.len()
        ))
    })?;
    PendantJoints::try_from_degrees(axes.map(f64::from)).map_err(|error| refused(error.to_string()))
}

/// The arm's joints as KAREL's.
#[must_use]
pub fn joint_position(joints: &PendantJoints) -> JointPosition {
    JointPosition {
        axes: joints.degrees().map(to_f32).to_vec(),
    }
}

/// A position as the ledger writes it.
#[must_use]
pub fn pose_of_target(target: &XyzwprExt) -> PoseMmDeg {
    let XyzwprExt {
        x, y, z, w, p, r, ..
    } = *target;
    [x, y, z, w, p, r].map(f64::from).into()
}

pub(super) fn ik_refusal(error: &IkError) -> Refusal {
    match error {
        IkError::JointLimit { violations, .. }
        | IkError::NoSolutionInConfiguration {
            obstacle: Obstacle::Limits(violations),
            ..
        } => Refusal::new(Status::MOTN_LIMIT, format!("Limit error: {violations}")),
        IkError::OutOfReach { .. }
        | IkError::NoSolutionInConfiguration {
            obstacle: Obstacle::OutOfReach,
            ..
        }
        | IkError::NotFinite(_) => Refusal::new(
            Status::MOTN_UNREACHABLE,
            format!("Position not reachable: {error}"),
        ),
    }
}

fn not_a_pose(what: &str, error: &PoseError) -> Refusal {
    let text = format!("{what} is not a pose: {error}");
    Refusal::new(Status::MOTN_UNREACHABLE, text)
}

fn checked_frames(user_frame: &Position, tool: &Position) -> Result<Frames, Refusal> {
    frames(user_frame, tool).map_err(|(what, error)| not_a_pose(what, &error))
}

fn frames(user_frame: &Position, tool: &Position) -> Result<Frames, (&'static str, PoseError)> {
    Ok(Frames {
        user_frame: pose(user_frame).map_err(|error| ("$UFRAME", error))?,
        tool: pose(tool).map_err(|error| ("$UTOOL", error))?,
    })
}

fn pose(position: &Position) -> Result<Pose, PoseError> {
    let Position {
        x, y, z, w, p, r, ..
    } = *position;
    let mm = |value: f32| Millimeters(f64::from(value));
    let deg = |value: f32| Degrees(f64::from(value));
    Pose::try_from_xyzwpr(&Xyzwpr {
        x: mm(x),
        y: mm(y),
        z: mm(z),
        w: deg(w),
        p: deg(p),
        r: deg(r),
    })
}

fn components(pose: &Xyzwpr) -> [f64; 6] {
    [pose.x.0, pose.y.0, pose.z.0, pose.w.0, pose.p.0, pose.r.0]
}

#[expect(clippy::cast_possible_truncation, reason = "KAREL's REAL has 32 bits")]
fn to_f32(value: f64) -> f32 {
    value as f32
}

fn configuration(config: Config) -> Configuration {
    Configuration {
        flip: match config.wrist {
            karel::Wrist::Flip => Flip::Flip,
            karel::Wrist::NoFlip => Flip::NoFlip,
        },
        elbow: match config.elbow {
            karel::Elbow::Up => Elbow::Up,
            karel::Elbow::Down => Elbow::Down,
        },
        front: match config.front {
            karel::Front::Toward => Front::Toward,
            karel::Front::Back => Front::Back,
        },
        turns: config.turns,
    }
}

fn karel_config(configuration: Configuration) -> Config {
    Config {
        wrist: match configuration.flip {
            Flip::Flip => karel::Wrist::Flip,
            Flip::NoFlip => karel::Wrist::NoFlip,
        },
        elbow: match configuration.elbow {
            Elbow::Up => karel::Elbow::Up,
            Elbow::Down => karel::Elbow::Down,
        },
        front: match configuration.front {
            Front::Toward => karel::Front::Toward,
            Front::Back => karel::Front::Back,
        },
        turns: configuration.turns,
    }
}
