use tests::{ACCEPTED, FakeRobot, Gate, Look, Turn, UNREACHABLE, wait_until};

use crate::{COMMAND, LONG, ask};

#[tokio::test]
async fn a_robot_without_a_script_accepts_everything() {
    let robot = FakeRobot::start([]).await.unwrap();
    assert_eq!(ask(robot.address()).await.unwrap(), ACCEPTED);
    assert_eq!(ask(robot.address()).await.unwrap(), ACCEPTED);
    let command = String::from_utf8(COMMAND.to_vec()).unwrap();
    assert_eq!(robot.received(), [command.clone(), command]);
}

#[tokio::test]
async fn turns_are_taken_in_order_and_the_last_one_stays() {
    let script = [
        Turn::reply(ACCEPTED),
        Turn::CloseWithoutReply,
        Turn::garbage(),
        Turn::reply(UNREACHABLE),
    ];
    let robot = FakeRobot::start(script).await.unwrap();
    assert_eq!(ask(robot.address()).await.unwrap(), ACCEPTED);
    assert_eq!(ask(robot.address()).await.unwrap(), b"");
    assert_eq!(ask(robot.address()).await.unwrap()[0], 0xff);
    assert_eq!(ask(robot.address()).await.unwrap(), UNREACHABLE);
    assert_eq!(ask(robot.address()).await.unwrap(), UNREACHABLE);
}

#[tokio::test]
async fn a_late_reply_comes_when_its_gate_is_open() {
    let gate = Gate::new();
    let turn = Turn::Late(gate.clone(), ACCEPTED.to_vec());
    let robot = FakeRobot::start([turn]).await.unwrap();
    let asking = tokio::spawn(ask(robot.address()));
    wait_until("the command at the robot", LONG, async || {
        match robot.received().as_slice() {
            [command] if command.len() == COMMAND.len() => Look::Ready(()),
            other => Look::not_yet(format!("{other:?}")),
        }
    })
    .await
    .unwrap();
    assert!(!asking.is_finished());
    gate.open();
    assert_eq!(asking.await.unwrap().unwrap(), ACCEPTED);
}

#[tokio::test]
async fn a_silent_robot_has_heard_the_command() {
    let robot = FakeRobot::start([Turn::Silent]).await.unwrap();
    let asking = tokio::spawn(ask(robot.address()));
    wait_until("the command at the robot", LONG, async || {
        match robot.received().first().map(String::len) {
            Some(length) if length == COMMAND.len() => Look::Ready(()),
            length => Look::not_yet(format!("{length:?} bytes")),
        }
    })
    .await
    .unwrap();
    assert!(!asking.is_finished());
    asking.abort();
}

#[tokio::test]
async fn a_robot_that_closes_at_once_hears_nothing() {
    let robot = FakeRobot::start([Turn::CloseAtOnce]).await.unwrap();
    // The command may meet a reset, or vanish: both are silence.
    if let Ok(reply) = ask(robot.address()).await {
        assert_eq!(reply, b"");
    }
    assert_eq!(robot.received(), [""]);
}
