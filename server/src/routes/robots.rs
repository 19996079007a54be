//! What a robot is, and what the server knows of it now.

use api::{JointDescription, LinkStatus, PoseSource, RobotDescription, RobotState};
use axum::Json;
use kinematics::Axis;

use super::params::{RobotOf, RobotPath};
use super::responses::{AnyProblem, NotFound};
use crate::config::RobotPlan;
use crate::link::cell_server::CellServerLink;
use crate::link::{Base, Link};
use crate::state::{Robot, RobotLink};
use crate::target::sent_point;
use crate::wire_bodies::{joints_body, pose_body};

/// Describes a robot: model, joints, limits, frames.
#[utoipa::path(
    get, path = "/api/v1/cells/{cell}/robots/{robot}", tag = "robots",
    params(RobotPath),
    responses((status = 200, description = "The robot.", body = RobotDescription), NotFound, AnyProblem),
)]
pub(super) async fn get_robot(RobotOf(robot): RobotOf) -> Json<RobotDescription> {
    Json(description(&robot.plan))
}

/// Describes a robot; the same as the robot itself.
#[utoipa::path(
    get, path = "/api/v1/cells/{cell}/robots/{robot}/description", tag = "robots",
    params(RobotPath),
    responses((status = 200, description = "The robot.", body = RobotDescription), NotFound, AnyProblem),
)]
pub(super) async fn get_robot_description(RobotOf(robot): RobotOf) -> Json<RobotDescription> {
    Json(description(&robot.plan))
}

/// Shows what the server knows of a robot now.
///
/// A seed controller reports no position: `pose` is the target it last accepted, and says so.
#[utoipa::path(
    get, path = "/api/v1/cells/{cell}/robots/{robot}/state", tag = "robots",
    params(RobotPath),
    responses((status = 200, description = "The robot's state.", body = RobotState), NotFound, AnyProblem),
)]
pub(super) async fn get_robot_state(RobotOf(robot): RobotOf) -> Json<RobotState> {
    Json(match &robot.link {
        RobotLink::Seed(link) => seed_state(&robot, link),
        RobotLink::CellServer(link) => controller_state(&robot, link),
    })
}

fn seed_state(robot: &Robot, link: &Link) -> RobotState {
    let status = link.status();
    let (queued, queue_capacity) = link.depth();
    let (pose, pose_source) = match status.base {
        Base::Target(wire) => (
            Some(pose_body(&sent_point(&wire))),
            PoseSource::LastAcceptedTarget,
        ),
        Base::Nothing | Base::InDoubt => (None, PoseSource::Unknown),
    };
    RobotState {
        id: robot.plan.id.clone(),
        cell: robot.plan.cell.clone(),
        tier: robot.plan.tier,
        link: LinkStatus {
            state: status.state,
            last_answer_at: status.last_answer_at,
            last_failure: status.last_failure,
        },
        pose,
        pose_source,
        controller: None,
        queued,
        queue_capacity,
        last_motion: status.last_motion,
        revision: robot.motions.book.revision(),
    }
}

fn controller_state(robot: &Robot, link: &CellServerLink) -> RobotState {
    let view = link.view();
    let (queued, queue_capacity) = link.depth();
    let (pose, pose_source) = view.pose();
    RobotState {
        id: robot.plan.id.clone(),
        cell: robot.plan.cell.clone(),
        tier: robot.plan.tier,
        link: LinkStatus {
            state: view.state,
            last_answer_at: None,
            last_failure: view.failure.as_ref().map(|(code, _)| *code),
        },
        pose,
        pose_source,
        controller: view.controller_state(),
        queued,
        queue_capacity,
        last_motion: view.last_motion,
        revision: robot.motions.book.revision(),
    }
}

fn description(plan: &RobotPlan) -> RobotDescription {
    let model = plan.model;
    RobotDescription {
        id: plan.id.clone(),
        cell: plan.cell.clone(),
        name: plan.name.clone(),
        model: model.name().to_owned(),
        manufacturer: model.manufacturer().to_owned(),
        tier: plan.tier,
        capabilities: plan.tier.capabilities(),
        controller_address: plan.controller.to_string(),
        joints: Axis::ALL
            .into_iter()
            .map(|axis| {
                let limits = model.limits(axis);
                JointDescription {
                    joint: axis.to_string(),
                    min_deg: limits.min.0,
                    max_deg: limits.max.0,
                    max_speed_deg_s: model.max_speed(axis).0,
                }
            })
            .collect(),
        reach_mm: model.reach().0,
        home: joints_body(&model.home()),
        configuration: plan.configuration.to_string(),
        tool: pose_body(&plan.frames.tool.xyzwpr()),
        user_frame: pose_body(&plan.frames.user_frame.xyzwpr()),
        max_speed_mm_s: f64::from(plan.max_speed),
    }
}
