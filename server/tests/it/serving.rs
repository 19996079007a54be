//! Connections: their limits, and the orderly end.

use std::sync::Arc;

use server::TcpConnector;
use server::config::ServerSection;
use tokio::io::{AsyncReadExt, AsyncWriteExt};
use tokio::net::TcpStream;

use crate::support::{
    ACCEPTED, Act, FakeRobot, MOTION, MOTIONS, TestServer, robot_section, wait_until,
};

async fn with(section: ServerSection, robot: &FakeRobot) -> TestServer {
    TestServer::with(
        section,
        robot_section(robot.address),
        TcpConnector::default(),
    )
    .await
}

/// Sends the bytes, then waits for the server to close; returns what it said.
async fn until_closed(server: &TestServer, bytes: &str) -> String {
    let mut stream = TcpStream::connect(server.address).await.unwrap();
    stream.write_all(bytes.as_bytes()).await.unwrap();
    let mut said = Vec::new();
    let _count = stream.read_to_end(&mut said).await.unwrap();
    String::from_utf8(said).unwrap()
}

#[tokio::test]
async fn a_request_whose_head_or_body_does_not_arrive_is_closed() {
    let robot = FakeRobot::accepting().await;
    let section = ServerSection {
        header_timeout_ms: 50,
        body_timeout_ms: 50,
        ..ServerSection::default()
    };
    let server = with(section, &robot).await;
    for beginning in ["", "P", "POST /fanuc/move HTTP/1.1\r\nhost: localhost\r\n"] {
        let said = until_closed(&server, beginning).await;
        assert!(!said.contains("200 OK"), "{said}");
    }
    let head = "POST /fanuc/move HTTP/1.1\r\nhost: localhost\r\ncontent-type: application/json\r\ncontent-length: 100\r\n\r\n";
    let said = until_closed(&server, &format!("{head}{{\"x\": 1")).await;
    assert!(said.starts_with("HTTP/1.1 408"), "{said}");
    assert!(said.contains("request-timeout"), "{said}");
    robot.assert_untouched();
}

#[tokio::test]
async fn a_request_with_too_large_a_head_or_too_many_headers_is_refused() {
    let robot = FakeRobot::accepting().await;
    let server = TestServer::start(&robot).await;
    let large = format!("GET / HTTP/1.1\r\nx: {}\r\n\r\n", "y".repeat(20_000));
    let many = format!("GET / HTTP/1.1\r\n{}\r\n", "x: y\r\n".repeat(100));
    for head in [large, many] {
        let mut stream = TcpStream::connect(server.address).await.unwrap();
        stream.write_all(head.as_bytes()).await.unwrap();
        let mut said = Vec::new();
        let _reset_or_end = stream.read_to_end(&mut said).await;
        let said = String::from_utf8(said).unwrap();
        assert!(said.starts_with("HTTP/1.1 431"), "{said}");
    }
}

/// Covers: X9.
#[tokio::test]
async fn a_request_that_could_be_read_two_ways_is_refused() {
    let robot = FakeRobot::accepting().await;
    let server = TestServer::start(&robot).await;
    let smuggled = "POST /fanuc/home HTTP/1.1\r\nhost: localhost\r\ncontent-length: 4\r\ncontent-length: 40\r\n\r\nabcd";
    let said = until_closed(&server, smuggled).await;
    assert!(said.starts_with("HTTP/1.1 400"), "{said}");
    robot.assert_untouched();
}

#[tokio::test]
async fn one_connection_serves_many_requests() {
    let robot = FakeRobot::accepting().await;
    let server = TestServer::start(&robot).await;
    let get = "GET /livez HTTP/1.1\r\nhost: localhost\r\n\r\n";
    let last = "GET /livez HTTP/1.1\r\nhost: localhost\r\nconnection: close\r\n\r\n";
    let said = until_closed(&server, &format!("{get}{get}{last}")).await;
    assert_eq!(said.matches("HTTP/1.1 200 OK").count(), 3);
}

#[tokio::test]
async fn a_stopping_server_finishes_what_was_sent_and_refuses_what_waits() {
    let robot = FakeRobot::start([Act::Held(ACCEPTED)]).await;
    let server = Arc::new(TestServer::start(&robot).await);
    let post = || {
        let server = Arc::clone(&server);
        tokio::spawn(async move { server.post(MOTIONS, MOTION).await })
    };
    let sent = post();
    wait_until("the command is with the robot", || {
        robot.commands().len() == 1
    })
    .await;
    let waiting = post();
    while server.get("/api/v1/cells/c1/robots/r1/state").await.json()["queued"] != 1 {}

    server.stop.cancel();
    robot.release();

    assert_eq!(sent.await.unwrap().status, 202);
    let reply = waiting.await.unwrap();
    let problem = reply.problem(503, "shutting-down", "NOT_SENT");
    assert_eq!(problem["retryable"], true);
    assert_eq!(robot.commands().len(), 1);
    assert!(TcpStream::connect(server.address).await.is_err());
    let server = Arc::into_inner(server).unwrap();
    server.task.await.unwrap().unwrap();
}

#[tokio::test]
async fn a_stopping_server_does_not_wait_for_ever() {
    let robot = FakeRobot::start([Act::Silence]).await;
    let mut plan = robot_section(robot.address);
    plan.reply_timeout_ms = 200;
    let section = ServerSection {
        shutdown_timeout_ms: 20,
        ..ServerSection::default()
    };
    let server = TestServer::with(section, plan, TcpConnector::default()).await;
    let mut stream = TcpStream::connect(server.address).await.unwrap();
    let request = "POST /fanuc/home HTTP/1.1\r\nhost: localhost\r\n\r\n";
    stream.write_all(request.as_bytes()).await.unwrap();
    wait_until("the command is with the robot", || {
        robot.commands().len() == 1
    })
    .await;
    server.stop.cancel();
    server.task.await.unwrap().unwrap();
}

/// Covers: X5.
#[tokio::test]
async fn a_web_page_from_elsewhere_cannot_send_the_robot_home() {
    let robot = FakeRobot::accepting().await;
    let server = TestServer::start(&robot).await;
    let page = [
        ("origin", "http://evil.example"),
        ("content-type", "text/plain"),
    ];
    let reply = server.request("POST", "/fanuc/home", &page, "").await;
    let _problem = reply.problem(403, "cross-site-request", "NOT_SENT");
    let said = until_closed(
        &server,
        "GET /livez HTTP/1.1\r\nhost: evil.example\r\nconnection: close\r\n\r\n",
    )
    .await;
    assert!(said.starts_with("HTTP/1.1 421"), "{said}");
    robot.assert_untouched();
}

#[tokio::test]
async fn a_caller_that_never_reads_loses_its_connection() {
    let robot = FakeRobot::accepting().await;
    let section = ServerSection {
        write_timeout_ms: 50,
        ..ServerSection::default()
    };
    let server = with(section, &robot).await;
    let mut stream = TcpStream::connect(server.address).await.unwrap();
    let request = b"GET /docs/swagger-ui-bundle.js HTTP/1.1\r\nhost: localhost\r\n\r\n";
    // Without the limit this would wait for ever, once the buffers on the way are full.
    while stream.write_all(request).await.is_ok() {}
}
