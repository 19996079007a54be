//! A request at one end of a whole cell, and what the arm really did at the other.

use std::time::Duration;

use api::{
    ForwardBody, InverseBody, JointsBody, LegacyDelta, Motion, MotionBody, MotionState, MotionType,
    Outcome, PoseBody, ProblemCode, TargetBody,
};
use client::{ClientError, Page};
use karel_emulator::{LedgerEntry, LedgerEvent};
use tests::{ACCEPTED, Direction, Look, Mode, TestCell, wait_until, while_stepping};
use tokio::io::{AsyncReadExt as _, AsyncWriteExt as _};
use tokio::net::TcpStream;

/// Long enough for a slow machine, and never waited for in full when all is well.
const LONG: Duration = Duration::from_secs(30);

/// What one thousandth, the wire's unit, may cost a joint, in degrees.
const JOINT_TOLERANCE: f64 = 0.01;

const POSE: PoseBody = PoseBody {
    x_mm: 900.0,
    y_mm: 100.0,
    z_mm: 800.0,
    w_deg: -180.0,
    p_deg: 0.0,
    r_deg: 0.0,
};

const FAR_AWAY: PoseBody = PoseBody {
    x_mm: 5_000.0,
    ..POSE
};

fn to(pose: PoseBody) -> MotionBody {
    MotionBody {
        target: Some(TargetBody::Pose(pose)),
        speed_mm_s: Some(500.0),
        reason: Some("end to end".to_owned()),
        ..MotionBody::new(MotionType::Joint)
    }
}

fn home() -> MotionBody {
    MotionBody {
        motion_type: MotionType::Home,
        target: None,
        ..to(POSE)
    }
}

#[track_caller]
fn assert_near(actual: [f64; 6], expected: JointsBody) {
    for (actual, expected) in actual.into_iter().zip(<[f64; 6]>::from(expected)) {
        assert!(
            (actual - expected).abs() < JOINT_TOLERANCE,
            "{actual} is not {expected}"
        );
    }
}

fn problem(result: Result<Motion, ClientError>) -> api::Problem {
    match result {
        Err(ClientError::Problem(problem)) => *problem,
        other => panic!("{other:?}"),
    }
}

async fn ledger(cell: &TestCell) -> anyhow::Result<Vec<LedgerEntry>> {
    Ok(cell.emulator().ledger().await?)
}

#[tokio::test]
async fn an_accepted_motion_arrives_where_the_server_expects_it() -> anyhow::Result<()> {
    let cell = TestCell::start().await?;
    let motion = cell.robot().create_motion(&to(POSE)).await?;
    assert_eq!(motion.state, MotionState::Accepted);

    let state = cell.wait_until_finished(1, LONG).await?;
    assert_near(state.joints_deg.into(), motion.expected_joints);
    let ledger = ledger(&cell).await?;
    let events: Vec<LedgerEvent> = ledger.iter().map(|entry| entry.event).collect();
    assert_eq!(events, [LedgerEvent::Started, LedgerEvent::Finished]);
    assert!((ledger[0].target_pose.x_mm - POSE.x_mm).abs() < 1e-3);
    assert!((ledger[0].speed_mm_s - 500.0).abs() < 1e-9);

    assert_eq!(cell.robot().motion(motion.id).await?, motion);
    cell.shutdown().await
}

#[tokio::test]
async fn one_request_id_runs_from_the_client_to_the_ledger() -> anyhow::Result<()> {
    let cell = TestCell::start().await?;
    let robot = cell
        .client()
        .with_request_id("end-to-end-1")?
        .robot("demo", "r1");
    let motion = robot.create_motion(&home()).await?;
    assert_eq!(motion.request_id, "end-to-end-1");
    let _ = cell.wait_until_finished(1, LONG).await?;
    let entry = &ledger(&cell).await?[0];
    assert_eq!(entry.request_id.as_deref(), Some("end-to-end-1"));

    let told = cell.panel()?.ledger(None).await?;
    assert_eq!(told.entries[0].request_id.as_deref(), Some("end-to-end-1"));
    cell.shutdown().await
}

#[tokio::test]
async fn the_panel_tells_what_the_controller_knows() -> anyhow::Result<()> {
    let cell = TestCell::start().await?;
    let motion = cell.robot().create_motion(&to(POSE)).await?;
    let _ = cell.wait_until_finished(1, LONG).await?;
    let panel = cell.panel()?;
    // The program answers before it starts the motion and hangs up after that: its end of the connection tells.
    let told = wait_until(
        "a controller that stands still",
        LONG,
        async || match panel.state().await {
            Ok(state) if state.is_still() => Look::Ready(state),
            other => Look::not_yet(format!("{other:?}")),
        },
    )
    .await?;
    assert_near(told.joints_deg.into(), motion.expected_joints);
    assert_eq!(told.ledger_seq, 2);
    assert_eq!(told.limits_deg.len(), 6);
    assert_eq!(panel.ledger(Some(1)).await?.entries.len(), 1);
    assert_eq!(panel.alarms().await?.entries, []);
    cell.shutdown().await
}

#[tokio::test]
async fn a_pose_out_of_reach_never_comes_near_the_controller() -> anyhow::Result<()> {
    let (cell, proxy) = TestCell::start_behind_proxy().await?;
    let refused = problem(cell.robot().create_motion(&to(FAR_AWAY)).await);
    assert_eq!(refused.code, ProblemCode::OutOfWorkspace);
    assert_eq!(refused.outcome, Outcome::NotSent);
    assert_eq!(proxy.traffic().connections, 0);
    assert_eq!(ledger(&cell).await?, []);
    cell.shutdown().await
}

/// Covers: W5, N2.
#[tokio::test]
async fn a_lost_reply_is_in_doubt_and_the_arm_moved_once() -> anyhow::Result<()> {
    let (cell, proxy) = TestCell::start_behind_proxy().await?;
    proxy.set(Mode::CutAfter(Direction::ToClient, 0)).await?;
    let doubt = problem(cell.robot().create_motion(&to(POSE)).await);
    assert_eq!(doubt.outcome, Outcome::Unknown);

    let _ = cell.wait_until_finished(1, LONG).await?;
    assert_eq!(ledger(&cell).await?.len(), 2, "started and finished, once");
    let motions = cell.robot().motions(&Page::default()).await?.motions;
    assert_eq!(motions.len(), 1);
    assert_eq!(motions[0].state, MotionState::InDoubt);
    assert_eq!(cell.robot().state().await?.pose, None);
    cell.shutdown().await
}

#[tokio::test]
async fn a_refused_connection_is_a_proof_and_the_arm_stands_still() -> anyhow::Result<()> {
    let (cell, proxy) = TestCell::start_behind_proxy().await?;
    proxy.set(Mode::Refuse).await?;
    let lost = problem(cell.robot().create_motion(&to(POSE)).await);
    assert_eq!(lost.code, ProblemCode::ControllerDisconnected);
    assert_eq!(lost.outcome, Outcome::NotSent);
    assert_eq!(ledger(&cell).await?, []);

    proxy.set(Mode::Pass).await?;
    let motion = cell.robot().create_motion(&to(POSE)).await?;
    assert_eq!(motion.state, MotionState::Accepted);
    cell.shutdown().await
}

#[tokio::test]
async fn inverse_and_forward_kinematics_agree_with_the_arm() -> anyhow::Result<()> {
    let cell = TestCell::start().await?;
    let robot = cell.robot();
    let inverse = robot
        .inverse(&InverseBody {
            pose: POSE,
            near: None,
        })
        .await?;
    let controller = inverse.controller.expect("the controller reaches the pose");
    let joints = inverse.branches[controller].joints;
    let forward = robot.forward(&ForwardBody { joints }).await?;
    assert!((forward.pose.x_mm - POSE.x_mm).abs() < 1e-6);

    let _ = robot.create_motion(&to(POSE)).await?;
    let state = cell.wait_until_finished(1, LONG).await?;
    assert_near(state.joints_deg.into(), joints);
    cell.shutdown().await
}

#[tokio::test]
async fn the_seeds_routes_move_the_same_arm() -> anyhow::Result<()> {
    let cell = TestCell::start().await?;
    let homed = cell.client().legacy_home(Some(500)).await?.current_position;
    let down = LegacyDelta {
        dx: 0.0,
        dy: 0.0,
        dz: -50.0,
        dw: 0.0,
        dp: 0.0,
        dr: 0.0,
    };
    let lowered = cell
        .client()
        .legacy_delta(&down, None)
        .await?
        .current_position;
    assert!((homed.z - 50.0 - lowered.z).abs() < 1e-9);
    let state = cell.wait_until_finished(2, LONG).await?;
    assert!(
        (state.pose.z_mm - lowered.z).abs() < 0.01,
        "{:?}",
        state.pose
    );
    cell.shutdown().await
}

#[tokio::test]
async fn an_answer_comes_before_the_end_and_a_second_motion_waits_its_turn() -> anyhow::Result<()> {
    let (cell, stepper) = TestCell::start_stepped().await?;
    let robot = cell.robot();
    let first = while_stepping(&stepper, robot.create_motion(&to(POSE))).await??;
    assert_eq!(first.state, MotionState::Accepted);
    let second = while_stepping(&stepper, robot.create_motion(&home())).await??;
    assert_eq!(second.state, MotionState::Accepted);
    assert!(cell.emulator().state().await?.moving);

    let end = while_stepping(&stepper, cell.wait_until_finished(2, LONG)).await??;
    assert_near(end.joints_deg.into(), second.expected_joints);
    let order: Vec<LedgerEvent> = ledger(&cell)
        .await?
        .iter()
        .map(|entry| entry.event)
        .collect();
    // The thesis's program says `$TERMTYPE = NODECEL`, so the second motion begins while the first one brakes.
    let (started, finished) = (LedgerEvent::Started, LedgerEvent::Finished);
    assert_eq!(order, [started, started, LedgerEvent::Passed, finished]);
    cell.shutdown().await
}

#[tokio::test]
async fn the_theses_own_line_over_bare_tcp_brings_the_arm_to_its_point() -> anyhow::Result<()> {
    let cell = TestCell::start().await?;
    let address = cell.emulator().address_of_port(59_002).await?;
    let mut stream = TcpStream::connect(address).await?;
    stream
        .write_all(b"600000 200000 600000 -180000 30000 0 300 1")
        .await?;
    let mut reply = Vec::new();
    let _length = stream.read_to_end(&mut reply).await?;
    assert_eq!(reply, ACCEPTED);

    let pose = cell.wait_until_finished(1, LONG).await?.pose;
    for (actual, expected) in [
        (pose.x_mm, 600.0),
        (pose.y_mm, 200.0),
        (pose.z_mm, 600.0),
        (pose.w_deg.abs(), 180.0),
        (pose.p_deg, 30.0),
        (pose.r_deg, 0.0),
    ] {
        assert!((actual - expected).abs() < 0.01, "{pose:?}");
    }
    let ledger = ledger(&cell).await?;
    let events: Vec<LedgerEvent> = ledger.iter().map(|entry| entry.event).collect();
    assert_eq!(events, [LedgerEvent::Started, LedgerEvent::Finished]);
    assert!((ledger[0].speed_mm_s - 300.0).abs() < 1e-9);
    assert_eq!(ledger[0].request_id, None);
    cell.shutdown().await
}
