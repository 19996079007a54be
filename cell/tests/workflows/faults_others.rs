//! Faults that another mobile robot, another slot, or another try at the dock mends.

use std::sync::Arc;

use cell::world::PartAt;
use mobile_emulator::{Fault, MobileRobot};
use serde_json::{Value, json};

use crate::kit::{A_JOB, SETUP, TestCell};
use crate::run::{Run, Which};

const B: Which = Which::Pickup;

/// A second mobile robot, which waits beside the way of the first.
const MR2: &str = r#"
[[mobile_robots]]
id = "mr2"
name = "Mecanum robot 2"
home = "warehouse/gate"
footprint = { length_mm = 800, width_mm = 600, height_mm = 650 }
slots = [{ id = "left", accepts = ["crate"] }, { id = "right", accepts = ["crate"] }]
"#;

async fn two() -> TestCell {
    let start = "start = { x_mm = 2500, y_mm = -3500, heading_deg = 0 }";
    TestCell::with_another(&format!("{SETUP}{MR2}"), "mr2", start).await
}

fn robot(cell: &TestCell, index: usize) -> Arc<MobileRobot> {
    let robots = cell.assembly.plant().mobile_robots();
    Arc::clone(robots.get(index).expect("both mobile robots"))
}

/// F1: the first one takes no notice of its order. Any will do, so the other is called, and nobody is asked.
#[tokio::test(flavor = "multi_thread")]
async fn f01_another_mobile_robot_is_called_where_any_will_do_b() {
    let cell = two().await;
    let deaf = Fault::OrderUnacknowledged { times: 100 };
    let _number = robot(&cell, 0).set_fault(deaf).await.unwrap();
    let run = Run::on(cell, B, &[], json!({"mobile_robot": "any"})).await;
    let job = run.until("COMPLETE").await;
    assert_eq!(job["mobile_robot"], "mr2", "{job}");
    assert!(run.has("F1").await);
    run.assert_nobody_asked().await;
    assert!(matches!(run.cell.truly_at(run.load()), PartAt::Away(_)));
    let custody = run.cell.custody(run.load()).await;
    assert_eq!(custody["location"]["at"], "DELIVERED", "{custody}");
    run.cell.assert_nothing_twice().await;
}

/// F20: it breaks down on its way. A person puts the load on another one, which drives on; the books follow.
#[tokio::test(flavor = "multi_thread")]
async fn f20_another_mobile_robot_takes_the_loads_over_b() {
    let run = Run::on(two().await, B, &[], json!({"expected_transport_s": 10})).await;
    run.until_phase("TRANSPORT").await;
    run.fault(Fault::Stuck { for_s: None }).await;
    let question = run.asked("F20").await;
    let moved = run.cell.begun().await;
    // Both see it in their slots, and say so.
    let load = robot(&run.cell, 0).take("right").await.unwrap();
    robot(&run.cell, 1).put("right", &load).await.unwrap();
    run.answer_with(
        &question,
        json!({"answer": "swap_mobile_robot", "mobile_robot": "mr2"}),
    )
    .await;
    let job = run.until("COMPLETE").await;
    assert_eq!(job["mobile_robot"], "mr2", "{job}");
    let at = run.cell.truly_at(run.load());
    assert!(matches!(at, PartAt::Away(_)), "{at:?}");
    let custody = run.cell.custody(run.load()).await;
    assert_eq!(custody["location"]["at"], "DELIVERED", "{custody}");
    assert_eq!(run.cell.begun().await, moved, "no arm moved for it");
    run.cell.assert_nothing_twice().await;
}

/// F6: the arm cannot reach the slot the job names. Another one of the same mobile robot is free, and taken.
#[tokio::test(flavor = "multi_thread")]
async fn f06_another_slot_is_taken_where_the_first_cannot_be_reached_b() {
    let mut setup = SETUP.to_owned();
    for (from, to) in [
        // The left slot is empty.
        (
            "on = { mobile_robot = \"mr1\", slot = \"left\" }",
            "place = \"rack/e\"",
        ),
        (
            "pose = { x_mm = 1100, y_mm = -180, z_mm = 600,",
            "pose = { x_mm = 1100, y_mm = -180, z_mm = 2600,",
        ),
    ] {
        assert!(setup.contains(from), "{from}");
        setup = setup.replacen(from, to, 1);
    }
    let cell = TestCell::with_setup(&setup).await;
    let run = Run::on(cell, B, &[], Value::Null).await;
    run.until_phase("RETREAT").await;
    let left = PartAt::Slot {
        mobile_robot: "mr1".to_owned(),
        slot: "left".to_owned(),
    };
    run.assert_at(&left).await;
    run.complete().await;
    assert!(run.has("F6").await);
    run.assert_nobody_asked().await;
}

/// F3: it believes that it has docked well, and has not. Told to try again it leaves the dock and approaches it anew;
/// only to say the same again would be of no use.
#[tokio::test(flavor = "multi_thread")]
async fn f03_a_mobile_robot_at_the_wrong_dock_is_sent_to_dock_anew_a() {
    let dock = json!({"x_mm": 1100, "y_mm": -150, "heading_deg": 90});
    let wrong = Fault::WrongDock {
        dock: serde_json::from_value(dock).unwrap(),
    };
    let run = Run::with(Which::Delivery, &[wrong], Value::Null).await;
    let _job = run.until("COMPLETE").await;
    assert!(run.has("F3").await);
    assert_eq!(run.told("RETRY").await, 1);
    run.assert_nobody_asked().await;
    run.assert_at(&Which::Delivery.target()).await;
    run.cell.assert_nothing_twice().await;
    // The arm went to it at its proper dock, and at no other.
    run.cell
        .wait("the mobile robot is away", A_JOB, async |_| {
            let state = run.mobile().state().await.unwrap();
            state.order.is_none().then_some(())
        })
        .await;
}
