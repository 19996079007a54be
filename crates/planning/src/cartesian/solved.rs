//! Any arm on a path of its tool: in closed form where it has one, by a search else.

use kinematics::serial::{DlsOptions, JointKind, JointValues, SerialArm, SerialError, Task};
use kinematics::{ArmModel, Frames, PendantJoints};

use super::error::{JointValue, ToolError, ToolMoveError};
use super::follower::{AT_START_DEG, LONGEST_STEP_DEG, ToolFollower};
use super::path::ToolPath;
use super::stepwise::{OnPath, after};

/// How the joints of each step are found.
#[derive(Clone, Copy, Debug)]
pub enum Solver<'a> {
    /// In the closed form of this model of the same arm.
    ClosedForm(&'a ArmModel),
    /// By damped least squares, from the joints of the step before: for any arm, as far as the task asks.
    Search(Task),
}

/// An arm, its frames, and how it is solved.
#[derive(Clone, Copy, Debug)]
pub struct SolvedArm<'a> {
    /// The arm.
    pub arm: &'a SerialArm,
    /// Its user frame and tool.
    pub frames: &'a Frames,
    /// How.
    pub solver: Solver<'a>,
}

/// A search follows the joints of the step before: one start, and few steps are the rule.
const SEARCH: DlsOptions = DlsOptions {
    position_tolerance_mm: 1e-7,
    rotation_tolerance_rad: 1e-10,
    max_steps: 100,
    starts: 1,
};

/// A solved arm on a path.
pub(super) enum SolvedFollower<'a> {
    ClosedForm(&'a SerialArm, ToolFollower<'a>),
    Search(Box<Search<'a>>),
}

pub(super) struct Search<'a> {
    /// With its frames: where it is is where its tool is in the user frame.
    framed: SerialArm,
    path: &'a ToolPath,
    task: Task,
}

impl<'a> SolvedFollower<'a> {
    pub(super) fn new(solved: &SolvedArm<'a>, path: &'a ToolPath) -> Self {
        let SolvedArm {
            arm,
            frames,
            solver,
        } = *solved;
        match solver {
            Solver::ClosedForm(model) => {
                SolvedFollower::ClosedForm(arm, ToolFollower::new(model, frames, path))
            }
            Solver::Search(task) => SolvedFollower::Search(Box::new(Search {
                framed: arm.with_frames(frames),
                path,
                task,
            })),
        }
    }

    pub(super) fn check_start(&self, start: &JointValues) -> Result<(), ToolMoveError> {
        match self {
            SolvedFollower::ClosedForm(_, follower) => Ok(follower.check_start(&pendant(start)?)?),
            SolvedFollower::Search(search) => search.check_start(start),
        }
    }

    /// As [`ToolFollower::follow`].
    pub(super) fn follow(
        &self,
        from: f64,
        joints: &JointValues,
        to: f64,
    ) -> Result<JointValues, ToolMoveError> {
        match self {
            SolvedFollower::ClosedForm(arm, follower) => {
                let found = follower.follow(from, &pendant(joints)?, to)?;
                Ok(arm.joints_from_radians(&found.radians())?)
            }
            SolvedFollower::Search(search) => after(&**search, to, to - from, joints),
        }
    }
}

/// The six joints of an arm that is solved in closed form.
fn pendant(joints: &JointValues) -> Result<PendantJoints, ToolMoveError> {
    let radians = joints.as_slice().try_into();
    radians.map(PendantJoints::from_radians).map_err(|_| {
        ToolMoveError::Joints(SerialError::JointCount {
            arm: "an arm that is solved in closed form".to_owned(),
            wanted: 6,
            given: joints.len(),
        })
    })
}

impl Search<'_> {
    fn check_start(&self, start: &JointValues) -> Result<(), ToolMoveError> {
        let begins = self.joints_at(0.0, start)?;
        let (joint, is, begins) = self.farthest(start, &begins);
        if (is.value - begins.value).abs() > AT_START_DEG {
            return Err(ToolError::StartElsewhere { joint, is, begins }.into());
        }
        Ok(())
    }

    /// The joint with the longest way: radians, and parts of the arm's span.
    fn farthest(&self, a: &JointValues, b: &JointValues) -> (String, JointValue, JointValue) {
        let pairs = a.as_slice().iter().zip(b.as_slice());
        let joints = self.framed.joint_list().iter().zip(pairs);
        let far = joints.max_by(|(one, (a, b)), (other, (c, d))| {
            let way = |kind, a: f64, b: f64| (b - a).abs() / self.unit(kind);
            way(one.kind, **a, **b).total_cmp(&way(other.kind, **c, **d))
        });
        let shown = |kind: JointKind, value: f64| JointValue {
            value: kind.shown(value),
            kind,
        };
        far.map_or_else(
            || {
                (
                    String::new(),
                    shown(JointKind::Revolute, 0.0),
                    shown(JointKind::Revolute, 0.0),
                )
            },
            |(joint, (a, b))| {
                (
                    joint.name.clone(),
                    shown(joint.kind, *a),
                    shown(joint.kind, *b),
                )
            },
        )
    }

    fn unit(&self, kind: JointKind) -> f64 {
        match kind {
            JointKind::Revolute => 1.0,
            JointKind::Prismatic => self.framed.span(),
        }
    }
}

impl OnPath for Search<'_> {
    type Joints = JointValues;
    type Error = ToolMoveError;

    fn joints_at(&self, parameter: f64, near: &JointValues) -> Result<JointValues, ToolMoveError> {
        let X_UT = self.path.pose_at(parameter)?;
        let found = self.framed.solve(&X_UT, self.task, near, &SEARCH);
        let found = found.map_err(|source| ToolMoveError::NotReached {
            parameter,
            pose: Box::new(X_UT.xyzwpr()),
            source,
        })?;
        Ok(found.joints)
    }

    fn far_apart(&self, a: &JointValues, b: &JointValues) -> bool {
        let pairs = a.as_slice().iter().zip(b.as_slice());
        let mut joints = self.framed.joint_list().iter().zip(pairs);
        let longest = LONGEST_STEP_DEG.to_radians();
        joints.any(|(joint, (a, b))| (b - a).abs() > longest * self.unit(joint.kind))
    }

    fn jump(&self, parameter: f64, from: &JointValues, to: &JointValues) -> ToolMoveError {
        let (joint, from, to) = self.farthest(from, to);
        match self.path.pose_at(parameter) {
            Ok(pose) => ToolError::Jump {
                parameter,
                pose: Box::new(pose.xyzwpr()),
                joint,
                from,
                to,
            }
            .into(),
            Err(error) => error.into(),
        }
    }
}
