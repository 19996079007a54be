//! The joints along a path of the tool, step by step, without time.

use kinematics::{ArmModel, Axis, Frames, PendantJoints, Seed};
use units::Degrees;

use super::error::ToolError;
use super::path::ToolPath;
use super::stepwise::{OnPath, after};
use super::wrist::WristWay;

/// Of one joint from one checked pose to the next.
pub(super) const LONGEST_STEP_DEG: f64 = 15.0;
/// Joints this close are where they should be.
pub(super) const AT_START_DEG: f64 = 0.01;

/// An arm that keeps its tool on a path: inverse kinematics at each step, near the joints before it.
#[derive(Clone, Copy, Debug)]
pub struct ToolFollower<'a> {
    arm: &'a ArmModel,
    frames: &'a Frames,
    path: &'a ToolPath,
    wrist: Option<WristWay>,
}

impl<'a> ToolFollower<'a> {
    /// With the tool in the orientation of the path. The path is that of the tool in the user frame of `frames`.
    #[must_use]
    pub fn new(arm: &'a ArmModel, frames: &'a Frames, path: &'a ToolPath) -> Self {
        ToolFollower {
            arm,
            frames,
            path,
            wrist: None,
        }
    }

    /// With J4, J5 and J6 evenly from where they are in `start` to where they are in `goal`, so that the singularity of
    /// the wrist does not matter. Only the place of the tool is kept; its orientation is what the wrist makes of it.
    #[must_use]
    pub fn with_wrist(mut self, start: &PendantJoints, goal: &PendantJoints) -> Self {
        self.wrist = Some(WristWay::new(start, goal));
        self
    }

    /// The joints at `parameter`, those nearest to `near`.
    ///
    /// # Errors
    /// The arm does not reach that pose.
    pub fn joints_at(
        &self,
        parameter: f64,
        near: &PendantJoints,
    ) -> Result<PendantJoints, ToolError> {
        let X_UT = self.path.pose_at(parameter)?;
        if let Some(wrist) = &self.wrist {
            return wrist.joints(self.arm, self.frames, &X_UT, (parameter, near));
        }
        let X_WF = self.frames.flange_in_world(&X_UT);
        let solution = self.arm.inverse(&X_WF, Seed::Near(*near));
        let solution = solution.map_err(|source| ToolError::Unreachable {
            parameter,
            pose: Box::new(X_UT.xyzwpr()),
            source,
        })?;
        Ok(solution.joints)
    }

    /// The joints at the parameter `to`, coming from `joints` at the parameter `from`; in smaller steps where they are
    /// far apart.
    ///
    /// # Errors
    /// As [`Self::joints_at`]; joints that jump.
    pub fn follow(
        &self,
        from: f64,
        joints: &PendantJoints,
        to: f64,
    ) -> Result<PendantJoints, ToolError> {
        after(self, to, to - from, joints)
    }

    pub(super) fn check_start(&self, start: &PendantJoints) -> Result<(), ToolError> {
        let begins = self.joints_at(0.0, start)?;
        let (joint, is, begins) = farthest(start, &begins);
        if (is.0 - begins.0).abs() > AT_START_DEG {
            return Err(ToolError::StartElsewhere {
                joint: joint.to_string(),
                is: is.into(),
                begins: begins.into(),
            });
        }
        Ok(())
    }
}

impl OnPath for ToolFollower<'_> {
    type Joints = PendantJoints;
    type Error = ToolError;

    fn joints_at(&self, parameter: f64, near: &PendantJoints) -> Result<PendantJoints, ToolError> {
        ToolFollower::joints_at(self, parameter, near)
    }

    fn far_apart(&self, a: &PendantJoints, b: &PendantJoints) -> bool {
        let (_, from, to) = farthest(a, b);
        (to.0 - from.0).abs() > LONGEST_STEP_DEG
    }

    fn jump(&self, parameter: f64, from: &PendantJoints, to: &PendantJoints) -> ToolError {
        let (joint, from, to) = farthest(from, to);
        let pose = match self.path.pose_at(parameter) {
            Ok(pose) => Box::new(pose.xyzwpr()),
            Err(error) => return error.into(),
        };
        ToolError::Jump {
            parameter,
            pose,
            joint: joint.to_string(),
            from: from.into(),
            to: to.into(),
        }
    }
}

fn farthest(a: &PendantJoints, b: &PendantJoints) -> (Axis, Degrees, Degrees) {
    let far = |axis: &Axis| (a.of(*axis).0 - b.of(*axis).0).abs();
    let axis = Axis::ALL
        .into_iter()
        .max_by(|a, b| far(a).total_cmp(&far(b)))
        .unwrap_or(Axis::J1);
    (axis, a.of(axis), b.of(axis))
}
