//! The same programs, bytes and times give the same ledger, byte for byte.

mod common;

use std::net::SocketAddr;
use std::time::Duration;

use common::{LINE, Stepped, call, config_of, sock_server};
use karel_emulator::Controller;
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
