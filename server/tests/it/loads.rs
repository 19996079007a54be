//! Loads and where people say they are.

use journal::MemoryDisk;
use serde_json::{Value, json};

use crate::support::{HttpReply, WorkCell};

const LOADS: &str = "/api/v1/cells/c1/loads";
const JSON: (&str, &str) = ("content-type", "application/json");

async fn put(cell: &WorkCell, load: &str, body: &Value) -> HttpReply {
    let path = format!("{LOADS}/{load}/custody");
    cell.request("PUT", &path, &[JSON], &body.to_string()).await
}

fn at(place: &str, confirm: &str) -> Value {
    json!({"location": {"at": "FIXED", "place": place}, "confirm": confirm, "reason": "it stands there"})
}

/// What a person says is kept with who and why, and survives.
#[tokio::test]
async fn a_person_says_where_a_load_is() {
    let disk = MemoryDisk::new();
    let cell = WorkCell::on(&disk).await;
    let list = cell.get(LOADS).await.json();
    let first = &list["loads"][0];
    assert_eq!(first["id"], "load-1");
    assert_eq!(
        first["location"],
        json!({"at": "MOBILE_ROBOT", "mobile_robot": "mr1", "slot": "left"})
    );
    for _again in 0..2 {
        let reply = put(&cell, "load-1", &at("rack/f", "load-1")).await;
        assert_eq!(reply.status, 200, "{reply:?}");
        assert_eq!(reply.json()["location"]["place"], "rack/f");
    }
    disk.lose_power();
    let cell = WorkCell::on(&disk).await;
    let load = cell.get(&format!("{LOADS}/load-1")).await.json();
    assert_eq!(load["location"], json!({"at": "FIXED", "place": "rack/f"}));
    let history = load["history"].as_array().unwrap();
    assert_eq!(history.len(), 2, "{load}");
    assert_eq!(history[0]["evidence"], "person");
    assert_eq!(history[0]["principal"], "demo");
    assert_eq!(history[0]["text"], "it stands there");
    assert_eq!(history[1]["evidence"], "setup");
    assert_eq!(history[1]["to"]["slot"], "left");
}

/// Two fields that agree, a place that exists and is free, a reason.
#[tokio::test]
async fn a_booking_that_cannot_be_is_refused() {
    let cell = WorkCell::start().await;
    let nowhere = json!({"at": "UNKNOWN"});
    for (body, item) in [
        (at("rack/f", "load-2"), "confirm"),
        (at("rack/z", "load-1"), "location"),
        (
            json!({"location": nowhere, "confirm": "load-1", "reason": "gone"}),
            "location",
        ),
        (
            json!({"location": {"at": "FIXED", "place": "rack/f"}, "confirm": "load-1", "reason": " "}),
            "reason",
        ),
        (
            json!({"location": {"at": "SHELF", "place": "rack/f"}, "confirm": "load-1", "reason": "x"}),
            "location",
        ),
        (
            json!({"location": {"at": "FIXED"}, "confirm": "load-1", "reason": "x"}),
            "location",
        ),
        (json!({"confirm": "load-1", "reason": "x"}), "location"),
    ] {
        let reply = put(&cell, "load-1", &body).await;
        assert_eq!(reply.status, 422, "{reply:?}");
        let problem = reply.json();
        assert_eq!(problem["code"], "validation");
        assert!(
            problem["detail"].as_str().unwrap().contains(item),
            "{problem}"
        );
    }
    let taken = put(&cell, "load-1", &at("rack/a", "load-1")).await;
    let problem = taken.problem(409, "custody-conflict", "NONE");
    assert!(
        problem["detail"].as_str().unwrap().contains("load-2"),
        "{problem}"
    );
    let none = put(&cell, "load-9", &at("rack/f", "load-9")).await;
    let _problem = none.problem(404, "not-found", "NONE");
    let load = cell.get(&format!("{LOADS}/load-1")).await.json();
    assert_eq!(load["location"]["at"], "MOBILE_ROBOT");
}
