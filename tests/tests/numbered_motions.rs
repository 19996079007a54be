//! Motions of tier 2: the server, and the cell server's programs on a virtual controller. Its ledger is the truth.

#![expect(
    clippy::unwrap_used,
    reason = "helpers of tests: a failure here fails the test"
)]

use std::time::Duration;

use api::{
    AcquireBody, JointsBody, LossBehavior, Motion, MotionBody, MotionState, MotionType, PoseBody,
    ProblemCode, RelativeTo, SpeedOverride, Station, StopBody, StopEffect, TargetBody, Tier,
};
use client::{Ask, ClientError, Robot};
use journal::{Clocks, KeyRetention, MemoryDisk, MemoryJournal, Opening};
use karel_emulator::cell_server::{COMMAND_PORT, STATUS_PORT};
use karel_emulator::{Clock, ControllerConfig, LedgerEvent, PeerLabels, VirtualController};
use kinematics::ArmModel;
use server::config::RobotSection;
use server::{SharedJournal, TcpConnector};
use tests::{CELL, Look, MODEL, ROBOT, TestServer, robot_at, wait_until};

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

fn controller() -> VirtualController {
    let model = ArmModel::builtin(MODEL).unwrap();
    let config = ControllerConfig::cell_server("arm-1", model);
    VirtualController::start(
        &config,
        Clock::scaled(TIME_SCALE).unwrap(),
        PeerLabels::new(),
    )
    .unwrap()
}

fn opened(disk: &MemoryDisk) -> SharedJournal {
    let opening = Opening {
        at: Clocks {
            wall: jiff::Timestamp::now(),
            monotonic: Duration::ZERO,
        },
        program: "test".into(),
        keys: KeyRetention::default(),
    };
    SharedJournal::durable(MemoryJournal::open(disk, &opening).unwrap())
}

async fn section(controller: &VirtualController) -> anyhow::Result<RobotSection> {
    let command = controller.address_of_port(COMMAND_PORT).await?;
    let status = controller.address_of_port(STATUS_PORT).await?;
    let mut section = robot_at(command);
    section.tier = Tier::CellServer;
    section.status_controller = Some(status.to_string());
    section.time_scale = TIME_SCALE;
    Ok(section)
}

async fn serve(controller: &VirtualController, disk: &MemoryDisk) -> anyhow::Result<TestServer> {
    let section = section(controller).await?;
    let server = TestServer::with_journal(section, TcpConnector::default(), opened(disk)).await?;
    until_in_control(&server).await?;
    Ok(server)
}

async fn until_in_control(server: &TestServer) -> anyhow::Result<()> {
    wait_until("the link takes motions", LONG, async || {
        match server.robot().state().await {
            Ok(state) if state.link.state == api::LinkState::Control => Look::Ready(()),
            other => Look::not_yet(format!("{other:?}")),
        }
    })
    .await?;
    Ok(())
}

fn to(pose: PoseBody, percent: f64) -> MotionBody {
    MotionBody {
        target: Some(TargetBody::Pose(pose)),
        speed_percent: Some(percent),
        ..MotionBody::new(MotionType::Joint)
    }
}

fn home() -> MotionBody {
    MotionBody {
        speed_percent: Some(100.0),
        ..MotionBody::new(MotionType::Home)
    }
}

async fn done(robot: &Robot, body: &MotionBody) -> Result<Motion, ClientError> {
    let ask = Ask {
        key: None,
        wait: Some(LONG),
    };
    robot.ask_for_motion(body, &ask).await
}

fn problem(result: Result<Motion, ClientError>) -> api::Problem {
    match result {
        Err(ClientError::Problem(problem)) => *problem,
        other => panic!("{other:?}"),
    }
}

async fn started(controller: &VirtualController) -> usize {
    let ledger = controller.ledger().await.unwrap();
    let begun = |entry: &&karel_emulator::LedgerEntry| entry.event == LedgerEvent::Started;
    ledger.iter().filter(begun).count()
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
async fn a_motion_succeeds_when_the_arm_is_seen_at_its_target() -> anyhow::Result<()> {
    let (controller, disk) = (controller(), MemoryDisk::new());
    let server = serve(&controller, &disk).await?;
    let robot = server.robot();
    let motion = done(&robot, &to(POSE, 100.0)).await?;
    assert_eq!(motion.state, MotionState::Succeeded, "{motion:?}");
    let evidence = motion.evidence.unwrap();
    assert!(
        evidence.distance_mm < 0.5 && evidence.standing,
        "{evidence:?}"
    );

    // H5: counted from where the arm is, and pinned as an absolute target.
    let up = MotionBody {
        relative_to: Some(RelativeTo::Actual),
        motion_type: MotionType::Relative,
        ..to([0.0, 0.0, 25.0, 0.0, 0.0, 0.0].into(), 100.0)
    };
    let motion = done(&robot, &up).await?;
    let from = motion.counted_from.unwrap();
    assert!((motion.target.z_mm - from.z_mm - 25.0).abs() < 0.002);
    assert!((controller.state().await?.pose.z_mm - 925.0).abs() < 0.5);

    let line = MotionBody {
        speed_mm_s: Some(400.0),
        speed_percent: None,
        motion_type: MotionType::Linear,
        ..to(POSE, 1.0)
    };
    assert_eq!(done(&robot, &line).await?.state, MotionState::Succeeded);
    // H4: a line that leaves the arm's reach on its way, or ends outside, is refused.
    let far = MotionBody {
        target: Some(TargetBody::Pose(PoseBody {
            x_mm: 5_000.0,
            ..POSE
        })),
        ..line.clone()
    };
    assert_eq!(
        problem(done(&robot, &far).await).code,
        ProblemCode::OutOfWorkspace
    );
    let behind = MotionBody {
        target: Some(TargetBody::Pose(PoseBody {
            x_mm: -985.0,
            r_deg: 180.0,
            ..POSE
        })),
        ..line
    };
    let refused = problem(done(&robot, &behind).await);
    assert!(
        refused.detail.contains("straight line") || !refused.violations.is_empty(),
        "{refused:?}"
    );

    // A plan is bound to where the arm is.
    let plan = robot.preview_motion(&home()).await?;
    assert!(plan.feasible && plan.duration_s.unwrap() > 0.0, "{plan:?}");
    let profile = plan.profile.as_ref().unwrap();
    let (first, last) = (&profile.samples[0], profile.samples.last().unwrap());
    let is = |joints: Option<api::JointsBody>| <[f64; 6]>::from(joints.unwrap()).to_vec();
    assert_eq!(first.position_deg_mm, is(plan.start_joints));
    assert_eq!(last.position_deg_mm, is(plan.expected_joints));
    assert!(profile.duration_s > 0.0 && profile.failure.is_none());
    let planned = MotionBody {
        plan_id: plan.plan_id,
        ..MotionBody::new(MotionType::Home)
    };
    assert_eq!(done(&robot, &planned).await?.state, MotionState::Succeeded);
    assert_eq!(
        problem(done(&robot, &planned).await).code,
        ProblemCode::StaleState
    );
    assert_eq!(started(&controller).await, 4);
    server.shutdown().await?;
    controller.shutdown().await;
    Ok(())
}

#[tokio::test]
async fn a_running_motion_is_held_slowed_canceled_and_stopped() -> anyhow::Result<()> {
    let (controller, disk) = (controller(), MemoryDisk::new());
    let server = serve(&controller, &disk).await?;
    let robot = server.robot();
    let slow = to(POSE, 1.0);
    let motion = robot.create_motion(&slow).await?;
    let _moving = until_state(&robot, motion.id, MotionState::Executing).await?;
    // H5: nothing to count from while the arm moves.
    let turn = MotionBody {
        relative_to: Some(RelativeTo::Actual),
        motion_type: MotionType::Relative,
        ..to(POSE, 1.0)
    };
    assert_eq!(
        problem(robot.create_motion(&turn).await).code,
        ProblemCode::PoseStale
    );
    let _held = robot.pause_motion(motion.id).await?;
    let _held = until_state(&robot, motion.id, MotionState::Paused).await?;
    let _moving = robot.resume_motion(motion.id).await?;
    let _moving = until_state(&robot, motion.id, MotionState::Executing).await?;
    let slowed = robot
        .set_speed_override(SpeedOverride { percent: 50 })
        .await?;
    assert_eq!(slowed.percent, 50);
    let canceled = robot.cancel_motion(motion.id).await?;
    assert_eq!(canceled.state, MotionState::Canceled, "{canceled:?}");

    let running = robot.create_motion(&slow).await?;
    let waiting = robot.create_motion(&home()).await?;
    let _moving = until_state(&robot, running.id, MotionState::Executing).await?;
    let stopped = robot.stop(StopBody::default()).await?;
    assert_eq!(stopped.stop_effect, StopEffect::HaltsMotion);
    assert_eq!(stopped.canceled, [waiting.id]);
    let _ended = until_state(&robot, running.id, MotionState::Canceled).await?;
    assert_eq!(robot.motion(waiting.id).await?.state, MotionState::Canceled);
    assert_eq!(started(&controller).await, 2);
    server.shutdown().await?;
    controller.shutdown().await;
    Ok(())
}

/// O4, SM-3: whoever has control falls silent while the arm moves, and what he asked for in that case happens.
#[tokio::test]
async fn a_lease_that_runs_out_does_to_the_motion_what_its_holder_asked_for() -> anyhow::Result<()>
{
    let (controller, disk) = (controller(), MemoryDisk::new());
    let mut server = serve(&controller, &disk).await?;
    server.give_up_control().await?;
    for (behavior, state, y_mm) in [
        (LossBehavior::Hold, MotionState::Paused, 700.0),
        (LossBehavior::Stop1, MotionState::Canceled, -700.0),
    ] {
        // An eighth of a turn, some six seconds.
        let far = PoseBody {
            x_mm: 700.0,
            y_mm,
            ..POSE
        };
        let terms = AcquireBody {
            station: Station::Remote,
            ttl_s: Some(2),
            loss_behavior: Some(behavior),
            reason: "falls silent".to_owned(),
            preempt: false,
        };
        let lease = server.client().control(CELL).acquire(&terms).await?;
        let robot = server.client().with_control(lease.token).robot(CELL, ROBOT);
        let slow = robot.create_motion(&to(far, 1.0)).await?;
        let _ended = until_state(&robot, slow.id, state).await?;
        if state == MotionState::Paused {
            let _ended = robot.cancel_motion(slow.id).await?;
        }
    }
    server.shutdown().await?;
    controller.shutdown().await;
    Ok(())
}

/// P6, P8, P9: the server dies while the arm moves. The next one asks the controller, and sends nothing again.
#[tokio::test]
async fn after_a_crash_the_controller_is_asked_and_the_motion_is_not_sent_again()
-> anyhow::Result<()> {
    let (controller, disk) = (controller(), MemoryDisk::new());
    // A process of its own, as far as its tasks and sockets go: dropping it ends them where they are.
    let process = tokio::runtime::Runtime::new()?;
    let section = section(&controller).await?;
    let serving = TestServer::with_journal(section, TcpConnector::default(), opened(&disk));
    let server = process.spawn(serving).await??;
    until_in_control(&server).await?;
    let ask = Ask {
        key: Some("the-one".to_owned()),
        wait: None,
    };
    let body = to(POSE, 20.0);
    let motion = server.robot().ask_for_motion(&body, &ask).await?;
    let _moving = until_state(&server.robot(), motion.id, MotionState::Executing).await?;
    disk.lose_power();
    process.shutdown_background();

    let next = serve(&controller, &disk).await?;
    let robot = next.robot();
    let ended = until_state(&robot, motion.id, MotionState::Succeeded).await?;
    assert!(ended.evidence.unwrap().distance_mm < 0.5);
    let again = robot.ask_for_motion(&body, &ask).await?;
    assert_eq!((again.id, again.state), (motion.id, MotionState::Succeeded));
    assert_eq!(started(&controller).await, 1);
    // And the arm takes the next one.
    let joints: [f64; 6] = JointsBody::from([10.0, 0.0, 0.0, 0.0, -90.0, 0.0]).into();
    let body = MotionBody {
        target: Some(TargetBody::Joints(joints.into())),
        ..to(POSE, 100.0)
    };
    assert_eq!(done(&robot, &body).await?.state, MotionState::Succeeded);
    assert_eq!(started(&controller).await, 2);
    drop(server);
    next.shutdown().await?;
    controller.shutdown().await;
    Ok(())
}
