//! The cell server's programs over the wire: every answer, and what stands behind it.

mod common;

use common::wire::{Line, cell, command, field, joints, nonce, pose, starts};
use karel_emulator::LedgerEvent;
use karel_emulator::LedgerEvent::{Finished, Held, Resumed, Started};
use karel_emulator::ledger::MotionKind;

const THERE: [f64; 6] = [20.0, 10.0, -10.0, 5.0, -60.0, 15.0];
const BACK: [f64; 6] = [0.0, 0.0, 0.0, 0.0, -90.0, 0.0];

#[tokio::test]
async fn a_motion_is_acknowledged_carried_out_once_and_reported() {
    let cell = cell();
    let mut line = Line::command(&cell).await;
    let greeting = line.next().await;
    assert_eq!(greeting[..8], ["V2", "1", "0", "0", "0", "0", "0", "0"]);
    let text = joints((1000, 1), &nonce(&greeting), THERE, 50);
    line.send(&text).await;
    assert_eq!(line.next().await, ["ACK", "1000", "1"]);
    let done = line.next().await;
    assert_eq!(done[..4], ["DONE", "1000", "1", "0"]);
    line.closed().await;
    let state = cell.controller.state().await.unwrap();
    let joints: [f64; 6] = state.joints_deg.into();
    for (is, wanted) in joints.into_iter().zip(THERE) {
        assert!((is - wanted).abs() < 1e-4, "{joints:?}");
    }
    let pose = state.pose;
    let shown = [
        pose.x_mm, pose.y_mm, pose.z_mm, pose.w_deg, pose.p_deg, pose.r_deg,
    ];
    for (text, is) in done[4..].iter().zip(shown) {
        let told: f64 = text.parse().unwrap();
        assert!((told / 1000.0 - is).abs() < 2e-3, "{done:?} {shown:?}");
    }
    assert_eq!(starts(&cell).await, [(1000, 1)]);
    let mut line = Line::command(&cell).await;
    assert_eq!(
        line.next().await[..8],
        ["V2", "1", "1000", "1000", "1", "1000", "1", "0"]
    );
}

#[tokio::test]
async fn a_pose_is_reached_in_the_configuration_that_was_asked_for_and_a_line_is_straight() {
    let cell = cell();
    let target = [900.0, 100.0, 700.0, 180.0, 0.0, 0.0];
    let (answer, mut line) = command(&cell, |nonce| {
        pose((1000, 1), nonce, 1, target, 30, "N U T 0 0 0")
    })
    .await;
    assert_eq!(answer, ["ACK", "1000", "1"]);
    let done = line.next().await;
    assert_eq!(done[..4], ["DONE", "1000", "1", "0"]);
    assert!((done[4].parse::<i64>().unwrap() - 900_000).abs() <= 2);
    let target = [900.0, -200.0, 600.0, 180.0, 0.0, 20.0];
    let (answer, mut line) = command(&cell, |nonce| {
        pose((1000, 2), nonce, 2, target, 250, "N U T 0 0 0")
    })
    .await;
    assert_eq!(answer, ["ACK", "1000", "2"]);
    assert_eq!(line.next().await[..4], ["DONE", "1000", "2", "0"]);
    let ledger = cell.controller.ledger().await.unwrap();
    let last = ledger.last().unwrap();
    assert_eq!(
        (last.event, last.kind),
        (LedgerEvent::Finished, MotionKind::Linear)
    );
    // 316 mm at 250 mm/s, and the ramps.
    assert!((1.26..1.6).contains(&last.duration_s.unwrap()), "{last:?}");
}

/// Writes a command with this nonce.
type Write = Box<dyn Fn(&str) -> String>;

#[tokio::test]
async fn every_refusal_says_why_and_stores_nothing() {
    let cell = cell();
    let far = [9000.0, 0.0, 0.0, 0.0, 0.0, 0.0];
    let near = [900.0, 100.0, 700.0, 180.0, 0.0, 0.0];
    let mut beyond = THERE;
    beyond[0] = 300.0;
    let cases: Vec<(&str, Write, &str)> = vec![
        (
            "far",
            Box::new(move |n| pose((9, 1), n, 1, far, 10, "N U T 0 0 0")),
            "ERR 3",
        ),
        (
            "turned",
            Box::new(move |n| pose((9, 1), n, 1, near, 10, "N U T 0 0 5")),
            "ERR 3",
        ),
        (
            "wild turn",
            Box::new(move |n| pose((9, 1), n, 1, near, 10, "N U T 0 0 99")),
            "ERR 3",
        ),
        (
            "limit",
            Box::new(move |n| joints((9, 1), n, beyond, 10)),
            "ERR 3",
        ),
        (
            "no speed",
            Box::new(|n| joints((9, 1), n, THERE, 0)),
            "ERR 4",
        ),
        (
            "too fast",
            Box::new(|n| joints((9, 1), n, THERE, 101)),
            "ERR 4",
        ),
        (
            "too fast a line",
            Box::new(move |n| pose((9, 1), n, 2, near, 2000, "N U T 0 0 0")),
            "ERR 4",
        ),
        (
            "kind",
            Box::new(move |n| pose((9, 1), n, 4, near, 10, "N U T 0 0 0")),
            "ERR 1",
        ),
        (
            "flip",
            Box::new(move |n| pose((9, 1), n, 1, near, 10, "X U T 0 0 0")),
            "ERR 1",
        ),
        ("output", Box::new(|n| format!("O 9 1 {n} 9 1")), "ERR 7"),
        ("output 0", Box::new(|n| format!("O 9 1 {n} 0 1")), "ERR 7"),
        ("level", Box::new(|n| format!("O 9 1 {n} 1 2")), "ERR 1"),
        ("verb", Box::new(|n| format!("Q 9 1 {n} 1 2")), "ERR 1"),
        (
            "token missing",
            Box::new(|n| format!("O 9 1 {n} 1")),
            "ERR 1",
        ),
        ("no number", Box::new(|n| format!("O 9 x {n} 1 1")), "ERR 1"),
        (
            "number of 33 bits",
            Box::new(|n| format!("O 9 4294967297 {n} 1 1")),
            "ERR 1",
        ),
        ("number 0", Box::new(|n| format!("O 9 0 {n} 1 1")), "ERR 1"),
        (
            "wrong nonce",
            Box::new(|_| "O 9 1 999999 1 1".to_owned()),
            "ERR 2",
        ),
    ];
    for (name, write, wanted) in cases {
        let (answer, mut line) = command(&cell, write).await;
        assert_eq!(answer.join(" "), wanted, "{name}");
        line.closed().await;
    }
    let mut line = Line::command(&cell).await;
    assert_eq!(line.next().await[1..8], ["1", "0", "0", "0", "0", "0", "0"]);
    assert!(cell.controller.ledger().await.unwrap().is_empty());
}

/// Covers: W8.
#[tokio::test]
async fn a_number_that_was_accepted_is_a_duplicate_and_an_older_epoch_is_stale() {
    let cell = cell();
    let (answer, mut line) = command(&cell, |n| joints((2000, 5), n, THERE, 80)).await;
    assert_eq!(answer, ["ACK", "2000", "5"]);
    assert_eq!(line.next().await[..4], ["DONE", "2000", "5", "0"]);
    for seq in [1, 4, 5] {
        let (answer, _line) = command(&cell, |n| joints((2000, seq), n, BACK, 80)).await;
        assert_eq!(answer, ["DUP", "2000", &seq.to_string(), "1"]);
    }
    let (answer, _line) = command(&cell, |n| joints((1999, 9), n, BACK, 80)).await;
    assert_eq!(answer, ["STALE", "2000"]);
    let (answer, mut line) = command(&cell, |n| joints((2001, 1), n, BACK, 80)).await;
    assert_eq!(answer, ["ACK", "2001", "1"]);
    assert_eq!(line.next().await[..4], ["DONE", "2001", "1", "0"]);
    assert_eq!(starts(&cell).await, [(2000, 5), (2001, 1)]);
}

#[tokio::test]
async fn a_client_that_leaves_makes_room_and_finds_the_motion_busy_or_a_duplicate() {
    let cell = cell();
    let (answer, line) = command(&cell, |n| joints((1000, 1), n, THERE, 3)).await;
    assert_eq!(answer, ["ACK", "1000", "1"]);
    drop(line);
    let (answer, _line) = command(&cell, |n| joints((1000, 1), n, THERE, 3)).await;
    assert_eq!(answer, ["DUP", "1000", "1", "0"]);
    let (answer, _line) = command(&cell, |n| joints((1000, 2), n, BACK, 3)).await;
    assert_eq!(answer, ["BUSY", "1000", "1"]);
    let mut status = Line::status(&cell).await;
    for _ in 0..600 {
        let now = status.ask("S 1000").await;
        if field(&now, "moving") == 0 {
            assert_eq!((field(&now, "fin_seq"), field(&now, "fin_status")), (1, 0));
            break;
        }
        cell.advance(0.1).await;
    }
    assert_eq!(starts(&cell).await, [(1000, 1)]);
}

#[tokio::test]
async fn the_status_port_reports_fences_and_stops() {
    let cell = cell();
    let mut status = Line::status(&cell).await;
    let first = status.ask("S 1000").await;
    assert_eq!(field(&first, "boot"), 1);
    assert_eq!(field(&first, "mode"), 3);
    assert_eq!(field(&first, "moving"), 0);
    assert_eq!(field(&first, "override"), 100);
    assert_eq!(field(&first, "utool"), 1);
    let fenced = status.ask("F 2000").await;
    assert_eq!(field(&fenced, "epoch_max"), 2000);
    let lower = status.ask("F 1500").await;
    assert_eq!(field(&lower, "epoch_max"), 2000, "it never goes back");
    let (answer, _line) = command(&cell, |nonce| joints((1000, 1), nonce, THERE, 50)).await;
    assert_eq!(answer, ["STALE", "2000"]);
    let (answer, mut line) = command(&cell, |nonce| joints((2000, 1), nonce, THERE, 5)).await;
    assert_eq!(answer, ["ACK", "2000", "1"]);
    cell.advance(0.3).await;
    let moving = status.ask("S 2000").await;
    assert_eq!(field(&moving, "moving"), 1);
    let _stopping = status.ask("X").await;
    let done = line.next().await;
    assert_eq!(done[..4], ["DONE", "2000", "1", "2"]);
    let after = status.ask("S 2000").await;
    assert_eq!(
        (field(&after, "moving"), field(&after, "fin_status")),
        (0, 2)
    );
    let events = cell.events().await;
    assert_eq!(
        events,
        [(1, LedgerEvent::Started), (1, LedgerEvent::Cancelled)]
    );
}

#[tokio::test]
async fn a_hold_brakes_and_a_continue_goes_on_to_the_target() {
    let cell = cell();
    let mut status = Line::status(&cell).await;
    let (answer, mut line) = command(&cell, |n| joints((1000, 1), n, THERE, 10)).await;
    assert_eq!(answer, ["ACK", "1000", "1"]);
    cell.advance(0.3).await;
    let _holding = status.ask("P").await;
    cell.advance(1.0).await;
    let held = status.ask("S 1000").await;
    assert_eq!((field(&held, "held"), field(&held, "moving")), (1, 0));
    let at = field(&held, "j1");
    assert!((1..20_000).contains(&at), "it stopped on its way: {at}");
    cell.advance(1.0).await;
    assert_eq!(field(&status.ask("C").await, "held"), 0);
    assert_eq!(line.next().await[..4], ["DONE", "1000", "1", "0"]);
    let events: Vec<LedgerEvent> = cell.events().await.into_iter().map(|e| e.1).collect();
    assert_eq!(events, [Started, Held, Resumed, Finished]);
    assert_eq!(field(&status.ask("S 1000").await, "j1"), 20_000);
}

#[tokio::test]
async fn the_override_is_set_and_nonsense_is_malformed() {
    let cell = cell();
    let mut status = Line::status(&cell).await;
    assert_eq!(field(&status.ask("G 40").await, "override"), 40);
    for wrong in ["G 0", "G 101", "G", "S", "S x", "Z", "X 1", "F -1", ""] {
        assert_eq!(status.ask(wrong).await, ["ERR", "1"], "{wrong:?}");
    }
    status.raw(b"S 1000 1\n").await;
    assert_eq!(status.next().await, ["ERR", "1"], "a wrong sum");
    assert_eq!(field(&status.ask("S 1").await, "override"), 40);
}

#[tokio::test]
async fn every_line_end_is_taken_and_empty_lines_are_skipped() {
    let cell = cell();
    let mut status = Line::status(&cell).await;
    let sum = common::wire::sum("S 1");
    for end in ["\n", "\r", "\r\n", "\r\n\r\n\n\r"] {
        status.raw(format!("S 1 {sum}{end}").as_bytes()).await;
        let answer = status.next().await;
        assert_eq!(answer[0], "ST", "{end:?}");
    }
}

#[tokio::test]
async fn an_output_is_set_once_and_its_number_counts() {
    let cell = cell();
    let mut status = Line::status(&cell).await;
    let (answer, mut line) = command(&cell, |n| format!("O 1000 1 {n} 3 1")).await;
    assert_eq!(answer, ["ACK", "1000", "1"]);
    assert_eq!(line.next().await[..4], ["DONE", "1000", "1", "0"]);
    assert_eq!(field(&status.ask("S 1000").await, "outputs"), 4);
    let (answer, _line) = command(&cell, |n| format!("O 1000 1 {n} 3 0")).await;
    assert_eq!(answer, ["DUP", "1000", "1", "1"]);
    assert_eq!(field(&status.ask("S 1000").await, "outputs"), 4);
}
