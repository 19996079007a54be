//! Jobs over HTTP, in a cell whose set-up is the demo's and whose arm takes no part: its controller cannot number
//! its commands, so a job claims, asks for a plan of its poses, and waits.

use jiff::{SignedDuration, Timestamp};
use journal::MemoryDisk;
use serde_json::{Value, json};

use crate::support::{FakeRobot, HttpReply, TestServer, WorkCell, fresh_key, opened, until};

pub(crate) const JOBS: &str = "/api/v1/cells/c1/jobs";

/// A delivery that fits the demo's set-up.
pub(crate) fn delivery() -> Value {
    json!({
        "workflow": "delivery-and-placement",
        "params": {
            "point": "handover/front",
            "items": [{"load_id": "load-1", "type": "crate", "mr_slot": "left", "place": "rack/d"}],
        },
    })
}

fn with(more: &Value) -> Value {
    let mut body = delivery();
    for (key, value) in more.as_object().unwrap() {
        body["params"][key] = value.clone();
    }
    body
}

async fn create(cell: &TestServer, body: &Value) -> HttpReply {
    cell.post(JOBS, &body.to_string()).await
}

/// A job that was taken.
async fn taken(cell: &TestServer, body: &Value) -> Value {
    let reply = create(cell, body).await;
    assert_eq!(reply.status, 201, "{reply:?}");
    reply.json()
}

pub(crate) fn path_of(job: &Value) -> String {
    format!("{JOBS}/{}", job["id"].as_str().unwrap())
}

async fn command(cell: &TestServer, job: &Value, command: &str) -> HttpReply {
    let body = json!({"command": command, "reason": "a test"}).to_string();
    cell.post(&format!("{}/commands", path_of(job)), &body).await
}

/// The job, once it is in a state.
async fn in_state(cell: &TestServer, job: &Value, state: &str) -> Value {
    let path = path_of(job);
    let mut last = Value::Null;
    until(&format!("the job is {state}"), async || {
        last = cell.get(&path).await.json();
        last["state"] == state
    })
    .await;
    last
}

/// Covers: W1.
#[tokio::test]
async fn a_job_is_created_shown_and_listed() {
    let cell = WorkCell::start().await;
    let mut body = delivery();
    body["priority"] = json!(7);
    let deadline = Timestamp::now() + SignedDuration::from_hours(2);
    let deadline = format!("{deadline:.0}");
    body["deadline"] = json!(deadline);
    let reply = create(&cell, &body).await;
    assert_eq!(reply.status, 201, "{reply:?}");
    assert_eq!(reply.header("idempotency-replayed"), None);
    let job = reply.json();
    assert_eq!(reply.header("location"), Some(&*path_of(&job)));
    let shown = cell.get(&path_of(&job)).await.json();
    for (key, value) in [
        ("workflow", json!("delivery-and-placement")),
        ("cell", json!("c1")),
        ("priority", json!(7)),
        ("deadline", json!(deadline)),
        ("number", json!(1)),
        ("compensation", json!("NONE")),
    ] {
        assert_eq!(shown[key], value, "{key}");
    }
    assert_eq!(shown["items"][0]["load"], "load-1");
    assert_eq!(shown["params"]["items"][0]["place"], "rack/d");
    assert_eq!(shown["params"]["max_attempts"], 2);
    let created: Timestamp = shown["created_at"].as_str().unwrap().parse().unwrap();
    assert!(Timestamp::now().duration_since(created).abs() < SignedDuration::from_secs(60));

    let second = taken(&cell, &with(&json!({"items": [
        {"type": "crate", "mr_slot": "right", "target_slot": "rack/e"},
    ]})))
    .await;
    let list = cell.get(&format!("{JOBS}?limit=1")).await.json();
    assert_eq!(list["jobs"][0]["id"], second["id"]);
    let next = list["next_cursor"].as_str().unwrap();
    let list = cell.get(&format!("{JOBS}?cursor={next}")).await.json();
    assert_eq!(list["jobs"].as_array().unwrap().len(), 1);
    assert_eq!(list["jobs"][0]["id"], job["id"]);
    assert_eq!(list["next_cursor"], Value::Null);
    let none = cell.get(&format!("{JOBS}?state=COMPLETE")).await.json();
    assert_eq!(none["jobs"], json!([]));
}
