//! The wrist on a way of its own, the rest of the arm keeping the tool in its place.

use kinematics::{ArmModel, Frames, PendantJoints, Pose};
use nalgebra::{Matrix3, Vector3};

use super::error::ToolError;

/// Steps of Newton's method; from one sample to the next it needs three.
const MOST_STEPS: u32 = 20;
/// How near the tool has to come, mm.
const NEAR_MM: f64 = 1e-7;
/// Degrees by which an axis is turned to see what that does.
const NUDGE_DEG: f64 = 1e-4;

/// Where the wrist starts and ends, degrees, and the joints at the end.
#[derive(Clone, Copy, Debug)]
pub(super) struct WristWay {
    start: [f64; 3],
    goal: PendantJoints,
}

impl WristWay {
    pub(super) fn new(start: &PendantJoints, goal: &PendantJoints) -> WristWay {
        let [_, _, _, j4, j5, j6] = start.degrees();
        WristWay {
            start: [j4, j5, j6],
            goal: *goal,
        }
    }

    /// The joints at `parameter` with the tool where it is in `X_UT`, the first three near those before.
    pub(super) fn joints(
        &self,
        arm: &ArmModel,
        frames: &Frames,
        X_UT: &Pose,
        (parameter, before): (f64, &PendantJoints),
    ) -> Result<PendantJoints, ToolError> {
        if parameter >= 1.0 {
            return Ok(self.goal);
        }
        let ([a1, a2, a3, ..], [.., b4, b5, b6]) = (before.degrees(), self.goal.degrees());
        let [a4, a5, a6] = self.start;
        let [j4, j5, j6] = [(a4, b4), (a5, b5), (a6, b6)].map(|(a, b)| a + (b - a) * parameter);
        let whole = |first: &Vector3<f64>| {
            PendantJoints::from_degrees([first.x, first.y, first.z, j4, j5, j6])
        };
        let place = |first: &Vector3<f64>| {
            let X_UT = frames.tcp_in_user_frame(&arm.forward(&whole(first)));
            X_UT.isometry().translation.vector
        };
        let wanted = X_UT.isometry().translation.vector;
        let mut first = Vector3::new(a1, a2, a3);
        for _ in 0..MOST_STEPS {
            let here = place(&first);
            let error = wanted - here;
            if error.norm() < NEAR_MM {
                let joints = whole(&first);
                arm.check_limits(&joints)
                    .map_err(|violations| ToolError::WristLimits {
                        parameter,
                        violations,
                    })?;
                return Ok(joints);
            }
            let nudged = Matrix3::identity() * NUDGE_DEG;
            let column = |n: usize| (place(&(first + nudged.column(n))) - here) / NUDGE_DEG;
            let jacobian = Matrix3::from_columns(&[column(0), column(1), column(2)]);
            if jacobian.determinant().abs() < 1e-9 {
                break;
            }
            let Some(inverse) = jacobian.try_inverse() else {
                break;
            };
            first += inverse * error;
        }
        Err(ToolError::Wrist { parameter })
    }
}
