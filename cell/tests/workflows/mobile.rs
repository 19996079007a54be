//! Mobile robots that come by themselves, lose signals, carry loads of others, or give docking up.

use std::sync::Arc;

use cell::world::PartAt;
use mobile_emulator::{Fault, LedgerEvent, LostNumber, MobileRobot};
use serde_json::{Value, json};

use crate::kit::{A_JOB, SETUP, TestCell};
use crate::run::{Run, Which};

/// A place to wait at, and the job that begins when a mobile robot comes there by itself.
const TRIGGER: &str = r#"
[[stations]]
id = "waiting"

[[stations.points]]
id = "bay"
dock = { x_mm = 2500, y_mm = -2500, heading_deg = 90 }
dock_tolerance = { position_mm = 50, angle_deg = 5 }

[[triggers]]
id = "unload"
on = { signal = "MR_ARRIVED", station = "waiting", mobile_robot = "mr1" }

[triggers.job]
workflow = "delivery-and-placement"
deadline_s = 600

[triggers.job.params]
point = "handover/front"
items = [{ type = "crate", mr_slot = "left", place = "rack/d" }]
"#;

fn mobile(cell: &TestCell) -> Arc<MobileRobot> {
    let robots = cell.assembly.plant().mobile_robots();
    Arc::clone(robots.first().expect("mr1"))
}

async fn job_of_trigger(cell: &TestCell) -> String {
    cell.wait("a job of the trigger", A_JOB, async |cell| {
        let jobs = cell.get("/jobs").await;
        Some(jobs["jobs"].get(0)?["id"].as_str()?.to_owned())
    })
    .await
}

#[tokio::test(flavor = "multi_thread")]
async fn a_mobile_robot_that_comes_by_itself_is_unloaded() {
    let cell = TestCell::with_setup(&format!("{SETUP}{TRIGGER}")).await;
    mobile(&cell).visit("waiting/bay").await.unwrap();
    let job = job_of_trigger(&cell).await;
    let done = cell.wait_for_job(&job, &["COMPLETE"]).await;
    assert_eq!(done["trigger"], "unload");
    assert_eq!(cell.truly_at("load-1"), PartAt::Place("rack/d".to_owned()));
    assert_eq!(cell.get("/jobs").await["jobs"].as_array().unwrap().len(), 1);
    cell.assert_nothing_twice().await;
}

/// The plug is pulled as soon as the job is there: the signal comes again, and starts no second one.
#[tokio::test(flavor = "multi_thread")]
async fn p1_a_trigger_fires_once_over_a_crash() {
    let mut cell = TestCell::with_setup(&format!("{SETUP}{TRIGGER}")).await;
    let lost = Fault::LoseAnswer {
        signal: Some(api::SignalName::MrArrived),
        nth: Some(1),
        answers: 2,
    };
    let _number = mobile(&cell).set_fault(lost).await.unwrap();
    mobile(&cell).visit("waiting/bay").await.unwrap();
    let job = job_of_trigger(&cell).await;
    cell.crash().await;
    let _done = cell.wait_for_job(&job, &["COMPLETE"]).await;
    assert_eq!(cell.get("/jobs").await["jobs"].as_array().unwrap().len(), 1);
    cell.assert_nothing_twice().await;
}

/// It takes load-2 to the warehouse, and keeps load-1, which nobody ordered off.
#[tokio::test(flavor = "multi_thread")]
async fn b15_only_the_loads_of_the_order_are_taken_off() {
    let run = Run::start(Which::Pickup).await;
    run.complete().await;
    let left = PartAt::Slot {
        mobile_robot: "mr1".to_owned(),
        slot: "left".to_owned(),
    };
    assert_eq!(run.cell.truly_at("load-1"), left);
    assert_eq!(run.cell.custody("load-1").await["location"]["slot"], "left");
    assert!(matches!(run.cell.truly_at("load-2"), PartAt::Away(_)));
    run.assert_nobody_asked().await;
}

/// Two signals are lost for ever, with their numbers: it says so and goes on.
#[tokio::test(flavor = "multi_thread")]
async fn f23_lost_numbers_do_not_silence_a_mobile_robot() {
    let lost = |nth| Fault::LoseSignal {
        signal: Some(api::SignalName::MrHeartbeat),
        nth: Some(nth),
        transmissions: None,
        number: LostNumber::Consumed,
    };
    let run = Run::with(Which::Delivery, &[lost(1), lost(1)], Value::Null).await;
    run.complete().await;
    let ledger = run.mobile().ledger().await.unwrap();
    let told = |event: &LedgerEvent| matches!(event, LedgerEvent::Resynchronized { .. });
    assert!(ledger.iter().any(|entry| told(&entry.event)), "{ledger:?}");
}

/// Docking is given up by a person's word: it backs out, is called anew, and the job is done.
#[tokio::test(flavor = "multi_thread")]
async fn f03_docking_that_is_given_up_begins_anew() {
    let run = Run::with(
        Which::Delivery,
        &[Fault::DockFails { times: 3 }],
        Value::Null,
    )
    .await;
    let question = run.asked("F3").await;
    run.answer(&question, "redispatch").await;
    run.complete().await;
    assert_eq!(run.told("SKIP_RETRY").await, 1);
    assert!(!run.has("F13").await, "F3's question is the only one");
}

/// It loses its order on the way to the destination: the same order is sent again, and leads there and not back.
#[tokio::test(flavor = "multi_thread")]
async fn f20_a_transport_is_taken_up_again_after_a_crash_of_the_mobile_robot() {
    let run = Run::with(Which::Pickup, &[], json!({"expected_transport_s": 20})).await;
    run.until_phase("TRANSPORT").await;
    run.fault(Fault::Crash { down_s: 5.0 }).await;
    run.complete().await;
    assert!(run.has("F20").await);
    run.assert_nobody_asked().await;
}

/// What a person has it do at once is in its outbox, and leaves a job alone.
#[tokio::test(flavor = "multi_thread")]
async fn an_instant_action_reaches_the_mobile_robot() {
    let run = Run::start(Which::Delivery).await;
    let path = "/mobile-robots/mr1/instant-actions";
    let paused = async |wanted: bool| {
        run.cell
            .wait("the pause", A_JOB, async |_| {
                let state = run.mobile().state().await.unwrap();
                (state.paused == wanted).then_some(())
            })
            .await;
    };
    let body = json!({"action": "START_PAUSE", "reason": "a person is in the aisle"});
    let (status, said) = run.cell.post(path, &body).await;
    assert_eq!(status, 202, "{said}");
    paused(true).await;
    let (status, said) = run.cell.post(path, &json!({"action": "STOP_PAUSE"})).await;
    assert_eq!(status, 202, "{said}");
    paused(false).await;
    run.until_in_zone().await;
    let (status, said) = run
        .cell
        .post(path, &json!({"action": "CANCEL_ORDER"}))
        .await;
    assert_eq!(
        (status.as_u16(), &said["code"]),
        (409, &json!("handover-conflict"))
    );
    assert!(said["detail"].as_str().unwrap().contains("stop the job"));
    let (status, said) = run.cell.post(path, &json!({"action": "STOP_PAUSE"})).await;
    assert_eq!(
        (status.as_u16(), &said["code"]),
        (409, &json!("interlock-violation"))
    );
    run.complete().await;
}
