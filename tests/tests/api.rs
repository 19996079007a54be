//! Every call of the typed client against the real server: the bodies of both sides are the same.

use api::{
    ForwardBody, InverseBody, LinkState, MotionBody, MotionState, MotionType, Outcome, PoseBody,
    PoseSource, ProblemCode, TargetBody,
};
use client::{ClientError, Page, Robot};
use tests::{CELL, FakeRobot, MODEL, ROBOT, TestServer, Turn, UNREACHABLE, robot_at};

const POSE: PoseBody = PoseBody {
    x_mm: 900.0,
    y_mm: 100.0,
    z_mm: 800.0,
    w_deg: -180.0,
    p_deg: 0.0,
    r_deg: 0.0,
};

fn to(target: TargetBody) -> MotionBody {
    MotionBody {
        target: Some(target),
        speed_mm_s: Some(200.0),
        deadline_ms: Some(20_000),
        reason: Some("a test".to_owned()),
        ..MotionBody::new(MotionType::Joint)
    }
}

fn home() -> MotionBody {
    MotionBody {
        motion_type: MotionType::Home,
        target: None,
        ..to(TargetBody::Pose(POSE))
    }
}

async fn problem(robot: &Robot, body: &MotionBody) -> api::Problem {
    match robot.create_motion(body).await {
        Err(ClientError::Problem(problem)) => *problem,
        other => panic!("{other:?}"),
    }
}

async fn start(
    script: impl IntoIterator<Item = Turn>,
) -> anyhow::Result<(TestServer, FakeRobot, Robot)> {
    let robot = FakeRobot::start(script).await?;
    let server = TestServer::start(robot_at(robot.address())).await?;
    let seen = server.robot();
    Ok((server, robot, seen))
}

#[tokio::test]
async fn what_there_is_can_be_listed_and_described() -> anyhow::Result<()> {
    let (server, controller, robot) = start([]).await?;
    let client = server.client();
    let cells = client.cells().await?;
    assert_eq!(cells.len(), 1);
    assert_eq!(client.cell(CELL).await?, cells[0]);
    assert_eq!(client.robots(CELL).await?, cells[0].robots);
    let description = robot.describe().await?;
    assert_eq!(description.id, ROBOT);
    assert_eq!(description.model, MODEL);
    assert_eq!(description.joints.len(), 6);
    assert_eq!(
        description.controller_address,
        controller.address().to_string()
    );

    assert!(client.livez().await?.alive);
    assert!(client.readyz().await?.ready);
    assert_eq!(client.version().await?.version.len(), 1);
    assert!(client.metrics().await?.contains("# TYPE"));
    server.shutdown().await
}

#[tokio::test]
async fn what_there_is_not_is_not_found() -> anyhow::Result<()> {
    let (server, _controller, robot) = start([]).await?;
    let nobody = server.client().robot(CELL, "nobody");
    for error in [
        nobody.state().await.unwrap_err(),
        server.client().cell("../x").await.unwrap_err(),
        robot.motion(uuid::Uuid::nil()).await.unwrap_err(),
    ] {
        let problem = error.problem().expect("a problem");
        assert_eq!(problem.code, ProblemCode::NotFound);
    }
    Ok(())
}

#[tokio::test]
async fn forward_and_inverse_kinematics_agree() -> anyhow::Result<()> {
    let (_server, _controller, robot) = start([]).await?;
    // Tilted, so that no wrist angle lies on the seam at 180 degrees between two turn numbers.
    let pose = PoseBody {
        w_deg: -170.0,
        p_deg: 10.0,
        r_deg: 20.0,
        ..POSE
    };
    let body = InverseBody {
        pose,
        near: Some(robot.describe().await?.home),
    };
    let inverse = robot.inverse(&body).await?;
    assert!(inverse.branches.len() >= 2);
    assert!(inverse.controller.is_some());
    for branch in &inverse.branches {
        let joints = branch.joints;
        let forward = robot.forward(&ForwardBody { joints }).await?;
        assert_eq!(forward.configuration, branch.configuration, "{joints:?}");
        assert!((forward.pose.x_mm - pose.x_mm).abs() < 1e-6);
        assert!((forward.pose.z_mm - pose.z_mm).abs() < 1e-6);
    }
    Ok(())
}

#[tokio::test]
async fn a_motion_is_recorded_and_found_again() -> anyhow::Result<()> {
    let (_server, controller, robot) = start([]).await?;
    let before = robot.state().await?;
    assert_eq!(before.link.state, LinkState::Untried);
    assert_eq!(before.pose_source, PoseSource::Unknown);

    let motion = robot.create_motion(&to(TargetBody::Pose(POSE))).await?;
    assert_eq!(motion.state, MotionState::Accepted);
    assert_eq!(motion.target, POSE);
    assert_eq!(robot.motion(motion.id).await?, motion);
    assert_eq!(controller.received().len(), 1);

    let after = robot.state().await?;
    assert_eq!(after.pose, Some(POSE));
    assert_eq!(after.last_motion, Some(motion.id));
    Ok(())
}

#[tokio::test]
async fn joints_as_a_target_are_sent_as_the_pose_they_reach() -> anyhow::Result<()> {
    let (_server, controller, robot) = start([]).await?;
    let joints = robot.describe().await?.home;
    let by_joints = robot.create_motion(&to(TargetBody::Joints(joints))).await?;
    let by_name = robot.create_motion(&home()).await?;
    assert_eq!(by_joints.target, by_name.target);
    let received = controller.received();
    assert_eq!(received[0], received[1]);
    Ok(())
}

#[tokio::test]
async fn pages_join_into_the_whole_list() -> anyhow::Result<()> {
    let (_server, _controller, robot) = start([]).await?;
    let mut created = Vec::new();
    for _ in 0..5 {
        created.insert(0, robot.create_motion(&home()).await?.id);
    }
    let mut listed = Vec::new();
    let mut page = Page {
        limit: Some(2),
        cursor: None,
    };
    loop {
        let list = robot.motions(&page).await?;
        assert!(list.motions.len() <= 2);
        listed.extend(list.motions.iter().map(|motion| motion.id));
        match list.next_cursor {
            Some(cursor) => page.cursor = Some(cursor),
            None => break,
        }
    }
    assert_eq!(listed, created, "newest first, each once");
    Ok(())
}

#[tokio::test]
async fn a_body_that_does_not_fit_is_refused_by_name_value_and_limit() -> anyhow::Result<()> {
    let (_server, controller, robot) = start([]).await?;
    let mut body = to(TargetBody::Pose(POSE));
    body.speed_mm_s = Some(2_000.0);
    let problem = problem(&robot, &body).await;
    assert_eq!(problem.code, ProblemCode::Validation);
    assert_eq!(problem.outcome, Outcome::NotSent);
    let violation = &problem.violations[0];
    assert_eq!(violation.item, "speed_mm_s");
    assert_eq!(violation.value, Some(2_000.0));
    assert_eq!(violation.max, Some(1_999.0));
    assert_eq!(controller.received(), Vec::<String>::new());
    Ok(())
}

#[tokio::test]
async fn joints_outside_their_limits_are_refused_by_joint() -> anyhow::Result<()> {
    let (_server, controller, robot) = start([]).await?;
    let mut joints = robot.describe().await?.home;
    joints.j5_deg = 179.0;
    let problem = problem(&robot, &to(TargetBody::Joints(joints))).await;
    assert_eq!(problem.code, ProblemCode::JointLimitExceeded, "{problem:?}");
    assert!(
        problem
            .violations
            .iter()
            .any(|violation| violation.item == "J5")
    );
    assert_eq!(controller.received(), Vec::<String>::new());
    Ok(())
}

#[tokio::test]
async fn the_controllers_no_is_recorded_with_its_words() -> anyhow::Result<()> {
    let (_server, _controller, robot) = start([Turn::reply(UNREACHABLE)]).await?;
    let problem = problem(&robot, &home()).await;
    assert_eq!(problem.code, ProblemCode::ControllerRejected);
    assert_eq!(
        problem.controller_text.as_deref(),
        Some("ERROR: POINT UNREACHABLE")
    );
    let motion = robot
        .motion(problem.motion.expect("a motion was recorded"))
        .await?;
    assert_eq!(motion.state, MotionState::Rejected);
    assert_eq!(motion.outcome, Some(Outcome::Rejected));
    Ok(())
}
