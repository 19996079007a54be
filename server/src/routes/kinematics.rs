//! Forward and inverse kinematics of a robot, with its tool and user frame. Nothing is sent.

#![expect(
    non_snake_case,
    reason = "frames are part of a pose's name: X_WF is the flange F in the world W"
)]

use std::cmp::Ordering;

use api::{BranchBody, ForwardBody, ForwardResult, InverseBody, InverseResult};
use axum::Json;
use kinematics::{PendantJoints, Pose, Seed, Solution};

use super::params::{RobotOf, RobotPath};
use super::responses::{AnyProblem, BodyProblem, CrossSite, InvalidJson, NotFound};
use crate::config::RobotPlan;
use crate::extract::JsonBody;
use crate::problem::Problem;
use crate::target::{Paths, Refusal, joints_of, margins};
use crate::wire_bodies::{as_shown, joints_body, point_of, pose_body, shown, singularity_body};

const PATHS: Paths = Paths {
    speed: "",
    point: [
        "pose.x_mm",
        "pose.y_mm",
        "pose.z_mm",
        "pose.w_deg",
        "pose.p_deg",
        "pose.r_deg",
    ],
    joints: "joints",
};
const PATHS_NEAR: Paths = Paths {
    joints: "near",
    ..PATHS
};

/// Computes the pose of joint values.
///
/// Joint values outside their limits have a pose too; the margins tell.
#[utoipa::path(
    post, path = "/api/v1/cells/{cell}/robots/{robot}/kinematics/forward", tag = "kinematics",
    params(RobotPath),
    request_body = ForwardBody,
    responses(
        (status = 200, description = "The pose.", body = ForwardResult),
        (status = 422, description = "`validation`: the body does not fit.", body = api::Problem, content_type = "application/problem+json"),
        CrossSite, InvalidJson, NotFound, BodyProblem, AnyProblem,
    ),
)]
pub(super) async fn forward(
    RobotOf(robot): RobotOf,
    JsonBody(body): JsonBody<ForwardBody>,
) -> Result<Json<ForwardResult>, Problem> {
    let plan = &robot.plan;
    let joints =
        joints_of(body.joints.into()).map_err(|refusal| refused(plan, &refusal, &PATHS))?;
    Ok(Json(ForwardResult {
        pose: pose_body(&plan.point_at(&joints).xyzwpr()),
        configuration: plan.model.configuration(&joints).to_string(),
        within_limits: plan.model.check_limits(&joints).is_ok(),
        margins: margins(plan, &joints),
        singularity: singularity_body(&plan.model.singularity(&joints)),
    }))
}

/// Computes every joint set that reaches a pose.
///
/// The branches inside the limits come first, the nearest to `near` (the home joints where absent) before the others.
/// A singular pose is answered too, with its measures; a motion to it is refused.
#[utoipa::path(
    post, path = "/api/v1/cells/{cell}/robots/{robot}/kinematics/inverse", tag = "kinematics",
    params(RobotPath),
    request_body = InverseBody,
    responses(
        (status = 200, description = "The branches.", body = InverseResult),
        (status = 422, description = "`validation`: the body does not fit. `out-of-workspace`, `joint-limit-exceeded`: no joint set, or none inside the limits.",
            body = api::Problem, content_type = "application/problem+json"),
        CrossSite, InvalidJson, NotFound, BodyProblem, AnyProblem,
    ),
)]
pub(super) async fn inverse(
    RobotOf(robot): RobotOf,
    JsonBody(body): JsonBody<InverseBody>,
) -> Result<Json<InverseResult>, Problem> {
    let plan = &robot.plan;
    let of_pose = |refusal: Refusal| refused(plan, &refusal, &PATHS);
    let near = match body.near {
        Some(near) => {
            joints_of(near.into()).map_err(|refusal| refused(plan, &refusal, &PATHS_NEAR))?
        }
        None => plan.model.home(),
    };
    let pose = Pose::try_from_xyzwpr(&point_of(&body.pose))
        .map_err(|error| of_pose(Refusal::Pose(error)))?;
    let X_WF = plan.frames.flange_in_world(&pose);
    // Also the check that there is a branch inside the limits, with the right error where there is none.
    let nearest = plan
        .model
        .inverse(&X_WF, Seed::Near(near))
        .map_err(|error| of_pose(Refusal::Kinematics(error)))?;
    let all = plan
        .model
        .inverse_all(&X_WF)
        .map_err(|error| of_pose(Refusal::Kinematics(error)))?;
    let controller = plan
        .model
        .inverse(&X_WF, Seed::InConfiguration(plan.configuration))
        .ok();

    // The nearest one and the controller's may lie a turn away from the branch as `inverse_all` writes it.
    let mut solutions = vec![nearest];
    for solution in controller.iter().chain(all.iter()) {
        if !solutions.iter().any(|known| same(known, solution)) {
            solutions.push(*solution);
        }
    }
    solutions.sort_by(|a, b| order(plan, &near, a, b));
    let position = |wanted: &Solution| solutions.iter().position(|known| same(known, wanted));
    Ok(Json(InverseResult {
        nearest: position(&nearest).unwrap_or(0),
        controller: controller.as_ref().and_then(position),
        branches: solutions
            .iter()
            .map(|solution| branch_body(plan, &near, solution))
            .collect(),
    }))
}

fn refused(plan: &RobotPlan, refusal: &Refusal, paths: &Paths) -> Problem {
    Problem::new(refusal.code(), refusal.to_string())
        .robot(&plan.id)
        .violations(refusal.violations(paths))
}

fn same(a: &Solution, b: &Solution) -> bool {
    let close = |(a, b): (f64, f64)| (a - b).abs() < 1e-6;
    a.joints
        .degrees()
        .into_iter()
        .zip(b.joints.degrees())
        .all(close)
}

pub(super) fn order(
    plan: &RobotPlan,
    near: &PendantJoints,
    a: &Solution,
    b: &Solution,
) -> Ordering {
    let inside = |solution: &Solution| plan.model.check_limits(&solution.joints).is_ok();
    inside(b)
        .cmp(&inside(a))
        .then_with(|| squares(near, a).total_cmp(&squares(near, b)))
}

fn differences(near: &PendantJoints, solution: &Solution) -> impl Iterator<Item = f64> {
    near.degrees()
        .into_iter()
        .zip(solution.joints.degrees())
        .map(|(a, b)| (a - b).abs())
}

fn squares(near: &PendantJoints, solution: &Solution) -> f64 {
    differences(near, solution).map(|angle| angle * angle).sum()
}

pub(super) fn branch_body(
    plan: &RobotPlan,
    near: &PendantJoints,
    solution: &Solution,
) -> BranchBody {
    // Everything is told of the joints as shown, so that forward kinematics of them tells the same.
    let joints = as_shown(&solution.joints);
    BranchBody {
        joints: joints_body(&joints),
        configuration: plan.model.configuration(&joints).to_string(),
        within_limits: plan.model.check_limits(&joints).is_ok(),
        margins: margins(plan, &joints),
        singularity: singularity_body(&plan.model.singularity(&joints)),
        distance_deg: shown(differences(near, solution).fold(0.0, f64::max)),
    }
}
