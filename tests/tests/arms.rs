//! Every question about arms and paths through the typed client against the real server: the answer is the library's.

use anyhow::Context as _;
use api::arms::{
    ArmCalibrationBody, ArmForwardBody, ArmInverseBody, ArmInverseDynamicsBody, ArmJacobianBody,
    ArmRatesBody, ArmTransferBody, ArmVelocityMotionBody, ReachBody,
};
use api::paths::PlanRouteBody;
use api::trajectory::{ToolPathBody, TrajectoryBody};
use api::{Outcome, ProblemCode};
use client::ClientError;
use karel_emulator::motion::path::Path;
use kinematics::{ArmModel, PendantJoints};
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

    // Each question's example, through the typed client and asked of the library.
    macro_rules! same_answers {
        ($($body:ident: $asked:ident is $answer:ident;)*) => {$(
            let body: $body = example(stringify!($body))?;
            let answer = robotics::$answer(MODEL, &body)?;
            assert_eq!(arms.$asked(MODEL, &body).await?, answer, stringify!($asked));
        )*};
    }
    same_answers! {
        ArmForwardBody: forward is forward;
        ArmInverseBody: inverse is inverse;
        ArmJacobianBody: jacobian is jacobian;
        ArmRatesBody: rates is rates;
        ArmInverseDynamicsBody: inverse_dynamics is inverse_dynamics;
        ArmVelocityMotionBody: velocity_motion is velocity_motion;
        ArmCalibrationBody: calibrate_tool is calibrate;
        ReachBody: reachability is reach;
        TrajectoryBody: trajectory is trajectory;
        ToolPathBody: tool_path is tool_path;
        ArmTransferBody: transfer is transfer;
    }
    // This robot has no tool and no user frame.
    let body: ArmJacobianBody = example("ArmJacobianBody")?;
    assert_eq!(
        server.robot().jacobian(&body).await?,
        robotics::jacobian(MODEL, &body)?
    );
    let body: ReachBody = example("ReachBody")?;
    assert_eq!(
        server.robot().reachability(&body).await?,
        robotics::reach(MODEL, &body)?
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

/// What the server says of a joint motion before it is made, and what the virtual controller makes of it.
#[test]
fn a_joint_motion_takes_as_long_as_the_server_says() {
    let arm = ArmModel::builtin(MODEL).unwrap();
    let postures = [
        [0.0, 0.0, 0.0, 0.0, -90.0, 0.0],
        [60.0, 20.0, -20.0, 10.0, -70.0, 30.0],
        [60.1, 20.0, -20.0, 10.0, -70.0, 30.0],
        [-150.0, 80.0, 60.0, -170.0, 120.0, 260.0],
    ]
    .map(PendantJoints::from_degrees);
    for from in &postures {
        for to in postures.iter().filter(|to| *to != from) {
            for percent in [1.0, 37.0, 100.0] {
                let said = robotics::joint_seconds(arm, from, to, percent / 100.0);
                let moved = Path::joint_at(arm, *from, *to, percent / 100.0, 1.0).duration();
                assert!((said - moved).abs() < 1e-9, "{from} {to}: {said} {moved}");
            }
        }
    }
}
