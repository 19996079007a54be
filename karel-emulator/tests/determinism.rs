//! The same programs, bytes and times give the same ledger, byte for byte.
#![allow(clippy::unwrap_used, reason = "a helper that fails stops its test")]

mod common;

use std::net::SocketAddr;
use std::time::Duration;

use common::{LINE, Stepped, call, config_of, sock_server};
use karel_emulator::alarms::Severity;
use karel_emulator::{Controller, ControllerConfig, Operation, StopSource};
use proptest::prelude::*;

use karel_emulator::effects::{ConnectionId, Effect, Event, Tag};

/// Two tasks that compute, wait and share the arm, without any socket.
const TWO_TASKS: [&str; 2] = [
    "PROGRAM one
VAR p : XYZWPR
    n : INTEGER
BEGIN
  p = CURPOS(0, 0)
  FOR n = 1 TO 40 DO
    p.z = p.z - 3
    MOVE TO p NOWAIT
    DELAY 7
  ENDFOR
END one
",
    "PROGRAM two
VAR n, k : INTEGER
BEGIN
  k = 0
  FOR n = 1 TO 100000 DO
    k = k + n MOD 7
  ENDFOR
  $MCR.$GENOVERRIDE = 30
  DELAY 500
  $MCR.$GENOVERRIDE = 80
END two
",
];

#[test]
fn two_tasks_interleave_the_same_way_however_time_is_cut() {
    let run = |cuts: u32| {
        let mut config = config_of(TWO_TASKS[0], &[]);
        config
            .programs
            .push(karel_emulator::ProgramSource::new("two.kl", TWO_TASKS[1]));
        config.run = vec!["ONE".to_owned(), "TWO".to_owned()];
        let mut core = Controller::try_new(&config).unwrap();
        for cut in 1..=cuts {
            core.advance_fully(Duration::from_mins(1) * cut / cuts);
        }
        serde_json::to_string(&core.ledger(0)).unwrap()
    };
    let whole = run(1);
    assert!(whole.contains("\"motion\":40"), "every motion ran");
    assert_eq!(run(1), whole);
    assert_eq!(run(977), whole, "time in 977 pieces is the same time");
}

#[test]
fn the_core_gives_the_same_ledger_for_the_same_events() {
    let run = || {
        let mut core = Controller::try_new(&sock_server()).unwrap();
        let peer = SocketAddr::from(([127, 0, 0, 1], 40_000));
        for number in 1..=5_u64 {
            let at = Duration::from_millis(1700 * number);
            core.advance_fully(at);
            let tag = Tag::try_new(3).unwrap();
            let connection = ConnectionId(number);
            core.event(Event::Connected {
                tag,
                connection,
                peer,
            });
            core.advance_fully(at);
            for piece in LINE.chunks(usize::try_from(number).unwrap()) {
                let request_id = Some(format!("req-{number}"));
                core.event(Event::Bytes {
                    connection,
                    bytes: piece.to_vec(),
                    request_id,
                });
                core.advance_fully(at);
            }
            let sent = core.take_effects().into_iter().any(|effect| {
                matches!(effect, Effect::Send { bytes, .. } if bytes == common::ACCEPTED.as_bytes())
            });
            assert!(sent, "command {number} is accepted");
        }
        core.advance_fully(Duration::from_mins(2));
        serde_json::to_string(&core.ledger(0)).unwrap()
    };
    assert_eq!(run(), run());
}

#[tokio::test]
async fn a_stepped_controller_gives_the_same_ledger_over_real_sockets() {
    let mut histories = Vec::new();
    for _ in 0..5 {
        let cell = Stepped::start(&sock_server());
        let address = cell.address().await;
        for (line, seconds) in [
            (LINE, 0.35),
            (b"985000 0 940000 -180000 0 0 700 1", 60.0),
            (b"x x x x x x x x\n", 0.0),
            (b"700000 -200000 700000 -180000 0 0 1999 1", 0.001),
        ] {
            let _reply = call(address, line).await;
            cell.advance(seconds).await;
        }
        cell.until_standstill().await;
        let mut ledger = cell.controller.ledger().await.unwrap();
        for entry in &mut ledger {
            // The operating system chooses the client's port anew each time.
            assert!(entry.peer.take().is_some());
        }
        histories.push(serde_json::to_string(&ledger).unwrap());
    }
    assert!(
        histories.iter().all(|history| *history == histories[0]),
        "{histories:#?}"
    );
}

/// Conditions of motions that are looked at, motions that begin and end within a few milliseconds, and an error behind
/// so many statements.
fn program_that_fails(fillers: usize) -> String {
    let fillers = "  n = n + 1\n".repeat(fillers);
    format!(
        "PROGRAM test
%NOLOCKGROUP
VAR p : XYZWPR
    n : INTEGER
    r : REAL
BEGIN
  n = 0
  p = CURPOS(0, 0)
  MOVE TO p NOWAIT,
  WHEN n > 3 DO
    n = n + 10
    UNHOLD
  ENDMOVE
  p.z = p.z - 2
  MOVE TO p NOWAIT,
  WHEN EVENT[1], n > 12 DO
    SIGNAL SEMAPHORE[1]
    n = n + 1
  ENDMOVE
{fillers}  CANCEL
  p.z = p.z + 40
  MOVE TO p NOWAIT
  p.y = p.y - 40
  MOVE TO p NOWAIT
{fillers}  r = ASIN(1.0 + n)
END test
"
    )
}

/// What can be seen of a controller in the end that is run to these moments, one after the other.
fn seen(
    config: &ControllerConfig,
    moments: impl Iterator<Item = u64>,
    (stopped, operation): (u64, &Operation),
) -> String {
    let mut core = Controller::try_new(config).unwrap();
    let mut is_stopped = false;
    for ms in moments.chain([MOST_MS]) {
        if ms >= stopped && !is_stopped {
            core.advance_fully(Duration::from_millis(stopped));
            let _refused = core.operate(operation.clone());
            is_stopped = true;
        }
        core.advance_fully(Duration::from_millis(ms));
    }
    let state = serde_json::to_string(&core.state()).unwrap();
    let ledger = serde_json::to_string(&core.ledger(0)).unwrap();
    format!("{state}\n{ledger}\n{:?}", core.alarms())
}

/// Controller time of such a program.
const MOST_MS: u64 = 400;

/// What stops an arm, or changes its pace.
fn stopping(which: u32) -> Operation {
    match which {
        0 => Operation::Hold,
        1 => Operation::SetOverride(7),
        2 => Operation::SetServoPower(false),
        3 => Operation::SafetyStop {
            source: StopSource::Panel,
            active: true,
        },
        _ => Operation::RaiseAlarm {
            facility: "SRVO".to_owned(),
            number: 38,
            text: "Pulse mismatch".to_owned(),
            severity: Severity::Abort,
        },
    }
}

/// Found by fuzzing: a traced task paid nothing for its conditions, so it was ahead of one that was not traced, and
/// what it stopped was stopped a millisecond earlier.
#[test]
fn a_watched_program_is_stopped_at_the_same_instruction_however_time_is_cut() {
    for speed in [2, 3, 5, 9, 17] {
        let mut config = config_of(&program_that_fails(16), &[]);
        config.limits.instructions_per_ms = speed;
        for stopped in 0..120 {
            let hold = (stopped, &Operation::Hold);
            config.trace = false;
            let whole = seen(&config, std::iter::empty(), hold);
            config.trace = true;
            let cut = 1 + stopped * 37 % 255;
            let pieces = seen(&config, (1..MOST_MS / cut).map(|n| n * cut), hold);
            assert_eq!(whole, pieces, "{speed} a ms, held at {stopped}, cut {cut}");
        }
    }
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(192))]

    #[test]
    fn a_stop_at_any_moment_ends_at_the_same_place_however_time_is_cut(
        fillers in 0..40usize, speed in 1..100u32, cut in 1..=255u64, stopped in 0..MOST_MS, which in 0..5u32,
    ) {
        let mut config = config_of(&program_that_fails(fillers), &[]);
        config.limits.instructions_per_ms = speed;
        let operation = stopping(which);
        let whole = seen(&config, std::iter::empty(), (stopped, &operation));
        config.trace = true;
        let pieces = seen(&config, (1..MOST_MS / cut).map(|n| n * cut), (stopped, &operation));
        prop_assert_eq!(whole, pieces);
    }
}

/// Time stood still for ever: a task that had used up its share was due to look at its conditions, and could not.
#[test]
fn a_task_without_instructions_left_looks_at_its_conditions_later() {
    let mut config = config_of(&program_that_fails(3), &[]);
    config.limits.instructions_per_ms = 1;
    let mut core = Controller::try_new(&config).unwrap();
    core.advance_fully(Duration::from_millis(MOST_MS));
    assert_eq!(core.now(), Duration::from_millis(MOST_MS));
}
