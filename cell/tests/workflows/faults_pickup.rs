//! The fault matrix in `pickup-and-delivery`, end to end.

use cell::world::PartAt;
use mobile_emulator::Fault;
use serde_json::{Value, json};

use crate::faults;
use crate::run::{Run, Which};

const B: Which = Which::Pickup;

macro_rules! tests {
    ($($name:ident => $test:expr;)*) => {
        $(#[tokio::test(flavor = "multi_thread")] async fn $name() { $test.await; })*
    };
}

tests! {
    f01_an_order_without_notice_is_sent_again_then_asked_b => faults::unacknowledged(B);
    f02_a_late_mobile_robot_is_called_anew_then_asked_b => faults::late(B);
    f02_a_mobile_robot_that_is_late_once_is_called_anew_b => faults::late_once(B);
    f03_docking_the_second_time_needs_nobody_b => faults::docks_the_second_time(B);
    f03_docking_that_fails_is_asked_b => faults::docking_fails(B);
    f06_an_unreachable_pose_stops_before_anything_moves_b => faults::unreachable(B);
    f07_an_alarm_holds_until_a_person_replans_b => faults::alarm(B);
    f08_a_power_cycle_in_a_motion_is_asked_b => faults::power_cycle(B);
    f09_a_grip_that_fails_is_tried_again_b => faults::grip_fails_once(B);
    f09_grips_that_fail_are_asked_b => faults::grip_fails(B);
    f10_a_lost_part_aborts_until_a_person_found_it_b => faults::part_lost(B);
    f10_a_stuck_gripper_aborts_b => faults::gripper_jams(B);
    f11_driving_off_under_the_arm_aborts_b => faults::drives_off(B);
    f12_without_heartbeats_the_arm_goes_out_b => faults::heartbeats_stop(B);
    f13_in_manual_mode_the_arm_goes_out_b => faults::manual_mode(B);
    f14_a_protective_stop_holds_until_a_person_goes_on_b => faults::protective_stop(B);
    f15_an_emergency_stop_aborts_until_cleared_b => faults::emergency_stop(B);
    f16_a_cancel_before_the_grip_undoes_all_b => faults::canceled_before_the_pivot(B);
    f16_a_cancel_on_the_way_takes_the_order_back_b => faults::canceled_before_it_came(B);
    f17_a_cancel_with_the_load_completes_b => faults::canceled_with_load(B, "COMPLETE", B.target());
    f17_a_cancel_with_the_load_returns_it_b => faults::canceled_with_load(B, "RETURN_TO_MR", B.source());
    f17_a_cancel_with_the_load_rejects_it_b => faults::canceled_with_load(B, "REJECT_BIN", PartAt::Place("reject".to_owned()));
    f17_a_cancel_with_the_load_asks_b => faults::canceled_with_load_asks(B);
    f19_a_mobile_robot_that_stays_is_asked_about_b => faults::does_not_leave(B);
    f22_without_control_the_job_stands_b => faults::control_taken(B);
    f23_confused_signals_do_nothing_twice_b => faults::confused_signals(B);
}

/// The mobile robot does not see what was put on it: it stays until a person looked.
#[tokio::test(flavor = "multi_thread")]
async fn f04_a_load_that_is_not_seen_on_the_mobile_robot_is_asked_about_b() {
    let blind = Fault::MisreportLoad {
        slot: "right".to_owned(),
        load: None,
        for_s: None,
    };
    let run = Run::with(B, &[blind], Value::Null).await;
    let question = run.asked("F4").await;
    assert!(
        question.answers().contains(&"repick"),
        "{:?}",
        question.answers()
    );
    let _job = run.until("HELD").await;
    run.nothing_moves().await;
    run.faults_end().await;
    run.answer(&question, "rescan").await;
    run.complete().await;
}

/// The same, and the load is taken back.
#[tokio::test(flavor = "multi_thread")]
async fn f04_a_load_that_is_not_seen_on_the_mobile_robot_is_taken_back_b() {
    let blind = Fault::MisreportLoad {
        slot: "right".to_owned(),
        load: None,
        for_s: None,
    };
    let run = Run::with(B, &[blind], Value::Null).await;
    let question = run.asked("F4").await;
    let _job = run.until("HELD").await;
    run.answer(&question, "repick").await;
    let _job = run.until("STOPPED").await;
    run.assert_at(&B.source()).await;
    run.assert_orderly().await;
}

/// Something lies in the slot, and no other is free: the arm does not go there.
#[tokio::test(flavor = "multi_thread")]
async fn f05_an_occupied_slot_is_asked_about_b() {
    let extra = Fault::LoadExtra {
        slot: "right".to_owned(),
        load: "load-9".to_owned(),
    };
    let run = Run::with(B, &[extra], Value::Null).await;
    let question = run.asked("F5").await;
    let _job = run.until("HELD").await;
    run.nothing_moves().await;
    let _load = run.mobile().take("right").await.unwrap();
    run.answer(&question, "rescan").await;
    run.complete().await;
}

/// It stands on its way to the destination: a person is asked, and the arm is free meanwhile.
#[tokio::test(flavor = "multi_thread")]
async fn f20_a_transport_that_does_not_arrive_is_asked_about_b() {
    let run = Run::with(B, &[], json!({"expected_transport_s": 10})).await;
    run.until_phase("TRANSPORT").await;
    run.fault(Fault::Stuck { for_s: None }).await;
    let question = run.asked("F20").await;
    assert_eq!(
        question.answers(),
        ["retry", "swap_mobile_robot", "mark_delivered"]
    );
    let job = run.until("SUSPENDED").await;
    let claims = job["claims"].to_string();
    assert!(!claims.contains("handover/front"), "{claims}");
    run.nothing_moves().await;
    run.faults_end().await;
    run.answer(&question, "retry").await;
    run.complete().await;
}
