//! What an operator at the controller does to the cell server: local control wins, and nothing goes on by itself.
#![allow(
    clippy::unwrap_used,
    clippy::indexing_slicing,
    reason = "a helper that fails stops its test"
)]

mod common;

use common::Stepped;
use common::wire::{Line, cell, command, field, joints, starts};
use karel_emulator::LedgerEvent::{Cancelled, Held, Started};
use karel_emulator::alarms::Severity;
use karel_emulator::ledger::JointsDeg;
use karel_emulator::{LedgerEvent, OperateError, OperatingMode, Operation};

const THERE: [f64; 6] = [20.0, 10.0, -10.0, 5.0, -60.0, 15.0];

/// A motion that takes some seconds, and its connection.
async fn under_way(cell: &Stepped) -> Line<'_> {
    let (answer, line) = command(cell, |n| joints((1000, 1), n, THERE, 5)).await;
    assert_eq!(answer, ["ACK", "1000", "1"]);
    cell.advance(0.5).await;
    assert!(cell.controller.state().await.unwrap().moving);
    line
}

async fn refused_with_6(cell: &Stepped, seq: u32) {
    let (answer, _line) = command(cell, |n| joints((1000, seq), n, THERE, 50)).await;
    assert_eq!(answer, ["ERR", "6"]);
}

/// Covers: C2.
#[tokio::test]
async fn an_emergency_stop_ends_the_motion_and_nothing_resumes_after_the_reset() {
    let cell = cell();
    let mut line = under_way(&cell).await;
    cell.controller.emergency_stop(true).await.unwrap();
    assert_eq!(line.next().await[..4], ["DONE", "1000", "1", "1"]);
    let mut status = Line::status(&cell).await;
    let stopped = status.ask("S 1000").await;
    assert_eq!(field(&stopped, "alarm"), 11_001, "SRVO-001");
    assert_eq!(field(&stopped, "moving"), 0);
    let at = field(&stopped, "j1");
    refused_with_6(&cell, 2).await;
    cell.controller.reset().await.unwrap();
    assert_eq!(
        field(&status.ask("S 1000").await, "alarm"),
        11_001,
        "still pressed"
    );
    cell.controller.emergency_stop(false).await.unwrap();
    refused_with_6(&cell, 2).await;
    cell.controller.reset().await.unwrap();
    cell.controller.cycle_start().await.unwrap();
    for _ in 0..10 {
        cell.advance(0.3).await;
        assert_eq!(field(&status.ask("S 1000").await, "j1"), at);
    }
    let (answer, _line) = command(&cell, |n| joints((1000, 2), n, THERE, 50)).await;
    assert_eq!(answer, ["ACK", "1000", "2"]);
    assert_eq!(starts(&cell).await, [(1000, 1), (1000, 2)]);
}

/// Covers: C4.
#[tokio::test]
async fn the_pendant_and_the_manual_modes_end_the_motion_and_refuse_commands() {
    let acts: [(&str, Operation, Operation, i64, i64); 3] = [
        (
            "pendant",
            Operation::SetPendant(true),
            Operation::SetPendant(false),
            3,
            1,
        ),
        (
            "T1",
            Operation::SetMode(OperatingMode::T1),
            Operation::SetMode(OperatingMode::Auto),
            1,
            0,
        ),
        (
            "T2",
            Operation::SetMode(OperatingMode::T2),
            Operation::SetMode(OperatingMode::Auto),
            2,
            0,
        ),
    ];
    for (name, act, undo, mode, pendant) in acts {
        let cell = cell();
        let mut line = under_way(&cell).await;
        cell.controller.operate(act).await.unwrap();
        assert_eq!(line.next().await[..4], ["DONE", "1000", "1", "1"], "{name}");
        let mut status = Line::status(&cell).await;
        let now = status.ask("S 1000").await;
        assert_eq!(
            (field(&now, "mode"), field(&now, "pendant")),
            (mode, pendant),
            "{name}"
        );
        refused_with_6(&cell, 2).await;
        let _ignored = status.ask("C").await;
        cell.controller.operate(undo).await.unwrap();
        cell.advance(0.5).await;
        let now = status.ask("S 1000").await;
        assert_eq!(
            (field(&now, "mode"), field(&now, "pendant")),
            (3, 0),
            "{name}"
        );
        assert_eq!(
            field(&now, "moving"),
            0,
            "{name}: nothing goes on by itself"
        );
        assert_eq!(starts(&cell).await, [(1000, 1)], "{name}");
    }
}

/// Covers: C3.
#[tokio::test]
async fn hold_at_the_controller_is_reported_and_only_the_operator_continues() {
    let cell = cell();
    let mut line = under_way(&cell).await;
    let mut status = Line::status(&cell).await;
    cell.controller.hold().await.unwrap();
    for _ in 0..6 {
        cell.advance(0.5).await;
        let held = status.ask("S 1000").await;
        assert_eq!((field(&held, "held"), field(&held, "moving")), (1, 0));
    }
    assert_eq!(
        field(&status.ask("C").await, "held"),
        1,
        "HOLD is the operator's"
    );
    let (answer, _line) = command_beside(&cell, &mut line).await;
    assert_eq!(answer, "BUSY");
    cell.controller.cycle_start().await.unwrap();
    assert_eq!(field(&status.ask("S 1000").await, "moving"), 1);
    for _ in 0..40 {
        cell.advance(0.2).await;
        let now = status.ask("S 1000").await;
        if field(&now, "moving") == 0 {
            assert_eq!((field(&now, "fin_seq"), field(&now, "fin_status")), (1, 0));
            assert_eq!(field(&now, "j1"), 20_000);
            return;
        }
    }
    panic!("it never arrives");
}

/// Another command while the first client is gone.
async fn command_beside<'a>(cell: &'a Stepped, line: &mut Line<'a>) -> (String, Line<'a>) {
    // The first connection ends, so that the next one is served.
    tokio::io::AsyncWriteExt::shutdown(&mut line.stream)
        .await
        .unwrap();
    let (answer, line) = command(cell, |n| joints((1000, 2), n, THERE, 50)).await;
    (answer[0].clone(), line)
}

#[tokio::test]
async fn a_held_motion_without_heartbeats_is_ended_and_a_cycle_start_does_not_revive_it() {
    let cell = cell();
    let mut line = under_way(&cell).await;
    cell.controller.hold().await.unwrap();
    assert_eq!(line.next().await[..4], ["DONE", "1000", "1", "3"]);
    refused_with_6(&cell, 2).await;
    let at = cell.controller.state().await.unwrap().joints_deg;
    cell.controller.cycle_start().await.unwrap();
    cell.advance(3.0).await;
    assert_eq!(cell.controller.state().await.unwrap().joints_deg, at);
    let events: Vec<LedgerEvent> = cell.events().await.into_iter().map(|e| e.1).collect();
    assert_eq!(events, [Started, Held, Cancelled]);
}

/// Covers: C5.
#[tokio::test]
async fn alarms_end_the_motion_by_their_severity_and_are_reported_until_reset() {
    for (severity, status_of_end) in [
        (Severity::Warn, "0"),
        (Severity::Pause, "1"),
        (Severity::Abort, "1"),
    ] {
        let cell = cell();
        let mut status = Line::status(&cell).await;
        let (_answer, mut line) = command(&cell, |n| joints((1000, 1), n, THERE, 20)).await;
        cell.advance(0.2).await;
        cell.controller
            .raise_alarm("SRVO", 50, severity)
            .await
            .unwrap();
        let done = line.next().await;
        assert_eq!(
            done[..4],
            ["DONE", "1000", "1", status_of_end],
            "{severity:?}"
        );
        let alarm = field(&status.ask("S 1000").await, "alarm");
        let active = severity != Severity::Warn;
        assert_eq!(alarm, if active { 11_050 } else { 0 }, "{severity:?}");
        if active {
            refused_with_6(&cell, 2).await;
            cell.controller
                .raise_alarm("SYST", 1, Severity::Warn)
                .await
                .unwrap();
            let alarm = field(&status.ask("S 1000").await, "alarm");
            assert_eq!(alarm, 11_050, "a later warning does not hide it");
            cell.controller.reset().await.unwrap();
        }
        let (answer, _line) = command(&cell, |n| joints((1000, 2), n, THERE, 50)).await;
        assert_eq!(answer, ["ACK", "1000", "2"], "{severity:?}");
    }
}

#[tokio::test]
async fn a_motion_that_the_arm_refuses_is_done_with_an_alarm_and_was_never_started() {
    let cell = cell();
    // A straight line to the other side of the base runs through axis 1.
    let (answer, mut line) = command(&cell, |n| {
        common::wire::pose(
            (1000, 1),
            n,
            1,
            [900.0, 300.0, 700.0, 180.0, 0.0, 0.0],
            50,
            "N U T 0 0 0",
        )
    })
    .await;
    assert_eq!(answer[0], "ACK");
    assert_eq!(line.next().await[3], "0");
    let (answer, mut line) = command(&cell, |n| {
        common::wire::pose(
            (1000, 2),
            n,
            2,
            [-900.0, -300.0, 700.0, 180.0, 0.0, 0.0],
            200,
            "N U T 0 0 0",
        )
    })
    .await;
    assert_eq!(
        answer,
        ["ACK", "1000", "2"],
        "the target itself is reachable"
    );
    assert_eq!(line.next().await[..4], ["DONE", "1000", "2", "1"]);
    let last = cell.controller.ledger().await.unwrap().pop().unwrap();
    assert_eq!(last.event, LedgerEvent::Refused);
    assert!(last.alarm.is_some());
    refused_with_6(&cell, 3).await;
    cell.controller.reset().await.unwrap();
    assert_eq!(starts(&cell).await, [(1000, 1)]);
}

#[tokio::test]
async fn a_jog_needs_the_pendant_and_changes_where_the_arm_is() {
    let cell = cell();
    let target = JointsDeg::from([10.0, 0.0, 0.0, 0.0, -90.0, 0.0]);
    let jog = || cell.controller.operate(Operation::Jog(target));
    assert!(matches!(jog().await, Err(OperateError::CannotJog { .. })));
    cell.controller.set_pendant(true).await.unwrap();
    jog().await.unwrap();
    let beyond = Operation::Jog(JointsDeg::from([900.0, 0.0, 0.0, 0.0, 0.0, 0.0]));
    let refused = cell.controller.operate(beyond).await;
    assert!(
        matches!(refused, Err(OperateError::JogLimits { .. })),
        "{refused:?}"
    );
    let mut status = Line::status(&cell).await;
    assert_eq!(field(&status.ask("S 1").await, "j1"), 10_000);
    let last = cell.controller.ledger().await.unwrap().pop().unwrap();
    assert_eq!(last.event, LedgerEvent::Jogged);
}

#[tokio::test]
async fn what_cannot_be_is_refused_and_changes_nothing() {
    let cell = cell();
    let wrong = [
        Operation::SetOverride(101),
        Operation::SetOverride(-1),
        Operation::JamGripper(true),
        Operation::LosePart,
        Operation::RaiseAlarm {
            facility: "NOPE".to_owned(),
            number: 1,
            text: String::new(),
            severity: Severity::Warn,
        },
        Operation::RaiseAlarm {
            facility: "SRVO".to_owned(),
            number: 1000,
            text: String::new(),
            severity: Severity::Warn,
        },
    ];
    let before = cell.controller.state().await.unwrap();
    for operation in wrong {
        let done = cell.controller.operate(operation.clone()).await;
        assert!(done.is_err(), "{operation:?}");
    }
    assert_eq!(cell.controller.state().await.unwrap(), before);
}
