//! The control interface over HTTP: what an operator does, time, faults, the ledger, and its document.

mod common;

use common::panel::{COUNTER, Panel, controlled};
use common::{ACCEPTED, LINE, Stepped, call, config_of, http, http_get, sock_server, within};
use karel_emulator::{Clock, ControlAccess, PeerLabels, VirtualController};
use serde_json::{Value, json};

#[tokio::test]
async fn the_operators_switches_pause_what_moves_and_alarms_are_reset() {
    let panel = Panel::start(sock_server());
    let _reply = call(panel.cell.address().await, LINE).await;
    panel.cell.advance(0.3).await;
    let (_, view) = panel
        .send("PATCH", "/api/v1/operator", json!({"emergency_stop": true}))
        .await;
    assert_eq!(
        (&view["emergency_stop"], &view["active_alarms"]),
        (&json!(true), &json!(1))
    );
    panel.cell.advance(1.0).await;
    assert!(!panel.cell.controller.state().await.unwrap().moving);
    panel
        .refused("POST", "/api/v1/cycle-start", json!({}), 409, &["RESET"])
        .await;
    let (_, _) = panel
        .send(
            "PATCH",
            "/api/v1/operator",
            json!({"emergency_stop": false}),
        )
        .await;
    let (_, alarms) = panel.get("/api/v1/alarms?active=true").await;
    assert_eq!(alarms["alarms"][0]["facility"], "SRVO");
    let (_, view) = panel.send("POST", "/api/v1/reset", json!({})).await;
    assert_eq!(view["active_alarms"], 0);
    let (status, _) = panel.send("POST", "/api/v1/cycle-start", json!({})).await;
    assert_eq!(status, 200);
    panel.cell.until_standstill().await;
    let (_, view) = panel
        .send(
            "PATCH",
            "/api/v1/operator",
            json!({"mode": "T1", "override_percent": 10}),
        )
        .await;
    assert_eq!(
        (&view["mode"], &view["override_percent"]),
        (&json!("T1"), &json!(10))
    );
    panel
        .refused(
            "PATCH",
            "/api/v1/operator",
            json!({"mode": "T2", "override_percent": 101}),
            422,
            &["101"],
        )
        .await;
    let (_, view) = panel.get("/api/v1/operator").await;
    assert_eq!(view["mode"], "T1", "nothing was done by halves");
    panel
        .refused(
            "PATCH",
            "/api/v1/operator",
            json!({"modus": "T1"}),
            422,
            &["modus"],
        )
        .await;
    let alarm = json!({"facility": "SRVO", "number": 50, "text": "Collision", "severity": "abort"});
    let (status, _) = panel.send("POST", "/api/v1/alarms", alarm).await;
    assert_eq!(status, 204);
    let wrong = json!({"facility": "NONE", "number": 50, "text": "", "severity": "warn"});
    panel
        .refused("POST", "/api/v1/alarms", wrong, 422, &["NONE"])
        .await;
    let (status, _) = panel
        .send("POST", "/api/v1/power-cycle", json!({"memory": "kept"}))
        .await;
    assert_eq!(status, 200);
    panel.cell.advance(0.1).await;
    let (_, state) = panel.get("/api/v1/state").await;
    assert_eq!(
        (&state["power_cycles"], &state["tasks"][0]["state"]),
        (&json!(1), &json!("waiting"))
    );
}

#[tokio::test]
async fn single_step_stops_every_task_after_each_line() {
    let panel = Panel::start(config_of(COUNTER, &[]));
    let (_, view) = panel
        .send("PATCH", "/api/v1/operator", json!({"single_step": true}))
        .await;
    assert_eq!(view["single_step"], true);
    let mut lines = Vec::new();
    for _ in 0..4 {
        panel.cell.advance(1.0).await;
        let (_, task) = panel.get("/api/v1/tasks/COUNTER").await;
        lines.push(task["calls"][0]["line"].as_u64().unwrap());
        let (status, _) = panel.send("POST", "/api/v1/cycle-start", json!({})).await;
        assert_eq!(status, 200);
    }
    assert_eq!(lines, [16, 19, 20, 21]);
    let (_, _) = panel
        .send("PATCH", "/api/v1/operator", json!({"single_step": false}))
        .await;
    let (_, _) = panel.send("POST", "/api/v1/cycle-start", json!({})).await;
    panel.cell.advance(500.0).await;
    let (_, task) = panel.get("/api/v1/tasks/COUNTER").await;
    assert_eq!(task["state"], "ended");
}

#[tokio::test]
async fn the_trace_tells_the_executed_lines() {
    let panel = Panel::start(config_of(COUNTER, &[]));
    let (_, list) = panel
        .send(
            "PUT",
            "/api/v1/trace",
            json!({"on": true, "task": "counter"}),
        )
        .await;
    assert_eq!((&list["on"], &list["next"]), (&json!(true), &json!(0)));
    panel.cell.advance(0.25).await;
    let (_, list) = panel.get("/api/v1/trace").await;
    let lines: Vec<u64> = list["lines"]
        .as_array()
        .unwrap()
        .iter()
        .map(|l| l["line"].as_u64().unwrap())
        .collect();
    assert_eq!(lines, [15, 16, 19, 20, 21, 15, 16, 19, 20, 21, 15]);
    assert_eq!(list["lines"][5]["routine"], "WAIT_A_BIT");
    let (_, rest) = panel.get("/api/v1/trace?after=10&limit=1").await;
    assert_eq!(
        (&rest["lines"][0]["seq"], &rest["next"]),
        (&json!(11), &json!(11))
    );
    let (_, _) = panel
        .send("PUT", "/api/v1/trace", json!({"on": false}))
        .await;
    panel.cell.advance(1.0).await;
    let (_, same) = panel.get("/api/v1/trace").await;
    assert_eq!(same["lines"], list["lines"]);
    panel
        .refused(
            "PUT",
            "/api/v1/trace",
            json!({"on": true, "task": "nobody"}),
            404,
            &["nobody"],
        )
        .await;
}

#[tokio::test]
async fn the_ledger_answers_a_cursor_and_waits_for_news() {
    let panel = Panel::start(sock_server());
    let address = panel.address;
    let waiting =
        tokio::spawn(async move { http(address, "GET", "/api/v1/ledger?wait_s=20", None).await });
    assert_eq!(call(panel.cell.address().await, LINE).await, ACCEPTED);
    panel.cell.advance(0.1).await;
    let (_, news) = within(waiting).await.unwrap();
    assert_eq!(
        (&news["next"], &news["entries"][0]["event"]),
        (&json!(1), &json!("started"))
    );
    panel.cell.until_standstill().await;
    let (_, rest) = panel.get("/api/v1/ledger?after=1&wait_s=20").await;
    assert_eq!(
        (&rest["next"], &rest["entries"][0]["event"]),
        (&json!(2), &json!("finished"))
    );
    let (_, nothing) = panel.get("/api/v1/ledger?after=2&wait_s=0.05").await;
    assert_eq!(nothing, json!({"dropped": 0, "entries": [], "next": 2}));
    panel
        .refused(
            "GET",
            "/api/v1/ledger?wait_s=31",
            json!({}),
            422,
            &["31", "0 to 30"],
        )
        .await;
}

#[tokio::test]
async fn time_is_paused_stepped_and_scaled() {
    let config = controlled(config_of(COUNTER, &[]));
    let controller = VirtualController::start(&config, Clock::real(), PeerLabels::new()).unwrap();
    let address = controller.panel_address().unwrap();
    let send =
        |method, path, body: Value| async move { http(address, method, path, Some(&body)).await };
    let (status, _) = send("POST", "/api/v1/time/step", json!({"ms": 5})).await;
    assert_eq!(status, 409, "it runs");
    let (_, paused) = send("PATCH", "/api/v1/time", json!({"paused": true})).await;
    assert_eq!(paused["paused"], true);
    let start = paused["time_s"].as_f64().unwrap();
    let (_, stepped) = send("POST", "/api/v1/time/step", json!({"ms": 60_000})).await;
    let later = stepped["time_s"].as_f64().unwrap();
    assert!((later - start - 60.0).abs() < 1e-6, "{start} {later}");
    let (_, n) = http(address, "GET", "/api/v1/variable?path=%5Bcounter%5Dn", None).await;
    assert!(n["value"].as_i64().unwrap() > 570, "{n}");
    let (_, scaled) = send(
        "PATCH",
        "/api/v1/time",
        json!({"scale": 1000.0, "paused": false}),
    )
    .await;
    assert_eq!(
        (&scaled["scale"], &scaled["paused"]),
        (&json!(1000.0), &json!(false))
    );
    common::wait_until(&controller, |state| state.idle).await;
    for (path, method, body, words) in [
        (
            "/api/v1/time",
            "PATCH",
            json!({"scale": 0.0}),
            "above 0 and at most 1000",
        ),
        (
            "/api/v1/time/step",
            "POST",
            json!({"ms": 0}),
            "1 to 86400000",
        ),
    ] {
        let (status, problem) = send(method, path, body).await;
        assert_eq!(status, 422);
        assert!(
            problem["detail"].as_str().unwrap().contains(words),
            "{problem}"
        );
    }
    within(controller.shutdown()).await;
    let stepped = Panel::start(sock_server());
    stepped
        .refused(
            "PATCH",
            "/api/v1/time",
            json!({"paused": true}),
            409,
            &["stepped"],
        )
        .await;
}

#[tokio::test]
async fn faults_are_injected_listed_and_cleared() {
    let panel = Panel::start(sock_server());
    let body = json!({"fault": {"delay": {"ms": 300}}, "scope": {"tag": "S3", "direction": "in"}, "times": 2});
    let (status, id) = panel.send("POST", "/api/v1/faults", body).await;
    assert_eq!((status, &id["id"]), (201, &json!(1)));
    let (_, _) = panel
        .send(
            "POST",
            "/api/v1/faults",
            json!({"fault": "servo_off", "for_ms": 5000}),
        )
        .await;
    let (_, list) = panel.get("/api/v1/faults").await;
    assert_eq!(list["faults"][0]["times_left"], 2);
    assert_eq!(list["faults"][1]["until_s"], 5.0);
    panel
        .refused_each([
            (
                "POST",
                "/api/v1/faults",
                json!({"fault": "servo_off"}),
                409,
                &["active already"],
            ),
            (
                "POST",
                "/api/v1/faults",
                json!({"fault": "explode"}),
                422,
                &["explode"],
            ),
            (
                "POST",
                "/api/v1/faults",
                json!({"fault": {"truncate": {"keep": 99999}}}),
                422,
                &["truncate.keep", "99999", "65536"],
            ),
        ])
        .await;
    let (status, _) = http(panel.address, "DELETE", "/api/v1/faults/1", None).await;
    assert_eq!(status, 204);
    let (status, _) = http(panel.address, "DELETE", "/api/v1/faults/1", None).await;
    assert_eq!(status, 404);
    let (_, cleared) = http(panel.address, "DELETE", "/api/v1/faults", None).await;
    assert_eq!(cleared["cleared"], 1);
}

#[tokio::test]
async fn what_may_only_look_touches_nothing_and_no_foreign_page_does() {
    let mut config = controlled(sock_server());
    config.control = ControlAccess::LookOnly;
    let cell = Stepped::start(&config);
    let address = cell.controller.panel_address().unwrap();
    let (status, problem) = http(address, "POST", "/api/v1/hold", Some(&json!({}))).await;
    assert_eq!(status, 403, "{problem}");
    let (status, _) = http(address, "GET", "/api/v1/state", None).await;
    assert_eq!(status, 200);
    let panel = Panel::start(sock_server());
    for (header, expected) in [
        ("Origin: http://evil.example", "403"),
        ("Origin: null", "403"),
        ("Sec-Fetch-Site: cross-site", "403"),
        ("Origin: http://localhost:3000", "403"),
        ("Origin: http://localhost:8081", "200"),
    ] {
        let request = format!(
            "POST /api/v1/hold HTTP/1.1\r\nHost: localhost:8081\r\n{header}\r\nConnection: close\r\nContent-Length: 0\r\n\r\n"
        );
        let answer = call(panel.address, request.as_bytes()).await;
        assert!(
            answer.starts_with(&format!("HTTP/1.1 {expected}")),
            "{header}: {answer}"
        );
    }
    let huge = json!({"path": "x".repeat(100_000), "value": 1});
    panel
        .refused_each([
            ("PUT", "/api/v1/variable", huge, 413, &["65536"]),
            ("GET", "/api/v1/ledger?aftr=1", json!({}), 400, &["aftr"]),
        ])
        .await;
}

#[tokio::test]
async fn the_document_is_served_and_names_every_route() {
    let panel = Panel::start(sock_server());
    let (_, document) = panel.get("/api/v1/openapi.json").await;
    assert_eq!(document["openapi"], "3.1.0");
    let paths = document["paths"].as_object().unwrap();
    assert!(paths.len() > 30, "{}", paths.len());
    for (path, item) in paths {
        for (method, operation) in item.as_object().unwrap() {
            let words = operation["summary"].as_str().unwrap_or_default();
            assert!(!words.is_empty(), "{method} {path}");
            assert!(operation["tags"][0].is_string(), "{method} {path}");
        }
        // Every path of the document is there: it answers something else than "not found".
        let sample = path
            .replace("{kind}", "user")
            .replace("{number}", "1")
            .replace("{register}", "R%5B1%5D")
            .replace("{port}", "DIN%5B1%5D")
            .replace("{id}", "1");
        let answer = http_get(panel.address, &sample, "localhost").await;
        assert!(!answer.contains("on this panel"), "{path}: {answer}");
    }
}

#[test]
fn the_document_in_the_repository_is_what_the_routes_say() {
    let path = std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("openapi.yaml");
    let current = karel_emulator::openapi_yaml().unwrap();
    if std::env::var_os("UPDATE_GOLDEN").is_some() {
        std::fs::write(&path, &current).unwrap();
        return;
    }
    let committed = std::fs::read_to_string(&path).unwrap_or_default();
    assert!(
        committed == current,
        "karel-emulator/openapi.yaml is not what the routes say; run the tests with UPDATE_GOLDEN=1"
    );
}
