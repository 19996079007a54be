//! What a network, a power switch and a careless client do to the cell server.

mod common;

use common::wait_until;
use common::wire::{Line, cell, command, field, joints, nonce, sealed, starts};
use karel_emulator::{CmosMemory, LedgerEvent};

const THERE: [f64; 6] = [20.0, 10.0, -10.0, 5.0, -60.0, 15.0];
const BACK: [f64; 6] = [0.0, 0.0, 0.0, 0.0, -90.0, 0.0];

/// Covers: K1.
#[tokio::test]
async fn a_silent_client_costs_half_a_second_and_a_late_command_is_refused() {
    let cell = cell();
    let mut silent = Line::command(&cell).await;
    let greeting = silent.next().await;
    cell.advance(0.45).await;
    assert_eq!(
        cell.controller.state().await.unwrap().tasks[0].name,
        "CELL_SERVER"
    );
    assert_eq!(silent.next().await, ["ERR", "2"]);
    silent.closed().await;
    // A slow client whose last byte comes too late.
    let mut slow = Line::command(&cell).await;
    let greeting_2 = slow.next().await;
    assert_ne!(nonce(&greeting), nonce(&greeting_2), "a nonce is for once");
    let text = sealed(&joints((1000, 1), &nonce(&greeting_2), THERE, 50));
    let (head, tail) = text.split_at(30);
    slow.raw(head.as_bytes()).await;
    cell.advance(0.49).await;
    cell.advance(0.02).await;
    let _too_late = slow.stream.try_write(tail.as_bytes());
    assert_eq!(slow.next().await, ["ERR", "2"]);
    // A nonce of another connection is nobody's.
    let (answer, _line) = command(&cell, |_| joints((1000, 1), &nonce(&greeting), THERE, 50)).await;
    assert_eq!(answer, ["ERR", "2"]);
    assert!(starts(&cell).await.is_empty());
}

/// Covers: W3.
#[tokio::test]
async fn a_client_may_vanish_at_any_byte_and_the_next_one_is_served() {
    let cell = cell();
    let mut accepted = 0;
    for cut in (0..100).step_by(7) {
        let mut line = Line::command(&cell).await;
        let greeting = line.next().await;
        assert_eq!(greeting[4], accepted.to_string(), "cut at {cut}");
        let text = sealed(&joints((1000, accepted + 1), &nonce(&greeting), BACK, 100));
        let cut = cut.min(text.len());
        line.raw(&text.as_bytes()[..cut]).await;
        // The sum, or at least its last digit, is missing in all but the whole line.
        drop(line);
        cell.advance(0.6).await;
        if cut == text.len() {
            accepted += 1;
        }
    }
    let (answer, mut line) = command(&cell, |n| joints((1000, accepted + 1), n, THERE, 100)).await;
    assert_eq!(answer[0], "ACK");
    assert_eq!(line.next().await[0], "DONE");
}

/// Covers: K4, K6.
#[tokio::test]
async fn garbage_and_lines_without_end_get_an_answer_and_do_no_harm() {
    let cell = cell();
    let long = vec![b'7'; 5_000];
    let mut blanks = vec![b' '; 300];
    blanks.push(b'\n');
    let mut tokens = b"M ".repeat(60);
    tokens.push(b'\n');
    let wild: Vec<u8> = (0..=255_u8).chain([b'\n']).collect();
    let mut long_line = long.clone();
    long_line.push(b'\n');
    for bytes in [
        &b"\n"[..],
        b"M\n",
        &blanks,
        &tokens,
        &wild,
        &long_line,
        b"\xff\xfe 1\r\n",
    ] {
        let mut line = Line::command(&cell).await;
        let _greeting = line.next().await;
        line.raw(bytes).await;
        let answer = line.next().await;
        assert_eq!(answer[0], "ERR", "{bytes:?}");
    }
    let mut endless = Line::command(&cell).await;
    let _greeting = endless.next().await;
    endless.raw(&long).await;
    assert_eq!(
        endless.next().await,
        ["ERR", "1"],
        "a line that is too long is cut, and its sum is wrong"
    );
    let mut status = Line::status(&cell).await;
    for bytes in [&b"M\n"[..], &blanks, &tokens, &wild, &long_line] {
        status.raw(bytes).await;
        let answer = status.next().await;
        assert_eq!(answer[0], "ERR", "{bytes:?}");
    }
    // The wild bytes hold line ends, so they are several lines.
    let mut answer = status.ask("S 1").await;
    while answer[0] == "ERR" {
        answer = status.next().await;
    }
    assert_eq!(answer[0], "ST");
    let state = cell.controller.state().await.unwrap();
    assert_eq!(state.active_alarms, 0);
    assert!(starts(&cell).await.is_empty());
}

/// Covers: W3.
#[tokio::test]
async fn every_damaged_byte_of_a_command_is_noticed() {
    let cell = cell();
    for at in 0..40 {
        let mut line = Line::command(&cell).await;
        let greeting = line.next().await;
        let mut bytes = sealed(&joints((1000, 1), &nonce(&greeting), THERE, 50)).into_bytes();
        bytes[at] ^= 1;
        line.raw(&bytes).await;
        assert_eq!(line.next().await, ["ERR", "1"], "byte {at}");
    }
    assert!(starts(&cell).await.is_empty());
}

#[tokio::test]
async fn a_motion_goes_on_while_heartbeats_come_whoever_else_is_gone() {
    let cell = cell();
    let (answer, line) = command(&cell, |n| joints((1000, 1), n, THERE, 2)).await;
    assert_eq!(answer, ["ACK", "1000", "1"]);
    drop(line);
    // The status client reconnects again and again.
    for _ in 0..6 {
        let mut status = Line::status(&cell).await;
        assert_eq!(field(&status.ask("S 1000").await, "moving"), 1);
        drop(status);
        cell.advance(0.5).await;
    }
}

#[tokio::test]
async fn without_heartbeats_the_dead_man_stops_the_motion_and_latches() {
    let cell = cell();
    let (answer, mut line) = command(&cell, |n| joints((1000, 1), n, THERE, 2)).await;
    assert_eq!(answer, ["ACK", "1000", "1"]);
    cell.advance(1.9).await;
    assert!(cell.controller.state().await.unwrap().moving);
    assert_eq!(line.next().await[..4], ["DONE", "1000", "1", "3"]);
    let (answer, _line) = command(&cell, |n| joints((1000, 2), n, BACK, 20)).await;
    assert_eq!(answer, ["ERR", "5"]);
    let mut status = Line::status(&cell).await;
    let latched = status.ask("S 1000").await;
    assert_eq!(
        field(&latched, "deadman"),
        1,
        "the same epoch frees nothing"
    );
    assert_eq!(field(&status.ask("F 1001").await, "deadman"), 0);
    let (answer, mut line) = command(&cell, |n| joints((1001, 1), n, BACK, 80)).await;
    assert_eq!(answer, ["ACK", "1001", "1"]);
    assert_eq!(line.next().await[..4], ["DONE", "1001", "1", "0"]);
}

#[tokio::test]
async fn a_command_of_a_greater_epoch_frees_the_dead_man_too() {
    let cell = cell();
    let (_answer, mut line) = command(&cell, |n| joints((1000, 1), n, THERE, 2)).await;
    assert_eq!(line.next().await[..4], ["DONE", "1000", "1", "3"]);
    let (answer, mut line) = command(&cell, |n| joints((1001, 1), n, BACK, 80)).await;
    assert_eq!(answer, ["ACK", "1001", "1"]);
    assert_eq!(line.next().await[..4], ["DONE", "1001", "1", "0"]);
}

#[tokio::test]
async fn heartbeats_of_an_old_epoch_do_not_count() {
    let cell = cell();
    let mut status = Line::status(&cell).await;
    let (_answer, mut line) = command(&cell, |n| joints((1000, 1), n, THERE, 2)).await;
    for _ in 0..5 {
        cell.advance(0.4).await;
        let _counts_for_nothing = status.ask("S 999").await;
    }
    assert_eq!(
        line.next_within(0.5).await.unwrap()[..4],
        ["DONE", "1000", "1", "3"]
    );
}

/// Covers: W8.
#[tokio::test]
async fn a_stop_or_a_fence_kills_the_nonce_that_is_out() {
    let cell = cell();
    let mut status = Line::status(&cell).await;
    for order in ["X", "F 1"] {
        let mut line = Line::command(&cell).await;
        let greeting = line.next().await;
        let _answer = status.ask(order).await;
        line.send(&joints((1000, 1), &nonce(&greeting), THERE, 50))
            .await;
        assert_eq!(line.next().await, ["ERR", "2"], "{order}");
    }
    assert!(starts(&cell).await.is_empty());
}

/// Covers: C1.
#[tokio::test]
async fn the_power_fails_in_a_motion_and_the_numbers_survive() {
    let cell = cell();
    let (answer, line) = command(&cell, |n| joints((1000, 7), n, THERE, 5)).await;
    assert_eq!(answer, ["ACK", "1000", "7"]);
    cell.advance(0.3).await;
    cell.controller.power_cycle(CmosMemory::Kept).await.unwrap();
    drop(line);
    cell.until_standstill().await;
    let mut next = Line::command(&cell).await;
    let greeting = next.next().await;
    assert_eq!(
        greeting[..8],
        ["V2", "2", "1000", "1000", "7", "0", "0", "0"]
    );
    let mut status = Line::status(&cell).await;
    let after = status.ask("S 1000").await;
    assert_eq!((field(&after, "boot"), field(&after, "moving")), (2, 0));
    drop(next);
    let (answer, _line) = command(&cell, |n| joints((1000, 7), n, THERE, 5)).await;
    assert_eq!(answer, ["DUP", "1000", "7", "0"]);
    let (answer, mut line) = command(&cell, |n| joints((1000, 8), n, THERE, 80)).await;
    assert_eq!(answer, ["ACK", "1000", "8"]);
    assert_eq!(line.next().await[..4], ["DONE", "1000", "8", "0"]);
    assert_eq!(starts(&cell).await, [(1000, 7), (1000, 8)]);
}

#[tokio::test]
async fn without_its_battery_the_controller_starts_from_nothing() {
    let cell = cell();
    let (_answer, mut line) = command(&cell, |n| joints((1000, 1), n, THERE, 90)).await;
    assert_eq!(line.next().await[0], "DONE");
    cell.controller.power_cycle(CmosMemory::Lost).await.unwrap();
    let mut next = Line::command(&cell).await;
    assert_eq!(
        next.next().await[..8],
        ["V2", "1", "0", "0", "0", "0", "0", "0"]
    );
}

/// Covers: C6.
#[tokio::test]
async fn an_abort_of_everything_makes_the_ports_silent_and_the_arm_stops() {
    let cell = cell();
    let (_answer, _line) = command(&cell, |n| joints((1000, 1), n, THERE, 5)).await;
    cell.advance(0.3).await;
    cell.controller.abort_all().await.unwrap();
    cell.until_standstill().await;
    let last = cell.controller.ledger().await.unwrap().pop().unwrap();
    assert_eq!(last.event, LedgerEvent::Cancelled);
    wait_until(&cell.controller, |s| {
        s.tags.iter().all(|tag| tag.state == "idle")
    })
    .await;
}

#[tokio::test]
async fn an_override_of_zero_holds_the_arm_and_a_stop_still_ends_the_motion() {
    let cell = cell();
    let mut status = Line::status(&cell).await;
    cell.controller.set_override(0).await.unwrap();
    let (answer, mut line) = command(&cell, |n| joints((1000, 1), n, THERE, 50)).await;
    assert_eq!(answer, ["ACK", "1000", "1"]);
    for _ in 0..5 {
        cell.advance(0.5).await;
        assert_eq!(field(&status.ask("S 1000").await, "j1"), 0);
    }
    let _stopped = status.ask("X").await;
    assert_eq!(line.next().await[..4], ["DONE", "1000", "1", "2"]);
    for percent in [1, 50, 100] {
        cell.controller.set_override(percent).await.unwrap();
        assert_eq!(
            field(&status.ask("S 1000").await, "override"),
            i64::from(percent)
        );
    }
}
