//! Motions that a person asks for, against the zones of the cell: refused before anything is sent, and the arm's ledger
//! knows nothing of them.

use serde_json::{Value, json};

use crate::kit::TestCell;
use crate::run::{Run, Which};

const MOTIONS: &str = "/robots/r1/motions";

fn to_joints(degrees: [f64; 6]) -> Value {
    let [j1, j2, j3, j4, j5, j6] = degrees;
    let joints = json!({
        "j1_deg": j1, "j2_deg": j2, "j3_deg": j3, "j4_deg": j4, "j5_deg": j5, "j6_deg": j6
    });
    json!({"type": "JOINT", "speed_percent": 100, "target": {"joints": joints}})
}

/// The tip 200 mm over the place of the mobile robot, in the hand-over zone.
fn into_the_hand_over_zone() -> Value {
    let pose = json!({
        "x_mm": 1100, "y_mm": 180, "z_mm": 425, "w_deg": 180, "p_deg": 0, "r_deg": 0
    });
    json!({"type": "JOINT", "speed_percent": 100, "target": {"pose": pose}})
}

/// Into the controller cabinet; out of the work area; and a preview says the same.
///
/// Covers: H4.
#[tokio::test(flavor = "multi_thread")]
async fn h4_a_motion_into_a_keep_out_zone_or_out_of_the_work_area_is_not_sent() {
    let cell = TestCell::start().await;
    cell.until_heard().await;
    let control = cell.take_control().await;
    for (body, zone) in [
        (to_joints([-165.0, 30.0, 0.0, 0.0, -60.0, 0.0]), "cabinet"),
        (to_joints([-90.0, 0.0, 0.0, 0.0, -90.0, 0.0]), "r1-work"),
    ] {
        let (status, said) = cell.post_in_control(MOTIONS, &control, &body).await;
        assert_eq!(status, 422, "{said}");
        assert_eq!(said["code"], "zone-violation", "{said}");
        assert_eq!(said["outcome"], "NOT_SENT", "{said}");
        let items = said["violations"].as_array().unwrap();
        let named = items.iter().find(|item| item["item"] == zone);
        let value = named.unwrap_or_else(|| panic!("{said}"))["value"].as_f64();
        assert!(value.unwrap() < 0.0, "{said}");
        let preview = format!("{MOTIONS}/preview");
        let (_, preview) = cell.post(&preview, &body).await;
        assert_eq!(preview["feasible"], false, "{preview}");
        assert_eq!(preview["code"], "zone-violation", "{preview}");
    }
    assert_eq!(cell.begun().await, 0);
}

/// Both ends of a straight line are fine, and the way between them leads into the rack.
///
/// Covers: H4.
#[tokio::test(flavor = "multi_thread")]
async fn h4_a_straight_line_through_a_keep_out_zone_is_not_sent() {
    let post = "
[[zones]]
id = \"post\"
kind = \"KEEP_OUT\"
box.min = { x_mm = 150, y_mm = 900, z_mm = 900 }
box.max = { x_mm = 250, y_mm = 1100, z_mm = 1600 }
";
    let cell = TestCell::with_setup(&format!("{}{post}", crate::kit::SETUP)).await;
    cell.until_heard().await;
    let control = cell.take_control().await;
    // From the safe pose at x 0, y 985 along X, with the post at x 200.
    let pose = json!({
        "x_mm": 450, "y_mm": 985, "z_mm": 940, "w_deg": 180, "p_deg": 0, "r_deg": 90
    });
    let body = json!({"type": "LINEAR", "speed_mm_s": 500, "target": {"pose": pose}});
    let (status, said) = cell.post_in_control(MOTIONS, &control, &body).await;
    assert_eq!(
        (status.as_u16(), &said["code"]),
        (422, &json!("zone-violation"))
    );
    assert_eq!(said["violations"][0]["item"], "post", "{said}");
    assert_eq!(cell.begun().await, 0);
}

/// While a hand-over is open, nobody's hand puts the arm where the mobile robot may be; afterwards it may go there.
///
/// Covers: H4.
#[tokio::test(flavor = "multi_thread")]
async fn i2_no_hand_moves_the_arm_into_the_zone_of_an_open_hand_over() {
    let run = Run::start(Which::Delivery).await;
    run.until_phase("AWAIT").await;
    let begun = run.cell.begun().await;
    let control = run.cell.take_control().await;
    let body = into_the_hand_over_zone();
    let (status, said) = run.cell.post_in_control(MOTIONS, &control, &body).await;
    assert_eq!(status, 409, "{said}");
    assert_eq!(said["code"], "interlock-violation", "{said}");
    assert_eq!(said["outcome"], "NOT_SENT", "{said}");
    let detail = said["detail"].as_str().unwrap();
    assert!(
        detail.contains("front") && detail.contains("mr1"),
        "{detail}"
    );
    assert_eq!(run.cell.begun().await, begun, "nothing was sent");
    run.assert_never_entered().await;
    drop(control);

    let empty = TestCell::start().await;
    empty.until_heard().await;
    let control = empty.take_control().await;
    let (status, said) = empty.post_in_control(MOTIONS, &control, &body).await;
    assert_eq!(status, 202, "nobody is there: {said}");
}

/// A keep-out zone in the way of the straight approach to a place of the rack, and in no other way.
fn over(x_mm: i32) -> Value {
    json!({
        "id": "post", "kind": "KEEP_OUT",
        "box": {
            "min": {"x_mm": x_mm - 50, "y_mm": 950, "z_mm": 660},
            "max": {"x_mm": x_mm + 50, "y_mm": 1050, "z_mm": 700}
        }
    })
}

/// A zone that comes while a job waits in the queue: its poses are planned when it starts, and nothing moves for it.
///
/// Covers: H4, F6.
#[tokio::test(flavor = "multi_thread")]
async fn h4_f06_a_zone_that_came_into_the_way_of_a_waiting_job_stops_it_before_anything_moves() {
    let cell = TestCell::start().await;
    cell.until_heard().await;
    // While somebody has control no job begins.
    let control = cell.take_control().await;
    let job = cell.delivery("rack/d").await;
    cell.change_setup("zones/post", Some(&over(-100))).await;
    // New ones are refused at once.
    let (status, said) = cell.post("/jobs", &TestCell::delivery_body("rack/d")).await;
    assert_eq!(
        (status.as_u16(), &said["code"]),
        (422, &json!("zone-violation")),
        "{said}"
    );
    let (id, _epoch) = control.split_once('.').unwrap();
    let status = cell.delete(&format!("/control-authority/{id}")).await;
    assert!(status.is_success(), "{status}");
    let stopped = cell.wait_for_job(&job, &["STOPPED"]).await;
    let faults = stopped["faults"].to_string();
    assert!(
        faults.contains("F6") && faults.contains("`post`"),
        "{faults}"
    );
    assert_eq!(cell.begun().await, 0, "nothing moved for it");
    cell.assert_sound().await;
}
