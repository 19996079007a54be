//! Jobs over HTTP, in a cell whose set-up is the demo's and whose arm takes no part: its controller cannot number
//! its commands, so a job claims, asks for a plan of its poses, and waits.

use std::sync::Arc;

use jiff::{SignedDuration, Timestamp};
use journal::MemoryDisk;
use serde_json::{Value, json};

use crate::support::{HttpReply, TestServer, WorkCell, until};

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
    cell.post(&format!("{}/commands", path_of(job)), &body)
        .await
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

    let second = taken(
        &cell,
        &with(&json!({"items": [
            {"type": "crate", "mr_slot": "right", "target_slot": "rack/e"},
        ]})),
    )
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

/// Covers: H6, P2. A job whose answer was lost is asked for again, by another process on the same journal.
#[tokio::test]
async fn the_same_request_again_is_the_same_job_over_a_restart_too() {
    let disk = MemoryDisk::new();
    let cell = WorkCell::on(&disk).await;
    let body = delivery().to_string();
    let first = cell.post_with_key(JOBS, "k1", &body).await;
    assert_eq!(first.status, 201, "{first:?}");
    let respaced = serde_json::to_string_pretty(&delivery()).unwrap();
    let again = cell.post_with_key(JOBS, "\"k1\"", &respaced).await;
    assert_eq!(again.status, 201);
    assert_eq!(again.header("idempotency-replayed"), Some("true"));
    assert_eq!(again.header("location"), first.header("location"));
    assert_eq!(again.json()["id"], first.json()["id"]);
    disk.lose_power();

    let cell = WorkCell::on(&disk).await;
    let again = cell.post_with_key(JOBS, "k1", &body).await;
    assert_eq!(again.status, 201, "{again:?}");
    assert_eq!(again.header("idempotency-replayed"), Some("true"));
    assert_eq!(again.json()["id"], first.json()["id"]);
    let list = cell.get(JOBS).await.json();
    assert_eq!(list["jobs"].as_array().unwrap().len(), 1);
    // H7: another job under the same key is none.
    let other = with(&json!({"max_attempts": 3})).to_string();
    let reply = cell.post_with_key(JOBS, "k1", &other).await;
    let _problem = reply.problem(422, "idempotency-mismatch", "NOT_SENT");
}

/// Covers: H6. Many at once with one key make one job.
#[tokio::test]
async fn one_key_used_by_many_at_once_makes_one_job() {
    let cell = Arc::new(WorkCell::start().await);
    let mut asked = tokio::task::JoinSet::new();
    for _ in 0..16 {
        let cell = Arc::clone(&cell);
        let body = delivery().to_string();
        let _task = asked.spawn(async move { cell.post_with_key(JOBS, "k1", &body).await });
    }
    let replies = asked.join_all().await;
    let id = replies[0].json()["id"].clone();
    let first = |reply: &&HttpReply| reply.header("idempotency-replayed").is_none();
    assert_eq!(replies.iter().filter(first).count(), 1);
    assert!(replies.iter().all(|reply| reply.json()["id"] == id));
    let list = cell.get(JOBS).await.json();
    assert_eq!(list["jobs"].as_array().unwrap().len(), 1);
}

/// A deadline that passed after the first request is no reason to deny what became of it.
#[tokio::test]
async fn a_replay_after_the_deadline_still_finds_its_job() {
    let cell = WorkCell::start().await;
    let mut body = delivery();
    let deadline = Timestamp::now() + SignedDuration::from_millis(1_500);
    body["deadline"] = json!(deadline.to_string());
    let first = cell.post_with_key(JOBS, "k1", &body.to_string()).await;
    assert_eq!(first.status, 201, "{first:?}");
    let stopped = in_state(&cell, &first.json(), "STOPPED").await;
    assert_eq!(stopped["reason"], "deadline_passed");
    let again = cell.post_with_key(JOBS, "k1", &body.to_string()).await;
    assert_eq!(again.header("idempotency-replayed"), Some("true"));
    assert_eq!(again.json()["state"], "STOPPED");
    let fresh = cell.post(JOBS, &body.to_string()).await;
    let problem = fresh.problem(422, "validation", "NOT_SENT");
    assert_eq!(problem["violations"][0]["item"], "deadline");
}

/// Covers: W9. Stop and abort need no key and are the same however often they come.
#[tokio::test]
async fn a_job_is_stopped_without_a_key_as_often_as_you_like() {
    let cell = WorkCell::start().await;
    let job = taken(&cell, &delivery()).await;
    assert!(job["commands"].as_array().unwrap().contains(&json!("stop")));
    let path = format!("{}/commands", path_of(&job));
    let json_type = [("content-type", "application/json")];
    for command in ["stop", "stop", "stop"] {
        let body = json!({"command": command, "reason": "enough"}).to_string();
        let reply = cell.request("POST", &path, &json_type, &body).await;
        assert_eq!(reply.status, 200, "{reply:?}");
        assert_eq!(reply.json()["state"], "STOPPED");
        assert_eq!(reply.json()["principal"], "demo");
        assert_eq!(reply.json()["text"], "enough");
    }
    let late = json!({"command": "abort", "reason": "enough"}).to_string();
    let late = cell.request("POST", &path, &json_type, &late).await;
    let _problem = late.problem(409, "wrong-job-state", "NOT_SENT");
    let hold = json!({"command": "hold", "reason": "enough"}).to_string();
    let reply = cell.request("POST", &path, &json_type, &hold).await;
    let _problem = reply.problem(400, "idempotency-missing", "NOT_SENT");
}

/// Covers: H6. A reset that is sent again does not put a job into the queue that was stopped since.
#[tokio::test]
async fn a_command_with_a_key_is_carried_out_once() {
    let disk = MemoryDisk::new();
    let cell = WorkCell::on(&disk).await;
    let job = taken(&cell, &delivery()).await;
    assert_eq!(command(&cell, &job, "stop").await.status, 200);
    let path = format!("{}/commands", path_of(&job));
    let reset = json!({"command": "reset", "reason": "again"}).to_string();
    let first = cell.post_with_key(&path, "r1", &reset).await;
    assert_eq!(first.status, 200, "{first:?}");
    let _idle = in_state(&cell, &job, "IDLE").await;
    assert_eq!(command(&cell, &job, "stop").await.status, 200);
    let again = cell.post_with_key(&path, "r1", &reset).await;
    assert_eq!(again.header("idempotency-replayed"), Some("true"));
    assert_eq!(again.json()["state"], "STOPPED");
    disk.lose_power();
    let cell = WorkCell::on(&disk).await;
    let again = cell.post_with_key(&path, "r1", &reset).await;
    assert_eq!(again.header("idempotency-replayed"), Some("true"));
    assert_eq!(again.json()["state"], "STOPPED");
}

/// What happened is told in order, page by page, and the same after a restart; the report adds it up.
#[tokio::test]
async fn events_and_report_come_from_the_journal() {
    let disk = MemoryDisk::new();
    let cell = WorkCell::on(&disk).await;
    let job = taken(&cell, &delivery()).await;
    let other = taken(
        &cell,
        &with(&json!({"items": [
            {"type": "crate", "mr_slot": "right", "place": "rack/e"},
        ]})),
    )
    .await;
    assert_eq!(command(&cell, &job, "stop").await.status, 200);
    let events = format!("{}/events", path_of(&job));
    let all = cell.get(&events).await.json();
    let all = all["events"].as_array().unwrap().clone();
    assert_eq!(all[0]["kind"], "job_created");
    let last = all.last().unwrap();
    assert_eq!(last["kind"], "job_moved");
    assert_eq!(last["text"], "STOPPED by demo: a test");
    assert_eq!(last["principal"], "demo");
    let mut cursor = String::new();
    let mut paged = Vec::new();
    loop {
        let page = cell.get(&format!("{events}?limit=1{cursor}")).await.json();
        paged.extend(page["events"].as_array().unwrap().clone());
        let Some(next) = page["next_cursor"].as_str() else {
            break;
        };
        cursor = format!("&cursor={next}");
    }
    assert_eq!(paged, all);

    let report = cell.get(&format!("{}/report", path_of(&job))).await.json();
    assert_eq!(report["state"], "STOPPED");
    assert_eq!(report["run"], 1);
    assert_eq!(report["queued_ms"], report["total_ms"]);
    assert_eq!(report["states"][0]["state"], "IDLE");
    assert_eq!(report["cycle_ms"], 0);
    assert_eq!(report["decisions"][0]["principal"], "demo");
    assert_eq!(report["decisions"][0]["reason"], "a test");
    disk.lose_power();

    let cell = WorkCell::on(&disk).await;
    let again = cell.get(&events).await.json();
    assert_eq!(again["events"].as_array().unwrap()[..all.len()], all[..]);
    let open = cell
        .get(&format!("{}/report", path_of(&other)))
        .await
        .json();
    assert_eq!(open["state"], "IDLE");
    assert_eq!(open["restarts"], 1, "{open}");
    assert_eq!(open["ended_at"], Value::Null);
}

#[tokio::test]
async fn the_state_of_a_cell_names_what_is_open_and_what_is_wrong() {
    let cell = WorkCell::start().await;
    let state = cell.get("/api/v1/cells/c1/state").await.json();
    assert_eq!(state["state"], "IDLE");
    assert_eq!(state["jobs_may_act"], true);
    assert_eq!(state["journal_writable"], true);
    assert_eq!(state["open_jobs"], json!([]));
    assert_eq!(state["arms"][0]["id"], "r1");
    assert_eq!(state["arms"][0]["safety"], "UNKNOWN");
    assert_eq!(
        state["permits"],
        json!([
            {"point": "handover/front", "arm_entry_permit": false, "mr_move_permit": false},
        ])
    );
    let _job = taken(&cell, &delivery()).await;
    let _control = cell.control().await;
    let state = cell.get("/api/v1/cells/c1/state").await.json();
    assert_eq!(state["open_jobs"], json!([{"state": "IDLE", "jobs": 1}]));
    assert_eq!(state["control"]["held"]["holder"], "demo");
    assert_eq!(state["jobs_may_act"], false);
    for path in ["sessions", "stations/handover/points/front/sessions"] {
        let sessions = cell.get(&format!("/api/v1/cells/c1/{path}")).await;
        assert_eq!(sessions.json(), json!({"sessions": []}), "{path}");
    }
    let none = cell
        .get("/api/v1/cells/c1/stations/handover/points/back/sessions")
        .await;
    let _problem = none.problem(404, "not-found", "NONE");
}
