//! What a command ends in when its controller does not answer as it should.

use std::net::SocketAddr;

use serde_json::Value;
use server::config::ServerSection;
use tokio::net::TcpSocket;

use crate::legacy_moves::POINT;
use crate::support::{
    ACCEPTED, Act, Attempt, FakeRobot, MOTION, MOTIONS, ScriptedNetwork, TestServer, robot_section,
};

/// The motion a problem is about, as the server shows it.
async fn motion_of(server: &TestServer, problem: &Value) -> Value {
    let id = problem["motion"].as_str().unwrap();
    server.get(&format!("{MOTIONS}/{id}")).await.json()
}

/// An address where connections are refused: the port is taken and nobody listens on it.
fn refusing() -> (TcpSocket, SocketAddr) {
    let socket = TcpSocket::new_v4().unwrap();
    socket.bind("127.0.0.1:0".parse().unwrap()).unwrap();
    let address = socket.local_addr().unwrap();
    (socket, address)
}

async fn impatient(robot: &FakeRobot) -> TestServer {
    let mut section = robot_section(robot.address);
    section.reply_timeout_ms = 50;
    TestServer::with_robot(section).await
}

/// Covers: W1.
#[tokio::test]
async fn a_refused_connection_proves_that_nothing_was_sent() {
    let (_socket, address) = refusing();
    let server = TestServer::with_robot(robot_section(address)).await;
    for path in [MOTIONS, "/fanuc/move"] {
        let body = if path == MOTIONS { MOTION } else { POINT };
        let reply = server.post(path, body).await;
        let problem = reply.problem(503, "controller-disconnected", "NOT_SENT");
        assert_eq!(problem["retryable"], true);
        assert_eq!(reply.header("retry-after"), Some("1"));
        assert!(
            problem["detail"]
                .as_str()
                .unwrap()
                .contains(&address.to_string())
        );
        let motion = motion_of(&server, &problem).await;
        assert_eq!(motion["state"], "not_executed");
        assert_eq!(motion["outcome"], "NOT_SENT");
        assert_eq!(motion["request_id"], problem["request_id"]);
    }
    let state = server.get("/api/v1/cells/c1/robots/r1/state").await.json();
    assert_eq!(state["link"]["state"], "disconnected");
    assert_eq!(state["link"]["last_failure"], "controller-disconnected");
}

/// Covers: W1.
#[tokio::test]
async fn a_connection_nobody_takes_is_given_up_after_its_time() {
    let robot = FakeRobot::accepting().await;
    let network = ScriptedNetwork::new([Attempt::BlackHole]);
    let mut section = robot_section(robot.address);
    section.connect_timeout_ms = 50;
    let server = TestServer::with(ServerSection::default(), section, network).await;
    let reply = server.post(MOTIONS, MOTION).await;
    let problem = reply.problem(503, "controller-disconnected", "NOT_SENT");
    assert!(problem["detail"].as_str().unwrap().contains("50 ms"));
    robot.assert_untouched();
}

#[tokio::test]
async fn a_controller_that_was_away_is_tried_once() {
    let robot = FakeRobot::accepting().await;
    let network = ScriptedNetwork::new([Attempt::Refused; 5]);
    let server = TestServer::with(
        ServerSection::default(),
        robot_section(robot.address),
        network.clone(),
    )
    .await;
    let reply = server.post(MOTIONS, MOTION).await;
    let _problem = reply.problem(503, "controller-disconnected", "NOT_SENT");
    assert_eq!(network.left(), 4);
    robot.assert_untouched();
}

/// Covers: W4, W5.
#[tokio::test]
async fn no_answer_or_half_of_one_leaves_the_motion_in_doubt() {
    let acts = [
        Act::Silence,
        Act::CloseAfter(""),
        Act::CloseAfter("SUCESS: MOV"),
        Act::ReplyAndStayOpen("SUCESS: MOVEMENT COMPLET"),
        Act::Held(ACCEPTED),
    ];
    for act in acts {
        let robot = FakeRobot::start([act.clone()]).await;
        let server = impatient(&robot).await;
        let reply = server.post(MOTIONS, MOTION).await;
        let problem = reply.problem(504, "controller-timeout", "UNKNOWN");
        assert_eq!(problem["retryable"], false, "{act:?}");
        let detail = problem["detail"].as_str().unwrap();
        assert!(detail.ends_with("the robot may have moved"), "{detail}");
        let motion = motion_of(&server, &problem).await;
        assert_eq!(motion["state"], "in_doubt");
        assert_eq!(motion["code"], "controller-timeout");
        // Sent once, and never again.
        assert_eq!(robot.commands().len(), 1, "{act:?}");

        let state = server.get("/api/v1/cells/c1/robots/r1/state").await.json();
        assert_eq!(state["link"]["state"], "degraded");
        assert_eq!(state["pose_source"], "unknown");
        robot.release();
    }
}

/// Covers: W4.
#[tokio::test]
async fn an_answer_that_is_not_the_protocols_leaves_the_motion_in_doubt_and_is_shown() {
    let acts = [
        (
            Act::Reply("SUCCESS: MOVEMENT COMPLETE"),
            "SUCCESS: MOVEMENT",
        ),
        (Act::Reply("SUCESS: MOVEMENT COMPLETE\n"), "COMPLETE\\n"),
        (
            Act::Reply("HTTP/1.1 400 Bad Request\r\n\r\n"),
            "HTTP/1.1 400",
        ),
        (Act::Reply("\u{1b}[31m\0"), "\\x1b[31m"),
        (Act::Flood(5 * 1024), "xxxx"),
        (Act::Flood(1 << 20), "xxxx"),
    ];
    for (act, shown) in acts {
        let robot = FakeRobot::start([act]).await;
        let server = TestServer::start(&robot).await;
        let reply = server.post(MOTIONS, MOTION).await;
        let problem = reply.problem(502, "controller-protocol", "UNKNOWN");
        let text = problem["controller_text"].as_str().unwrap();
        assert!(text.contains(shown) && text.len() <= 800, "{text}");
        let motion = motion_of(&server, &problem).await;
        assert_eq!(
            (&motion["state"], &motion["controller_text"]),
            (&"in_doubt".into(), &text.into())
        );
        assert_eq!(robot.commands().len(), 1);
    }
}

/// Covers: W6.
#[tokio::test]
async fn a_refusal_of_the_controller_is_a_rejected_motion() {
    let robot = FakeRobot::start([Act::Reply("ERROR: POINT UNREACHABLE")]).await;
    let server = TestServer::start(&robot).await;
    let reply = server.post(MOTIONS, MOTION).await;
    let problem = reply.problem(409, "controller-rejected", "REJECTED");
    assert_eq!(problem["controller_text"], "ERROR: POINT UNREACHABLE");
    let motion = motion_of(&server, &problem).await;
    assert_eq!(motion["state"], "rejected");
}

#[tokio::test]
async fn a_controller_that_stays_open_after_its_answer_does_not_hold_the_caller() {
    let robot = FakeRobot::start([Act::ReplyAndStayOpen(ACCEPTED)]).await;
    let server = TestServer::start(&robot).await;
    assert_eq!(server.post(MOTIONS, MOTION).await.status, 202);
    // The connection is closed from here before the next command.
    assert_eq!(server.post(MOTIONS, MOTION).await.status, 202);
}

#[tokio::test]
async fn the_request_id_goes_with_the_connection() {
    let robot = FakeRobot::accepting().await;
    let network = ScriptedNetwork::default();
    let server = TestServer::with(
        ServerSection::default(),
        robot_section(robot.address),
        network.clone(),
    )
    .await;
    let headers = [
        ("content-type", "application/json"),
        ("idempotency-key", "k1"),
        ("x-request-id", "job-17.a_b"),
    ];
    let reply = server.request("POST", MOTIONS, &headers, MOTION).await;
    assert_eq!(reply.header("x-request-id"), Some("job-17.a_b"));
    assert_eq!(reply.json()["request_id"], "job-17.a_b");
    assert_eq!(network.labels(), ["job-17.a_b"]);

    let forged = [
        ("content-type", "application/json"),
        ("idempotency-key", "k2"),
        ("x-request-id", "a b"),
    ];
    let reply = server.request("POST", MOTIONS, &forged, MOTION).await;
    assert_eq!(reply.json()["request_id"].as_str().unwrap().len(), 36);
}
