//! The fault matrix in `pickup-and-delivery`, end to end.

use cell::world::PartAt;
use mobile_emulator::Fault;
use serde_json::{Value, json};

use crate::faults;
use crate::kit::A_JOB;
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
    f07_an_alarm_in_a_motion_holds_until_a_person_replans_b => faults::alarm_in_motion(B);
    f07_an_alarm_in_the_zone_is_retreated_from_b => faults::alarm_in_the_zone(B);
    f07_an_alarm_between_motions_holds_and_asks_nothing_b => faults::alarm_between_motions(B);
    f08_a_command_line_that_breaks_in_a_motion_sends_nothing_twice_b => faults::command_line_cut(B);
    f08_a_status_line_that_breaks_in_a_motion_takes_the_permits_b => faults::status_line_cut(B);
    f08_a_cable_that_is_pulled_out_takes_the_permits_b => faults::cable_pulled(B);
    f08_a_power_cycle_in_a_motion_is_asked_b => faults::power_cycle(B);
    f09_a_grip_that_fails_is_tried_again_b => faults::grip_fails_once(B);
    f09_grips_that_fail_are_asked_b => faults::grip_fails(B);
    f10_a_lost_part_aborts_until_a_person_found_it_b => faults::part_lost(B);
    f10_a_stuck_gripper_aborts_b => faults::gripper_jams(B);
    f11_driving_off_under_the_arm_aborts_b => faults::drives_off(B);
    f12_without_heartbeats_the_arm_goes_out_b => faults::heartbeats_stop(B);
    f12_without_heartbeats_the_job_can_be_taken_back_b => faults::heartbeats_stop_and_the_job_is_taken_back(B);
    f13_an_order_lost_on_the_way_is_given_anew_b => faults::order_lost(B);
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

/// Something lies in the slot, and another one is free: the load is put there, and nobody is asked.
#[tokio::test(flavor = "multi_thread")]
async fn f05_an_occupied_slot_is_replaced_by_a_free_one_b() {
    let extra = Fault::LoadExtra {
        slot: "right".to_owned(),
        load: "load-9".to_owned(),
    };
    let left_is_free = (
        "on = { mobile_robot = \"mr1\", slot = \"left\" }",
        "place = \"rack/e\"",
    );
    let run = Run::with_setup(B, left_is_free, &[extra], Value::Null).await;
    run.until_phase("RETREAT").await;
    let left = PartAt::Slot {
        mobile_robot: "mr1".to_owned(),
        slot: "left".to_owned(),
    };
    run.assert_at(&left).await;
    run.complete().await;
    run.assert_nobody_asked().await;
}

/// A prefetched load waits in the gripper for a mobile robot that does not come: not for ever. It is put back, and
/// picked again when the mobile robot is there.
#[tokio::test(flavor = "multi_thread")]
async fn f02_a_prefetched_load_is_put_back_and_picked_again_b() {
    let late = Fault::Late { delay_s: 10_000.0 };
    let soon = (
        "arm_silence_ms = 15000",
        "arm_silence_ms = 15000\nhold_ms = 20000",
    );
    let run = Run::with_setup(B, soon, &[late], json!({"prefetch": true})).await;
    run.until_gripped().await;
    run.cell
        .wait("the load is back in its place", A_JOB, async |cell| {
            (cell.truly_at(run.load()) == B.source()).then_some(())
        })
        .await;
    run.cell
        .wait("its place is in the books", A_JOB, async |cell| {
            (cell.custody(run.load()).await["location"]["at"] == "FIXED").then_some(())
        })
        .await;
    run.faults_end().await;
    run.complete().await;
    run.assert_nobody_asked().await;
}

/// Somebody puts something into the slot after it was found empty, with the load already in the gripper: the arm does
/// not go there, and goes on when the slot is free.
#[tokio::test(flavor = "multi_thread")]
async fn f18_a_slot_that_fills_up_is_waited_for_b() {
    let run = Run::start(B).await;
    run.until_gripped().await;
    run.hold_in_motion("LIFT_CLEAR").await;
    run.mobile().put("right", "load-9").await.unwrap();
    run.cell
        .wait("the server heard of it", A_JOB, async |cell| {
            let robot = cell.get("/mobile-robots/mr1").await.to_string();
            robot.contains("load-9").then_some(())
        })
        .await;
    run.operate(karel_emulator::Operation::CycleStart).await;
    let question = run.asked("F18").await;
    assert_eq!(question.answers(), ["wait", "put_back"]);
    let _job = run.until("SUSPENDED").await;
    run.until_out_of_zone().await;
    run.nothing_moves().await;
    let _load = run.mobile().take("right").await.unwrap();
    let _job = run.cell.wait_for_job(&run.job, &["COMPLETE"]).await;
    assert!(matches!(run.cell.truly_at(run.load()), PartAt::Away(_)));
    run.cell.assert_nothing_twice().await;
}

/// The same, and the load goes back where it came from.
#[tokio::test(flavor = "multi_thread")]
async fn f18_a_load_for_a_slot_that_fills_up_is_put_back_b() {
    let run = Run::start(B).await;
    run.until_gripped().await;
    run.hold_in_motion("LIFT_CLEAR").await;
    run.mobile().put("right", "load-9").await.unwrap();
    run.cell
        .wait("the server heard of it", A_JOB, async |cell| {
            let robot = cell.get("/mobile-robots/mr1").await.to_string();
            robot.contains("load-9").then_some(())
        })
        .await;
    run.operate(karel_emulator::Operation::CycleStart).await;
    let question = run.asked("F18").await;
    let _job = run.until("SUSPENDED").await;
    run.answer(&question, "put_back").await;
    let _job = run.until("STOPPED").await;
    run.assert_at(&B.source()).await;
    run.cell.assert_nothing_twice().await;
}

/// It stands on its way for good, and a person took the load where it was going.
#[tokio::test(flavor = "multi_thread")]
async fn f20_a_load_that_a_person_carried_is_marked_delivered_b() {
    let run = Run::with(B, &[], json!({"expected_transport_s": 10})).await;
    run.until_phase("TRANSPORT").await;
    run.fault(Fault::Stuck { for_s: None }).await;
    let question = run.asked("F20").await;
    let moved = run.cell.begun().await;
    // What a person carried is taken on that person's word.
    run.answer(&question, "mark_delivered").await;
    let _job = run.until("COMPLETE").await;
    let custody = run.cell.custody(run.load()).await;
    assert_eq!(custody["location"]["at"], "DELIVERED", "{custody}");
    run.assert_orderly().await;
    assert_eq!(
        run.cell.begun().await,
        moved,
        "nothing is unloaded from afar"
    );
}
