//! The socket server moves the arm, and the ledger says so.

mod common;

use common::{ACCEPTED, INCORRECT, LINE, Stepped, UNREACHABLE, call, sock_server, within};
use karel_emulator::LedgerEvent::{Cancelled, Finished, Passed, Started};
use karel_emulator::PeerLabels;
use tokio::io::{AsyncReadExt, AsyncWriteExt};
use tokio::net::TcpStream;

#[tokio::test]
async fn an_accepted_line_is_answered_before_the_motion_ends_and_the_arm_arrives() {
    let cell = Stepped::start(&sock_server());
    assert_eq!(call(cell.address().await, LINE).await, ACCEPTED);

    let state = cell.controller.state().await.unwrap();
    assert!(state.moving, "the reply does not wait for the arm");
    assert_eq!(state.override_percent, 25);
    assert_eq!(cell.events().await, [(1, Started)]);

    cell.until_standstill().await;
    let state = cell.controller.state().await.unwrap();
    let pose = state.pose;
    let reached = [pose.x_mm, pose.y_mm, pose.z_mm, pose.p_deg, pose.r_deg];
    for (value, wanted) in reached.into_iter().zip([600.0, 200.0, 600.0, 30.0, 0.0]) {
        assert!((value - wanted).abs() < 1e-3, "{pose:?}");
    }
    assert!((pose.w_deg.abs() - 180.0).abs() < 1e-3, "{pose:?}");
    assert_eq!(cell.events().await, [(1, Started), (1, Finished)]);
    cell.controller.shutdown().await;
}

#[tokio::test]
async fn the_ledger_says_who_moved_the_arm_where_from_where_and_how_long() {
    let labels = PeerLabels::new();
    let cell = Stepped::start_labeled(&sock_server(), labels.clone());
    let mut stream = TcpStream::connect(cell.address().await).await.unwrap();
    let peer = stream.local_addr().unwrap();
    labels.set(peer, "req-42");
    stream.write_all(LINE).await.unwrap();
    assert_eq!(common::read_to_end(&mut stream).await, ACCEPTED);
    cell.until_standstill().await;

    let ledger = cell.controller.ledger().await.unwrap();
    let [started, finished] = ledger.as_slice() else {
        panic!("{ledger:#?}")
    };
    assert_eq!((started.seq, finished.seq), (1, 2));
    for entry in [started, finished] {
        assert_eq!(entry.peer, Some(peer));
        assert_eq!(entry.request_id.as_deref(), Some("req-42"));
        assert_eq!(entry.program, "SOCK_SERVER");
        assert!(entry.line > 0);
        assert_eq!(entry.override_percent, 25);
        assert!((entry.speed_mm_s - 300.0).abs() < 1e-9);
        assert!((entry.target_pose.x_mm - 600.0).abs() < 1e-9);
        assert_eq!(entry.alarm, None);
    }
    assert_eq!(started.to_deg, finished.to_deg);
    let home: [f64; 6] = started.from_deg.into();
    assert!(
        home.iter()
            .zip(common::arm().home().degrees())
            .all(|(a, b)| (a - b).abs() < 1e-9)
    );
    let (took, planned) = (finished.duration_s.unwrap(), started.duration_s.unwrap());
    assert!(
        (took - planned).abs() < 1e-5,
        "took {took} s, planned {planned} s"
    );
    assert!(
        took > 1.0,
        "at 25 % of 300/2000 of the axis speeds the arm needs its time"
    );
    assert!((finished.time_s - started.time_s - took).abs() < 1e-5);
}

#[tokio::test]
async fn refusals_move_nothing_and_the_next_client_is_served() {
    let cell = Stepped::start(&sock_server());
    let address = cell.address().await;
    for (line, reply) in [
        (&b"9000000 0 0 0 0 0 300 1"[..], UNREACHABLE),
        (b"600000 200000 600000 -180000 30000 0 2000 1", UNREACHABLE),
        (b"600000 200000 600000 -180000 30000 0 0 1", UNREACHABLE),
        (b"600000 200000 600000 -180000 30000 0 -1 1", UNREACHABLE),
        (b"a b c d e f g h\n", INCORRECT),
    ] {
        assert_eq!(
            call(address, line).await,
            reply,
            "{:?}",
            String::from_utf8_lossy(line)
        );
    }
    assert_eq!(cell.events().await, []);
    assert_eq!(call(address, LINE).await, ACCEPTED);
}

/// Covers: K8.
#[tokio::test]
async fn a_second_command_waits_behind_the_running_motion() {
    let cell = Stepped::start(&sock_server());
    let address = cell.address().await;
    assert_eq!(call(address, LINE).await, ACCEPTED);
    cell.advance(0.5).await;
    let back = b"985000 0 940000 -180000 0 0 1999 1";
    assert_eq!(call(address, back).await, ACCEPTED);
    assert_eq!(cell.controller.state().await.unwrap().motion_queue, 2);

    // A third finds no place: the program waits in its MOVE and does not close the connection before it has one.
    let mut third = TcpStream::connect(address).await.unwrap();
    third.write_all(LINE).await.unwrap();
    let mut reply = vec![0; ACCEPTED.len()];
    let _count = within(third.read_exact(&mut reply)).await.unwrap();
    assert_eq!(reply, ACCEPTED.as_bytes());
    cell.advance(0.0).await;
    assert_eq!(cell.controller.state().await.unwrap().motion_queue, 2);

    cell.until_standstill().await;
    assert_eq!(common::read_to_end(&mut third).await, "");
    let history = [
        (1, Started),
        // The program says `$TERMTYPE = NODECEL`, so the corners between its moves are rounded.
        (2, Started),
        (1, Passed),
        (3, Started),
        (2, Passed),
        (3, Finished),
    ];
    assert_eq!(cell.events().await, history);
}

#[tokio::test]
async fn abort_brakes_the_arm_and_the_ledger_says_cancelled() {
    let cell = Stepped::start(&sock_server());
    assert_eq!(call(cell.address().await, LINE).await, ACCEPTED);
    cell.advance(1.0).await;
    cell.controller.abort_all().await.unwrap();
    cell.until_standstill().await;
    let ledger = cell.controller.ledger().await.unwrap();
    let last = ledger.last().unwrap();
    assert_eq!(last.event, Cancelled);
    assert!(
        last.alarm
            .as_deref()
            .is_some_and(|reason| reason.contains("operator"))
    );
    assert_ne!(last.to_deg, ledger[0].to_deg, "it did not arrive");
    let refused = TcpStream::connect(cell.address().await).await;
    assert!(refused.is_err(), "no task, no listener");
}

#[tokio::test]
async fn an_error_of_the_program_brakes_the_arm_and_the_ledger_names_it() {
    let program = "PROGRAM fails
VAR p : XYZWPR
    n : INTEGER
BEGIN
  p = CURPOS(0, 0)
  p.z = p.z - 200
  MOVE TO p NOWAIT
  p.z = p.z + 100
  MOVE TO p NOWAIT
  DELAY 400
  n = 1 DIV 0
END fails
";
    let cell = Stepped::start(&common::config_of(program, &[]));
    cell.until_standstill().await;
    // The motion that waited is dropped at once, the arm stands still a little later.
    assert_eq!(
        cell.events().await,
        [(1, Started), (2, Cancelled), (1, Cancelled)]
    );
    for entry in &cell.controller.ledger().await.unwrap()[1..] {
        assert!(
            entry
                .alarm
                .as_deref()
                .is_some_and(|reason| reason.contains("FAILS, 11"))
        );
    }
}
