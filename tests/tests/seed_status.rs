//! Motions of tier 1: the server, and the pose server with the status program beside it on a virtual controller. Its
//! ledger is the truth.

#![expect(
    clippy::unwrap_used,
    reason = "helpers of tests: a failure here fails the test"
)]

use std::net::SocketAddr;
use std::time::Duration;

use api::{
    LinkState, Motion, MotionBody, MotionState, MotionType, PoseBody, PoseSource, ProblemCode,
    RelativeTo, StopBody, StopEffect, TargetBody, Tier,
};
use client::{Ask, ClientError, Robot};
use karel_emulator::cell_server::{COMMAND_PORT, STATUS_PORT};
use karel_emulator::{Clock, ControllerConfig, LedgerEvent, PeerLabels, VirtualController};
use kinematics::ArmModel;
use server::config::RobotSection;
use tests::{ChaosProxy, Direction, Look, MODEL, Mode, TestServer, robot_at, wait_until};

const LONG: Duration = Duration::from_secs(30);
const TIME_SCALE: f64 = 4.0;
const POSE: PoseBody = PoseBody {
    x_mm: 985.0,
    y_mm: 100.0,
    z_mm: 900.0,
    w_deg: -180.0,
    p_deg: 0.0,
    r_deg: 0.0,
};
const FAR: PoseBody = PoseBody {
    x_mm: 700.0,
    y_mm: 700.0,
    ..POSE
};

/// A controller, and the server on it, where a proxy may stand in front of the command port.
struct Cell {
    controller: VirtualController,
    server: TestServer,
}

impl Cell {
    async fn start() -> anyhow::Result<Self> {
        let controller = controller();
        let command = controller.address_of_port(COMMAND_PORT).await?;
        Self::behind(controller, command).await
    }

    async fn behind(controller: VirtualController, command: SocketAddr) -> anyhow::Result<Self> {
        let status = controller.address_of_port(STATUS_PORT).await?;
        let server = TestServer::start(section(command, status)).await?;
        wait_until("the link takes motions", LONG, async || {
            match server.robot().state().await {
                Ok(state) if state.link.state == LinkState::Control => Look::Ready(()),
                other => Look::not_yet(format!("{other:?}")),
            }
        })
        .await?;
        Ok(Self { controller, server })
    }

    async fn events(&self) -> Vec<LedgerEvent> {
        let ledger = self.controller.ledger().await.unwrap();
        ledger.iter().map(|entry| entry.event).collect()
    }

    async fn started(&self) -> usize {
        let events = self.events().await;
        let started = |event: &&LedgerEvent| **event == LedgerEvent::Started;
        events.iter().filter(started).count()
    }

    async fn end(self) -> anyhow::Result<()> {
        self.server.shutdown().await?;
        self.controller.shutdown().await;
        Ok(())
    }
}

fn controller() -> VirtualController {
    let config = ControllerConfig::seed_status("arm-1", ArmModel::builtin(MODEL).unwrap());
    let clock = Clock::scaled(TIME_SCALE).unwrap();
    VirtualController::start(&config, clock, PeerLabels::new()).unwrap()
}

fn section(command: SocketAddr, status: SocketAddr) -> RobotSection {
    RobotSection {
        tier: Tier::SeedStatus,
        status_controller: Some(status.to_string()),
        time_scale: TIME_SCALE,
        reply_timeout_ms: 2_000,
        ..robot_at(command)
    }
}

fn to(pose: PoseBody, speed: f64) -> MotionBody {
    MotionBody {
        target: Some(TargetBody::Pose(pose)),
        speed_mm_s: Some(speed),
        ..MotionBody::new(MotionType::Joint)
    }
}

async fn done(robot: &Robot, body: &MotionBody) -> Result<Motion, ClientError> {
    let ask = Ask {
        key: None,
        wait: Some(LONG),
    };
    robot.ask_for_motion(body, &ask).await
}

fn problem<T: std::fmt::Debug>(result: Result<T, ClientError>) -> api::Problem {
    match result {
        Err(ClientError::Problem(problem)) => *problem,
        other => panic!("{other:?}"),
    }
}

async fn until_state(robot: &Robot, id: uuid::Uuid, wanted: MotionState) -> anyhow::Result<Motion> {
    let what = format!("the motion is {wanted:?}");
    Ok(
        wait_until(&what, LONG, async || match robot.motion(id).await {
            Ok(motion) if motion.state == wanted => Look::Ready(motion),
            other => Look::not_yet(format!("{other:?}")),
        })
        .await?,
    )
}

#[tokio::test]
async fn a_motion_succeeds_when_the_arm_is_seen_at_its_target_and_a_relative_one_counts_from_there()
-> anyhow::Result<()> {
    let cell = Cell::start().await?;
    let robot = cell.server.robot();
    let described = robot.describe().await?;
    assert_eq!(described.tier, Tier::SeedStatus);
    assert!(described.capabilities.completion_observable);
    assert_eq!(described.capabilities.stop_effect, StopEffect::HaltsMotion);
    assert!(!described.capabilities.hold_and_continue);

    let motion = done(&robot, &to(POSE, 1_500.0)).await?;
    assert_eq!(motion.state, MotionState::Succeeded, "{motion:?}");
    let evidence = motion.evidence.unwrap();
    assert!(evidence.distance_mm < 0.5 && evidence.standing);
    let state = robot.state().await?;
    assert_eq!(state.pose_source, PoseSource::Controller);

    let up = MotionBody {
        relative_to: Some(RelativeTo::Actual),
        motion_type: MotionType::Relative,
        ..to([0.0, 0.0, 25.0, 0.0, 0.0, 0.0].into(), 1_500.0)
    };
    let motion = done(&robot, &up).await?;
    let from = motion.counted_from.unwrap();
    assert!((motion.target.z_mm - from.z_mm - 25.0).abs() < 0.002);
    assert!((cell.controller.state().await?.pose.z_mm - 925.0).abs() < 0.5);

    // What the pose server cannot do is refused, and not taken for something else.
    let line = MotionBody {
        motion_type: MotionType::Linear,
        ..to(POSE, 100.0)
    };
    let refused = problem(done(&robot, &line).await);
    assert_eq!(refused.code, ProblemCode::NotSupported);
    let percent = MotionBody {
        speed_mm_s: None,
        speed_percent: Some(10.0),
        ..to(POSE, 1.0)
    };
    let refused = problem(done(&robot, &percent).await);
    assert_eq!(refused.code, ProblemCode::Validation);
    assert_eq!(cell.started().await, 2);
    cell.end().await
}

#[tokio::test]
async fn a_running_motion_is_stopped_and_never_goes_on_and_the_next_one_is_served()
-> anyhow::Result<()> {
    let cell = Cell::start().await?;
    let robot = cell.server.robot();
    let slow = robot.create_motion(&to(FAR, 20.0)).await?;
    let _moving = until_state(&robot, slow.id, MotionState::Executing).await?;
    let refused = problem(robot.pause_motion(slow.id).await);
    assert_eq!(refused.code, ProblemCode::NotSupported);
    let stopped = robot.stop(StopBody::default()).await?;
    assert_eq!(stopped.stop_effect, StopEffect::HaltsMotion);
    let _ended = until_state(&robot, slow.id, MotionState::Canceled).await?;
    let motion = done(&robot, &to(POSE, 1_500.0)).await?;
    assert_eq!(motion.state, MotionState::Succeeded);
    assert_eq!(cell.started().await, 2);
    cell.end().await
}

/// C5: an alarm in the middle; nothing goes on when it is reset.
#[tokio::test]
async fn c5_an_alarm_in_the_middle_of_a_motion_fails_it_for_good() -> anyhow::Result<()> {
    let cell = Cell::start().await?;
    let robot = cell.server.robot();
    let slow = robot.create_motion(&to(FAR, 20.0)).await?;
    let _moving = until_state(&robot, slow.id, MotionState::Executing).await?;
    cell.controller.emergency_stop(true).await?;
    let failed = until_state(&robot, slow.id, MotionState::Failed).await?;
    let evidence = failed.evidence.unwrap();
    assert!(evidence.alarm.is_some(), "{evidence:?}");
    cell.controller.emergency_stop(false).await?;
    cell.controller.reset().await?;
    wait_until(
        "the controller is ready again",
        LONG,
        async || match robot.state().await {
            Ok(state) if state.link.state == LinkState::Control => Look::Ready(()),
            other => Look::not_yet(format!("{other:?}")),
        },
    )
    .await?;
    let motion = done(&robot, &to(POSE, 1_500.0)).await?;
    assert_eq!(motion.state, MotionState::Succeeded);
    assert_eq!(cell.started().await, 2);
    cell.end().await
}

/// W5: the reply is cut off on its way; it is not known whether the motion was taken until the arm is seen there.
#[tokio::test]
async fn w5_a_lost_reply_leaves_the_motion_open_until_the_pose_proves_it() -> anyhow::Result<()> {
    let controller = controller();
    let command = controller.address_of_port(COMMAND_PORT).await?;
    let proxy = ChaosProxy::start(command).await?;
    let cell = Cell::behind(controller, proxy.address()).await?;
    let robot = cell.server.robot();
    // The first motion has fenced the pose server, so that the next connection is the command's.
    let first = done(&robot, &to(POSE, 1_500.0)).await?;
    assert_eq!(first.state, MotionState::Succeeded);
    proxy.set(Mode::CutAfter(Direction::ToClient, 0)).await?;
    let motion = done(&robot, &to(FAR, 1_500.0)).await?;
    assert_eq!(motion.state, MotionState::Succeeded, "{motion:?}");
    assert_eq!(cell.started().await, 2, "and it was sent once");
    cell.end().await
}

/// W5: the command itself is lost, and nobody can tell. The arm stands where it stood: that is shown, and a person
/// decides.
#[tokio::test]
async fn w5_a_command_that_nobody_answers_is_in_doubt_with_where_the_arm_stands()
-> anyhow::Result<()> {
    let controller = controller();
    let command = controller.address_of_port(COMMAND_PORT).await?;
    let proxy = ChaosProxy::start(command).await?;
    let cell = Cell::behind(controller, proxy.address()).await?;
    let robot = cell.server.robot();
    let first = done(&robot, &to(POSE, 1_500.0)).await?;
    assert_eq!(first.state, MotionState::Succeeded);
    proxy.set(Mode::Blackhole).await?;
    let motion = robot.create_motion(&to(FAR, 1_500.0)).await?;
    let doubt = until_state(&robot, motion.id, MotionState::InDoubt).await?;
    let evidence = doubt.evidence.unwrap();
    assert!(
        evidence.standing && evidence.distance_mm > 100.0,
        "{evidence:?}"
    );
    let refused = problem(robot.create_motion(&to(POSE, 100.0)).await);
    assert_eq!(refused.code, ProblemCode::InDoubt);
    assert_eq!(cell.started().await, 1);
    cell.end().await
}
