//! The control interface over HTTP: what cannot be read is named with its value and with what it can be, on every route.

#![expect(clippy::too_many_lines, reason = "the table is long")]

mod common;

use common::panel::Panel;
use common::sock_server;
use serde_json::json;

#[tokio::test]
async fn what_cannot_be_read_is_named_with_what_it_can_be_on_every_route() {
    let panel = Panel::start(sock_server());
    let pose = "{x_mm, y_mm, z_mm, w_deg, p_deg, r_deg, configuration?}";
    let rows = [
        (
            "POST",
            "/api/v1/faults",
            json!({"fault": "dropp"}),
            "fault is \"dropp\", it must be drop, delay,",
        ),
        (
            "POST",
            "/api/v1/faults",
            json!({"fault": {"power_loss": {"memory": "half"}}}),
            "fault.power_loss.memory is \"half\", it must be kept or lost",
        ),
        (
            "POST",
            "/api/v1/faults",
            json!({"fault": {"option_missing": {"option": "R999"}}}),
            "fault.option_missing.option is \"R999\", it must be R632 or R648",
        ),
        (
            "POST",
            "/api/v1/alarms",
            json!({"facility": "SRVO", "number": 1, "text": "x", "severity": "bad"}),
            "severity is \"bad\", it must be warn, pause or abort",
        ),
        (
            "PATCH",
            "/api/v1/operator",
            json!({"mode": "T3"}),
            "mode is \"T3\", it must be T1, T2 or AUTO",
        ),
        (
            "PATCH",
            "/api/v1/operator",
            json!({"modes": "T1"}),
            "modes is no key here, there is mode, pendant_enabled,",
        ),
        (
            "POST",
            "/api/v1/power-cycle",
            json!({"memory": 1}),
            "memory is 1, it must be kept or lost",
        ),
        (
            "POST",
            "/api/v1/keyboard",
            json!({"text": 7}),
            "text is 7, it must be a text",
        ),
        ("POST", "/api/v1/jog", json!({}), "is missing"),
        (
            "PATCH",
            "/api/v1/profile",
            json!({"fidelity": "x"}),
            "fidelity is \"x\", it must be faithful or kind",
        ),
        (
            "PATCH",
            "/api/v1/time",
            json!({"scale": "x"}),
            "scale is \"x\", it must be a number",
        ),
        (
            "POST",
            "/api/v1/time/step",
            json!({"ms": -1}),
            "ms is -1, it must be a whole number, 0 or more",
        ),
        ("PUT", "/api/v1/trace", json!({"enabled": 3}), "enabled"),
        (
            "PUT",
            "/api/v1/variable",
            json!({"path": "$SPEED", "value": {"int": 5}}),
            pose,
        ),
        (
            "PUT",
            "/api/v1/registers/R%5B1%5D",
            json!({"value": {"real": 5}}),
            "value is {\"real\":5}, it must be true or false,",
        ),
        (
            "PUT",
            "/api/v1/io/DIN%5B1%5D",
            json!({"value": true}),
            "value is true, it must be a whole number,",
        ),
        (
            "PUT",
            "/api/v1/io/DIN%5B1%5D/simulation",
            json!([]),
            "the body",
        ),
        (
            "PUT",
            "/api/v1/selected-frames/user",
            json!({"number": "x"}),
            "number is \"x\", it must be a whole number,",
        ),
        (
            "PUT",
            "/api/v1/frames/user/1",
            json!({"x_mm": 1}),
            "y_mm is missing",
        ),
    ];
    for (method, path, body, words) in rows {
        panel.refused(method, path, body, 422, &[words]).await;
    }
    for (path, words) in [
        (
            "/api/v1/alarms?activ=true",
            "activ is no key here, there is active or limit",
        ),
        (
            "/api/v1/alarms?active=maybe",
            "active is \"maybe\", it must be true or false",
        ),
        (
            "/api/v1/ledger?after=x",
            "after is \"x\", it must be a whole number, 0 or more",
        ),
        (
            "/api/v1/ledger?wait_s=x",
            "wait_s is \"x\", it must be a number",
        ),
        ("/api/v1/variables", "program is missing"),
        (
            "/ledger?after=x",
            "after is \"x\", it must be a whole number, 0 or more",
        ),
    ] {
        let (status, problem) = panel.get(path).await;
        let detail = problem["detail"].as_str().unwrap_or_default();
        assert!(
            status == 400 && detail.contains(words),
            "{path}: {status} {detail}"
        );
    }
}
