//! Signals and outboxes of mobile robots over HTTP: numbering, copies, what is refused.

use journal::MemoryDisk;
use serde_json::{Value, json};

use crate::support::{FakeRobot, HttpReply, TestServer, opened, robot_section};

pub(crate) const ROBOT: &str = "/api/v1/cells/c1/mobile-robots/mr1";

/// A server with the demo's set-up, once its cell knows it.
pub(crate) async fn serve(disk: &MemoryDisk) -> TestServer {
    let robot = FakeRobot::accepting().await;
    let section = robot_section(robot.address);
    let server = TestServer::with_demo_setup(section, opened(disk)).await;
    while server.get(&format!("{ROBOT}/outbox")).await.status == 404 {
        tokio::task::yield_now().await;
    }
    server
}

pub(crate) fn signal(name: &str, (boot, seq): (u64, u64)) -> Value {
    json!({
        "session": null, "seq": seq, "boot": boot, "signal": name, "at": "2026-01-01T00:00:00Z",
        "data": {
            "pose": {"x_mm": 3000, "y_mm": -1500, "heading_deg": 0}, "driving": false, "localized": true,
            "battery_percent": 90, "mode": "AUTOMATIC", "loads": [{"slot": "left", "load": null}],
            "order": null, "at_point": null, "errors": []
        }
    })
}

pub(crate) async fn send(server: &TestServer, signal: &Value) -> HttpReply {
    let headers = [("content-type", "application/json")];
    let path = format!("{ROBOT}/signals");
    server
        .bare("POST", &path, &headers, &signal.to_string())
        .await
}

fn accepted(duplicate: bool, parked: bool) -> Value {
    json!({"accepted": true, "duplicate": duplicate, "parked": parked})
}

/// Covers: M1.
#[tokio::test]
async fn a_copy_of_a_signal_gets_the_answer_of_the_first() {
    let server = serve(&MemoryDisk::new()).await;
    let fault = signal("MR_FAULT", (1, 1));
    assert_eq!(send(&server, &fault).await.json(), accepted(false, false));
    assert_eq!(send(&server, &fault).await.json(), accepted(true, false));
    // Of a hand-over that never was: refused, counted, and refused the same again.
    let mut stale = signal("MR_CLEAR", (1, 2));
    stale["session"] = json!("0190f3a2-0000-7000-8000-000000000001");
    for _copy in 0..2 {
        let reply = send(&server, &stale).await;
        let _problem = reply.problem(410, "session-closed", "NONE");
    }
    let next = send(&server, &signal("MR_HEARTBEAT", (1, 3))).await;
    assert_eq!(next.json(), accepted(false, false));
}

/// Covers: M1. A server that was started again still knows what it answered.
#[tokio::test]
async fn a_copy_is_known_after_a_restart_of_the_server() {
    let disk = MemoryDisk::new();
    let server = serve(&disk).await;
    let fault = signal("MR_FAULT", (1, 1));
    assert_eq!(send(&server, &fault).await.status, 200);
    server.stopped().await;
    let server = serve(&disk).await;
    assert_eq!(send(&server, &fault).await.json(), accepted(true, false));
    // Heartbeats are not kept, so the next number is whatever the robot says.
    let next = send(&server, &signal("MR_HEARTBEAT", (1, 9))).await;
    assert_eq!(next.json(), accepted(false, false));
}

/// Covers: M3.
#[tokio::test]
async fn a_signal_before_its_predecessor_is_parked_and_one_still_earlier_is_refused() {
    let server = serve(&MemoryDisk::new()).await;
    assert_eq!(
        send(&server, &signal("MR_HEARTBEAT", (1, 1))).await.status,
        200
    );
    let early = send(&server, &signal("MR_FAULT", (1, 3))).await;
    assert_eq!((early.status, early.json()), (202, accepted(false, true)));
    let too_early = send(&server, &signal("MR_FAULT", (1, 5))).await;
    let problem = too_early.problem(409, "handover-conflict", "NONE");
    assert_eq!(problem["violations"][0]["item"], "expected");
    assert_eq!(problem["violations"][0]["message"], "boot 1 seq 2");
    assert_eq!(problem["violations"][1]["message"], "boot 1 seq 5");
    assert_eq!(
        send(&server, &signal("MR_HEARTBEAT", (1, 2))).await.status,
        200
    );
    // The parked one was taken with its predecessor.
    let copy = send(&server, &signal("MR_FAULT", (1, 3))).await;
    assert_eq!((copy.status, copy.json()), (200, accepted(true, false)));
}

/// Covers: M10. Somebody else speaks for the robot, or it was set back: its earlier boots do not count any more.
#[tokio::test]
async fn a_boot_that_goes_back_is_refused() {
    let server = serve(&MemoryDisk::new()).await;
    assert_eq!(
        send(&server, &signal("MR_HEARTBEAT", (7, 1))).await.status,
        200
    );
    for seq in [1, 2] {
        let back = send(&server, &signal("MR_HEARTBEAT", (6, seq))).await;
        let problem = back.problem(409, "handover-conflict", "NONE");
        assert_eq!(problem["violations"][0]["message"], "boot 7");
    }
    assert_eq!(
        send(&server, &signal("MR_HEARTBEAT", (8, 1))).await.status,
        200
    );
}

/// Covers: T6. What counts is the order of arrival.
#[tokio::test]
async fn the_clock_of_a_robot_decides_nothing() {
    let server = serve(&MemoryDisk::new()).await;
    for (seq, at) in [(1, "2199-01-01T00:00:00Z"), (2, "1999-01-01T00:00:00Z")] {
        let mut beat = signal("MR_HEARTBEAT", (1, seq));
        beat["at"] = json!(at);
        beat["data"]["battery_percent"] = json!(50 + seq);
        assert_eq!(send(&server, &beat).await.json(), accepted(false, false));
    }
    let state = server.get(&format!("{ROBOT}/state")).await.json();
    assert_eq!(state["data"]["battery_percent"], 52.0);
    let heard: jiff::Timestamp = state["last_signal_at"].as_str().unwrap().parse().unwrap();
    let age = jiff::Timestamp::now().duration_since(heard).as_secs();
    assert!((0..60).contains(&age), "{state}");
}

#[tokio::test]
async fn every_value_out_of_its_range_is_named() {
    let server = serve(&MemoryDisk::new()).await;
    let mut bad = signal("MR_HEARTBEAT", (1, 0));
    bad["data"]["pose"]["x_mm"] = json!(1e9);
    bad["data"]["battery_percent"] = json!(101);
    bad["data"]["at_point"] = json!("");
    bad["data"]["loads"] = json!([{"slot": "a", "load": null}, {"slot": "a", "load": "x\u{1b}"}]);
    let problem = send(&server, &bad).await.problem(422, "validation", "NONE");
    let items: Vec<_> = problem["violations"]
        .as_array()
        .unwrap()
        .iter()
        .map(|one| one["item"].as_str().unwrap())
        .collect();
    assert_eq!(
        items,
        [
            "seq",
            "data.pose.x_mm",
            "data.battery_percent",
            "data.loads[1].load",
            "data.loads[1].slot",
            "data.at_point"
        ]
    );
    // A list where an object belongs is not taken for its values in order.
    let mut listed = signal("MR_HEARTBEAT", (1, 1));
    listed["data"]["pose"] = json!([1, 2, 3]);
    let problem = send(&server, &listed)
        .await
        .problem(422, "validation", "NONE");
    assert_eq!(problem["violations"][0]["item"], "data.pose");
    assert_eq!(
        send(&server, &signal("MR_HEARTBEAT", (1, 1))).await.status,
        200
    );
}

#[tokio::test]
async fn an_outbox_is_asked_of_a_robot_of_the_set_up_within_limits() {
    let server = serve(&MemoryDisk::new()).await;
    let empty = server
        .get(&format!("{ROBOT}/outbox?after=0&wait_s=0"))
        .await;
    assert_eq!(empty.json(), json!({"messages": [], "next": 0}));
    for query in ["wait_s=31", "wait_s=-1", "after=x", "limit=1"] {
        let reply = server.get(&format!("{ROBOT}/outbox?{query}")).await;
        let _problem = reply.problem(422, "validation", "NONE");
    }
    for path in ["mr9/outbox", "mr9/state", "mr9"] {
        let path = format!("/api/v1/cells/c1/mobile-robots/{path}");
        let _problem = server.get(&path).await.problem(404, "not-found", "NONE");
    }
}

/// Covers: M3. Two signals are lost for ever: the robot is told what is wanted, gives them up, and goes on; if they
/// come after all, they are recorded and nothing else.
#[tokio::test]
async fn a_robot_that_lost_signals_for_ever_goes_on() {
    let server = serve(&MemoryDisk::new()).await;
    for seq in 1..=4 {
        let beat = signal("MR_HEARTBEAT", (1, seq));
        assert_eq!(send(&server, &beat).await.json(), accepted(false, false));
    }
    for _twice in 0..2 {
        let reply = send(&server, &signal("MR_MODE", (1, 7))).await;
        let problem = reply.problem(409, "handover-conflict", "NONE");
        let items: Vec<_> = problem["violations"]
            .as_array()
            .unwrap()
            .iter()
            .map(|one| {
                (
                    one["item"].as_str().unwrap(),
                    one["message"].as_str().unwrap(),
                )
            })
            .collect();
        assert_eq!(items[0], ("expected", "boot 1 seq 5"));
        assert_eq!(items[1], ("got", "boot 1 seq 7"));
        assert_eq!(items[2], ("expected.seq", "5"));
    }
    let mut resync = signal("MR_MODE", (1, 8));
    resync["resync"] = json!(true);
    let refused = send(&server, &resync).await;
    let problem = refused.problem(422, "validation", "NONE");
    assert_eq!(problem["violations"][0]["item"], "resync");
    resync["signal"] = json!("MR_HEARTBEAT");
    assert_eq!(send(&server, &resync).await.json(), accepted(false, false));
    let next = signal("MR_MODE", (1, 9));
    assert_eq!(send(&server, &next).await.json(), accepted(false, false));
    for (copy, seq) in [(false, 5), (true, 5), (false, 7)] {
        let late = send(&server, &signal("MR_MODE", (1, seq))).await.json();
        assert_eq!(late["duplicate"], copy);
        assert!(late["note"].as_str().unwrap().contains("has no effect"));
    }
}

/// No detection of loads is not the same as no loads.
#[tokio::test]
async fn loads_that_are_not_told_are_not_shown_as_none() {
    let server = serve(&MemoryDisk::new()).await;
    let shown = async || server.get(&format!("{ROBOT}/state")).await.json()["data"].clone();
    let mut blind = signal("MR_MODE", (1, 1));
    let _loads = blind["data"].as_object_mut().unwrap().remove("loads");
    assert_eq!(send(&server, &blind).await.status, 200);
    assert_eq!(shown().await.get("loads"), None);
    let mut empty = signal("MR_MODE", (1, 2));
    empty["data"]["loads"] = json!([]);
    assert_eq!(send(&server, &empty).await.status, 200);
    let loads = shown().await["loads"].clone();
    let slots = loads.as_array().unwrap();
    assert_eq!(slots.len(), 2, "{loads}");
    assert!(slots.iter().all(|slot| slot["load"].is_null()), "{loads}");
}

/// An instant action is in the outbox once for each key, over a restart too.
#[tokio::test]
async fn an_instant_action_is_taken_once_for_its_key() {
    let disk = MemoryDisk::new();
    let server = serve(&disk).await;
    let path = format!("{ROBOT}/instant-actions");
    let ask = async |server: &TestServer, key: Option<&str>, body: Value| {
        let mut headers = vec![("content-type", "application/json")];
        headers.extend(key.map(|key| ("idempotency-key", key)));
        server
            .bare("POST", &path, &headers, &body.to_string())
            .await
    };
    let pause = json!({"action": "START_PAUSE", "reason": "a person is in the aisle"});
    let _missing =
        ask(&server, None, pause.clone())
            .await
            .problem(400, "idempotency-missing", "NOT_SENT");
    for _again in 0..2 {
        let taken = ask(&server, Some("pause-1"), pause.clone()).await;
        assert_eq!(taken.status, 202);
        let answer = taken.json();
        assert_eq!(
            (&answer["action"], &answer["unacknowledged"]),
            (&json!("START_PAUSE"), &json!(1))
        );
    }
    let _other = ask(&server, Some("pause-1"), json!({"action": "STOP_PAUSE"}))
        .await
        .problem(422, "idempotency-mismatch", "NOT_SENT");
    let _none = ask(&server, Some("cancel-1"), json!({"action": "CANCEL_ORDER"}))
        .await
        .problem(409, "handover-conflict", "NOT_SENT");
    let order = "0190f3a2-0000-7000-8000-000000000001";
    let odd = json!({"action": "RETRY", "order": order});
    let problem = ask(&server, Some("retry-1"), odd)
        .await
        .problem(422, "validation", "NOT_SENT");
    assert_eq!(problem["violations"][0]["item"], "order");
    let messages = server.get(&format!("{ROBOT}/outbox")).await.json();
    let kinds: Vec<_> = messages["messages"]
        .as_array()
        .unwrap()
        .iter()
        .map(|one| one["kind"].clone())
        .collect();
    assert_eq!(kinds, ["START_PAUSE"]);
}
