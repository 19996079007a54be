//! `cellctl emulator` against a fake panel.

use std::sync::atomic::{AtomicUsize, Ordering};

use serde_json::json;

use crate::fake::{Answer, Fake};
use crate::samples;

#[tokio::test]
async fn state_ledger_and_alarms_are_shown() {
    let fake = Fake::start(|seen| {
        Answer::Json(match seen.line.as_str() {
            "GET /state" => samples::emulator_state(false),
            "GET /alarms" => samples::alarms(),
            "GET /api/v1/notes?after=2&wait_s=1.5" => samples::notes(),
            "GET /api/v1/notes?after=0" => json!({"notes": [], "next": 0}),
            _ => samples::ledger(),
        })
    })
    .await;
    for (arguments, expected) in [
        (
            &["emulator", "state"][..],
            "motion      not moving, 0 in the motion queue",
        ),
        (
            &["emulator", "state"],
            "profile     kind, generation v9, 3 notes",
        ),
        (&["emulator", "state"], "operator    AUTO\n"),
        (
            &["emulator", "notes", "--after", "2", "--wait", "1.5"],
            "MAPPDK_SERVER   203      1  CNV_STR_REAL finds no number in",
        ),
        (&["emulator", "notes"], "No note."),
        (&["emulator", "ledger"], "finished       1  joint"),
        (&["emulator", "alarms"], "MOTN-017  abort"),
    ] {
        let ran = fake.cellctl(arguments).await;
        assert_eq!(ran.code, 0, "{ran:?}");
        assert!(
            ran.stdout.contains(expected),
            "{arguments:?}:\n{}",
            ran.stdout
        );
    }
    let ran = fake
        .cellctl(&["emulator", "ledger", "--after", "7", "--json"])
        .await;
    assert_eq!(ran.json(), samples::ledger());
    assert_eq!(fake.lines().last().unwrap(), "GET /ledger?after=7");
}

#[tokio::test]
async fn wait_still_waits_until_nothing_moves() {
    let asked = AtomicUsize::new(0);
    let fake = Fake::start(move |_| {
        let moving = asked.fetch_add(1, Ordering::SeqCst) < 3;
        Answer::Json(samples::emulator_state(moving))
    })
    .await;
    let ran = fake
        .cellctl(&["emulator", "state", "--wait-still", "60"])
        .await;
    assert_eq!(ran.code, 0, "{ran:?}");
    assert_eq!(
        fake.lines().len(),
        5,
        "three times moving, once still, once to show"
    );
}

#[tokio::test]
async fn a_connected_peer_may_still_start_a_motion() {
    let mut state = samples::emulator_state(false);
    state["tags"][0]["peer"] = json!("127.0.0.1:50000");
    let fake = Fake::always(Answer::Json(state)).await;
    let ran = fake
        .cellctl(&["emulator", "state", "--wait-still", "0.1"])
        .await;
    assert_eq!(ran.code, 3);
    assert!(
        ran.stderr.contains("still not at rest after 0.1 s"),
        "{ran:?}"
    );
    assert!(ran.stderr.contains("connected: 127.0.0.1:50000"), "{ran:?}");
}

#[tokio::test]
async fn the_control_interface_is_asked_and_changed() {
    let fake = Fake::start(|_| Answer::Json(json!({"value": 5}))).await;
    for (arguments, line, body) in [
        (
            &["get", "[MAIN]N"][..],
            "GET /api/v1/variable?path=%5BMAIN%5DN",
            json!(null),
        ),
        (&["get", "R[3]"], "GET /api/v1/registers/R[3]", json!(null)),
        (&["get", "DIN[2]"], "GET /api/v1/io/DIN[2]", json!(null)),
        (
            &["set", "$MCR.$GENOVERRIDE", "40"],
            "PUT /api/v1/variable",
            json!({"path": "$MCR.$GENOVERRIDE", "value": 40}),
        ),
        (
            &["set", "SR[1]", "hello"],
            "PUT /api/v1/registers/SR[1]",
            json!({"value": "hello"}),
        ),
        (
            &["set", "DOUT[1]", "ON"],
            "PUT /api/v1/io/DOUT[1]",
            json!({"value": 1}),
        ),
        (
            &["emergency-stop", "on"],
            "PATCH /api/v1/operator",
            json!({"emergency_stop": true}),
        ),
        (
            &["mode", "t1"],
            "PATCH /api/v1/operator",
            json!({"mode": "T1"}),
        ),
        (&["reset"], "POST /api/v1/reset", json!({})),
        (
            &["power-cycle", "--lose-memory"],
            "POST /api/v1/power-cycle",
            json!({"memory": "lost"}),
        ),
        (
            &["time", "step", "250"],
            "POST /api/v1/time/step",
            json!({"ms": 250}),
        ),
        (
            &["fault", "freeze"],
            "POST /api/v1/faults",
            json!({"fault": "freeze"}),
        ),
        (
            &["clear-fault", "7"],
            "DELETE /api/v1/faults/7",
            json!(null),
        ),
        (&["tasks"], "GET /api/v1/tasks", json!(null)),
    ] {
        let ran = fake.cellctl(&[&["emulator"], arguments].concat()).await;
        assert_eq!(ran.code, 0, "{ran:?}");
        let seen = fake.seen().pop().unwrap();
        assert_eq!(
            (seen.line.as_str(), &seen.body),
            (line, &body),
            "{arguments:?}"
        );
        assert!(ran.stdout.contains("value 5"), "{ran:?}");
    }
}

#[tokio::test]
async fn what_the_controller_refuses_is_exit_code_one_and_nonsense_is_two() {
    let body = r#"{"title":"Unprocessable Entity","status":422,"detail":"times is 0, it must be 1 to 1000000"}"#;
    let fake = Fake::always(Answer::Raw {
        status: 422,
        media_type: "application/problem+json",
        body: body.to_owned(),
    })
    .await;
    let fault = r#"{"fault": "drop", "times": 0}"#;
    let ran = fake.cellctl(&["emulator", "fault", fault]).await;
    assert_eq!(ran.code, 1, "{ran:?}");
    assert!(
        ran.stderr.contains("times is 0, it must be 1 to 1000000"),
        "{ran:?}"
    );
    for arguments in [
        &["fault", "{"][..],
        &["mode", "T3"],
        &["time", "step"],
        &["override", "101"],
        &["notes", "--wait", "31"],
    ] {
        let ran = fake.cellctl(&[&["emulator"], arguments].concat()).await;
        assert_eq!(ran.code, 2, "{arguments:?}: {ran:?}");
    }
}
