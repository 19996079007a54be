//! The pose server with the status program beside it: what the status line says, and what a stop does.

mod common;

use common::wire::{Line, field};
use common::{ACCEPTED, LINE, Stepped, arm, call};
use karel_emulator::{ControllerConfig, LedgerEvent};

#[tokio::test]
async fn the_status_beside_the_pose_server_follows_a_motion_and_a_stop_ends_it_for_good() {
    let cell = Stepped::start(&ControllerConfig::seed_status("test", arm()));
    cell.advance(0.1).await;
    // A connection for each line: one that is silent for 2 s is closed.
    let ask = async |text: &str| Line::status(&cell).await.ask(text).await;
    let fenced = ask("F 7000").await;
    assert_eq!(
        (field(&fenced, "boot"), field(&fenced, "epoch_max")),
        (1, 7000)
    );
    assert_eq!(field(&fenced, "acc_seq"), 0);
    assert_eq!((field(&fenced, "moving"), field(&fenced, "mode")), (0, 3));

    let address = cell.address().await;
    let (reply, ()) = tokio::join!(call(address, LINE), async {
        for _ in 0..20 {
            cell.advance(0.01).await;
        }
    });
    assert_eq!(reply, ACCEPTED);
    assert_eq!(field(&ask("S 7000").await, "moving"), 1);
    cell.until_standstill().await;
    let there = ask("S 7000").await;
    assert_eq!(field(&there, "moving"), 0);
    for (name, wanted) in [("x", 600_000), ("y", 200_000), ("p", 30_000)] {
        assert!((field(&there, name) - wanted).abs() < 100, "{there:?}");
    }

    // A second motion is stopped halfway, and the pose server serves again.
    let back: &[u8] = b"900000 -200000 700000 -180000 0 0 100 1";
    for expected in [LedgerEvent::Cancelled, LedgerEvent::Finished] {
        let (reply, ()) = tokio::join!(call(address, back), async {
            for _ in 0..40 {
                cell.advance(0.01).await;
            }
        });
        assert_eq!(reply, ACCEPTED);
        if expected == LedgerEvent::Cancelled {
            let _braking = ask("X").await;
        }
        cell.until_standstill().await;
        let _runs_again = ask("S 7000").await;
        assert_eq!(cell.events().await.last().unwrap().1, expected);
    }
    assert_eq!(ask("P").await, ["ERR", "1"]);
}
