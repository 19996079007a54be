//! A broken network between the client and the real server: what the client concludes, and that no command reaches the
//! robot twice.

use std::time::Duration;

use api::{LegacyMoved, LegacyPoint, Outcome};
use client::{Client, ClientError, Timeouts};
use tests::{
    ACCEPTED, ChaosProxy, Direction, FakeRobot, Mode, TestServer, Turn, UNREACHABLE, robot_at,
};

const POINT: LegacyPoint = LegacyPoint {
    x: 900.0,
    y: 100.0,
    z: 800.0,
    w: -180.0,
    p: 0.0,
    r: 0.0,
};

/// Client, proxy, server and robot in a row.
struct Line {
    client: Client,
    proxy: ChaosProxy,
    robot: FakeRobot,
    _server: TestServer,
}

impl Line {
    async fn start(mode: Mode) -> anyhow::Result<Self> {
        Self::with_script(mode, [], Timeouts::default()).await
    }

    async fn with_script(
        mode: Mode,
        script: impl IntoIterator<Item = Turn>,
        timeouts: Timeouts,
    ) -> anyhow::Result<Self> {
        let robot = FakeRobot::start(script).await?;
        let mut server = TestServer::start(robot_at(robot.address())).await?;
        // The client of these tests is one of its own.
        server.give_up_control().await?;
        let proxy = ChaosProxy::start(server.address()).await?;
        proxy.set(mode).await?;
        let client = Client::with_timeouts(&format!("http://{}", proxy.address()), timeouts)?;
        Ok(Self {
            client,
            proxy,
            robot,
            _server: server,
        })
    }

    async fn send(&self) -> Result<LegacyMoved, ClientError> {
        self.client.legacy_move(&POINT, None).await
    }
}

#[tokio::test]
async fn an_answer_that_comes_byte_by_byte_is_an_answer() -> anyhow::Result<()> {
    let line = Line::start(Mode::SplitIntoBytes).await?;
    assert_eq!(line.send().await?.current_position, POINT);
    Ok(())
}

#[tokio::test]
async fn a_server_that_is_not_there_has_moved_nothing() -> anyhow::Result<()> {
    let line = Line::start(Mode::Refuse).await?;
    let error = line.send().await.unwrap_err();
    assert!(
        matches!(error, ClientError::Unreachable { .. }),
        "{error:?}"
    );
    assert_eq!(error.outcome(), Outcome::NotSent);
    assert_eq!(line.robot.received(), Vec::<String>::new());
    Ok(())
}

#[tokio::test]
async fn an_answer_cut_short_is_in_doubt_and_the_command_is_not_repeated() -> anyhow::Result<()> {
    // In the status line, in the headers, in the body.
    for length in [0, 9, 60, 150] {
        let line = Line::start(Mode::CutAfter(Direction::ToClient, length)).await?;
        let error = line.send().await.unwrap_err();
        assert!(
            matches!(error, ClientError::Interrupted { .. }),
            "{error:?}"
        );
        assert_eq!(error.outcome(), Outcome::Unknown, "cut after {length}");
        assert_eq!(line.robot.received().len(), 1, "cut after {length}");
        assert_eq!(line.proxy.traffic().connections, 1);
    }
    Ok(())
}

#[tokio::test]
async fn a_request_cut_short_reaches_no_robot() -> anyhow::Result<()> {
    let line = Line::start(Mode::CutAfter(Direction::ToTarget, 100)).await?;
    let error = line.send().await.unwrap_err();
    assert_eq!(
        error.outcome(),
        Outcome::Unknown,
        "the client cannot know better"
    );
    assert_eq!(line.robot.received(), Vec::<String>::new());
    Ok(())
}

#[tokio::test]
async fn a_request_swallowed_on_its_way_is_in_doubt() -> anyhow::Result<()> {
    let impatient = Timeouts {
        command: Duration::from_millis(300),
        ..Timeouts::default()
    };
    let line = Line::with_script(Mode::Blackhole, [], impatient).await?;
    let error = line.send().await.unwrap_err();
    assert!(matches!(error, ClientError::Timeout { .. }), "{error:?}");
    assert_eq!(error.outcome(), Outcome::Unknown);
    assert_eq!(line.proxy.traffic().connections, 1);
    Ok(())
}

#[tokio::test]
async fn a_corrupted_answer_is_in_doubt() -> anyhow::Result<()> {
    let line = Line::start(Mode::CorruptReply).await?;
    let error = line.send().await.unwrap_err();
    assert_eq!(error.outcome(), Outcome::Unknown, "{error}");
    assert_eq!(line.robot.received().len(), 1);
    Ok(())
}

#[tokio::test]
async fn a_doubled_answer_is_never_taken_for_the_next_one() -> anyhow::Result<()> {
    let script = [Turn::reply(ACCEPTED), Turn::reply(UNREACHABLE)];
    let line = Line::with_script(Mode::DuplicateReply, script, Timeouts::default()).await?;
    let first = line.send().await?;
    assert_eq!(first.current_position, POINT);
    // Either the copy is noticed on an idle connection, or it answers the second request with the wrong request id.
    let second = line.send().await.unwrap_err();
    let outcomes = [Outcome::Rejected, Outcome::Unknown];
    assert!(outcomes.contains(&second.outcome()), "{second}");
    Ok(())
}
