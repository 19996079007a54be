//! Jobs that are refused: each names the item, the value and the limit, and nothing is kept.

use journal::MemoryDisk;
use serde_json::{Value, json};

use crate::jobs::{JOBS, delivery, path_of};
use crate::support::{DEMO_SETUP, WorkCell};

/// The delivery with one thing changed.
fn changed(pointer: &str, value: Value) -> Value {
    let mut body = delivery();
    if let Some(old) = body.pointer_mut(pointer) {
        *old = value;
    } else {
        let (parent, key) = pointer.rsplit_once('/').unwrap();
        body.pointer_mut(parent).unwrap()[key] = value;
    }
    body
}

/// Covers: H1, H2, W2. Every parameter out of its range, or not of this cell.
#[expect(
    clippy::too_many_lines,
    reason = "one row for each item that can be wrong"
)]
#[tokio::test]
async fn a_job_that_does_not_fit_is_refused_by_item() {
    let cell = WorkCell::start().await;
    let item = json!({"type": "crate", "mr_slot": "left", "place": "rack/d"});
    let many = vec![item.clone(); 33];
    let long = "x".repeat(129);
    for (pointer, value, item, says) in [
        (
            "/params/point",
            json!("handover/back"),
            "params.point",
            "handover/back",
        ),
        ("/params/point", json!(""), "params.point", "1 to 128"),
        (
            "/params/point",
            json!(long),
            "params.point",
            "129 characters",
        ),
        ("/params/arm", json!("r9"), "params.arm", "r9"),
        (
            "/params/mobile_robot",
            json!("mr9"),
            "params.mobile_robot",
            "mr9",
        ),
        (
            "/params/items",
            json!([]),
            "params.items",
            "0 items; 1 to 32",
        ),
        (
            "/params/items",
            json!(many),
            "params.items",
            "33 items; 1 to 32",
        ),
        (
            "/params/items",
            json!([item, item]),
            "params.items[1]",
            "twice",
        ),
        (
            "/params/items/0/place",
            json!("rack/z"),
            "params.items[0].place",
            "rack/z",
        ),
        (
            "/params/items/0/type",
            json!("barrel"),
            "params.items[0].type",
            "barrel",
        ),
        (
            "/params/items/0/mr_slot",
            json!("top"),
            "params.items[0].mr_slot",
            "top",
        ),
        (
            "/params/items/0/load_id",
            json!("load-2"),
            "params.items[0].load_id",
            "rack/a",
        ),
        (
            "/params/items/0/alternates",
            json!(["rack/z"]),
            "params.items[0].alternates",
            "rack/z",
        ),
        (
            "/priority",
            json!(101),
            "priority",
            "101 is not from -100 to 100",
        ),
        (
            "/priority",
            json!(-101),
            "priority",
            "-101 is not from -100 to 100",
        ),
        (
            "/deadline",
            json!("tomorrow"),
            "deadline",
            "`tomorrow` is no time, expected a time with its offset (RFC 3339)",
        ),
        (
            "/deadline",
            json!(1_800_000_000),
            "deadline",
            "expected a time with its offset (RFC 3339)",
        ),
        (
            "/params/max_attempts",
            json!(0),
            "params.max_attempts",
            "0 is not from 1 to 10",
        ),
        (
            "/params/max_attempts",
            json!(11),
            "params.max_attempts",
            "11 is not from 1 to 10",
        ),
        (
            "/params/expected_arrival_s",
            json!(-1),
            "params.expected_arrival_s",
            "0 to 86400 s",
        ),
        (
            "/params/expected_transport_s",
            json!(1e9),
            "params.expected_transport_s",
            "86400 s",
        ),
        (
            "/params/on_cancel_with_load",
            json!("REJECT_BIN"),
            "params.reject_slot",
            "REJECT_BIN",
        ),
        (
            "/params/destination",
            json!("warehouse"),
            "params.prefetch",
            "pickup-and-delivery",
        ),
        (
            "/params/prefetch",
            json!(true),
            "params.prefetch",
            "pickup-and-delivery",
        ),
        (
            "/params/complete_on",
            json!("DELIVERED"),
            "params.destination",
            "DELIVERED",
        ),
        (
            "/deadline",
            json!("2020-01-01T00:00:00Z"),
            "deadline",
            "2020-01-01T00:00:00Z has passed",
        ),
    ] {
        let body = changed(pointer, value);
        let reply = cell.post(JOBS, &body.to_string()).await;
        let problem = reply.problem(422, "validation", "NOT_SENT");
        assert_eq!(problem["violations"][0]["item"], item, "{body} {problem}");
        let message = problem["violations"][0]["message"].as_str().unwrap();
        assert!(message.contains(says), "{item}: {message}");
    }
    assert_eq!(cell.get(JOBS).await.json()["jobs"], json!([]));
}

/// Covers: H1. What is no job at all.
#[tokio::test]
async fn a_body_of_another_shape_is_refused_by_key() {
    let cell = WorkCell::start().await;
    for (pointer, value, item) in [
        ("/workflow", json!("delivery"), "workflow"),
        (
            "/params/items/0/slot",
            json!("left"),
            "params.items[0].slot",
        ),
        ("/params/speed", json!(1), "params.speed"),
        ("/params/max_attempts", json!(256), "params.max_attempts"),
        ("/params/max_attempts", json!(1.5), "params.max_attempts"),
        (
            "/params/on_cancel_with_load",
            json!("DROP"),
            "params.on_cancel_with_load",
        ),
        ("/deadline", json!("tomorrow"), "deadline"),
        ("/priority", json!(3_000_000_000_u64), "priority"),
        ("/version", json!(1), "version"),
    ] {
        let body = changed(pointer, value);
        let reply = cell.post(JOBS, &body.to_string()).await;
        let problem = reply.problem(422, "validation", "NOT_SENT");
        let text = problem.to_string();
        assert!(text.contains(item), "{item}: {text}");
    }
    let twice =
        delivery()
            .to_string()
            .replacen("\"place\"", "\"target_slot\":\"rack/e\",\"place\"", 1);
    let reply = cell.post(JOBS, &twice).await;
    let _problem = reply.problem(422, "validation", "NOT_SENT");
    let reply = cell.post(JOBS, "{").await;
    let _problem = reply.problem(400, "invalid-json", "NOT_SENT");
    assert_eq!(cell.get(JOBS).await.json()["jobs"], json!([]));
}

/// Covers: H8.
#[tokio::test]
async fn a_job_without_a_key_is_refused() {
    let cell = WorkCell::start().await;
    let headers = [("content-type", "application/json")];
    let body = delivery().to_string();
    let reply = cell.request("POST", JOBS, &headers, &body).await;
    let _problem = reply.problem(400, "idempotency-missing", "NOT_SENT");
    assert_eq!(cell.get(JOBS).await.json()["jobs"], json!([]));
}

/// Covers: W9. Each command that the state does not allow.
#[tokio::test]
async fn a_command_that_does_not_fit_the_state_is_refused() {
    let cell = WorkCell::start().await;
    let reply = cell.post(JOBS, &delivery().to_string()).await;
    let job = reply.json();
    let path = format!("{}/commands", path_of(&job));
    for name in [
        "hold",
        "unhold",
        "retry-step",
        "skip-step",
        "complete-manually",
        "clear",
        "reset",
    ] {
        assert!(
            !job["commands"].as_array().unwrap().contains(&json!(name)),
            "{job}"
        );
        let body = json!({"command": name, "reason": "a test"}).to_string();
        let problem = cell.post(&path, &body).await;
        let problem = problem.problem(409, "wrong-job-state", "NOT_SENT");
        let detail = problem["detail"].as_str().unwrap();
        assert!(detail.starts_with(name), "{detail}");
    }
    for (body, item) in [
        (json!({"command": "stop", "reason": ""}), "reason"),
        (json!({"command": "stop", "reason": " "}), "reason"),
        (
            json!({"command": "stop", "reason": "x".repeat(501)}),
            "reason",
        ),
        (json!({"command": "stop"}), "reason"),
        (json!({"command": "start", "reason": "a test"}), "command"),
        (
            json!({"command": "stop", "reason": "a", "force": true}),
            "force",
        ),
    ] {
        let reply = cell.post(&path, &body.to_string()).await;
        let problem = reply.problem(422, "validation", "NOT_SENT");
        assert!(problem.to_string().contains(item), "{problem}");
    }
    assert_eq!(cell.get(&path_of(&job)).await.json()["state"], "IDLE");
}

/// Covers: H3.
#[tokio::test]
async fn what_is_not_there_is_not_found() {
    let cell = WorkCell::start().await;
    let nobody = "00000000-0000-7000-8000-000000000000";
    for path in [
        format!("{JOBS}/{nobody}"),
        format!("{JOBS}/7"),
        format!("{JOBS}/{nobody}/events"),
        format!("{JOBS}/{nobody}/report"),
        "/api/v1/cells/c9/jobs".to_owned(),
        "/api/v1/cells/c9/state".to_owned(),
        "/api/v1/cells/c9/loads".to_owned(),
        "/api/v1/cells/c1/loads/load-99".to_owned(),
        format!("/api/v1/cells/c1/sessions/{nobody}"),
        "/api/v1/cells/c1/sessions/7".to_owned(),
        format!("/api/v1/cells/c1/interventions/{nobody}"),
    ] {
        let _problem = cell.get(&path).await.problem(404, "not-found", "NONE");
    }
    let body = json!({"command": "stop", "reason": "a test"}).to_string();
    let reply = cell.post(&format!("{JOBS}/{nobody}/commands"), &body).await;
    let _problem = reply.problem(404, "not-found", "NOT_SENT");
    let reply = cell
        .post("/api/v1/cells/c9/jobs", &delivery().to_string())
        .await;
    let _problem = reply.problem(404, "not-found", "NOT_SENT");
    for query in ["state=held", "limit=0", "cursor=x", "open=1"] {
        let reply = cell.get(&format!("{JOBS}?{query}")).await;
        let _problem = reply.problem(422, "validation", "NONE");
    }
}

/// Both ends of the arm's way, or all of it, may be in a zone: a job that would have to go there is not taken.
///
/// Covers: H4.
#[tokio::test]
async fn h4_a_job_whose_approach_leads_through_a_zone_is_refused_by_place() {
    for (kind, what) in [
        ("KEEP_OUT", "the keep-out zone `post`"),
        ("HANDOVER", "the hand-over zone `post`"),
    ] {
        // Below the approach to rack/d, at x -100, y 1000, and above where the load stands.
        let post = format!(
            "
[[zones]]
id = \"post\"
kind = \"{kind}\"
box.min = {{ x_mm = -150, y_mm = 950, z_mm = 660 }}
box.max = {{ x_mm = -50, y_mm = 1050, z_mm = 700 }}
"
        );
        let disk = MemoryDisk::new();
        let cell = WorkCell::with_setup(&disk, &format!("{DEMO_SETUP}{post}")).await;
        let reply = cell.post(JOBS, &delivery().to_string()).await;
        let problem = reply.problem(422, "zone-violation", "NOT_SENT");
        let violation = &problem["violations"][0];
        assert_eq!(violation["item"], "params.items[0].place", "{problem}");
        let message = violation["message"].as_str().unwrap();
        for said in ["r1 at `rack/d`: the approach: ", what, " mm at x "] {
            assert!(message.contains(said), "{message}");
        }
        assert!(violation["value"].as_f64().unwrap() < 0.0, "{problem}");
        assert_eq!(violation["min"], 0.0, "{problem}");
        let jobs = cell.get(JOBS).await.json();
        assert_eq!(jobs["jobs"], json!([]));
        // Beside it there is nothing in the way.
        let other = changed("/params/items/0/place", json!("rack/f"));
        assert_eq!(cell.post(JOBS, &other.to_string()).await.status, 201);
    }
}
