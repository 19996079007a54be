//! Every question about arms and paths through the typed client against the real server: the answer is the library's.

use anyhow::Context as _;
use api::arms::{
    ArmCalibrationBody, ArmForwardBody, ArmInverseBody, ArmJacobianBody, ArmRatesBody,
    ArmTransferBody, ArmVelocityMotionBody, ReachBody,
};
use api::paths::PlanRouteBody;
use api::trajectory::{ToolPathBody, TrajectoryBody};
use api::{Outcome, ProblemCode};
use client::ClientError;
use serde::de::DeserializeOwned;
use tests::{FakeRobot, MODEL, TestServer, robot_at};

/// The example that the API's document has for a body.
fn example<T: DeserializeOwned>(name: &str) -> anyhow::Result<T> {
    let document = serde_json::to_value(server::openapi())?;
    let example = document.pointer(&format!("/components/schemas/{name}/example"));
    Ok(serde_json::from_value(
        example.context("no example")?.clone(),
    )?)
}

#[tokio::test]
async fn a_question_over_http_has_the_answer_of_the_library() -> anyhow::Result<()> {
    let controller = FakeRobot::start([]).await?;
    let server = TestServer::start(robot_at(controller.address())).await?;
    let client = server.client();
    let arms = client.arms();
    assert_eq!(arms.list().await?, robotics::models());
    assert_eq!(arms.describe(MODEL).await?, robotics::describe(MODEL)?);

    let body: ArmForwardBody = example("ArmForwardBody")?;
    assert_eq!(
        arms.forward(MODEL, &body).await?,
        robotics::forward(MODEL, &body)?
    );
    let body: ArmInverseBody = example("ArmInverseBody")?;
    assert_eq!(
        arms.inverse(MODEL, &body).await?,
        robotics::inverse(MODEL, &body)?
    );
    let body: ArmJacobianBody = example("ArmJacobianBody")?;
    let jacobian = robotics::jacobian(MODEL, &body)?;
    assert_eq!(arms.jacobian(MODEL, &body).await?, jacobian);
    // This robot has no tool and no user frame.
    assert_eq!(server.robot().jacobian(&body).await?, jacobian);
    let body: ArmRatesBody = example("ArmRatesBody")?;
    assert_eq!(
        arms.rates(MODEL, &body).await?,
        robotics::rates(MODEL, &body)?
    );
    let body: ArmVelocityMotionBody = example("ArmVelocityMotionBody")?;
    let moved = robotics::velocity_motion(MODEL, &body)?;
    assert_eq!(arms.velocity_motion(MODEL, &body).await?, moved);
    let body: ArmCalibrationBody = example("ArmCalibrationBody")?;
    let tool = robotics::calibrate(MODEL, &body)?;
    assert_eq!(arms.calibrate_tool(MODEL, &body).await?, tool);
    let body: ReachBody = example("ReachBody")?;
    let reached = robotics::reach(MODEL, &body)?;
    assert_eq!(arms.reachability(MODEL, &body).await?, reached);
    assert_eq!(server.robot().reachability(&body).await?, reached);
    let body: TrajectoryBody = example("TrajectoryBody")?;
    let planned = robotics::trajectory(MODEL, &body)?;
    assert_eq!(arms.trajectory(MODEL, &body).await?, planned);
    let body: ToolPathBody = example("ToolPathBody")?;
    assert_eq!(
        arms.tool_path(MODEL, &body).await?,
        robotics::tool_path(MODEL, &body)?
    );
    let body: ArmTransferBody = example("ArmTransferBody")?;
    assert_eq!(
        arms.transfer(MODEL, &body).await?,
        robotics::transfer(MODEL, &body)?
    );
    let body: PlanRouteBody = example("PlanRouteBody")?;
    assert_eq!(arms.plan_route(&body).await?, robotics::plan_route(&body)?);

    let Err(ClientError::Problem(problem)) = arms.describe("kuka").await else {
        anyhow::bail!("there is no such model");
    };
    assert_eq!(
        (problem.code, problem.outcome),
        (ProblemCode::NotFound, Outcome::None)
    );
    Ok(())
}
