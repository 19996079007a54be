//! Where a transfer may end.

use api::arms::{ArmBranch, ArmInverseBody, ArmTransferBody};
use kinematics::serial::JointValues;

use crate::arm::Arm;
use crate::inverse::inverse;
use crate::refusal::{Refusal, RefusalKind};

const GOAL_JOINTS: &str = "goal_deg_mm";
const GOAL_POSE: &str = "goal_pose";

/// The joint sets at which the way may end, the one to be tried first before the others, and the key they come from.
///
/// A pose has as many as the arm has branches inside its ranges, the nearest to the start first.
pub(super) fn goals(
    arm: &Arm,
    model: &str,
    body: &ArmTransferBody,
) -> Result<(&'static str, Vec<JointValues>), Refusal> {
    let Some(pose) = body.goal_pose else {
        if body.goal_deg_mm.is_empty() {
            return Err(Refusal::invalid(
                GOAL_JOINTS,
                "it is missing, and so is goal_pose",
            ));
        }
        let goal = arm.joints_inside(GOAL_JOINTS, &body.goal_deg_mm)?;
        return Ok((GOAL_JOINTS, vec![goal]));
    };
    if !body.goal_deg_mm.is_empty() {
        let detail = format!("there is {GOAL_JOINTS} too; give one of them");
        return Err(Refusal::invalid(GOAL_POSE, detail));
    }
    let question = ArmInverseBody {
        pose: Some(pose),
        near_deg_mm: Some(body.start_deg_mm.clone()),
        frames: body.frames.clone(),
        ..ArmInverseBody::default()
    };
    let found = inverse(model, &question).map_err(of_the_goal)?;
    if let Some(reason) = found.reason {
        return Err(Refusal::new(RefusalKind::JointLimit, GOAL_POSE, reason));
    }
    let inside = |branch: &&ArmBranch| branch.within_ranges;
    let goals = found.branches.iter().filter(inside);
    let goals = goals.map(|branch| arm.joints(GOAL_POSE, &branch.joints_deg_mm));
    Ok((GOAL_POSE, goals.collect::<Result<_, _>>()?))
}

/// The inverse kinematics call the goal `pose`.
fn of_the_goal(refusal: Refusal) -> Refusal {
    let path = match refusal.path.strip_prefix("pose") {
        Some(rest) => format!("{GOAL_POSE}{rest}"),
        None => refusal.path,
    };
    Refusal { path, ..refusal }
}
