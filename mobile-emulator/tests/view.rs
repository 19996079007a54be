//! The robot over HTTP: what it shows, what it takes, and what it refuses.
#![allow(clippy::unwrap_used, reason = "a helper that fails stops its test")]

mod common;

use std::net::SocketAddr;

use common::{Scene, config, order, within};
use mobile_emulator::config::ViewSection;
use mobile_emulator::{CellAddress, Clock, MobileRobot, Phase, StartError};
use serde_json::{Value, json};
use tokio::io::{AsyncReadExt, AsyncWriteExt};
use tokio::net::TcpStream;

async fn scene() -> (Scene, SocketAddr) {
    let mut config = config();
    config.view = Some(ViewSection {
        address: "127.0.0.1:0".parse().unwrap(),
        expose_to_network: false,
    });
    let scene = Scene::start(config).await;
    let address = scene.robot.view_address().unwrap();
    (scene, address)
}

/// One HTTP request with these header lines; status and body.
async fn ask(address: SocketAddr, head: &str, headers: &str, body: &str) -> (u16, String) {
    let request = format!(
        "{head} HTTP/1.1\r\n{headers}Content-Length: {}\r\nConnection: close\r\n\r\n{body}",
        body.len()
    );
    let mut stream = within(TcpStream::connect(address)).await.unwrap();
    stream.write_all(request.as_bytes()).await.unwrap();
    let mut answer = Vec::new();
    let _count = within(stream.read_to_end(&mut answer)).await.unwrap();
    let answer = String::from_utf8(answer).unwrap();
    let status = answer.split(' ').nth(1).unwrap().parse().unwrap();
    let body = answer.split_once("\r\n\r\n").unwrap().1.to_owned();
    (status, body)
}

async fn get(address: SocketAddr, path: &str) -> (u16, Value) {
    let (status, body) = ask(address, &format!("GET {path}"), "Host: localhost\r\n", "").await;
    (status, serde_json::from_str(&body).unwrap())
}

async fn post(address: SocketAddr, path: &str, body: &str) -> (u16, Value) {
    let headers = "Host: localhost\r\nContent-Type: application/json\r\n";
    let (status, body) = ask(address, &format!("POST {path}"), headers, body).await;
    (status, serde_json::from_str(&body).unwrap())
}

#[tokio::test]
async fn it_shows_its_state_and_its_ledger() {
    let (scene, address) = scene().await;
    scene.until_ready(order()).await;
    let (status, state) = get(address, "/state").await;
    assert_eq!((status, &state["phase"]), (200, &json!("READY")));
    assert_eq!(state["slots"][0], json!({"slot": "a", "load": "box-1"}));
    let (_, ledger) = get(address, "/ledger?limit=3").await;
    assert_eq!(ledger["entries"].as_array().unwrap().len(), 3);
    // Whoever looks after a quiet hour wants to see what was before it, not an hour of heartbeats.
    let (_, eventful) = get(address, "/ledger?heartbeats=false&limit=1000").await;
    let eventful = eventful["entries"].as_array().unwrap();
    let signals = |name: &str| eventful.iter().filter(|e| e["signal"] == name).count();
    assert_eq!(signals("MR_HEARTBEAT"), 0);
    assert!(signals("MR_DOCKED") > 0);
    let n = ledger["entries"][2]["n"].as_u64().unwrap();
    let (_, newer) = get(address, &format!("/ledger?after={n}")).await;
    assert_eq!(newer["entries"], json!([]));
    let (status, page) = ask(address, "GET /", "Host: 127.0.0.1\r\n", "").await;
    assert!(status == 200 && page.contains("Floor plan"));
}

#[tokio::test]
async fn faults_and_loads_are_set_over_http() {
    let (scene, address) = scene().await;
    let (status, body) = post(address, "/faults", r#"{"fault":"LIE","x_mm":500}"#).await;
    assert_eq!((status, &body["id"]), (201, &json!(1)));
    let (_, state) = get(address, "/state").await;
    assert_eq!(state["told_pose"]["x_mm"], json!(500.0));
    assert_eq!(state["faults"][0]["fault"], json!("LIE"));
    let headers = "Host: localhost\r\n";
    let (_, body) = ask(address, "DELETE /faults", headers, "").await;
    assert_eq!(body, r#"{"cleared":1}"#);
    let (status, loads) = post(address, "/loads", r#"{"slot":"a","load":null}"#).await;
    assert_eq!((status, &loads[0]["load"]), (200, &Value::Null));
    let (status, loads) = post(address, "/loads", r#"{"slot":"b","load":"box-1"}"#).await;
    assert_eq!((status, &loads[1]["load"]), (200, &json!("box-1")));
    assert_eq!(
        scene.robot.slots().await.unwrap()[1].load.as_deref(),
        Some("box-1")
    );
}

#[tokio::test]
async fn bad_input_is_answered_with_item_value_and_limit() {
    let (scene, address) = scene().await;
    let before = scene.robot.state().await.unwrap();
    let long = format!(r#"{{"slot":"b","load":"{}"}}"#, "x".repeat(65));
    let cases = [
        ("/faults", r#"{"fault":"LATE"}"#, 422, "delay_s"),
        (
            "/faults",
            r#"{"fault":"LATE","delay_s":-1}"#,
            422,
            "delay_s is -1; it must be from 0 to 86400",
        ),
        (
            "/faults",
            r#"{"fault":"LATE","delay_s":"soon"}"#,
            422,
            "delay_s",
        ),
        (
            "/faults",
            r#"{"fault":"LATE","delay_s":1,"for":2}"#,
            422,
            "`for`",
        ),
        (
            "/faults",
            r#"{"fault":"LATER"}"#,
            422,
            "fault: there is no `LATER`, expected one of `LATE`, `STUCK`",
        ),
        (
            "/faults",
            r#"{"fault":"BATTERY","percent":101}"#,
            422,
            "percent is 101; it must be from 0 to 100",
        ),
        ("/faults", r#"{"fault":"LATE","delay_s":1"#, 400, "EOF"),
        ("/faults", "", 400, "EOF"),
        (
            "/faults",
            r#"{"fault":"CRASH","down_s":1} {}"#,
            400,
            "trailing",
        ),
        (
            "/loads",
            r#"{"slot":"z","load":"x"}"#,
            422,
            "no slot `z`; there are: a, b",
        ),
        ("/loads", r#"{"slot":"a","load":"x"}"#, 409, "holds `box-1`"),
        ("/loads", r#"{"slot":"b","load":null}"#, 409, "`b` is empty"),
        (
            "/loads",
            r#"{"slot":"b","load":"box-1"}"#,
            409,
            "in slot `a`",
        ),
        ("/loads", &long, 422, "1 to 64 of"),
        (
            "/messages",
            r#"{"n":1,"at":"2026-01-01T00:00:00Z","kind":"FLY"}"#,
            422,
            "FLY",
        ),
        (
            "/messages",
            r#"{"n":7,"at":"2026-01-01T00:00:00Z","kind":"CELL_READY"}"#,
            409,
            "message 7 is not the next one; that is 1",
        ),
    ];
    for (path, body, wanted, detail) in cases {
        let (status, problem) = post(address, path, body).await;
        let said = problem["detail"].as_str().unwrap();
        assert_eq!(status, wanted, "{body}: {said}");
        assert!(said.contains(detail), "{body}: {said}");
    }
    let too_long = format!(r#"{{"fault":"{}"}}"#, "x".repeat(300_000));
    assert_eq!(post(address, "/faults", &too_long).await.0, 413);
    let plain = "Host: localhost\r\nContent-Type: text/plain\r\n";
    assert_eq!(ask(address, "POST /faults", plain, "{}").await.0, 415);
    assert_eq!(get(address, "/ledger?limit=-1").await.0, 400);
    assert_eq!(get(address, "/nothing").await.0, 404);
    assert_eq!(post(address, "/state", "{}").await.0, 405);
    let after = scene.robot.state().await.unwrap();
    assert_eq!(after, before, "nothing has happened");
}

#[tokio::test]
async fn another_sites_page_cannot_reach_it() {
    let (_scene, address) = scene().await;
    let (status, _) = ask(address, "GET /state", "Host: evil.example\r\n", "").await;
    assert_eq!(status, 403);
    let headers =
        "Host: localhost\r\nOrigin: http://evil.example\r\nContent-Type: application/json\r\n";
    let body = r#"{"fault":"LATE","delay_s":1}"#;
    assert_eq!(ask(address, "POST /faults", headers, body).await.0, 403);
    let headers =
        "Host: localhost\r\nOrigin: http://localhost\r\nContent-Type: application/json\r\n";
    assert_eq!(ask(address, "POST /faults", headers, body).await.0, 201);
}

#[tokio::test]
async fn messages_may_be_pushed_instead_of_polled() {
    let mut config = config();
    config.link.poll = false;
    config.view = Some(ViewSection {
        address: "127.0.0.1:0".parse().unwrap(),
        expose_to_network: false,
    });
    let scene = Scene::start(config).await;
    let address = scene.robot.view_address().unwrap();
    let mut message = json!({"n": 5, "at": "2026-01-01T00:00:00Z", "session": common::session(), "kind": "TRANSPORT_ORDER"});
    let order = serde_json::to_value(order()).unwrap();
    message
        .as_object_mut()
        .unwrap()
        .extend(order.as_object().unwrap().clone());
    // The same push again is the same message.
    for _ in 0..2 {
        assert_eq!(
            post(address, "/messages", &message.to_string()).await.0,
            200
        );
    }
    let permit = json!({"n": 6, "at": "2026-01-01T00:00:00Z", "session": common::session(), "kind": "MOVE_PERMIT", "granted": true});
    assert_eq!(post(address, "/messages", &permit.to_string()).await.0, 200);
    scene.until_phase(Some(Phase::Docked)).await;
    assert_eq!(scene.count(api::SignalName::MrAssigned), 1);
    assert!(scene.cell.polls().is_empty());
}

#[tokio::test]
async fn it_opens_to_other_machines_only_when_it_shall() {
    let mut config = config();
    config.view = Some(ViewSection {
        address: "0.0.0.0:0".parse().unwrap(),
        expose_to_network: false,
    });
    let cell = CellAddress::new("http://127.0.0.1:9", "demo").unwrap();
    let refused = MobileRobot::start(&config, Clock::real(), &cell);
    assert!(matches!(refused, Err(StartError::NotLoopback { .. })));
}
