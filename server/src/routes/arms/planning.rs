//! What takes long: computed in the one place for it.

use std::sync::Arc;

use api::arms::{
    ArmFrames, ArmJacobianBody, ArmJacobianResult, ArmTransferBody, ArmTransferResult,
    ArmVelocityMotionBody, ArmVelocityMotionResult, ReachBody, ReachResult,
};
use api::trajectory::{ToolPathBody, ToolPathResult, TrajectoryBody, TrajectoryResult};
use axum::Json;
use axum::extract::State;

use super::super::params::{RobotOf, RobotPath};
use super::super::responses::{AnyProblem, BodyProblem, CrossSite, InvalidJson, NotFound};
use super::{ArmPath, ModelName, answered, computed};
use crate::config::RobotPlan;
use crate::extract::ListJson;
use crate::problem::Problem;
use crate::state::App;
use crate::wire_bodies::pose_body;

/// Computes the motion of an arm model's tool with a constant velocity, as far as it goes.
#[utoipa::path(
    post, path = "/api/v1/arms/{model}/velocity-motion", tag = "arms",
    params(ArmPath),
    request_body = ArmVelocityMotionBody,
    responses(
        (status = 200, description = "The motion; `end` says why it ended.", body = ArmVelocityMotionResult),
        (status = 422, description = "`validation`: an item is out of its range. `joint-limit-exceeded`: the start is.",
            body = api::Problem, content_type = "application/problem+json"),
        CrossSite, InvalidJson, NotFound, BodyProblem, AnyProblem,
    ),
)]
pub(super) async fn arm_velocity_motion(
    State(app): State<Arc<App>>,
    ModelName(model): ModelName,
    ListJson(body): ListJson<ArmVelocityMotionBody>,
) -> Result<Json<ArmVelocityMotionResult>, Problem> {
    computed(&app, move |_| robotics::velocity_motion(&model, &body)).await
}

/// Counts in how many ways an arm model reaches each of a set of poses, or each point of a plane.
#[utoipa::path(
    post, path = "/api/v1/arms/{model}/reachability", tag = "arms",
    params(ArmPath),
    request_body = ReachBody,
    responses(
        (status = 200, description = "The counts.", body = ReachResult),
        (status = 422, description = "`validation`: an item is out of its range, or there are too many poses.",
            body = api::Problem, content_type = "application/problem+json"),
        CrossSite, InvalidJson, NotFound, BodyProblem, AnyProblem,
    ),
)]
pub(super) async fn arm_reachability(
    State(app): State<Arc<App>>,
    ModelName(model): ModelName,
    ListJson(body): ListJson<ReachBody>,
) -> Result<Json<ReachResult>, Problem> {
    computed(&app, move |wanted| {
        robotics::reach_while(&model, &body, wanted)
    })
    .await
}

/// Plans a trajectory of an arm model's joints: polynomials, jerk-limited, or past via points.
#[utoipa::path(
    post, path = "/api/v1/arms/{model}/trajectories", tag = "arms",
    params(ArmPath),
    request_body = TrajectoryBody,
    responses(
        (status = 200, description = "The trajectory, sampled, and what it asks of each joint.", body = TrajectoryResult),
        (status = 422, description = "`validation`: an item is out of its range, or a time is impossible. `joint-limit-exceeded`: a state is outside the limits.",
            body = api::Problem, content_type = "application/problem+json"),
        CrossSite, InvalidJson, NotFound, BodyProblem, AnyProblem,
    ),
)]
pub(super) async fn arm_trajectory(
    State(app): State<Arc<App>>,
    ModelName(model): ModelName,
    ListJson(body): ListJson<TrajectoryBody>,
) -> Result<Json<TrajectoryResult>, Problem> {
    computed(&app, move |_| robotics::trajectory(&model, &body)).await
}

/// Follows a line, an arc, a circle or a spline with the tool of an arm model, and says where the arm cannot.
#[utoipa::path(
    post, path = "/api/v1/arms/{model}/tool-paths", tag = "arms",
    params(ArmPath),
    request_body = ToolPathBody,
    responses(
        (status = 200, description = "The joints along it; or `failure` says where and why the arm cannot follow.", body = ToolPathResult),
        (status = 422, description = "`validation`: an item is out of its range. `joint-limit-exceeded`: the start is.",
            body = api::Problem, content_type = "application/problem+json"),
        CrossSite, InvalidJson, NotFound, BodyProblem, AnyProblem,
    ),
)]
pub(super) async fn arm_tool_path(
    State(app): State<Arc<App>>,
    ModelName(model): ModelName,
    ListJson(body): ListJson<ToolPathBody>,
) -> Result<Json<ToolPathResult>, Problem> {
    computed(&app, move |wanted| {
        robotics::tool_path_while(&model, &body, wanted)
    })
    .await
}

/// Finds a way of an arm model's joints on which it touches no obstacle.
#[utoipa::path(
    post, path = "/api/v1/arms/{model}/transfers", tag = "arms",
    params(ArmPath),
    request_body = ArmTransferBody,
    responses(
        (status = 200, description = "The way.", body = ArmTransferResult),
        (status = 422, description = "`validation`: an item is out of its range, or start or goal touches an obstacle. `joint-limit-exceeded`. `no-way`: none was found.",
            body = api::Problem, content_type = "application/problem+json"),
        CrossSite, InvalidJson, NotFound, BodyProblem, AnyProblem,
    ),
)]
pub(super) async fn arm_transfer(
    State(app): State<Arc<App>>,
    ModelName(model): ModelName,
    ListJson(body): ListJson<ArmTransferBody>,
) -> Result<Json<ArmTransferResult>, Problem> {
    computed(&app, move |wanted| {
        robotics::transfer_while(&model, &body, wanted)
    })
    .await
}

/// The robot's own frames where the question has none.
fn with_own(frames: &mut ArmFrames, plan: &RobotPlan) {
    let own = &plan.frames;
    let _ = frames
        .user_frame
        .get_or_insert_with(|| pose_body(&own.user_frame.xyzwpr()));
    let _ = frames
        .tool
        .get_or_insert_with(|| pose_body(&own.tool.xyzwpr()));
}

/// Counts in how many ways a robot reaches each of a set of poses, with its own tool and user frame.
#[utoipa::path(
    post, path = "/api/v1/cells/{cell}/robots/{robot}/reachability", tag = "kinematics",
    params(RobotPath),
    request_body = ReachBody,
    responses(
        (status = 200, description = "The counts.", body = ReachResult),
        (status = 422, description = "`validation`: an item is out of its range, or there are too many poses.",
            body = api::Problem, content_type = "application/problem+json"),
        CrossSite, InvalidJson, NotFound, BodyProblem, AnyProblem,
    ),
)]
pub(super) async fn robot_reachability(
    State(app): State<Arc<App>>,
    RobotOf(robot): RobotOf,
    ListJson(mut body): ListJson<ReachBody>,
) -> Result<Json<ReachResult>, Problem> {
    with_own(&mut body.frames, &robot.plan);
    let model = robot.plan.model.name().to_owned();
    computed(&app, move |wanted| {
        robotics::reach_while(&model, &body, wanted)
    })
    .await
}

/// Computes the Jacobians of a robot at its tool, in its user frame: geometric, analytic, rank, what is lost.
#[utoipa::path(
    post, path = "/api/v1/cells/{cell}/robots/{robot}/kinematics/jacobian", tag = "kinematics",
    params(RobotPath),
    request_body = ArmJacobianBody,
    responses(
        (status = 200, description = "Them.", body = ArmJacobianResult),
        (status = 422, description = "`validation`: an item is out of its range.", body = api::Problem, content_type = "application/problem+json"),
        CrossSite, InvalidJson, NotFound, BodyProblem, AnyProblem,
    ),
)]
pub(super) async fn robot_jacobian(
    RobotOf(robot): RobotOf,
    ListJson(mut body): ListJson<ArmJacobianBody>,
) -> Result<Json<ArmJacobianResult>, Problem> {
    with_own(&mut body.frames, &robot.plan);
    answered(robotics::jacobian(robot.plan.model.name(), &body))
}
