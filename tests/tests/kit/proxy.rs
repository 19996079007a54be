#![expect(clippy::unwrap_used, reason = "a kit that breaks is a test that fails")]

use std::io::ErrorKind;

use tests::{ACCEPTED, ChaosProxy, Direction, FakeRobot, Gate, Look, Mode, Traffic, wait_until};
use tokio::net::TcpStream;

use crate::{COMMAND, LONG, ask};

async fn robot_behind(mode: Mode) -> (FakeRobot, ChaosProxy) {
    let robot = FakeRobot::start([]).await.unwrap();
    let proxy = ChaosProxy::start(robot.address()).await.unwrap();
    proxy.set(mode).await.unwrap();
    (robot, proxy)
}

fn command() -> String {
    String::from_utf8(COMMAND.to_vec()).unwrap()
}

#[tokio::test]
async fn passing_changes_nothing_and_counts_everything() {
    let (robot, proxy) = robot_behind(Mode::Pass).await;
    assert_eq!(ask(proxy.address()).await.unwrap(), ACCEPTED);
    assert_eq!(robot.received(), [command()]);
    let expected = Traffic {
        connections: 1,
        bytes_from_clients: COMMAND.len(),
        bytes_from_target: ACCEPTED.len(),
    };
    assert_eq!(proxy.traffic(), expected);
}

#[tokio::test]
async fn splitting_into_bytes_changes_nothing() {
    let (robot, proxy) = robot_behind(Mode::SplitIntoBytes).await;
    assert_eq!(ask(proxy.address()).await.unwrap(), ACCEPTED);
    assert_eq!(robot.received(), [command()]);
}

#[tokio::test]
async fn refusing_is_a_refused_connection_and_can_be_taken_back() {
    let (robot, proxy) = robot_behind(Mode::Pass).await;
    for _ in 0..3 {
        proxy.set(Mode::Refuse).await.unwrap();
        let refused = TcpStream::connect(proxy.address()).await.unwrap_err();
        assert_eq!(refused.kind(), ErrorKind::ConnectionRefused);
        proxy.set(Mode::Pass).await.unwrap();
        assert_eq!(ask(proxy.address()).await.unwrap(), ACCEPTED);
    }
    assert_eq!(robot.received().len(), 3);
}

#[tokio::test]
async fn a_command_cut_short_arrives_cut_short() {
    let (robot, proxy) = robot_behind(Mode::CutAfter(Direction::ToTarget, 10)).await;
    let reply = ask(proxy.address()).await;
    assert!(reply.is_err() || reply.is_ok_and(|reply| reply.is_empty()));
    wait_until("ten bytes at the robot", LONG, async || {
        match robot.received().first() {
            Some(received) if *received == command()[..10] => Look::Ready(()),
            received => Look::not_yet(format!("{received:?}")),
        }
    })
    .await
    .unwrap();
}

#[tokio::test]
async fn a_reply_cut_short_arrives_cut_short() {
    let (robot, proxy) = robot_behind(Mode::CutAfter(Direction::ToClient, 6)).await;
    assert_eq!(ask(proxy.address()).await.unwrap(), b"SUCESS");
    assert_eq!(robot.received(), [command()]);
}

#[tokio::test]
async fn a_cut_before_the_first_byte_carries_none() {
    let (_robot, proxy) = robot_behind(Mode::CutAfter(Direction::ToClient, 0)).await;
    assert_eq!(ask(proxy.address()).await.unwrap(), b"");
    assert_eq!(proxy.traffic().bytes_from_target, ACCEPTED.len());
}

#[tokio::test]
async fn a_reply_held_back_comes_when_the_gate_is_open() {
    let gate = Gate::new();
    let (_robot, proxy) = robot_behind(Mode::HoldAt(Direction::ToClient, gate.clone())).await;
    let asking = tokio::spawn(ask(proxy.address()));
    wait_until("the reply at the proxy", LONG, async || {
        match proxy.traffic().bytes_from_target {
            count if count == ACCEPTED.len() => Look::Ready(()),
            count => Look::not_yet(format!("{count} bytes")),
        }
    })
    .await
    .unwrap();
    assert!(!asking.is_finished());
    gate.open();
    assert_eq!(asking.await.unwrap().unwrap(), ACCEPTED);
}

#[tokio::test]
async fn a_black_hole_swallows_the_command() {
    let (robot, proxy) = robot_behind(Mode::Blackhole).await;
    let asking = tokio::spawn(ask(proxy.address()));
    wait_until("the command in the hole", LONG, async || {
        match proxy.traffic().bytes_from_clients {
            count if count == COMMAND.len() => Look::Ready(()),
            count => Look::not_yet(format!("{count} bytes")),
        }
    })
    .await
    .unwrap();
    assert!(!asking.is_finished());
    assert_eq!(robot.received(), Vec::<String>::new());
    asking.abort();
}

#[tokio::test]
async fn a_corrupted_reply_differs_in_its_first_byte() {
    let (robot, proxy) = robot_behind(Mode::CorruptReply).await;
    let reply = ask(proxy.address()).await.unwrap();
    assert_ne!(reply[0], ACCEPTED[0]);
    assert_eq!(reply[1..], ACCEPTED[1..]);
    assert_eq!(robot.received(), [command()]);
}

#[tokio::test]
async fn a_duplicated_reply_comes_twice() {
    let (robot, proxy) = robot_behind(Mode::DuplicateReply).await;
    assert_eq!(
        ask(proxy.address()).await.unwrap(),
        [ACCEPTED, ACCEPTED].concat()
    );
    assert_eq!(robot.received(), [command()]);
}
