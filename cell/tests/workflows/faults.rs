//! What goes wrong in both workflows: each function is one row of the fault matrix, or a part of one.

use cell::world::PartAt;
use karel_emulator::{LedgerEvent, Operation};
use mobile_emulator::{Fault, LedgerEvent as MobileEvent};
use serde_json::{Value, json};

use crate::kit::TestCell;
use crate::run::{Run, Which};

/// The mobile robot takes no notice of its order: the same is sent three times more, then a person is asked.
pub(crate) async fn unacknowledged(which: Which) {
    let run = Run::with(
        which,
        &[Fault::OrderUnacknowledged { times: 4 }],
        Value::Null,
    )
    .await;
    let question = run.asked("F1").await;
    assert_eq!(
        question.answers(),
        ["retry", "choose_mobile_robot", "cancel"]
    );
    let _job = run.until("SUSPENDED").await;
    assert_eq!(
        run.told("TRANSPORT_ORDER").await,
        4,
        "once and three times again"
    );
    run.answer(&question, "retry").await;
    run.complete().await;
}

/// It stands on its way once: it is called anew, and nobody is asked.
pub(crate) async fn late_once(which: Which) {
    let late = Fault::Late { delay_s: 10_000.0 };
    let run = Run::with(which, &[late], json!({"expected_arrival_s": 20})).await;
    run.complete().await;
    assert!(run.has("F2").await);
    run.assert_nobody_asked().await;
}

/// It stands on its way, whatever it is told: it is called anew twice, then a person is asked.
pub(crate) async fn late(which: Which) {
    let late = Fault::Late { delay_s: 10_000.0 };
    let each = [late.clone(), late.clone(), late];
    let run = Run::with(which, &each, json!({"expected_arrival_s": 20})).await;
    let question = run.asked("F2").await;
    let ledger = run.mobile().ledger().await.unwrap();
    let orders: std::collections::BTreeSet<_> = ledger.iter().filter_map(order_taken).collect();
    assert_eq!(orders.len(), 3, "called, and called anew twice");
    let _job = run.until("SUSPENDED").await;
    run.nothing_moves().await;
    run.answer(&question, "redispatch").await;
    run.complete().await;
}

fn order_taken(entry: &mobile_emulator::LedgerEntry) -> Option<String> {
    let MobileEvent::OrderTaken { order, .. } = &entry.event else {
        return None;
    };
    Some(order.to_string())
}

/// Docking fails once: nobody has to do anything.
pub(crate) async fn docks_the_second_time(which: Which) {
    let run = Run::with(which, &[Fault::DockFails { times: 1 }], Value::Null).await;
    run.complete().await;
    assert!(run.has("F3").await);
    run.assert_nobody_asked().await;
}

/// It fails again and again: it is told to try again twice, then a person is asked, and takes the job back.
pub(crate) async fn docking_fails(which: Which) {
    let run = Run::with(which, &[Fault::DockFails { times: 100 }], Value::Null).await;
    let question = run.asked("F3").await;
    assert_eq!(question.answers(), ["retry", "redispatch", "cancel"]);
    assert_eq!(run.told("RETRY").await, 2);
    run.command("stop").await;
    let _job = run.until("STOPPED").await;
    run.assert_at(&which.source()).await;
    run.assert_orderly().await;
}

/// A pose that cannot be reached: nothing moves, nobody is called, and the report names what is wrong.
pub(crate) async fn unreachable(which: Which) {
    let at = match which {
        Which::Delivery => (
            "pose = { x_mm = -100, y_mm = 1000,",
            "pose = { x_mm = -1190, y_mm = 1390,",
        ),
        Which::Pickup => (
            "pose = { x_mm = 500, y_mm = 1000,",
            "pose = { x_mm = 1590, y_mm = 1390,",
        ),
    };
    let run = Run::with_setup(which, at, &[], Value::Null).await;
    let job = run.until("STOPPED").await;
    assert!(run.has("F6").await, "{job}");
    let text = job["faults"].to_string();
    assert!(text.contains(which.place()), "{text}");
    assert_eq!(run.told("TRANSPORT_ORDER").await, 0, "nobody was called");
    let ledger = run.cell.ledger().await;
    assert!(
        !ledger
            .iter()
            .any(|entry| entry.event == LedgerEvent::Started)
    );
    assert_eq!(run.job().await["claims"], json!([]));
    run.assert_at(&which.source()).await;
}

/// An abort of the controller's own making.
fn abort_alarm() -> Operation {
    Operation::RaiseAlarm {
        facility: "MOTN".to_owned(),
        number: 63,
        text: "Position not reachable".to_owned(),
        severity: karel_emulator::alarms::Severity::Abort,
    }
}

/// The controller raises an alarm in the middle of a motion: nothing goes on before a person said how.
pub(crate) async fn alarm_in_motion(which: Which) {
    let run = Run::start(which).await;
    run.hold_in_motion("PLACE_APPROACH").await;
    run.operate(abort_alarm()).await;
    let question = run.asked("F7").await;
    assert_eq!(
        question.answers(),
        ["retreat", "replan", "happened", "abort", "cancel"]
    );
    let _job = run.until("HELD").await;
    run.nothing_moves().await;
    let (status, said) = run.try_command("unhold").await;
    assert_eq!(status, 409, "the question is to be answered: {said}");
    run.operate(Operation::Reset).await;
    run.operate(Operation::CycleStart).await;
    run.nothing_moves().await;
    run.until_ready().await;
    run.answer(&question, "replan").await;
    run.complete().await;
}

/// The same among the mobile robot's slots: it has no permit to drive, and the arm goes out where it knows the way.
pub(crate) async fn alarm_in_the_zone(which: Which) {
    let run = Run::start(which).await;
    run.until_in_zone().await;
    run.operate(abort_alarm()).await;
    let _job = run.until("HELD").await;
    let sessions = run.cell.get("/sessions").await;
    assert_eq!(sessions["sessions"][0]["mr_move_permit"], false);
    run.nothing_moves().await;
    run.operate(Operation::Reset).await;
    run.until_ready().await;
    // It may have been at the end of its motion: then there is nothing to ask, and a person lets it go on.
    let (status, _said) = run.try_command("unhold").await;
    if status == 409 {
        let question = run.asked("F7").await;
        run.answer(&question, "retreat").await;
        run.until_out_of_zone().await;
    }
    run.complete().await;
}

/// An alarm while the arm has nothing to do: there is nothing to ask, and nothing goes on before a person lets it.
pub(crate) async fn alarm_between_motions(which: Which) {
    let run = Run::start(which).await;
    run.until_phase("AWAIT").await;
    run.operate(abort_alarm()).await;
    let _job = run.until("HELD").await;
    assert!(run.has("F7").await);
    run.nothing_moves().await;
    run.operate(Operation::Reset).await;
    run.until_ready().await;
    run.assert_nobody_asked().await;
    run.command("unhold").await;
    run.complete().await;
}

/// The command line breaks in the middle of a motion: what became of it is read from the controller, and it is never
/// sent again.
pub(crate) async fn command_line_cut(which: Which) {
    let run = Run::on(TestCell::with_wires().await, which, &[], Value::Null).await;
    run.hold_in_motion("PLACE_APPROACH").await;
    run.wires().command.cut();
    run.operate(Operation::CycleStart).await;
    run.until_arm_stands().await;
    run.wires().command.mend();
    run.complete_with_a_person().await;
}

/// The status line breaks while the arm is among the mobile robot's slots: nobody has a permit, the controller stops the
/// arm by itself, and what became of the motion is read from it when it is heard again.
pub(crate) async fn status_line_cut(which: Which) {
    let run = Run::on(TestCell::with_wires().await, which, &[], Value::Null).await;
    run.until_in_zone().await;
    run.wires().status.cut();
    run.until_has("F8").await;
    run.until_no_permits().await;
    run.until_arm_stands().await;
    run.nothing_moves().await;
    run.wires().status.mend();
    run.complete_with_a_person().await;
}

/// A cable is pulled out: nothing arrives, and nobody says so.
pub(crate) async fn cable_pulled(which: Which) {
    let run = Run::on(TestCell::with_wires().await, which, &[], Value::Null).await;
    run.until_in_zone().await;
    run.wires().command.falls_silent();
    run.wires().status.falls_silent();
    run.until_has("F8").await;
    run.until_no_permits().await;
    run.until_arm_stands().await;
    run.nothing_moves().await;
    run.wires().command.mend();
    run.wires().status.mend();
    run.complete_with_a_person().await;
}

/// The controller loses power in the middle of a motion. What became of the motion nobody knows but a person.
pub(crate) async fn power_cycle(which: Which) {
    let run = Run::start(which).await;
    run.power_cycle_in_motion(which.phase_in_zone()).await;
    let question = run.asked_for("F8", "replan").await;
    let _job = run.until("SUSPENDED").await;
    run.nothing_moves().await;
    run.until_ready().await;
    run.answer(&question, "replan").await;
    run.complete().await;
}

/// The load is not there at the first try: the gripper opens, goes out and tries again, and nobody is asked.
pub(crate) async fn grip_fails_once(which: Which) {
    let run = Run::start(which).await;
    run.until_phase("APPROACH").await;
    takes_away(&run).await;
    run.until_has("F9").await;
    brings_back(&run).await;
    run.complete().await;
    run.assert_nobody_asked().await;
}

/// The load is not there at all: after the tries a person is asked.
pub(crate) async fn grip_fails(which: Which) {
    let run = Run::start(which).await;
    run.until_phase("APPROACH").await;
    takes_away(&run).await;
    let question = run.asked("F4").await;
    assert!(run.has("F9").await);
    let _job = run.until("HELD").await;
    run.nothing_moves().await;
    run.until_out_of_zone().await;
    brings_back(&run).await;
    run.answer(&question, "rescan").await;
    run.complete().await;
}

/// The gripper gets stuck half closed. Whether it has the load nobody can tell, so nothing goes on.
pub(crate) async fn gripper_jams(which: Which) {
    let run = Run::start(which).await;
    run.until_phase("APPROACH").await;
    run.operate(Operation::JamGripper(true)).await;
    let _job = run.until("ABORTED").await;
    let question = run.asked("F10").await;
    assert_eq!(question.answers(), ["set_custody"]);
    let custody = run.cell.custody(run.load()).await;
    assert_eq!(custody["location"]["at"], "UNKNOWN");
    run.until_no_permits().await;
    run.nothing_moves().await;
    run.assert_orderly().await;
}

/// A person takes the load, where no sensor sees it.
async fn takes_away(run: &Run) {
    match run.which {
        Which::Delivery => {
            let (slot, load) = ("left".to_owned(), Some("load-1".to_owned()));
            run.fault(Fault::MisreportLoad {
                slot,
                load,
                for_s: None,
            })
            .await;
            run.fault(Fault::LoadMissing {
                slot: "left".to_owned(),
            })
            .await;
        }
        Which::Pickup => run.moves_part(run.load(), PartAt::Place("rack/f".to_owned())),
    }
}

/// And puts it where it was.
async fn brings_back(run: &Run) {
    match run.which {
        Which::Delivery => {
            run.mobile().put("left", "load-1").await.unwrap();
            run.faults_end().await;
        }
        Which::Pickup => run.moves_part(run.load(), run.which.source()),
    }
}

/// The part falls out of the gripper: the job is aborted, and only a person can say where the part is.
pub(crate) async fn part_lost(which: Which) {
    let run = Run::start(which).await;
    run.until_gripped().await;
    run.until_phase("PLACE_APPROACH").await;
    run.operate(Operation::LosePart).await;
    let _job = run.until("ABORTED").await;
    let custody = run.cell.custody(run.load()).await;
    assert_eq!(custody["location"]["at"], "UNKNOWN");
    let question = run.asked("F10").await;
    assert_eq!(question.answers(), ["set_custody"]);
    run.nothing_moves().await;
    let (status, said) = run.try_command("clear").await;
    assert_eq!(status, 409, "first the load: {said}");
    let at = json!({"at": "FIXED", "place": "rack/f"});
    let custody = json!({"confirm": "load-9", "location": at});
    let wrong = json!({"answer": "set_custody", "custody": custody});
    let (status, said) = run.try_answer(&question, wrong).await;
    assert!(
        (400..500).contains(&status),
        "two fields have to agree: {status} {said}"
    );
    run.moves_part(run.load(), PartAt::Place("rack/f".to_owned()));
    let custody = json!({"confirm": run.load(), "location": at});
    run.answer_with(
        &question,
        json!({"answer": "set_custody", "custody": custody}),
    )
    .await;
    run.command("clear").await;
    let _job = run.until("STOPPED").await;
    run.assert_at(&PartAt::Place("rack/f".to_owned())).await;
    run.assert_orderly().await;
}

/// It drives off while the arm is in the zone: the arm stops at once, it is told to stand, all is aborted.
pub(crate) async fn drives_off(which: Which) {
    let run = Run::start(which).await;
    run.until_in_zone().await;
    run.fault(Fault::DrivesOff { after_s: 0.0 }).await;
    let _job = run.until("ABORTED").await;
    assert!(run.has("F11").await);
    run.until_no_permits().await;
    run.cell
        .wait(
            "the mobile robot was told to stand",
            crate::kit::A_JOB,
            async |_| (run.told("START_PAUSE").await == 1).then_some(()),
        )
        .await;
    let ledger = run.cell.ledger().await;
    let last = ledger
        .iter()
        .rev()
        .find(|entry| entry.command.is_some())
        .unwrap();
    assert!(
        matches!(last.event, LedgerEvent::Cancelled | LedgerEvent::Finished),
        "the arm stands: {last:?}"
    );
    run.nothing_moves().await;
    run.command("clear").await;
    let _job = run.until("STOPPED").await;
    run.cell.assert_nothing_twice().await;
}

/// A silent mobile robot is lost while the arm still works.
const SOON_LOST: (&str, &str) = ("heartbeat_ms = 15000", "heartbeat_ms = 4000");

/// Its heartbeats stop under the arm: the arm goes out; when they come again, the job goes on by itself.
pub(crate) async fn heartbeats_stop(which: Which) {
    let run = Run::with_setup(which, SOON_LOST, &[], Value::Null).await;
    run.slowly().await;
    run.until_in_zone().await;
    run.fault(Fault::HeartbeatStops { for_s: None }).await;
    let question = run.asked("F12").await;
    assert_eq!(question.answers(), ["resume", "cancel"]);
    let _job = run.until("SUSPENDED").await;
    run.until_no_permits().await;
    run.until_out_of_zone().await;
    run.nothing_moves().await;
    run.faults_end().await;
    run.complete().await;
    let asked = run.question_now(&question).await;
    assert_eq!(asked["state"], "withdrawn", "{asked}");
}

/// The same, and a person takes the job back: the load stays where it was, or goes back there.
pub(crate) async fn heartbeats_stop_and_the_job_is_taken_back(which: Which) {
    let policy = json!({"on_cancel_with_load": "RETURN_TO_MR"});
    let run = Run::with_setup(which, SOON_LOST, &[], policy).await;
    run.slowly().await;
    run.until_in_zone().await;
    run.fault(Fault::HeartbeatStops { for_s: None }).await;
    let question = run.asked("F12").await;
    let _job = run.until("SUSPENDED").await;
    run.until_out_of_zone().await;
    run.answer(&question, "cancel").await;
    run.faults_end().await;
    let (ended, said) = run.cell.see_through(&run.job).await;
    assert_eq!(ended["state"], "STOPPED", "{ended:#}\n{said:#?}");
    run.assert_at(&which.source()).await;
    run.assert_orderly().await;
}

/// It loses power on its way, and with it its order: it is called anew, and nobody is asked.
pub(crate) async fn order_lost(which: Which) {
    let run = Run::start(which).await;
    run.until_phase("AWAIT").await;
    run.cell
        .wait("it drives", crate::kit::A_JOB, async |_| {
            run.mobile().state().await.unwrap().driving.then_some(())
        })
        .await;
    run.fault(Fault::Crash { down_s: 3.0 }).await;
    run.complete_with_a_person().await;
    assert!(run.has("F13").await || run.has("F2").await);
    let ledger = run.mobile().ledger().await.unwrap();
    let orders: std::collections::BTreeSet<_> = ledger.iter().filter_map(order_taken).collect();
    assert!(orders.len() >= 2, "called anew: {orders:?}");
}

/// Somebody turns its key: the arm goes out, and waits until it is automatic again.
pub(crate) async fn manual_mode(which: Which) {
    let run = Run::start(which).await;
    run.until_in_zone().await;
    let mode = api::OperatingMode::Manual;
    run.fault(Fault::Mode { mode }).await;
    let question = run.asked("F13").await;
    assert_eq!(question.answers(), ["redispatch", "cancel"]);
    let _job = run.until("SUSPENDED").await;
    run.until_no_permits().await;
    run.until_out_of_zone().await;
    run.nothing_moves().await;
    let mode = api::OperatingMode::Automatic;
    run.fault(Fault::Mode { mode }).await;
    run.complete().await;
}

/// Somebody opens the fence: nothing goes on before a person has reset the arm and lets the job go on.
pub(crate) async fn protective_stop(which: Which) {
    let run = Run::start(which).await;
    run.until_in_zone().await;
    run.operate(Operation::RaiseAlarm {
        facility: "SRVO".to_owned(),
        number: 4,
        text: "Fence open".to_owned(),
        severity: karel_emulator::alarms::Severity::Pause,
    })
    .await;
    let _job = run.until("HELD").await;
    assert!(run.has("F14").await);
    run.until_no_permits().await;
    run.nothing_moves().await;
    run.operate(Operation::Reset).await;
    run.nothing_moves().await;
    run.command("unhold").await;
    run.complete().await;
}

/// Somebody presses the emergency stop: the job is aborted, and stays so until a person cleared it.
pub(crate) async fn emergency_stop(which: Which) {
    let run = Run::start(which).await;
    run.until_in_zone().await;
    run.operate(Operation::EmergencyStop(true)).await;
    let _job = run.until("ABORTED").await;
    assert!(run.has("F15").await);
    run.until_no_permits().await;
    run.nothing_moves().await;
    run.operate(Operation::EmergencyStop(false)).await;
    run.operate(Operation::Reset).await;
    run.nothing_moves().await;
    run.command("clear").await;
    let _job = run.until("STOPPED").await;
    run.assert_orderly().await;
}

/// Canceled before the load was touched: the arm goes out, the mobile robot goes away, the load is where it was.
pub(crate) async fn canceled_before_the_pivot(which: Which) {
    let run = Run::start(which).await;
    run.until_phase("APPROACH").await;
    run.command("stop").await;
    let _job = run.until("STOPPED").await;
    run.assert_at(&which.source()).await;
    run.cell
        .wait("no claims", crate::kit::A_JOB, async |_| {
            (run.job().await["claims"] == json!([])).then_some(())
        })
        .await;
    let ledger = run.mobile().ledger().await.unwrap();
    let left = ledger
        .iter()
        .any(|entry| matches!(entry.event, MobileEvent::ZoneLeft { .. }));
    assert!(left, "it has left the zone");
    run.assert_orderly().await;
}

/// Canceled while it is on its way: the order is taken back.
pub(crate) async fn canceled_before_it_came(which: Which) {
    let run = Run::start(which).await;
    run.until_phase("AWAIT").await;
    run.command("stop").await;
    let _job = run.until("STOPPED").await;
    assert_eq!(run.told("CANCEL_ORDER").await, 1);
    assert_eq!(run.job().await["claims"], json!([]));
    run.assert_at(&which.source()).await;
    run.assert_orderly().await;
}

/// Canceled with the load in the gripper: the job's own policy says where it goes.
pub(crate) async fn canceled_with_load(which: Which, policy: &str, at: PartAt) {
    let more = json!({"on_cancel_with_load": policy, "reject_slot": "reject"});
    let run = Run::with(which, &[], more).await;
    run.until_gripped().await;
    run.until_phase("LIFT_CLEAR").await;
    run.command("stop").await;
    let _job = run.until("STOPPED").await;
    run.assert_at(&at).await;
    run.assert_orderly().await;
}

/// The policy is to ask: a person says where it goes.
pub(crate) async fn canceled_with_load_asks(which: Which) {
    let run = Run::start(which).await;
    run.until_gripped().await;
    run.until_phase("LIFT_CLEAR").await;
    run.command("stop").await;
    let question = run.asked("F17").await;
    assert_eq!(question.answers(), ["complete", "put_back", "set_custody"]);
    assert_eq!(run.job().await["state"], "STOPPING");
    run.nothing_moves().await;
    run.answer(&question, "put_back").await;
    let _job = run.until("STOPPED").await;
    run.assert_at(&which.source()).await;
    run.assert_orderly().await;
}

/// It stays although it may leave: the point stays occupied, and a person is asked.
pub(crate) async fn does_not_leave(which: Which) {
    let run = Run::with(which, &[Fault::DoesNotLeave { for_s: None }], Value::Null).await;
    let question = run.asked("F19").await;
    assert_eq!(
        question.answers(),
        ["retry", "operator_moved", "cancel_order"]
    );
    assert_eq!(
        run.told("EXIT_GRANTED").await,
        4,
        "once and three times again"
    );
    let sessions = run.cell.get("/sessions").await;
    let session = &sessions["sessions"][0];
    assert_eq!(session["closed"], false, "the point is not free");
    assert_eq!(session["arm_entry_permit"], false);
    run.faults_end().await;
    run.answer(&question, "retry").await;
    run.complete().await;
    run.cell
        .wait("the point is free", crate::kit::A_JOB, async |cell| {
            let sessions = cell.get("/sessions").await;
            (sessions["sessions"][0]["closed"] == true).then_some(())
        })
        .await;
}

/// Somebody takes control: the job stands still until it has control again, and a person lets it go on.
pub(crate) async fn control_taken(which: Which) {
    let run = Run::start(which).await;
    run.until_in_zone().await;
    let control = run.cell.take_control().await;
    let _job = run.until("HELD").await;
    assert!(run.has("F22").await);
    run.nothing_moves().await;
    let (status, said) = run.try_command("unhold").await;
    assert_eq!(status, 409, "control has to come back first: {said}");
    let (id, _epoch) = control.split_once('.').unwrap();
    let given = run.cell.delete(&format!("/control-authority/{id}")).await;
    assert_eq!(given, 200);
    run.nothing_moves().await;
    run.command("unhold").await;
    run.complete().await;
}

/// Signals come twice, late, and one before the other: nothing happens twice.
pub(crate) async fn confused_signals(which: Which) {
    let faults = [
        Fault::DuplicateSignal {
            signal: Some(api::SignalName::MrDocked),
            nth: None,
            copies: 3,
        },
        Fault::DuplicateSignal {
            signal: Some(api::SignalName::MrReady),
            nth: None,
            copies: 2,
        },
        Fault::LoseAnswer {
            signal: Some(api::SignalName::MrArrived),
            nth: None,
            answers: 2,
        },
        Fault::ReorderSignal {
            signal: Some(api::SignalName::MrAssigned),
            nth: None,
        },
        Fault::LoseSignal {
            signal: Some(api::SignalName::MrClear),
            nth: None,
            transmissions: Some(2),
            number: mobile_emulator::LostNumber::Unused,
        },
    ];
    let run = Run::with(which, &faults, Value::Null).await;
    run.complete().await;
    let ledger = run.mobile().ledger().await.unwrap();
    let sent_again = ledger.iter().filter(
        |entry| matches!(entry.event, MobileEvent::SignalSent { attempt, .. } if attempt > 1),
    );
    assert!(sent_again.count() >= 3, "the faults happened");
    run.assert_nobody_asked().await;
}
