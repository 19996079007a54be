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
            _ => samples::ledger(),
        })
    })
    .await;
    for (arguments, expected) in [
        (
            &["emulator", "state"][..],
            "motion      not moving, 0 in the motion queue",
        ),
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
