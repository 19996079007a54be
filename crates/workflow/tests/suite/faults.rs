//! F1 to F24 in both workflows, each by its name in the matrix.

use super::usual::{A, B, assert_question_stands, m1, r1, start, until, until_at};
use super::world::{World, delivery, fixed, item, operator, pickup};
use uuid::Uuid;
use workflow::{
    Answer, Command, Detail, Fault, Input, JobState, Location, Message, MobileMode, OnCancel,
    Permit, Phase, Refusal, Reply, Role, Safety, SignalAnswer, SignalKind, Workflow,
};

type Which = Workflow;

fn has(w: &World, job: Uuid, fault: Fault) -> bool {
    w.cell
        .job(w.now, job)
        .unwrap()
        .faults
        .iter()
        .any(|f| f.fault == fault)
}

fn until_asked(w: &mut World, fault: Fault) {
    let ok = w.run(1_500_000, |w| {
        w.open_question().is_some_and(|q| q.question.fault == fault)
    });
    assert!(ok, "no question about {fault:?}\n{}", w.story());
}

/// The arm is in the zone, moving to or at the mobile robot.
fn until_in_zone(w: &mut World) {
    assert!(
        w.run(120_000, |w| w.arm_inside(&w.arms["r1"])),
        "{}",
        w.story()
    );
}

fn permit(w: &World) -> Permit {
    w.cell.permits()[0].1
}

macro_rules! both {
    ($($a:ident, $b:ident => $test:ident;)*) => {
        $(#[test] fn $a() { $test(A); } #[test] fn $b() { $test(B); })*
    };
}

both! {
    f01_an_unanswered_order_is_sent_again_then_asked_a, f01_an_unanswered_order_is_sent_again_then_asked_b => f01;
    f01_a_refused_order_goes_to_another_if_any_will_do_a, f01_a_refused_order_goes_to_another_if_any_will_do_b => f01_other;
    f02_a_late_arrival_is_dispatched_again_then_asked_a, f02_a_late_arrival_is_dispatched_again_then_asked_b => f02;
    f03_docking_is_tried_again_then_asked_a, f03_docking_is_tried_again_then_asked_b => f03;
    f04_wrong_loads_stop_the_arm_a, f04_missing_loads_on_the_robot_are_asked_about_b => f04;
    f06_an_unreachable_pose_stops_the_job_before_anything_moves_a, f06_an_unreachable_pose_stops_the_job_before_anything_moves_b => f06;
    f07_an_alarm_holds_the_job_and_a_human_replans_a, f07_an_alarm_holds_the_job_and_a_human_replans_b => f07;
    f08_a_lost_answer_is_looked_up_a, f08_a_lost_answer_is_looked_up_b => f08;
    f08_a_truth_that_cannot_be_found_is_asked_a, f08_a_truth_that_cannot_be_found_is_asked_b => f08_ask;
    f09_a_failed_grip_is_tried_again_a, f09_a_failed_grip_is_tried_again_b => f09;
    f09_grips_that_always_fail_become_f4_a, f09_grips_that_always_fail_become_f4_b => f09_ask;
    f10_a_lost_part_aborts_with_custody_unknown_a, f10_a_lost_part_aborts_with_custody_unknown_b => f10;
    f10_an_unclear_release_aborts_with_custody_unknown_a, f10_an_unclear_release_aborts_with_custody_unknown_b => f10_release;
    f11_a_mobile_robot_that_moves_under_the_arm_aborts_a, f11_a_mobile_robot_that_moves_under_the_arm_aborts_b => f11;
    f12_a_lost_heartbeat_takes_the_permit_and_comes_back_a, f12_a_lost_heartbeat_takes_the_permit_and_comes_back_b => f12;
    f13_a_manual_mobile_robot_suspends_the_job_a, f13_a_manual_mobile_robot_suspends_the_job_b => f13;
    f13_a_dropped_order_is_dispatched_again_a, f13_a_dropped_order_is_dispatched_again_b => f13_dropped;
    f14_a_protective_stop_holds_until_a_human_unholds_a, f14_a_protective_stop_holds_until_a_human_unholds_b => f14;
    f15_an_emergency_stop_aborts_until_cleared_a, f15_an_emergency_stop_aborts_until_cleared_b => f15;
    f16_a_cancel_before_the_pivot_undoes_everything_a, f16_a_cancel_before_the_pivot_undoes_everything_b => f16;
    f17_a_cancel_with_a_load_follows_the_policy_a, f17_a_cancel_with_a_load_follows_the_policy_b => f17;
    f17_a_cancel_with_a_load_asks_if_told_to_hold_a, f17_a_cancel_with_a_load_asks_if_told_to_hold_b => f17_ask;
    f19_a_mobile_robot_that_stays_keeps_the_point_a, f19_a_mobile_robot_that_stays_keeps_the_point_b => f19;
    f21_a_restart_in_the_middle_of_a_motion_goes_on_a, f21_a_restart_in_the_middle_of_a_motion_goes_on_b => f21;
    f22_without_control_the_job_is_held_a, f22_without_control_the_job_is_held_b => f22;
    f23_a_duplicate_is_answered_alike_and_acted_on_once_a, f23_a_duplicate_is_answered_alike_and_acted_on_once_b => f23;
    f24_an_unwritable_journal_begins_nothing_a, f24_an_unwritable_journal_begins_nothing_b => f24;
}

fn f01(which: Which) {
    let mut w = World::new();
    m1(&mut w).acks = false;
    let job = start(&mut w, which);
    until_asked(&mut w, Fault::NotAcknowledged);
    let orders: Vec<_> = m1(&mut w)
        .got
        .iter()
        .filter_map(|m| match m {
            Message::TransportOrder { order, update, .. } => Some((*order, *update)),
            _ => None,
        })
        .collect();
    assert_eq!(orders.len(), 4, "once and three times again");
    assert!(orders.iter().all(|o| *o == orders[0]), "the same ids");
    assert_eq!(w.state(job), JobState::Suspended);
    m1(&mut w).acks = true;
    let _reply = w.answer(Answer::Retry, Detail::None).unwrap();
    w.complete(job);
}

fn f01_other(which: Which) {
    let mut w = World::new();
    m1(&mut w).rejects = true;
    let mut job = if which == A { delivery() } else { pickup() };
    job.mobile_robot = None;
    job.items = vec![if which == A {
        item(None, "s3", "rack/a")
    } else {
        item(None, "s3", "rack/c")
    }];
    if which == A {
        let at = Location::MobileRobot {
            mobile_robot: "m2".into(),
            slot: "s3".into(),
        };
        let _old = w.loads.insert("new".into(), at);
    }
    let job = w.create(job);
    w.complete(job);
    assert_eq!(
        w.cell.job(w.now, job).unwrap().mobile_robot.as_deref(),
        Some("m2")
    );
    assert!(
        m1(&mut w)
            .got
            .iter()
            .any(|m| matches!(m, Message::CancelOrder { .. }))
    );
}

fn f02(which: Which) {
    let mut w = World::new();
    m1(&mut w).arrives = false;
    let job = start(&mut w, which);
    until_asked(&mut w, Fault::ArrivalLate);
    let orders: std::collections::BTreeSet<_> = m1(&mut w)
        .got
        .iter()
        .filter_map(|m| match m {
            Message::TransportOrder { order, .. } => Some(*order),
            _ => None,
        })
        .collect();
    assert_eq!(orders.len(), 3, "dispatched again twice");
    assert_eq!(permit(&w), Permit::None);
    m1(&mut w).arrives = true;
    let _reply = w.answer(Answer::Redispatch, Detail::None).unwrap();
    w.complete(job);
}

#[test]
fn f02_an_arm_left_in_the_zone_is_named_and_driven_out_on_request() {
    let mut w = World::new();
    r1(&mut w).at = Some(workflow::Target::LiftOf {
        place: super::world::slot("s1"),
    });
    let _never = w.run(1_000, |_| false);
    let job = start(&mut w, A);
    until_asked(&mut w, Fault::ArrivalLate);
    assert_eq!(permit(&w), Permit::None);
    until(&mut w, job, JobState::Suspended);
    let known = w.open_question().unwrap().question.known;
    assert!(known.iter().any(|k| k.contains("in the zone")), "{known:?}");
    let _reply = w.answer(Answer::Retreat, Detail::None).unwrap();
    w.complete(job);
}

#[test]
fn f02_a_prefetched_load_is_put_back_and_picked_again() {
    let mut w = World::new();
    m1(&mut w).arrives = false;
    let mut spec = pickup();
    spec.prefetch = true;
    let job = w.create(spec);
    assert!(w.run(30_000, |w| w.arms["r1"].holds.is_some()));
    let back = fixed("rack/c");
    assert!(w.run(200_000, |w| w.loads["P1"] == back), "{}", w.story());
    m1(&mut w).arrives = true;
    assert!(
        w.run(900_000, |w| w.state(job) == JobState::Complete),
        "{}",
        w.story()
    );
    w.judge_custody();
}

fn f03(which: Which) {
    let mut w = World::new();
    m1(&mut w).dock_error_mm = 50.0;
    let job = start(&mut w, which);
    until_asked(&mut w, Fault::DockFailed);
    let retries = m1(&mut w)
        .got
        .iter()
        .filter(|m| **m == Message::Retry)
        .count();
    assert_eq!(retries, 2);
    // It waits before the dock: only then can it still be told to try again.
    assert!(!m1(&mut w).got.contains(&Message::SkipRetry));
    assert!(!w.arms["r1"].asked.is_empty() && w.arms["r1"].moving.is_none());
    // Only an integrator may accept the measured pose.
    let open = w.open_question().unwrap().question.id;
    let refused = w.input(Input::Respond {
        intervention: open,
        answer: Answer::AcceptMeasured,
        detail: Detail::None,
        principal: operator(),
        reason: "looks fine".into(),
    });
    assert!(matches!(
        refused,
        Err(Refusal::Forbidden {
            needed: Role::Integrator,
            ..
        })
    ));
    let _reply = w.answer(Answer::AcceptMeasured, Detail::None).unwrap();
    w.complete(job);
}

#[test]
fn f03_a_docking_that_succeeds_the_second_time_needs_nobody() {
    let mut w = World::new();
    m1(&mut w).dock_errors = 1;
    let job = start(&mut w, A);
    w.complete(job);
    assert!(has(&w, job, Fault::DockFailed) && w.asked.is_empty());
}

fn f04(which: Which) {
    let mut w = World::new();
    let slot = if which == A { "s1" } else { "s3" };
    if which == A {
        m1(&mut w).lies_slot = Some((slot.into(), Some("other".into())));
    }
    let job = start(&mut w, which);
    if which == B {
        until_at(&mut w, job, Phase::Retreat);
        m1(&mut w).lies_slot = Some((slot.into(), None));
    }
    until_asked(&mut w, Fault::LoadMismatch);
    until(&mut w, job, JobState::Held);
    if which == A {
        assert!(!w.arm_inside(&w.arms["r1"]) && w.arms["r1"].at == Some(workflow::Target::Safe));
    }
    m1(&mut w).lies_slot = None;
    let _reply = w.answer(Answer::Rescan, Detail::None).unwrap();
    w.complete(job);
}

#[test]
fn f04_the_mobile_robot_can_be_sent_back_with_its_loads() {
    let mut w = World::new();
    m1(&mut w).lies_slot = Some(("s1".into(), None));
    let job = start(&mut w, A);
    until_asked(&mut w, Fault::LoadMismatch);
    until(&mut w, job, JobState::Held);
    let _reply = w.answer(Answer::SendBack, Detail::None).unwrap();
    until(&mut w, job, JobState::Stopped);
    assert!(w.cell.claims().is_empty());
    assert!(
        m1(&mut w)
            .got
            .iter()
            .any(|m| matches!(m, Message::TransferFailed { .. }))
    );
}

#[test]
fn f04_a_placed_load_can_be_picked_up_again_b() {
    let mut w = World::new();
    let job = start(&mut w, B);
    until_at(&mut w, job, Phase::Retreat);
    m1(&mut w).lies_slot = Some(("s3".into(), None));
    until_asked(&mut w, Fault::LoadMismatch);
    until(&mut w, job, JobState::Held);
    let _reply = w.answer(Answer::Repick, Detail::None).unwrap();
    until(&mut w, job, JobState::Stopped);
    assert_eq!(w.loads["P1"], fixed("rack/c"));
    w.judge_custody();
}

#[test]
fn f05_an_occupied_slot_is_replaced_by_a_free_one_b() {
    let mut w = World::new();
    m1(&mut w).lies_slot = Some(("s3".into(), Some("ghost".into())));
    let at = Location::MobileRobot {
        mobile_robot: "m1".into(),
        slot: "s2".into(),
    };
    // L2 is gone, so that s2 is free.
    let _old = w.loads.insert("L2".into(), fixed("bin"));
    let _reply = w
        .input(Input::SetCustody {
            load: "L2".into(),
            location: fixed("bin"),
            confirm: "L2".into(),
            principal: operator(),
            reason: "taken off".into(),
        })
        .unwrap();
    let job = start(&mut w, B);
    assert!(w.run(120_000, |w| w.loads["P1"] == at), "{}", w.story());
    w.complete(job);
}

#[test]
fn f05_an_occupied_slot_without_another_is_asked_about_b() {
    let mut w = World::new();
    m1(&mut w).lies_slot = Some(("s3".into(), Some("ghost".into())));
    let job = start(&mut w, B);
    until_asked(&mut w, Fault::SlotOccupied);
    until(&mut w, job, JobState::Held);
    m1(&mut w).lies_slot = None;
    let _reply = w.answer(Answer::Rescan, Detail::None).unwrap();
    w.complete(job);
}

fn f06(which: Which) {
    let mut w = World::new();
    let place = if which == A { "rack/a" } else { "rack/c" };
    let _new = r1(&mut w).blocked.insert(place.into());
    let job = start(&mut w, which);
    until(&mut w, job, JobState::Stopped);
    let view = w.cell.job(w.now, job).unwrap();
    let note = view
        .faults
        .iter()
        .find(|f| f.fault == Fault::Unreachable)
        .unwrap();
    assert!(
        note.text.contains(place) && note.text.contains("J5"),
        "{}",
        note.text
    );
    assert!(w.mobiles["m1"].got.is_empty(), "nobody was called");
    assert!(w.cell.claims().is_empty());
}

#[test]
fn f06_an_alternate_place_is_taken_instead_a() {
    let mut w = World::new();
    let _new = r1(&mut w).blocked.insert("rack/a".into());
    let mut spec = delivery();
    spec.items[0].alternates = vec!["rack/b".into()];
    let job = w.create(spec);
    w.complete(job);
    assert_eq!(w.loads["L1"], fixed("rack/b"));
}

fn f07(which: Which) {
    let mut w = World::new();
    let job = start(&mut w, which);
    until_at(&mut w, job, Phase::PlaceApproach);
    r1(&mut w).alarm_next = true;
    until_asked(&mut w, Fault::ControllerAlarm);
    until(&mut w, job, JobState::Held);
    assert_ne!(permit(&w), Permit::MrMove);
    assert_question_stands(&mut w, job);
    let _reply = w.answer(Answer::Replan, Detail::None).unwrap();
    w.complete(job);
}

fn f08(which: Which) {
    let mut w = World::new();
    let job = start(&mut w, which);
    until_in_zone(&mut w);
    r1(&mut w).doubt_next = true;
    assert!(
        w.run(60_000, |w| has(w, job, Fault::NoAnswer)),
        "{}",
        w.story()
    );
    assert_eq!(permit(&w), Permit::None, "both permits 0");
    w.complete(job);
    assert!(w.asked.is_empty(), "the controller knew: nobody is asked");
}

fn f08_ask(which: Which) {
    let mut w = World::new();
    let job = start(&mut w, which);
    until_in_zone(&mut w);
    (r1(&mut w).doubt_next, r1(&mut w).doubt_for_good) = (true, true);
    until_asked(&mut w, Fault::NoAnswer);
    let q = w.open_question().unwrap();
    assert!(
        q.question.op.is_some() && !q.question.known.is_empty() && !q.question.unknown.is_empty()
    );
    until(&mut w, job, JobState::Suspended);
    r1(&mut w).doubt_for_good = false;
    assert!(w.run(5_000, |w| w.arms["r1"].moving.is_none()));
    if w.open_question().is_some() {
        let _reply = w.answer(Answer::Happened, Detail::None).unwrap();
    }
    w.complete(job);
}

fn f09(which: Which) {
    let mut w = World::new();
    r1(&mut w).grip_fails = 1;
    let job = start(&mut w, which);
    w.complete(job);
    assert!(has(&w, job, Fault::GripFailed) && w.asked.is_empty());
}

fn f09_ask(which: Which) {
    let mut w = World::new();
    r1(&mut w).grip_fails = 2;
    let job = start(&mut w, which);
    until_asked(&mut w, Fault::LoadMismatch);
    until(&mut w, job, JobState::Held);
    assert_eq!(
        w.arms["r1"].at,
        Some(workflow::Target::Safe),
        "it opened and left"
    );
    let _reply = w.answer(Answer::Rescan, Detail::None).unwrap();
    w.complete(job);
}

fn f10(which: Which) {
    let mut w = World::new();
    let job = start(&mut w, which);
    assert!(w.run(120_000, |w| w.arms["r1"].holds.is_some()));
    until_at(&mut w, job, Phase::LiftClear);
    let load = r1(&mut w).holds.take().unwrap();
    let floor = Location::Unknown { arm: None };
    let _old = w.loads.insert(load.clone(), floor);
    until(&mut w, job, JobState::Aborted);
    let booked = w
        .cell
        .custody()
        .into_iter()
        .find(|l| l.id == load)
        .unwrap()
        .load
        .location;
    assert!(matches!(booked, Location::Unknown { .. }), "{booked}");
    assert!(w.command(job, Command::Clear).is_err(), "first the load");
    let bin = fixed("bin");
    let _old = w.loads.insert(load.clone(), bin.clone());
    let wrong = Detail::Custody {
        load: load.clone(),
        confirm: "L9".into(),
        location: bin.clone(),
    };
    assert!(
        w.answer(Answer::SetCustody, wrong).is_err(),
        "two fields have to agree"
    );
    let right = Detail::Custody {
        load: load.clone(),
        confirm: load,
        location: bin,
    };
    let _reply = w.answer(Answer::SetCustody, right).unwrap();
    let _reply = w.command(job, Command::Clear).unwrap();
    until(&mut w, job, JobState::Stopped);
    w.judge_custody();
}

fn f10_release(which: Which) {
    let mut w = World::new();
    r1(&mut w).release_sticks = true;
    let job = start(&mut w, which);
    until(&mut w, job, JobState::Aborted);
    assert!(has(&w, job, Fault::PartLost));
    assert_eq!(
        w.open_question().unwrap().question.answers,
        [Answer::SetCustody]
    );
}

fn f11(which: Which) {
    let mut w = World::new();
    w.rogue = true;
    let job = start(&mut w, which);
    until_in_zone(&mut w);
    m1(&mut w).state.pose.x_mm += 40.0;
    w.say("m1", SignalKind::MrHeartbeat);
    until(&mut w, job, JobState::Aborted);
    assert!(has(&w, job, Fault::Interlock));
    assert!(m1(&mut w).got.contains(&Message::StartPause));
    assert!(w.arms["r1"].moving.is_none());
    assert_eq!(permit(&w), Permit::None);
    let stopped = w.log.iter().position(|l| l.contains("stop r1")).unwrap();
    let told = w.log.iter().position(|l| l.contains("StartPause")).unwrap();
    assert!(stopped < told, "the arm is safe before anybody is told");
    assert!(
        !w.run(20_000, |w| w.state(job) != JobState::Aborted),
        "nothing goes on by itself"
    );
    let _reply = w.command(job, Command::Clear).unwrap();
    until(&mut w, job, JobState::Stopped);
}

fn f12(which: Which) {
    let mut w = World::new();
    let job = start(&mut w, which);
    until_in_zone(&mut w);
    m1(&mut w).beats = false;
    let ok = w.run(20_000, |w| has(w, job, Fault::HeartbeatLost));
    assert!(ok, "{}", w.story());
    assert_eq!(permit(&w), Permit::None);
    let out = w.run(10_000, |w| {
        !w.arm_inside(&w.arms["r1"]) && w.arms["r1"].moving.is_none()
    });
    assert!(out, "the arm leaves the zone\n{}", w.story());
    until(&mut w, job, JobState::Suspended);
    m1(&mut w).beats = true;
    w.complete(job);
    let question = w
        .cell
        .interventions()
        .into_iter()
        .find(|i| i.question.fault == Fault::HeartbeatLost);
    assert!(question.unwrap().withdrawn.is_some());
}

fn f13(which: Which) {
    let mut w = World::new();
    let job = start(&mut w, which);
    until_in_zone(&mut w);
    m1(&mut w).state.mode = MobileMode::Manual;
    w.say("m1", SignalKind::MrMode);
    until(&mut w, job, JobState::Suspended);
    assert_eq!(permit(&w), Permit::None);
    assert!(
        w.run(10_000, |w| !w.arm_inside(&w.arms["r1"])),
        "{}",
        w.story()
    );
    assert!(
        !w.run(10_000, |w| w.state(job) == JobState::Execute),
        "{}",
        w.story()
    );
    m1(&mut w).state.mode = MobileMode::Automatic;
    w.say("m1", SignalKind::MrMode);
    w.complete(job);
}

/// Somebody turns its key in the very moment the gripper acts: the arm goes out, and what the gripper did is not done
/// again.
fn f13_gripping(which: Which, phase: Phase) {
    let mut w = World::new();
    let job = start(&mut w, which);
    until_at(&mut w, job, phase);
    m1(&mut w).state.mode = MobileMode::Manual;
    w.say("m1", SignalKind::MrMode);
    until(&mut w, job, JobState::Suspended);
    let out = w.run(20_000, |w| !w.arm_inside(&w.arms["r1"]));
    assert!(out, "{}", w.story());
    m1(&mut w).state.mode = MobileMode::Automatic;
    w.say("m1", SignalKind::MrMode);
    w.complete(job);
    assert!(!has(&w, job, Fault::TargetBlocked), "{}", w.story());
    let moves = w
        .log
        .iter()
        .filter(|line| line.contains("Move { target: ApproachOf"));
    assert_eq!(moves.count(), 2, "{}", w.story());
}

#[test]
fn f13_a_key_turned_while_the_gripper_closes_does_not_pick_twice_a() {
    f13_gripping(A, Phase::Grip);
}

#[test]
fn f13_a_key_turned_while_the_gripper_opens_does_not_place_twice_b() {
    f13_gripping(B, Phase::Release);
}

/// A job that asks where its load should go is not asked something else instead when the heartbeats stop.
#[test]
fn f17_the_question_about_the_load_outlives_a_lost_heartbeat() {
    let mut w = World::new();
    let job = start(&mut w, A);
    assert!(w.run(120_000, |w| w.arms["r1"].holds.is_some()));
    let _reply = w.command(job, Command::Stop).unwrap();
    until_asked(&mut w, Fault::CanceledWithLoad);
    m1(&mut w).beats = false;
    assert!(w.run(20_000, |w| has(w, job, Fault::HeartbeatLost)));
    let open = w.open_question().unwrap().question.fault;
    assert_eq!(open, Fault::CanceledWithLoad, "{}", w.story());
    m1(&mut w).beats = true;
    let _never = w.run(10_000, |_| false);
    let _reply = w.answer(Answer::PutBack, Detail::None).unwrap();
    until(&mut w, job, JobState::Stopped);
    w.judge_custody();
}

fn f13_dropped(which: Which) {
    let mut w = World::new();
    let job = start(&mut w, which);
    assert!(w.run(60_000, |w| w.mobiles["m1"].state.driving));
    let m = m1(&mut w);
    (m.state.order, m.state.driving) = (None, false);
    m.plan.clear();
    w.say("m1", SignalKind::MrHeartbeat);
    w.complete(job);
    assert!(has(&w, job, Fault::ModeChanged));
}

fn f14(which: Which) {
    let mut w = World::new();
    let job = start(&mut w, which);
    until_in_zone(&mut w);
    r1(&mut w).safety = Safety::ProtectiveStop;
    until(&mut w, job, JobState::Held);
    assert_eq!(permit(&w), Permit::None);
    r1(&mut w).safety = Safety::Normal;
    assert!(
        !w.run(20_000, |w| w.state(job) != JobState::Held),
        "no automatic resume"
    );
    let _reply = w.command(job, Command::Unhold).unwrap();
    w.complete(job);
}

fn f15(which: Which) {
    let mut w = World::new();
    let job = start(&mut w, which);
    until_in_zone(&mut w);
    r1(&mut w).safety = Safety::EmergencyStop;
    until(&mut w, job, JobState::Aborted);
    assert_eq!(permit(&w), Permit::None);
    r1(&mut w).safety = Safety::Normal;
    assert!(!w.run(20_000, |w| w.state(job) != JobState::Aborted), "I8");
    let _reply = w.command(job, Command::Clear).unwrap();
    until(&mut w, job, JobState::Stopped);
}

fn f16(which: Which) {
    let mut w = World::new();
    let job = start(&mut w, which);
    until_at(&mut w, job, Phase::Approach);
    assert!(w.run(5_000, |w| w.arms["r1"].moving.is_some()));
    let _reply = w.command(job, Command::Stop).unwrap();
    until(&mut w, job, JobState::Stopped);
    assert!(
        w.run(30_000, |w| w.cell.claims().is_empty()),
        "{:?}\n{}",
        w.cell.claims(),
        w.story()
    );
    assert_eq!(w.arms["r1"].at, Some(workflow::Target::Safe));
    assert!(w.mobiles["m1"].state.at_point.is_none());
    w.judge_custody();
    // Reset puts it back into the queue.
    let _reply = w.command(job, Command::Reset).unwrap();
    w.complete(job);
}

#[test]
fn f16_a_cancel_before_the_mobile_robot_came_takes_the_order_back() {
    let mut w = World::new();
    m1(&mut w).arrives = false;
    let job = start(&mut w, A);
    until(&mut w, job, JobState::Suspended);
    let _reply = w.command(job, Command::Stop).unwrap();
    until(&mut w, job, JobState::Stopped);
    assert!(
        m1(&mut w)
            .got
            .iter()
            .any(|m| matches!(m, Message::CancelOrder { .. }))
    );
    assert!(w.cell.claims().is_empty());
}

fn f17(which: Which) {
    for policy in [
        OnCancel::Complete,
        OnCancel::ReturnToMr,
        OnCancel::RejectBin,
    ] {
        let mut w = World::new();
        let mut spec = if which == A { delivery() } else { pickup() };
        (spec.on_cancel_with_load, spec.reject_slot) = (policy, Some("bin".into()));
        let load = if which == A { "L1" } else { "P1" };
        let job = w.create(spec);
        assert!(w.run(120_000, |w| w.arms["r1"].holds.is_some()));
        let _reply = w.command(job, Command::Stop).unwrap();
        until(&mut w, job, JobState::Stopped);
        let expected = match (which, policy) {
            (_, OnCancel::RejectBin) => fixed("bin"),
            (Workflow::DeliveryAndPlacement, OnCancel::Complete) => fixed("rack/a"),
            (Workflow::PickupAndDelivery, OnCancel::ReturnToMr) => fixed("rack/c"),
            (Workflow::DeliveryAndPlacement, _) => Location::MobileRobot {
                mobile_robot: "m1".into(),
                slot: "s1".into(),
            },
            (Workflow::PickupAndDelivery, _) => Location::MobileRobot {
                mobile_robot: "m1".into(),
                slot: "s3".into(),
            },
        };
        assert_eq!(w.loads[load], expected, "{policy:?}\n{}", w.story());
        w.judge_custody();
    }
}

fn f17_ask(which: Which) {
    let mut w = World::new();
    let job = start(&mut w, which);
    assert!(w.run(120_000, |w| w.arms["r1"].holds.is_some()));
    let _reply = w.command(job, Command::Stop).unwrap();
    until_asked(&mut w, Fault::CanceledWithLoad);
    assert_eq!(w.state(job), JobState::Stopping);
    let _reply = w.answer(Answer::PutBack, Detail::None).unwrap();
    until(&mut w, job, JobState::Stopped);
    w.judge_custody();
    assert!(w.arms["r1"].holds.is_none());
}

/// The target is taken by hand while the load is on its way.
fn block(w: &mut World, place: &str) {
    let at = Location::Fixed {
        place: place.into(),
    };
    let _old = w.loads.insert("P2".into(), at.clone());
    let _reply = w
        .input(Input::SetCustody {
            load: "P2".into(),
            location: at,
            confirm: "P2".into(),
            principal: operator(),
            reason: "put there by hand".into(),
        })
        .unwrap();
}

#[test]
fn f18_a_blocked_target_waits_until_it_is_free_a() {
    let mut w = World::new();
    let job = start(&mut w, A);
    until_at(&mut w, job, Phase::Grip);
    block(&mut w, "rack/a");
    until_asked(&mut w, Fault::TargetBlocked);
    until(&mut w, job, JobState::Suspended);
    block(&mut w, "rack/b");
    w.complete(job);
    assert_eq!(w.loads["L1"], fixed("rack/a"));
}

#[test]
fn f18_a_blocked_target_is_replaced_by_an_alternate_or_an_answer_a() {
    for alternate in [true, false] {
        let mut w = World::new();
        let mut spec = delivery();
        if alternate {
            spec.items[0].alternates = vec!["rack/b".into()];
        }
        let job = w.create(spec);
        until_at(&mut w, job, Phase::Grip);
        block(&mut w, "rack/a");
        if !alternate {
            until_asked(&mut w, Fault::TargetBlocked);
            until(&mut w, job, JobState::Suspended);
            let _reply = w
                .answer(
                    Answer::ChooseSlot,
                    Detail::Place {
                        place: "rack/b".into(),
                    },
                )
                .unwrap();
        }
        w.complete(job);
        assert_eq!(w.loads["L1"], fixed("rack/b"));
    }
}

#[test]
fn f18_a_slot_that_is_taken_during_the_approach_is_asked_about_b() {
    let mut w = World::new();
    let job = start(&mut w, B);
    until_at(&mut w, job, Phase::Grip);
    let at = Location::MobileRobot {
        mobile_robot: "m1".into(),
        slot: "s3".into(),
    };
    let _reply = w
        .input(Input::SetCustody {
            load: "P2".into(),
            location: at,
            confirm: "P2".into(),
            principal: operator(),
            reason: "somebody put it there".into(),
        })
        .unwrap();
    until_asked(&mut w, Fault::TargetBlocked);
    until(&mut w, job, JobState::Suspended);
    let _reply = w.answer(Answer::PutBack, Detail::None).unwrap();
    until(&mut w, job, JobState::Stopped);
    assert_eq!(w.loads["P1"], fixed("rack/c"));
}

fn f19(which: Which) {
    let mut w = World::new();
    m1(&mut w).leaves = false;
    let job = start(&mut w, which);
    until_asked(&mut w, Fault::DoesNotLeave);
    let grants = m1(&mut w)
        .got
        .iter()
        .filter(|m| **m == Message::ExitGranted)
        .count();
    assert_eq!(grants, 4, "once and three times again");
    if which == A {
        until(&mut w, job, JobState::Complete);
    }
    let held: Vec<_> = w.cell.claims();
    assert!(
        held.iter()
            .any(|c| c.resource == workflow::Resource::Point(super::world::POINT.into()))
    );
    m1(&mut w).leaves = true;
    let _reply = w.answer(Answer::Retry, Detail::None).unwrap();
    w.complete(job);
    assert!(
        w.run(30_000, |w| w.cell.claims().is_empty()),
        "{}",
        w.story()
    );
}

#[test]
fn f20_a_failed_transport_is_sent_again_then_asked_b() {
    let mut w = World::new();
    m1(&mut w).delivers = false;
    let mut spec = pickup();
    spec.expected_transport_ms = Some(10_000);
    let job = w.create(spec);
    until_asked(&mut w, Fault::TransportFailed);
    until(&mut w, job, JobState::Suspended);
    assert!(
        !w.cell
            .claims()
            .iter()
            .any(|c| matches!(c.resource, workflow::Resource::Point(_)))
    );
    let _old = w.loads.insert(
        "P1".into(),
        Location::Delivered {
            destination: "warehouse".into(),
        },
    );
    let _reply = w.answer(Answer::MarkDelivered, Detail::None).unwrap();
    w.complete(job);
}

fn f21(which: Which) {
    // At every 50 ms of the whole job, one process dies.
    for at in (0..600).step_by(9) {
        let mut w = World::new();
        let job = start(&mut w, which);
        for _tick in 0..at {
            w.tick();
        }
        w.crash();
        let ok = w.run(200_000, |w| w.state(job) == JobState::Complete);
        assert!(
            ok,
            "crash at tick {at}: {:?} {:?}\n{}",
            w.state(job),
            w.open_question(),
            w.story()
        );
        w.judge_custody();
    }
}

/// P4 to P13: the process dies after every single record, before anything of it was carried out; and once more right
/// after the first record of the recovery.
#[test]
fn f21_a_restart_after_every_record_ends_in_the_same_place() {
    for which in [A, B] {
        for again in [false, true] {
            let mut at = 3;
            loop {
                let mut w = World::new();
                w.crash_at = vec![at];
                if again {
                    w.crash_at.push(at + 1);
                }
                let mut spec = if which == A { delivery() } else { pickup() };
                spec.prefetch = which == B;
                let job = w.create(spec);
                let ok = w.run(200_000, |w| w.state(job) == JobState::Complete);
                assert!(
                    ok,
                    "record {at}: {:?} {:?}\n{}",
                    w.state(job),
                    w.open_question(),
                    w.story()
                );
                w.judge_custody();
                assert!(w.asked.is_empty(), "record {at}: nobody had to be asked");
                if w.crashes == 0 {
                    assert!(at > 15, "{at} records");
                    break;
                }
                at += 1;
            }
        }
    }
}

#[test]
fn f21_an_interrupted_grip_is_never_guessed() {
    let mut w = World::new();
    let job = start(&mut w, A);
    until_at(&mut w, job, Phase::Grip);
    r1(&mut w).doubt_for_good = true;
    w.crash();
    until_asked(&mut w, Fault::NoAnswer);
    let q = w.open_question().unwrap();
    assert!(q.question.answers.contains(&Answer::Happened));
    assert!(
        !q.question.answers.contains(&Answer::Replan),
        "a grip is not simply done again"
    );
    let _reply = w.answer(Answer::Happened, Detail::None).unwrap();
    r1(&mut w).doubt_for_good = false;
    w.complete(job);
}

fn f22(which: Which) {
    let mut w = World::new();
    let job = start(&mut w, which);
    until_in_zone(&mut w);
    let _reply = w
        .input(Input::Control {
            jobs_may_act: false,
        })
        .unwrap();
    until(&mut w, job, JobState::Held);
    assert!(has(&w, job, Fault::ControlLost));
    assert!(
        w.command(job, Command::Unhold).is_err(),
        "control has to come back first"
    );
    let _reply = w.input(Input::Control { jobs_may_act: true }).unwrap();
    assert!(!w.run(10_000, |w| w.state(job) != JobState::Held));
    let _reply = w.command(job, Command::Unhold).unwrap();
    w.complete(job);
}

fn f23(which: Which) {
    let mut w = World::new();
    (w.odds.duplicated, w.odds.reordered) = (700, 500);
    let job = start(&mut w, which);
    w.complete(job);
    let duplicates = w
        .answers
        .iter()
        .filter(|(_, a)| *a == SignalAnswer::Accepted { duplicate: true });
    assert!(duplicates.count() > 3);
    // A stale one: closed sessions are gone, and nothing happens.
    let session = w.cell.sessions(w.now)[0].id;
    let m = m1(&mut w);
    (m.session, m.state.order) = (Some(session), Some(Uuid::nil()));
    w.odds = super::world::Odds::default();
    assert!(w.run(5_000, |w| w.mobiles["m1"].sending.is_empty()));
    w.say("m1", SignalKind::MrDocked);
    assert!(w.run(5_000, |w| w.mobiles["m1"].sending.is_empty()));
    let (_, last) = w
        .answers
        .iter()
        .rev()
        .find(|(k, _)| *k == SignalKind::MrDocked)
        .unwrap();
    assert!(matches!(last, SignalAnswer::Closed { .. }), "{last:?}");
}

#[test]
fn f23_a_gap_is_refused_with_what_was_expected() {
    let mut w = World::new();
    assert!(w.run(5_000, |w| w.mobiles["m1"].seq > 2
        && w.mobiles["m1"].sending.is_empty()));
    w.say("m1", SignalKind::LoadChanged);
    let mut signal = m1(&mut w).sending.pop_front().unwrap();
    let expected = signal.seq;
    signal.seq += 5;
    let refused = w.input(Input::Signal(Box::new(signal.clone()))).unwrap();
    let gap = SignalAnswer::Gap {
        boot: signal.boot,
        expected,
        got: expected + 5,
    };
    assert_eq!(refused, Reply::Signal(gap));
    // Next but one: parked, and acted on when its predecessor comes.
    signal.seq = expected + 1;
    let parked = w.input(Input::Signal(Box::new(signal.clone()))).unwrap();
    assert_eq!(parked, Reply::Signal(SignalAnswer::Parked));
    signal.seq = expected;
    let first = w.input(Input::Signal(Box::new(signal))).unwrap();
    assert_eq!(
        first,
        Reply::Signal(SignalAnswer::Accepted { duplicate: false })
    );
    assert_eq!(w.cell.mobile_robots()[0].last_seq, expected + 1);
}

fn f24(which: Which) {
    let mut w = World::new();
    let job = start(&mut w, which);
    until_in_zone(&mut w);
    let _reply = w.input(Input::Journal { writable: false }).unwrap();
    let before = w.journal.len();
    let refused = w.input(Input::CreateJob {
        job: Box::new(delivery()),
    });
    assert_eq!(refused, Err(Refusal::JournalUnavailable));
    assert_eq!(w.journal.len(), before);
    let _reply = w.input(Input::Journal { writable: true }).unwrap();
    until(&mut w, job, JobState::Held);
    assert!(has(&w, job, Fault::JournalUnwritable));
    let _reply = w.command(job, Command::Unhold).unwrap();
    w.complete(job);
}

/// Somebody puts something into the slot after it was found empty, with the load already in the gripper.
#[test]
fn f18_a_slot_that_fills_up_under_the_arm_is_waited_for_b() {
    let mut w = World::new();
    let job = start(&mut w, B);
    until_at(&mut w, job, Phase::LiftClear);
    m1(&mut w).lies_slot = Some(("s3".into(), Some("ghost".into())));
    w.say("m1", SignalKind::LoadChanged);
    until_asked(&mut w, Fault::TargetBlocked);
    until(&mut w, job, JobState::Suspended);
    assert!(!w.arm_inside(&w.arms["r1"]), "{}", w.story());
    m1(&mut w).lies_slot = None;
    w.say("m1", SignalKind::LoadChanged);
    w.complete(job);
}
