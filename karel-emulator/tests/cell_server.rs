//! The cell server's programs over the wire: every answer, and what stands behind it.

mod common;

use common::wire::{Line, cell, command, field, joints, nonce, starts};

const THERE: [f64; 6] = [20.0, 10.0, -10.0, 5.0, -60.0, 15.0];

#[tokio::test]
async fn a_motion_is_acknowledged_carried_out_once_and_reported() {
    let cell = cell();
    let mut line = Line::command(&cell).await;
    let greeting = line.next().await;
    assert_eq!(greeting[..8], ["V2", "1", "0", "0", "0", "0", "0", "0"]);
    line.send(&joints((1000, 1), &nonce(&greeting), THERE, 50))
        .await;
    assert_eq!(line.next().await, ["ACK", "1000", "1"]);
    let done = line.next().await;
    assert_eq!(done[..4], ["DONE", "1000", "1", "0"]);
    line.closed().await;
    let state = cell.controller.state().await.unwrap();
    let joints: [f64; 6] = state.joints_deg.into();
    for (is, wanted) in joints.into_iter().zip(THERE) {
        assert!((is - wanted).abs() < 1e-4, "{joints:?}");
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
    let fenced = status.ask("F 2000").await;
    assert_eq!(field(&fenced, "epoch_max"), 2000);
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
}
