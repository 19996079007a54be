//! From a KAREL position to joints, or to the alarm that says why not.

use karel::{JointPosition, Position, Status, TpTarget, XyzwprExt};
use kinematics::{ArmModel, Frames, IkError, Obstacle, PendantJoints, Pose, PoseError, Seed};

use super::arc::{self, OnCircle};
use super::convert::{
    components, configuration, frames, karel_config, pendant_joints, pose, to_f32,
};
use super::linear::{self, LinearTarget, Pace};
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
        (pace, wrist_joint): (&Pace, bool),
    ) -> Result<Path, Refusal> {
        let frames = checked_frames(user_frame, tool)?;
        let target = self.end_point(target, &frames, wrist_joint)?;
        linear::plan(&self.model, &frames, from, &target, pace)
    }

    /// The way of the tool from `from` to `target` on the circle through `via`, which is on the way or elsewhere.
    ///
    /// # Errors
    /// As [`arc::plan_arc`]; a position or a frame that is no pose.
    pub fn circular(
        &self,
        from: PendantJoints,
        (via, place, target): (&TpTarget, OnCircle, &TpTarget),
        (user_frame, tool): (&Position, &Position),
        (pace, wrist_joint): (&Pace, bool),
    ) -> Result<Path, Refusal> {
        let frames = checked_frames(user_frame, tool)?;
        let via = self.way_point(via, &frames)?;
        let target = self.end_point(target, &frames, wrist_joint)?;
        let via = (&via.tcp, place);
        arc::plan_arc(&self.model, &frames, from, (via, &target), pace)
    }

    /// As [`Self::way_point`], with the joints there if the wrist goes to them.
    fn end_point(
        &self,
        target: &TpTarget,
        frames: &Frames,
        wrist_joint: bool,
    ) -> Result<LinearTarget, Refusal> {
        let mut end = self.way_point(target, frames)?;
        if wrist_joint {
            let flange = frames.flange_in_world(&end.tcp);
            let wanted = Seed::InConfiguration(end.configuration);
            let solution = self.model.inverse(&flange, wanted);
            end.wrist = Some(solution.map_err(|error| ik_refusal(&error))?.joints);
        }
        Ok(end)
    }

    fn way_point(&self, target: &TpTarget, frames: &Frames) -> Result<LinearTarget, Refusal> {
        Ok(match target {
            TpTarget::Cartesian(position) => LinearTarget {
                tcp: pose(&Position::from(*position))
                    .map_err(|error| not_a_pose("the position", &error))?,
                configuration: configuration(position.config),
                wrist: None,
            },
            TpTarget::Joints(joints) => {
                let joints = pendant_joints(joints)?;
                LinearTarget {
                    tcp: frames.tcp_in_user_frame(&self.model.forward(&joints)),
                    configuration: self.model.configuration(&joints),
                    wrist: None,
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
