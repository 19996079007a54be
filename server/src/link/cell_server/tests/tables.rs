//! The decision table, line by line.

use protocol::v2::{FinishStatus, MotionNumber, StatusLine};
use units::{Degrees, Millimeters};

use super::fake::{Brain, joints_at, pose_at};
use super::harness::{output, to, to_joints};
use crate::config::Tolerance;
use crate::link::cell_server::Open;
use crate::link::cell_server::judge::{Finding, Verdict, judge};

const N: MotionNumber = MotionNumber {
    epoch: 7_000,
    seq: 3,
};
const TOLERANCE: Tolerance = Tolerance {
    position: Millimeters(0.5),
    rotation: Degrees(0.1),
};

fn below() -> MotionNumber {
    MotionNumber { seq: 2, ..N }
}

/// The controller has finished the command before, stands still, and was fenced with the next epoch.
fn fenced() -> StatusLine {
    StatusLine {
        epoch_max: 7_001,
        accepted: below(),
        finished: below(),
        pose: pose_at(100.0),
        ..Brain::new().status
    }
}

fn finished(finish: FinishStatus) -> StatusLine {
    StatusLine {
        accepted: N,
        finished: N,
        finish,
        ..fenced()
    }
}

fn begun() -> StatusLine {
    StatusLine {
        accepted: N,
        ..fenced()
    }
}

fn open() -> Open {
    Open {
        number: N,
        boot: Some(1),
        accepted: false,
        command: to(100.0).into(),
    }
}

fn verdict(status: &StatusLine) -> Verdict {
    judge(status, &open(), TOLERANCE)
}

#[tokio::test]
async fn a_command_that_was_not_taken_is_not_executed_once_it_is_fenced() {
    let unfenced = StatusLine {
        epoch_max: 7_000,
        ..fenced()
    };
    assert_eq!(verdict(&unfenced), Verdict::Wait);
    let finding = Finding::NotTaken { accepted: below() };
    assert_eq!(verdict(&fenced()), Verdict::Unless(finding));
    let accepted = Open {
        accepted: true,
        ..open()
    };
    let verdict = judge(&fenced(), &accepted, TOLERANCE);
    assert_eq!(
        verdict,
        Verdict::Unless(Finding::Forgotten { accepted: below() })
    );
}

#[tokio::test]
async fn a_finished_command_is_judged_when_the_arm_stands() {
    for finish in FinishStatus::ALL {
        let moving = StatusLine {
            moving: true,
            ..finished(finish)
        };
        assert_eq!(verdict(&moving), Verdict::Wait);
    }
    assert_eq!(verdict(&finished(FinishStatus::Arrived)), Verdict::Arrived);
    for finish in [
        FinishStatus::Alarm,
        FinishStatus::Stopped,
        FinishStatus::DeadMan,
    ] {
        assert_eq!(verdict(&finished(finish)), Verdict::Interrupted(finish));
    }
}

#[tokio::test]
async fn another_boot_does_not_undo_what_was_stored_as_finished() {
    let status = StatusLine {
        boot: 2,
        ..finished(FinishStatus::Arrived)
    };
    assert_eq!(verdict(&status), Verdict::Arrived);
}

#[tokio::test]
async fn a_command_in_the_middle_is_waited_for_while_it_may_go_on() {
    let waits = [
        StatusLine {
            moving: true,
            ..begun()
        },
        StatusLine {
            held: true,
            ..begun()
        },
        StatusLine {
            speed_override: 0,
            ..begun()
        },
    ];
    for status in waits {
        assert_eq!(verdict(&status), Verdict::Wait);
        let other_boot = StatusLine { boot: 2, ..status };
        let restarted = Finding::Restarted { was: 1, is: 2 };
        assert_eq!(verdict(&other_boot), Verdict::Lost(restarted));
    }
    assert_eq!(verdict(&begun()), Verdict::Unless(Finding::Unfinished));
}

#[tokio::test]
async fn a_later_command_leaves_the_one_before_in_doubt() {
    let later = MotionNumber {
        epoch: 8_000,
        seq: 1,
    };
    let status = StatusLine {
        accepted: later,
        ..finished(FinishStatus::Arrived)
    };
    let overtaken = Finding::Overtaken { accepted: later };
    assert_eq!(verdict(&status), Verdict::Lost(overtaken));
}

#[tokio::test]
async fn the_target_is_compared_with_what_the_command_moves() {
    let at = |x| StatusLine {
        pose: pose_at(x),
        ..finished(FinishStatus::Arrived)
    };
    assert_eq!(verdict(&at(100.5)), Verdict::Arrived);
    let missed = verdict(&at(100.501));
    assert!(
        matches!(missed, Verdict::Unless(Finding::PoseMismatch { apart_mm, .. }) if (apart_mm - 0.501).abs() < 1e-9),
        "{missed:?}"
    );
    let joints = |j1| StatusLine {
        joints: joints_at(j1),
        ..at(0.0)
    };
    let of_joints = Open {
        command: to_joints(30.0).into(),
        ..open()
    };
    assert_eq!(
        judge(&joints(30.1), &of_joints, TOLERANCE),
        Verdict::Arrived
    );
    let missed = judge(&joints(30.101), &of_joints, TOLERANCE);
    assert!(
        matches!(missed, Verdict::Unless(Finding::PoseMismatch { .. })),
        "{missed:?}"
    );
    let of_output = Open {
        command: output(2, true).into(),
        ..open()
    };
    let level = |outputs| StatusLine { outputs, ..at(0.0) };
    assert_eq!(judge(&level(0b10), &of_output, TOLERANCE), Verdict::Arrived);
    let missed = judge(&level(0b01), &of_output, TOLERANCE);
    assert_eq!(
        missed,
        Verdict::Unless(Finding::OutputMismatch { output: 2 })
    );
}
