//! Pages of others: they may neither frame an answer nor listen to what happens.

use tokio::io::{AsyncReadExt as _, AsyncWriteExt as _};
use tokio::net::TcpStream;

use crate::support::{FakeRobot, TestServer};

const EVENTS: &str = "/api/v1/cells/c1/events";

/// The panel, the documents, a resource, a refusal: none of them is shown in the frame of another page.
///
/// Covers: X14.
#[tokio::test]
async fn x14_no_answer_may_be_framed() {
    let robot = FakeRobot::accepting().await;
    let server = TestServer::start(&robot).await;
    for path in [
        "/",
        "/docs",
        "/livez",
        "/api/v1/openapi.json",
        "/api/v1/cells/c1/robots/r1/state",
        "/nowhere",
    ] {
        let reply = server.get(path).await;
        let policy = reply.header("content-security-policy").unwrap_or_default();
        assert!(
            policy.contains("frame-ancestors 'none'"),
            "{path}: {policy}"
        );
    }
    let page = [("origin", "http://evil.example")];
    let refused = server.request("POST", "/fanuc/home", &page, "").await;
    let policy = refused
        .header("content-security-policy")
        .unwrap_or_default();
    assert!(policy.contains("frame-ancestors 'none'"), "{policy}");
    robot.assert_untouched();
}

/// Covers: X11.
#[tokio::test]
async fn x11_the_start_page_takes_nothing_from_elsewhere() {
    let robot = FakeRobot::accepting().await;
    let server = TestServer::start(&robot).await;
    let page = server.get("/").await;
    let policy = page.header("content-security-policy").unwrap_or_default();
    for part in [
        "default-src 'none'",
        "connect-src 'self'",
        "base-uri 'none'",
    ] {
        assert!(policy.contains(part), "{policy}");
    }
    // What robots, people and controllers say is set as text.
    for markup in [
        "innerHTML",
        "outerHTML",
        "insertAdjacentHTML",
        "document.write",
    ] {
        assert!(!page.body.contains(markup), "{markup}");
    }
    server.stopped().await;
}

/// The first line that the server answers to a request for its events.
async fn asked_for_events(server: &TestServer, header: &str) -> String {
    let mut stream = TcpStream::connect(server.address).await.unwrap();
    let head = format!("GET {EVENTS} HTTP/1.1\r\nhost: localhost\r\n{header}\r\n");
    stream.write_all(head.as_bytes()).await.unwrap();
    let mut said = Vec::new();
    while !said.contains(&b'\n') {
        let mut byte = [0];
        assert_eq!(stream.read(&mut byte).await.unwrap(), 1, "it closed");
        said.extend(byte);
    }
    String::from_utf8(said).unwrap()
}

/// Covers: X15.
#[tokio::test]
async fn x15_a_stream_for_another_origin_is_refused() {
    let robot = FakeRobot::accepting().await;
    let server = TestServer::start(&robot).await;
    for foreign in [
        "origin: http://evil.example\r\n",
        "origin: null\r\n",
        "origin: http://localhost:1\r\n",
        "sec-fetch-site: cross-site\r\n",
    ] {
        let said = asked_for_events(&server, foreign).await;
        assert!(said.contains(" 403 "), "{foreign}: {said}");
    }
    for own in [
        "",
        "origin: http://localhost\r\n",
        "sec-fetch-site: same-origin\r\n",
    ] {
        let said = asked_for_events(&server, own).await;
        assert!(said.contains(" 200 "), "{own}: {said}");
    }
}
