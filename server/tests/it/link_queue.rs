//! Many callers, one controller: order, bounds, deadlines, callers that go away.

use std::sync::Arc;

use tokio::io::AsyncWriteExt;
use tokio::net::TcpStream;

use crate::support::{
    ACCEPTED, Act, FakeRobot, MOTION, MOTIONS, TestServer, robot_section, wait_until,
};

const STATE: &str = "/api/v1/cells/c1/robots/r1/state";

async fn held(queue_capacity: u64) -> (FakeRobot, Arc<TestServer>) {
    let robot = FakeRobot::start([Act::Held(ACCEPTED)]).await;
    let mut section = robot_section(robot.address);
    section.queue_capacity = queue_capacity;
    (robot, Arc::new(TestServer::with_robot(section).await))
}

fn post(
    server: &Arc<TestServer>,
    body: &str,
) -> tokio::task::JoinHandle<crate::support::HttpReply> {
    let (server, body) = (Arc::clone(server), body.to_owned());
    tokio::spawn(async move { server.post(MOTIONS, &body).await })
}

/// Waits until so many commands wait.
pub(crate) async fn queued(server: &TestServer, count: u64) {
    loop {
        if server.get(STATE).await.json()["queued"] == count {
            return;
        }
    }
}

/// Covers: R3.
#[tokio::test]
async fn a_full_queue_is_said_at_once_and_leaves_no_motion() {
    let (robot, server) = held(1).await;
    let first = post(&server, MOTION);
    wait_until("the first command is with the robot", || {
        robot.commands().len() == 1
    })
    .await;
    let second = post(&server, MOTION);
    queued(&server, 1).await;

    let reply = server.post(MOTIONS, MOTION).await;
    let problem = reply.problem(503, "controller-busy", "NOT_SENT");
    assert_eq!(reply.header("retry-after"), Some("1"));
    assert_eq!(problem["motion"], serde_json::Value::Null);
    let legacy = server.post("/fanuc/home", "").await;
    let _problem = legacy.problem(503, "controller-busy", "NOT_SENT");
    // The state tells while the robot is busy.
    let motions = server.get(MOTIONS).await.json();
    let states: Vec<_> = motions["motions"]
        .as_array()
        .unwrap()
        .iter()
        .map(|motion| motion["state"].as_str().unwrap().to_owned())
        .collect();
    assert_eq!(states, ["queued", "dispatched"]);
    assert_eq!(server.get(STATE).await.json()["link"]["state"], "busy");

    robot.release();
    robot.release();
    assert_eq!(first.await.unwrap().status, 202);
    assert_eq!(second.await.unwrap().status, 202);
    assert_eq!(robot.commands().len(), 2);
}

/// Covers: T5.
#[tokio::test]
async fn a_command_whose_deadline_passes_in_the_queue_is_not_sent() {
    let robot = FakeRobot::start([Act::Silence]).await;
    let mut section = robot_section(robot.address);
    section.reply_timeout_ms = 500;
    let server = Arc::new(TestServer::with_robot(section).await);
    let first = post(&server, MOTION);
    wait_until("the first command is with the robot", || {
        robot.commands().len() == 1
    })
    .await;
    let hasty = MOTION.replacen('{', r#"{"deadline_ms": 1, "#, 1);
    let reply = server.post(MOTIONS, &hasty).await;

    let problem = reply.problem(409, "deadline-passed", "NOT_SENT");
    let id = problem["motion"].as_str().unwrap();
    let motion = server.get(&format!("{MOTIONS}/{id}")).await.json();
    assert_eq!(motion["state"], "expired");
    assert_eq!(motion["outcome"], "NOT_SENT");
    assert_eq!(first.await.unwrap().status, 504);
    assert_eq!(robot.commands().len(), 1);
}

/// Covers: H10.
#[tokio::test]
async fn a_caller_that_goes_away_does_not_take_its_command_with_it() {
    let (robot, server) = held(4).await;
    let mut stream = TcpStream::connect(server.address).await.unwrap();
    let length = MOTION.len();
    let control = server.control().await;
    let request = format!(
        "POST {MOTIONS} HTTP/1.1\r\nhost: localhost\r\ncontrol-token: {control}\r\ncontent-type: application/json\r\nidempotency-key: gone\r\ncontent-length: {length}\r\n\r\n{MOTION}"
    );
    stream.write_all(request.as_bytes()).await.unwrap();
    wait_until("the command is with the robot", || {
        robot.commands().len() == 1
    })
    .await;
    drop(stream);
    robot.release();

    let second = post(&server, MOTION);
    wait_until("the next command is with the robot", || {
        robot.commands().len() == 2
    })
    .await;
    robot.release();
    assert_eq!(second.await.unwrap().status, 202);
    let motions = server.get(MOTIONS).await.json();
    assert_eq!(motions["motions"][1]["state"], "accepted", "{motions}");
}

#[tokio::test]
async fn commands_are_sent_one_after_the_other_each_on_a_connection_of_its_own() {
    let robot = FakeRobot::accepting().await;
    let mut section = robot_section(robot.address);
    section.queue_capacity = 64;
    let server = Arc::new(TestServer::with_robot(section).await);
    let posts: Vec<_> = (1..=20)
        .map(|speed| post(&server, &MOTION.replace("200", &speed.to_string())))
        .collect();
    for post in posts {
        assert_eq!(post.await.unwrap().status, 202);
    }
    let mut commands = robot.commands();
    assert_eq!(commands.len(), 20);
    commands.sort();
    commands.dedup();
    assert_eq!(commands.len(), 20);
}
