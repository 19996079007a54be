//! The reserve: a full disk leaves no motion without an end. The disk is full by SQLite's own limit on pages; the
//! reserve's file is a real one.
#![allow(clippy::unwrap_used, reason = "a test's helpers fail as its tests do")]

mod common;

use std::path::{Path, PathBuf};
use std::time::Duration;

use common::{at, audit, directory, intent, motion, not_sent, open, opening, options, outcome};
use journal::{
    AppendError, Begun, Effect, Journal, MotionPhase, Position, Record, Room, SqliteJournal,
    SqliteOptions, verify,
};

const RESERVE: u64 = 256 << 10;

fn small() -> SqliteOptions {
    SqliteOptions {
        max_pages: Some(140),
        reserve: RESERVE,
        look_for_room: Duration::from_millis(5),
        ..options()
    }
}

async fn open_small(path: &Path) -> SqliteJournal {
    SqliteJournal::open(path, &opening(), &small())
        .await
        .unwrap()
}

fn reserve_of(path: &Path) -> PathBuf {
    path.with_file_name("cell.journal.reserve")
}

fn long(n: u64) -> Record {
    let Record::Audit(mut audit) = audit(n) else {
        unreachable!("an audit record")
    };
    audit.after = Some("x".repeat(4_000));
    Record::Audit(audit)
}

/// Takes pages of the file away, as another program takes the disk's blocks.
async fn filler(path: &Path, sql: &'static str) {
    use sqlx::ConnectOptions as _;
    let mut other = sqlx::sqlite::SqliteConnectOptions::new()
        .filename(path)
        .busy_timeout(Duration::from_secs(5))
        .connect()
        .await
        .unwrap();
    let _done = sqlx::raw_sql(sql).execute(&mut other).await.unwrap();
}

/// Fills the room in front of the reserve, and a bit of the reserve.
async fn fill(journal: &SqliteJournal) {
    while journal.room() == Room::Free {
        let _kept = journal.append(at(1), long(1)).await.unwrap();
    }
}

/// Covers: D1.
#[tokio::test]
async fn d1_on_a_full_disk_what_runs_gets_its_end_and_nothing_new_begins() {
    let (_directory, path) = directory();
    let journal = open_small(&path).await;
    assert_eq!(std::fs::metadata(reserve_of(&path)).unwrap().len(), RESERVE);
    let running = intent(journal.epoch(), 1, None);
    let begun = journal.begin_motion(at(1), running).await.unwrap();
    assert!(matches!(begun, Begun::New(_)));
    fill(&journal).await;
    assert!(!reserve_of(&path).exists(), "it was given up");

    let refused = journal
        .begin_motion(at(2), intent(journal.epoch(), 2, None))
        .await
        .unwrap_err();
    assert!(matches!(refused, AppendError::NoRoom { reserve: RESERVE }));
    assert!(refused.is_disk_full() && !refused.is_fatal());
    assert_eq!(refused.effect(), Effect::None);
    assert!(refused.to_string().contains("256 KiB"), "{refused}");
    let _ended = journal.append(at(3), outcome(1, not_sent())).await.unwrap();
    let _said = journal.append(at(4), audit(4)).await.unwrap();
    let closed = journal.motion(motion(1)).await.unwrap().unwrap();
    assert_eq!(closed.phase, MotionPhase::Closed);
    let head = journal.head();
    journal.close().await;
    assert_eq!(verify(&path, Some(head)).await.unwrap().head, head);
}

/// Covers: D1. A group in which one record finds no room is written as a whole, except for what would begin something.
#[tokio::test]
async fn a_group_on_the_edge_of_the_reserve_loses_nothing_that_is_kept() {
    let (_directory, path) = directory();
    let journal = std::sync::Arc::new(open_small(&path).await);
    let appends: Vec<_> = (0..120)
        .map(|n| {
            let journal = std::sync::Arc::clone(&journal);
            tokio::spawn(async move {
                if n % 2 == 0 {
                    journal.append(at(n), long(n)).await.map(drop)
                } else {
                    let intent = intent(journal.epoch(), n.into(), None);
                    journal.begin_motion(at(n), intent).await.map(drop)
                }
            })
        })
        .collect();
    let (mut kept, mut refused) = (0, 0);
    for append in appends {
        match append.await.unwrap() {
            Ok(()) => kept += 1,
            Err(error) => {
                assert!(matches!(error, AppendError::NoRoom { .. }), "{error}");
                refused += 1;
            }
        }
    }
    assert!(kept >= 60 && refused > 0, "{kept} {refused}");
    assert_eq!(journal.head().position, Position(kept + 1));
}

/// Covers: D1. The reserve, too, has an end, and then the journal is of no more use until it is opened again.
#[tokio::test]
async fn when_the_reserve_is_full_too_nothing_is_kept_any_more() {
    let (_directory, path) = directory();
    let journal = open_small(&path).await;
    fill(&journal).await;
    let before = journal.head();
    let mut on_reserve = 0;
    let error = loop {
        match journal.append(at(1), long(1)).await {
            Ok(_) => on_reserve += 1,
            Err(error) => break error,
        }
    };
    assert!(error.is_fatal() && error.is_disk_full(), "{error}");
    // A record of 4 KB takes two pages of 4 KiB at most: half of the reserve at least is records.
    assert!(on_reserve >= 25, "{on_reserve}");
    let head = journal.head();
    assert_eq!(head.position.0, before.position.0 + on_reserve);
    journal.close().await;
    assert_eq!(verify(&path, Some(head)).await.unwrap().head, head);
    // A disk with room: everything goes on.
    let journal = open(&path).await;
    let next = intent(journal.epoch(), 7, None);
    assert!(journal.begin_motion(at(2), next).await.is_ok());
}

/// Covers: D1. When there is room again the reserve is made again, and new things begin, without a new start.
#[tokio::test]
async fn when_there_is_room_again_the_journal_goes_on_by_itself() {
    let (_directory, path) = directory();
    let journal = open_small(&path).await;
    filler(
        &path,
        "CREATE TABLE filler (bytes BLOB); INSERT INTO filler VALUES (zeroblob(150000))",
    )
    .await;
    fill(&journal).await;
    let refused = journal
        .begin_motion(at(2), intent(journal.epoch(), 2, None))
        .await;
    assert!(matches!(refused, Err(AppendError::NoRoom { .. })));
    filler(&path, "DROP TABLE filler").await;
    while journal.room() != Room::Free {
        tokio::task::yield_now().await;
    }
    assert_eq!(std::fs::metadata(reserve_of(&path)).unwrap().len(), RESERVE);
    let begun = journal
        .begin_motion(at(3), intent(journal.epoch(), 2, None))
        .await;
    assert!(matches!(begun, Ok(Begun::New(_))), "{begun:?}");
    // The limit in front of the reserve holds again.
    fill(&journal).await;
}

/// Covers: D1. A start on a full disk: what was under way can be decided, and nothing begins.
#[tokio::test]
async fn a_journal_is_opened_on_a_full_disk_for_what_is_to_be_decided() {
    let (_directory, path) = directory();
    let journal = open_small(&path).await;
    let begun = journal
        .begin_motion(at(1), intent(journal.epoch(), 1, None))
        .await
        .unwrap();
    assert!(matches!(begun, Begun::New(_)));
    fill(&journal).await;
    journal.close().await;
    for _start in 0..2 {
        let journal = open_small(&path).await;
        fill(&journal).await;
        let refused = journal
            .begin_motion(at(2), intent(journal.epoch(), 9, None))
            .await;
        assert!(matches!(refused, Err(AppendError::NoRoom { .. })));
        journal.close().await;
    }
    let journal = open_small(&path).await;
    let ended = journal.append(at(3), outcome(1, not_sent())).await;
    assert!(ended.is_ok(), "{ended:?}");
}

/// The blocks of the reserve are on the disk, not only its length.
#[cfg(target_os = "linux")]
#[tokio::test]
async fn the_reserve_takes_its_blocks_and_is_kept_over_a_start() {
    use std::os::unix::fs::MetadataExt as _;
    let (_directory, path) = directory();
    open_small(&path).await.close().await;
    let first = std::fs::metadata(reserve_of(&path)).unwrap();
    assert!(first.blocks() * 512 >= RESERVE);
    open_small(&path).await.close().await;
    let second = std::fs::metadata(reserve_of(&path)).unwrap();
    assert_eq!(first.modified().unwrap(), second.modified().unwrap());
    // One of another size is made anew.
    std::fs::write(reserve_of(&path), "short").unwrap();
    open_small(&path).await.close().await;
    assert_eq!(std::fs::metadata(reserve_of(&path)).unwrap().len(), RESERVE);
}
