//! The fault matrix in `delivery-and-placement`, end to end.

use cell::world::PartAt;
use mobile_emulator::Fault;
use serde_json::{Value, json};

use crate::faults;
use crate::run::{Run, Which};

const A: Which = Which::Delivery;

macro_rules! tests {
    ($($name:ident => $test:expr;)*) => {
        $(#[tokio::test(flavor = "multi_thread")] async fn $name() { $test.await; })*
    };
}

tests! {
    f01_an_order_without_notice_is_sent_again_then_asked_a => faults::unacknowledged(A);
    f02_a_late_mobile_robot_is_called_anew_then_asked_a => faults::late(A);
    f02_a_mobile_robot_that_is_late_once_is_called_anew_a => faults::late_once(A);
    f03_docking_the_second_time_needs_nobody_a => faults::docks_the_second_time(A);
    f03_docking_that_fails_is_asked_a => faults::docking_fails(A);
    f06_an_unreachable_pose_stops_before_anything_moves_a => faults::unreachable(A);
    f07_an_alarm_in_a_motion_holds_until_a_person_replans_a => faults::alarm_in_motion(A);
    f07_an_alarm_in_the_zone_is_retreated_from_a => faults::alarm_in_the_zone(A);
    f07_an_alarm_between_motions_holds_and_asks_nothing_a => faults::alarm_between_motions(A);
    f08_a_command_line_that_breaks_in_a_motion_sends_nothing_twice_a => faults::command_line_cut(A);
    f08_a_status_line_that_breaks_in_a_motion_takes_the_permits_a => faults::status_line_cut(A);
    f08_a_cable_that_is_pulled_out_takes_the_permits_a => faults::cable_pulled(A);
    f08_a_power_cycle_in_a_motion_is_asked_a => faults::power_cycle(A);
    f09_a_grip_that_fails_is_tried_again_a => faults::grip_fails_once(A);
    f09_grips_that_fail_are_asked_a => faults::grip_fails(A);
    f10_a_lost_part_aborts_until_a_person_found_it_a => faults::part_lost(A);
    f10_a_stuck_gripper_aborts_a => faults::gripper_jams(A);
    f11_driving_off_under_the_arm_aborts_a => faults::drives_off(A);
    f12_without_heartbeats_the_arm_goes_out_a => faults::heartbeats_stop(A);
    f12_without_heartbeats_the_job_can_be_taken_back_a => faults::heartbeats_stop_and_the_job_is_taken_back(A);
    f13_an_order_lost_on_the_way_is_given_anew_a => faults::order_lost(A);
    f13_in_manual_mode_the_arm_goes_out_a => faults::manual_mode(A);
    f14_a_protective_stop_holds_until_a_person_goes_on_a => faults::protective_stop(A);
    f15_an_emergency_stop_aborts_until_cleared_a => faults::emergency_stop(A);
    f16_a_cancel_before_the_grip_undoes_all_a => faults::canceled_before_the_pivot(A);
    f16_a_cancel_on_the_way_takes_the_order_back_a => faults::canceled_before_it_came(A);
    f17_a_cancel_with_the_load_completes_a => faults::canceled_with_load(A, "COMPLETE", A.target());
    f17_a_cancel_with_the_load_returns_it_a => faults::canceled_with_load(A, "RETURN_TO_MR", A.source());
    f17_a_cancel_with_the_load_rejects_it_a => faults::canceled_with_load(A, "REJECT_BIN", PartAt::Place("reject".to_owned()));
    f17_a_cancel_with_the_load_asks_a => faults::canceled_with_load_asks(A);
    f19_a_mobile_robot_that_stays_is_asked_about_a => faults::does_not_leave(A);
    f22_without_control_the_job_stands_a => faults::control_taken(A);
    f23_confused_signals_do_nothing_twice_a => faults::confused_signals(A);
}

/// What should be in its slot is not: the arm does not move before a person looked.
#[tokio::test(flavor = "multi_thread")]
async fn f04_a_missing_load_is_asked_about_a() {
    let missing = Fault::LoadMissing {
        slot: "left".to_owned(),
    };
    let run = Run::with(A, &[missing], Value::Null).await;
    let question = run.asked("F4").await;
    assert_eq!(
        question.answers(),
        ["rescan", "accept", "send_back", "cancel"]
    );
    let _job = run.until("HELD").await;
    run.nothing_moves().await;
    run.mobile().put("left", "load-1").await.unwrap();
    run.answer(&question, "rescan").await;
    run.complete().await;
}

/// Something else is in its slot: it is sent back with it.
#[tokio::test(flavor = "multi_thread")]
async fn f04_a_wrong_load_is_sent_back_a() {
    let wrong = Fault::LoadWrong {
        slot: "left".to_owned(),
        load: "load-9".to_owned(),
    };
    let run = Run::with(A, &[wrong], Value::Null).await;
    let question = run.asked("F4").await;
    let _job = run.until("HELD").await;
    run.nothing_moves().await;
    run.answer(&question, "send_back").await;
    let job = run.until("STOPPED").await;
    assert_eq!(job["claims"], json!([]));
    assert_eq!(run.told("TRANSFER_FAILED").await, 1);
    run.assert_orderly().await;
}

/// The target is taken while the load is on its way: it waits with the load until a person names another place.
#[tokio::test(flavor = "multi_thread")]
async fn f18_a_blocked_target_is_replaced_by_an_answer_a() {
    let run = Run::start(A).await;
    run.until_gripped().await;
    block(&run).await;
    let question = run.asked("F18").await;
    let _job = run.until("SUSPENDED").await;
    run.nothing_moves().await;
    run.answer_with(
        &question,
        json!({"answer": "choose_slot", "place": "rack/f"}),
    )
    .await;
    let _job = run.until("COMPLETE").await;
    run.assert_at(&PartAt::Place("rack/f".to_owned())).await;
    run.assert_orderly().await;
}

/// The same with an alternate: nobody is asked.
#[tokio::test(flavor = "multi_thread")]
async fn f18_a_blocked_target_is_replaced_by_an_alternate_a() {
    let run = Run::with(A, &[], json!({"alternates": ["rack/e"]})).await;
    run.until_gripped().await;
    block(&run).await;
    let _job = run.until("COMPLETE").await;
    run.assert_at(&PartAt::Place("rack/e".to_owned())).await;
    run.assert_nobody_asked().await;
    run.assert_orderly().await;
}

/// The same, and a person has it put into the reject bin.
#[tokio::test(flavor = "multi_thread")]
async fn f18_a_load_without_a_place_goes_into_the_reject_bin_a() {
    let run = Run::with(A, &[], json!({"reject_slot": "reject"})).await;
    run.until_gripped().await;
    block(&run).await;
    let question = run.asked("F18").await;
    assert!(question.answers().contains(&"reject_bin"));
    let _job = run.until("SUSPENDED").await;
    run.answer(&question, "reject_bin").await;
    let _job = run.until("COMPLETE").await;
    run.assert_at(&PartAt::Place("reject".to_owned())).await;
    run.assert_orderly().await;
}

/// The same, and it goes back to where the mobile robot has it.
#[tokio::test(flavor = "multi_thread")]
async fn f18_a_load_without_a_place_goes_back_to_the_mobile_robot_a() {
    let run = Run::start(A).await;
    run.until_gripped().await;
    block(&run).await;
    let question = run.asked("F18").await;
    let _job = run.until("SUSPENDED").await;
    run.answer(&question, "put_back").await;
    let _job = run.until("STOPPED").await;
    run.assert_at(&A.source()).await;
    run.assert_orderly().await;
}

/// The same, and somebody takes away what is in the way: it goes on by itself.
#[tokio::test(flavor = "multi_thread")]
async fn f18_a_place_that_becomes_free_again_is_used_a() {
    let run = Run::start(A).await;
    run.until_gripped().await;
    block(&run).await;
    let question = run.asked("F18").await;
    let _job = run.until("SUSPENDED").await;
    run.moves_part("load-3", PartAt::Place("rack/b".to_owned()));
    let location = json!({"at": "FIXED", "place": "rack/b"});
    let body = json!({"location": location, "confirm": "load-3", "reason": "out of the way"});
    let (status, said) = run.cell.put("/loads/load-3/custody", &body).await;
    assert_eq!(status, 200, "{said}");
    run.complete().await;
    assert_eq!(run.question_now(&question).await["state"], "withdrawn");
}

/// A place that cannot be reached, and another that can: the load goes there, and nobody is asked.
#[tokio::test(flavor = "multi_thread")]
async fn f06_an_alternate_place_is_taken_where_the_first_cannot_be_reached_a() {
    let at = (
        "pose = { x_mm = -100, y_mm = 1000,",
        "pose = { x_mm = -1190, y_mm = 1390,",
    );
    let run = Run::with_setup(A, at, &[], json!({"alternates": ["rack/e"]})).await;
    let _job = run.until("COMPLETE").await;
    assert!(run.has("F6").await);
    run.assert_at(&PartAt::Place("rack/e".to_owned())).await;
    run.assert_nobody_asked().await;
    run.assert_orderly().await;
}

/// A person puts load-3 into rack/d, and says so.
async fn block(run: &Run) {
    run.moves_part("load-3", PartAt::Place("rack/d".to_owned()));
    let location = json!({"at": "FIXED", "place": "rack/d"});
    let body = json!({"location": location, "confirm": "load-3", "reason": "it was in the way"});
    let (status, said) = run.cell.put("/loads/load-3/custody", &body).await;
    assert_eq!(status, 200, "{said}");
}
