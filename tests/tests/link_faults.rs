//! A broken network between the real server and a controller: what the client is told, and that no command is ever
//! sent twice.

use api::{LegacyPoint, Outcome, ProblemCode};
use client::ClientError;
use tests::{
    ACCEPTED, ChaosProxy, Direction, FakeRobot, Gate, INCORRECT_INPUT, Mode, TestServer, Turn,
    UNREACHABLE, robot_at,
};

const POINT: LegacyPoint = LegacyPoint {
    x: 900.0,
    y: 100.0,
    z: 800.0,
    w: -180.0,
    p: 0.0,
    r: 0.0,
};

/// Exactly what goes over the wire for [`POINT`] at 200 mm/s.
const BYTES: &str = "900000 100000 800000 -180000 0 0 200 1";

/// Server, proxy and robot in a row.
struct Line {
    server: TestServer,
    proxy: ChaosProxy,
    robot: FakeRobot,
}

impl Line {
    async fn start(script: impl IntoIterator<Item = Turn>) -> anyhow::Result<Self> {
        Self::with_patience(script, 20_000).await
    }

    /// For answers that never come: the whole patience is waited for.
    async fn impatient(script: impl IntoIterator<Item = Turn>) -> anyhow::Result<Self> {
        Self::with_patience(script, 500).await
    }

    async fn with_patience(
        script: impl IntoIterator<Item = Turn>,
        reply_timeout_ms: u64,
    ) -> anyhow::Result<Self> {
        let robot = FakeRobot::start(script).await?;
        let proxy = ChaosProxy::start(robot.address()).await?;
        let mut section = robot_at(proxy.address());
        section.reply_timeout_ms = reply_timeout_ms;
        section.deadline_ms = 30_000;
        let server = TestServer::start(section).await?;
        Ok(Self {
            server,
            proxy,
            robot,
        })
    }

    async fn send(&self) -> Result<(), ClientError> {
        let moved = self.server.client().legacy_move(&POINT, Some(200)).await?;
        assert_eq!(moved.current_position, POINT);
        Ok(())
    }

    async fn expect_problem(&self, code: ProblemCode, outcome: Outcome) {
        match self.send().await {
            Err(ClientError::Problem(problem)) => {
                assert_eq!(
                    (problem.code, problem.outcome),
                    (code, outcome),
                    "{problem:?}"
                );
            }
            other => panic!("{other:?}"),
        }
    }
}

#[tokio::test]
async fn a_move_goes_over_the_wire_once_and_as_frozen() -> anyhow::Result<()> {
    let line = Line::start([]).await?;
    line.send().await?;
    assert_eq!(line.robot.received(), [BYTES]);
    line.server.shutdown().await
}

#[tokio::test]
async fn bytes_that_come_one_by_one_are_the_same_bytes() -> anyhow::Result<()> {
    let line = Line::start([]).await?;
    line.proxy.set(Mode::SplitIntoBytes).await?;
    line.send().await?;
    assert_eq!(line.robot.received(), [BYTES]);
    Ok(())
}

#[tokio::test]
async fn a_refused_connection_proves_that_nothing_was_sent() -> anyhow::Result<()> {
    let line = Line::start([]).await?;
    line.proxy.set(Mode::Refuse).await?;
    line.expect_problem(ProblemCode::ControllerDisconnected, Outcome::NotSent)
        .await;
    line.proxy.set(Mode::Pass).await?;
    line.send().await?;
    assert_eq!(line.robot.received(), [BYTES]);
    Ok(())
}

/// Covers: W5, N1.
#[tokio::test]
async fn a_command_swallowed_on_its_way_is_in_doubt() -> anyhow::Result<()> {
    let line = Line::impatient([]).await?;
    line.proxy.set(Mode::Blackhole).await?;
    line.expect_problem(ProblemCode::ControllerTimeout, Outcome::Unknown)
        .await;
    assert_eq!(line.proxy.traffic().connections, 1);
    assert_eq!(line.proxy.traffic().bytes_from_clients, BYTES.len());
    Ok(())
}

/// Covers: W3, W3.
#[tokio::test]
async fn a_command_cut_short_is_in_doubt_and_not_repeated() -> anyhow::Result<()> {
    let line = Line::start([]).await?;
    line.proxy
        .set(Mode::CutAfter(Direction::ToTarget, 4))
        .await?;
    line.expect_problem(ProblemCode::ControllerTimeout, Outcome::Unknown)
        .await;
    assert_eq!(line.proxy.traffic().connections, 1);
    Ok(())
}

/// Covers: W4, N5.
#[tokio::test]
async fn a_reply_cut_short_is_in_doubt_whatever_it_began_with() -> anyhow::Result<()> {
    for length in [0, 1, 6, ACCEPTED.len() - 1] {
        let line = Line::start([]).await?;
        line.proxy
            .set(Mode::CutAfter(Direction::ToClient, length))
            .await?;
        line.expect_problem(ProblemCode::ControllerTimeout, Outcome::Unknown)
            .await;
        assert_eq!(line.robot.received(), [BYTES], "cut after {length}");
    }
    Ok(())
}

/// Covers: W4.
#[tokio::test]
async fn a_corrupted_reply_is_in_doubt() -> anyhow::Result<()> {
    let line = Line::start([]).await?;
    line.proxy.set(Mode::CorruptReply).await?;
    line.expect_problem(ProblemCode::ControllerProtocol, Outcome::Unknown)
        .await;
    assert_eq!(line.robot.received(), [BYTES]);
    Ok(())
}

/// Covers: W7, W7.
#[tokio::test]
async fn a_doubled_reply_answers_no_later_command() -> anyhow::Result<()> {
    let line = Line::start([Turn::reply(ACCEPTED), Turn::reply(UNREACHABLE)]).await?;
    line.proxy.set(Mode::DuplicateReply).await?;
    // Whether the second copy comes with the first decides between yes and doubt; it is never a no.
    if let Err(error) = line.send().await {
        assert_eq!(error.outcome(), Outcome::Unknown, "{error}");
    }
    line.proxy.set(Mode::Pass).await?;
    let refused = line.send().await.unwrap_err();
    assert_eq!(refused.outcome(), Outcome::Rejected, "{refused}");
    assert_eq!(line.robot.received(), [BYTES, BYTES]);
    Ok(())
}

/// Covers: W7, W7, N3.
#[tokio::test]
async fn a_late_reply_is_never_taken_for_the_next_one() -> anyhow::Result<()> {
    let gate = Gate::new();
    let late = Turn::Late(gate.clone(), ACCEPTED.to_vec());
    let line = Line::impatient([late, Turn::reply(UNREACHABLE)]).await?;
    line.expect_problem(ProblemCode::ControllerTimeout, Outcome::Unknown)
        .await;
    gate.open();
    let refused = line.send().await.unwrap_err();
    assert_eq!(refused.outcome(), Outcome::Rejected, "{refused}");
    Ok(())
}

#[tokio::test]
async fn a_reply_held_back_and_released_in_time_is_an_answer() -> anyhow::Result<()> {
    let line = Line::start([]).await?;
    let gate = Gate::new();
    line.proxy
        .set(Mode::HoldAt(Direction::ToTarget, gate.clone()))
        .await?;
    let (sent, ()) = tokio::join!(line.send(), async { gate.open() });
    sent?;
    assert_eq!(line.robot.received(), [BYTES]);
    Ok(())
}

#[tokio::test]
async fn each_misbehavior_of_a_controller_has_its_answer() -> anyhow::Result<()> {
    for (turn, code) in [
        (Turn::Silent, ProblemCode::ControllerTimeout),
        (Turn::CloseWithoutReply, ProblemCode::ControllerTimeout),
        (Turn::garbage(), ProblemCode::ControllerProtocol),
    ] {
        let line = Line::impatient([turn]).await?;
        line.expect_problem(code, Outcome::Unknown).await;
        assert_eq!(line.robot.received(), [BYTES]);
    }
    Ok(())
}

#[tokio::test]
async fn the_controllers_no_is_a_proof() -> anyhow::Result<()> {
    for reply in [UNREACHABLE, INCORRECT_INPUT] {
        let line = Line::start([Turn::reply(reply)]).await?;
        let refused = line.send().await.unwrap_err();
        assert_eq!(refused.status(), Some(409));
        assert_eq!(refused.outcome(), Outcome::Rejected);
        assert_eq!(refused.to_string(), String::from_utf8_lossy(reply));
    }
    Ok(())
}
