//! The panel answers, whatever the program does.

mod common;

use common::{ACCEPTED, LINE, Stepped, call, config_of, http_get, sock_server, within};
use karel_emulator::{Clock, ControllerConfig, PeerLabels, StartError, VirtualController};
use tokio::net::TcpStream;

fn with_panel(mut config: ControllerConfig) -> ControllerConfig {
    config.panel = Some(([127, 0, 0, 1], 0).into());
    config
}

/// Covers: K6.
#[tokio::test]
async fn an_endless_loop_in_a_program_does_not_stop_the_panel() {
    let program = "PROGRAM busy\nVAR n : INTEGER\nBEGIN\nn = 0\nWHILE TRUE DO\nn = 1 - n\nENDWHILE\nEND busy\n";
    let config = with_panel(config_of(program, &[]));
    let controller = VirtualController::start(&config, Clock::real(), PeerLabels::new()).unwrap();
    let panel = controller.panel_address().unwrap();
    let mut last = 0.0;
    for _ in 0..20 {
        let answer = http_get(panel, "/state", "localhost").await;
        let body = answer.split("\r\n\r\n").nth(1).unwrap();
        let state: serde_json::Value = serde_json::from_str(body).unwrap();
        assert_eq!(state["tasks"][0]["state"], "running");
        assert!(state["time_s"].as_f64().unwrap() >= last);
        last = state["time_s"].as_f64().unwrap();
    }
    within(controller.shutdown()).await;
}

#[tokio::test]
async fn the_panel_shows_the_ledger_from_a_number_on() {
    let cell = Stepped::start(&with_panel(sock_server()));
    let _reply = call(cell.address().await, LINE).await;
    cell.until_standstill().await;
    let panel = cell.controller.panel_address().unwrap();
    let answer = http_get(panel, "/ledger?after=1", "127.0.0.1").await;
    let body = answer.split("\r\n\r\n").nth(1).unwrap();
    let list: serde_json::Value = serde_json::from_str(body).unwrap();
    assert_eq!(list["dropped"], 0);
    assert_eq!(list["entries"].as_array().unwrap().len(), 1);
    assert_eq!(list["entries"][0]["event"], "finished");
    let answer = http_get(panel, "/ledger?limit=1", "127.0.0.1").await;
    assert!(answer.contains("finished") && !answer.contains("started"));
    let answer = http_get(panel, "/alarms?limit=0", "127.0.0.1").await;
    assert!(
        answer.ends_with(r#"{"dropped":0,"entries":[]}"#),
        "{answer}"
    );
    let page = http_get(panel, "/", "localhost").await;
    assert!(page.starts_with("HTTP/1.1 200") && page.contains("<!doctype html>"));
}

#[tokio::test]
async fn what_the_panel_does_not_have_it_says_in_json() {
    let cell = Stepped::start(&with_panel(sock_server()));
    let panel = cell.controller.panel_address().unwrap();
    let answer = http_get(panel, "/no/such", "localhost").await;
    assert!(answer.starts_with("HTTP/1.1 404"), "{answer}");
    assert!(answer.contains("application/problem+json") && answer.contains("/no/such"));
    let answer = http_get(panel, "/ledger?after=x", "localhost").await;
    assert!(answer.starts_with("HTTP/1.1 400"), "{answer}");
    let answer = http_get(panel, "/state", "evil.example").await;
    assert!(answer.starts_with("HTTP/1.1 403"), "{answer}");
}

#[tokio::test]
async fn the_panel_refuses_what_is_not_a_question_and_what_is_too_long() {
    let cell = Stepped::start(&with_panel(sock_server()));
    let panel = cell.controller.panel_address().unwrap();
    let post = "POST /state HTTP/1.1\r\nHost: localhost\r\nContent-Length: 99999999\r\nConnection: close\r\n\r\n";
    let answer = call(panel, post.as_bytes()).await;
    assert!(answer.starts_with("HTTP/1.1 405"), "{answer}");
    assert!(answer.contains("application/problem+json"), "{answer}");
    let answer = http_get(panel, &format!("/{}", "x".repeat(20_000)), "localhost").await;
    assert!(answer.starts_with("HTTP/1.1 4"), "{answer}");
    let answer = http_get(panel, "/state", "localhost").await;
    assert!(answer.contains("frame-ancestors 'none'"), "{answer}");
}

#[tokio::test]
async fn clients_that_hold_the_panel_get_no_more_than_its_places_and_stop_nobody() {
    let cell = Stepped::start(&with_panel(sock_server()));
    let panel = cell.controller.panel_address().unwrap();
    let mut held = Vec::new();
    for _ in 0..100 {
        held.push(within(TcpStream::connect(panel)).await.unwrap());
    }
    assert_eq!(call(cell.address().await, LINE).await, ACCEPTED);
    drop(held);
    let answer = http_get(panel, "/state", "localhost").await;
    assert!(answer.starts_with("HTTP/1.1 200"), "{answer}");
    within(cell.controller.shutdown()).await;
}

/// Covers: K9.
#[tokio::test]
async fn only_loopback_is_opened_without_permission() {
    let mut config = with_panel(sock_server());
    config.panel = Some(([0, 0, 0, 0], 0).into());
    let started = VirtualController::start(&config, Clock::real(), PeerLabels::new());
    assert!(matches!(started, Err(StartError::NotLoopback { .. })));
    let mut config = sock_server();
    config.ip = [0, 0, 0, 0].into();
    let started = VirtualController::start(&config, Clock::real(), PeerLabels::new());
    assert!(matches!(started, Err(StartError::NotLoopback { .. })));
}

#[tokio::test]
async fn the_shapes_of_state_and_ledger_are_what_clients_rely_on() {
    let cell = Stepped::start(&sock_server());
    let _reply = call(cell.address().await, LINE).await;
    let state = serde_json::to_value(cell.controller.state().await.unwrap()).unwrap();
    let ledger = serde_json::to_value(cell.controller.ledger().await.unwrap()).unwrap();
    let keys = |value: &serde_json::Value| -> Vec<String> {
        let mut keys: Vec<String> = value.as_object().unwrap().keys().cloned().collect();
        keys.sort();
        keys
    };
    let state_keys = [
        "active_alarms",
        "configuration",
        "controller",
        "emergency_stop",
        "faults",
        "fidelity",
        "generation",
        "gripper",
        "held",
        "hold",
        "idle",
        "joints_deg",
        "ledger_seq",
        "limits_deg",
        "mode",
        "model",
        "motion_queue",
        "moving",
        "note_seq",
        "override_percent",
        "pendant_enabled",
        "ports",
        "pose",
        "power_cycles",
        "power_on",
        "servo_power",
        "single_step",
        "tags",
        "tasks",
        "time_s",
    ];
    assert_eq!(keys(&state), state_keys);
    assert_eq!(
        keys(&state["joints_deg"]),
        ["j1", "j2", "j3", "j4", "j5", "j6"]
    );
    assert_eq!(
        keys(&state["pose"]),
        ["p_deg", "r_deg", "w_deg", "x_mm", "y_mm", "z_mm"]
    );
    assert_eq!(
        keys(&state["tasks"][0]),
        ["detail", "line", "name", "program", "state"]
    );
    assert_eq!(keys(&state["tags"][0]), ["peer", "port", "state", "tag"]);
    let entry_keys = [
        "alarm",
        "duration_s",
        "event",
        "from_deg",
        "kind",
        "line",
        "motion",
        "override_percent",
        "peer",
        "program",
        "request_id",
        "seq",
        "speed_mm_s",
        "target_pose",
        "time_s",
        "to_deg",
    ];
    assert_eq!(keys(&ledger[0]), entry_keys);
    assert_eq!(ledger[0]["event"], "started");
    assert_eq!(ledger[0]["kind"], "joint");
}
