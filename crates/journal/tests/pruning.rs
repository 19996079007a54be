//! Snapshots, and the removal of old records: what may go, what is left, and what can still be proved.
#![allow(
    clippy::unwrap_used,
    clippy::indexing_slicing,
    reason = "a test's helpers fail as its tests do"
)]

mod common;

use std::io::Cursor;
use std::path::Path;

use common::{
    accepted, at, audit, claim, directory, in_doubt, intent, motion, not_sent, open, opening,
    options, outcome,
};
use journal::{
    AppendError, Appended, CellDecided, Completion, Fault, Head, Journal, Kept, MemoryDisk,
    MemoryJournal, NewSnapshot, OpenError, Position, ReadError, Record, Refusal, SqliteJournal,
    VerifyError, export, import, verify, verify_archives, write_line,
};
use sqlx::{ConnectOptions as _, Connection as _};

fn decided(n: u64) -> Record {
    Record::CellDecided(CellDecided {
        cell: "c1".into(),
        facts: format!("[{n}]"),
        claim: None,
    })
}

async fn keep(journal: &impl Journal, second: u64, record: Record) -> Head {
    let Appended::New(receipt) = journal.append(at(second), record).await.unwrap() else {
        panic!("no key was given");
    };
    receipt.head
}

async fn snapshot(journal: &impl Journal, covers: Head, body: &str) -> Result<(), AppendError> {
    let snapshot = NewSnapshot {
        cell: "c1".into(),
        covers,
        format: 1,
        body: body.into(),
    };
    journal.keep_snapshot(at(5), snapshot).await.map(drop)
}

/// Ten decisions, a snapshot of the seventh, ten audits. The opening is record 1.
async fn history(journal: &impl Journal) {
    let mut covers = Head::EMPTY;
    for n in 1..=10 {
        let head = keep(journal, 1, decided(n)).await;
        if n == 7 {
            covers = head;
        }
    }
    snapshot(journal, covers, "seven").await.unwrap();
    for n in 1..=10 {
        let _head = keep(journal, 2, audit(n)).await;
    }
}

async fn edit(path: &Path, statement: &'static str) {
    let options = sqlx::sqlite::SqliteConnectOptions::new().filename(path);
    let mut connection = options.connect().await.unwrap();
    let _done = sqlx::raw_sql(statement)
        .execute(&mut connection)
        .await
        .unwrap();
    connection.close().await.unwrap();
}

const ALL: Position = Position(1_000);

#[tokio::test]
async fn r6_a_snapshot_is_kept_with_its_record_and_a_later_one_replaces_it() {
    let (_directory, path) = directory();
    let journal = open(&path).await;
    history(&journal).await;
    let other = Head {
        position: Position(9),
        ..Head::EMPTY
    };
    let refused = snapshot(&journal, other, "no such decision").await;
    assert!(
        matches!(
            refused,
            Err(AppendError::Refused(Refusal::NotCovered { .. }))
        ),
        "{refused:?}"
    );
    let last = keep(&journal, 3, decided(11)).await;
    snapshot(&journal, last, "eleven").await.unwrap();
    journal.close().await;
    let journal = open(&path).await;
    let Some(Kept::Whole(kept)) = journal.snapshot("c1").await.unwrap() else {
        panic!("it is there");
    };
    assert_eq!((kept.body.as_str(), kept.taken.covers), ("eleven", last));
    assert_eq!(journal.snapshot("c2").await.unwrap(), None);
    journal.close().await;
    assert_eq!(verify(&path, None).await.unwrap().snapshots, 1);
}

#[tokio::test]
async fn r6_an_edited_snapshot_is_noticed_by_a_start_and_by_verify() {
    let (_directory, path) = directory();
    let journal = open(&path).await;
    history(&journal).await;
    journal.close().await;
    edit(&path, "UPDATE snapshots SET body = 'eight'").await;
    let journal = open(&path).await;
    let kept = journal.snapshot("c1").await.unwrap();
    assert!(matches!(kept, Some(Kept::Damaged { .. })), "{kept:?}");
    journal.close().await;
    let found = verify(&path, None).await;
    assert!(
        matches!(found, Err(VerifyError::Snapshot { .. })),
        "{found:?}"
    );
}

/// What a caller, a doubt or a start still needs stays; everything else goes, and the rest holds.
#[tokio::test]
async fn r6_only_what_nobody_needs_is_removed() {
    let (_directory, path) = directory();
    let journal = open(&path).await;
    for n in 1..=3 {
        let _head = keep(&journal, 1, decided(n)).await;
    }
    // Without a snapshot the first decision is needed.
    let pruned = journal.prune(at(2), ALL, None).await.unwrap();
    assert_eq!((pruned.base.position, pruned.removed), (Position(1), 1));
    let covers = keep(&journal, 3, decided(4)).await;
    snapshot(&journal, covers, "four").await.unwrap();
    // A doubt, begun before what follows.
    let doubt = intent(journal.epoch(), 1, None);
    let _begun = journal.begin_motion(at(3), doubt).await.unwrap();
    let _head = keep(&journal, 3, outcome(1, in_doubt())).await;
    let doubt_at = journal.motion(motion(1)).await.unwrap().unwrap();
    let first = doubt_at.intent.position;
    // Behind the snapshot nothing was decided; the doubt stays, and so does what the snapshot stands on.
    let pruned = journal.prune(at(4), ALL, None).await.unwrap();
    assert_eq!(pruned.base.position.next(), first);
    assert!(covers.position < first);
    assert!(journal.motion(motion(1)).await.unwrap().is_some());
    // Once it is decided a key holds what stands behind it, for as long as it may be used.
    let keyed = intent(journal.epoch(), 2, Some(claim("k1", "body")));
    let _begun = journal.begin_motion(at(5), keyed).await.unwrap();
    for n in [1, 2] {
        let _head = keep(&journal, 5, outcome(n, not_sent())).await;
    }
    let covers = keep(&journal, 5, decided(6)).await;
    snapshot(&journal, covers, "six").await.unwrap();
    let pruned = journal.prune(at(6), ALL, None).await.unwrap();
    let now = at(6);
    let replay = journal.lookup(&claim("k1", "body"), now).await.unwrap();
    assert_eq!(
        replay.unwrap().first.position,
        pruned.base.position.next(),
        "the key's record is the first one left"
    );
    let last = journal.head();
    let pruned = journal.prune(at(106), ALL, None).await.unwrap();
    assert_eq!(pruned.base.position.next(), last.position);
    assert!(covers.position < pruned.base.position);
    let Some(Kept::Whole(kept)) = journal.snapshot("c1").await.unwrap() else {
        panic!("it is told of again behind what was removed");
    };
    assert_eq!((kept.body.as_str(), kept.taken.covers), ("six", covers));
    assert!(kept.position > last.position);
    let covers = pruned.base;
    assert_eq!(journal.motion(motion(2)).await.unwrap(), None);
    let late = journal.page(Position(1), 1).await.unwrap();
    assert_eq!(late[0].position, covers.position.next());
    journal.close().await;
    let report = verify(&path, None).await.unwrap();
    assert_eq!(report.base, covers);
    // And the next process goes on behind it.
    let journal = open(&path).await;
    let _head = keep(&journal, 107, decided(7)).await;
    journal.close().await;
    assert_eq!(verify(&path, None).await.unwrap().base, covers);
}

/// The cut goes through motions that had begun before and ended behind; cells that always move have no better place.
#[tokio::test]
async fn r6_a_cut_through_a_motion_leaves_the_rest_provable() {
    let (directory, path) = directory();
    let journal = open(&path).await;
    for n in 1..=4 {
        let intent = intent(journal.epoch(), n, None);
        let _begun = journal.begin_motion(at(1), intent).await.unwrap();
    }
    let _head = keep(&journal, 1, accepted(1, Completion::Observable)).await;
    let _head = keep(&journal, 1, outcome(3, in_doubt())).await;
    let cut = journal.head();
    for n in 1..=4 {
        let _head = keep(&journal, 2, outcome(n, not_sent())).await;
    }
    let pruned = journal.prune(at(3), cut.position, None).await.unwrap();
    assert_eq!(pruned.base, cut);
    for n in 1..=4 {
        assert_eq!(journal.motion(motion(n)).await.unwrap(), None);
    }
    assert!(journal.latest_motions(ALL, 10).await.unwrap().is_empty());
    let again = intent(journal.epoch(), 1, None);
    let refused = journal.begin_motion(at(3), again).await;
    assert!(matches!(
        refused,
        Err(AppendError::Refused(Refusal::MotionExists { .. }))
    ));
    journal.close().await;
    let report = verify(&path, None).await.unwrap();
    assert_eq!((report.base, report.open_motions), (cut, 0));
    let mut lines = Vec::new();
    let _head = export(&path, &mut lines).await.unwrap();
    let copy = directory.path().join("copy");
    let _head = import(&copy, &mut Cursor::new(&lines)).await.unwrap();
    assert_eq!(verify(&copy, None).await.unwrap().base, cut);
}

/// What was written out before is proved to be what stood there; together it is the whole chain.
#[tokio::test]
async fn r6_an_archive_and_the_rest_are_one_chain() {
    let (_directory, path) = directory();
    let journal = open(&path).await;
    history(&journal).await;
    let through = journal.retained(at(5)).await.unwrap().removable;
    let rows = journal.rows(Position::START, 1_000).await.unwrap();
    let archive: String = rows
        .iter()
        .filter(|row| row.position <= through)
        .map(|row| write_line(row).unwrap() + "\n")
        .collect();
    let pruned = journal.prune(at(5), through, None).await.unwrap();
    assert_eq!(pruned.base.position, Position(8), "the seventh decision");
    journal.close().await;
    let report = verify(&path, None).await.unwrap();
    let (one, two) = archive.split_at(archive.find('\n').unwrap() + 1);
    let proved = verify_archives([Cursor::new(one), Cursor::new(two)]).unwrap();
    assert_eq!(proved, report.base);
    let edited = archive.replace("[3]", "[4]");
    assert!(verify_archives([Cursor::new(edited)]).is_err());
}

#[tokio::test]
async fn r6_a_beginning_that_was_cut_off_by_hand_is_noticed() {
    for (statement, opens) in [
        // As much as a hasty hand removes.
        ("DELETE FROM records WHERE position = 9", false),
        ("DELETE FROM base", false),
        ("UPDATE base SET hash = zeroblob(32)", false),
        // With the place changed accordingly only the record that tells of it differs.
        (
            "UPDATE base SET position = 9, hash = (SELECT hash FROM records WHERE position = 9); \
             DELETE FROM records WHERE position <= 9; DELETE FROM decided WHERE position <= 9",
            true,
        ),
        ("DELETE FROM snapshots", true),
    ] {
        let (_directory, path) = directory();
        let journal = open(&path).await;
        history(&journal).await;
        let pruned = journal.prune(at(5), ALL, None).await.unwrap();
        assert_eq!(pruned.base.position, Position(8));
        journal.close().await;
        edit(&path, statement).await;
        assert!(verify(&path, None).await.is_err(), "{statement}");
        let opened = SqliteJournal::open(&path, &opening(), &options()).await;
        assert_eq!(opened.is_ok(), opens, "{statement}");
        if let Ok(journal) = opened {
            journal.close().await;
        } else {
            assert!(matches!(opened, Err(OpenError::Broken(_))), "{statement}");
        }
    }
}

/// The removal and its record are one: after a power loss at it either both are there or neither is.
#[tokio::test]
async fn r6_a_power_loss_at_a_snapshot_or_a_removal_leaves_one_or_the_other_state() {
    for fault in [Fault::PowerLossBefore, Fault::PowerLossAfter] {
        for kind in ["snapshot_taken", "pruned"] {
            let disk = MemoryDisk::new();
            let journal = MemoryJournal::open(&disk, &opening()).unwrap();
            for n in 1..=3 {
                let _head = keep(&journal, 1, decided(n)).await;
            }
            let first = journal.head();
            snapshot(&journal, first, "three").await.unwrap();
            let covers = keep(&journal, 1, decided(4)).await;
            disk.fail_next(kind, fault);
            let second = snapshot(&journal, covers, "four").await;
            let pruned = journal.prune(at(5), ALL, None).await;
            assert!(second.is_err() || pruned.is_err());
            drop(journal);
            let journal = MemoryJournal::open(&disk, &opening()).unwrap();
            let Some(Kept::Whole(kept)) = journal.snapshot("c1").await.unwrap() else {
                panic!("one of the two is there");
            };
            let happened = fault == Fault::PowerLossAfter;
            let newest = kind == "pruned" || happened;
            assert_eq!(kept.body, if newest { "four" } else { "three" });
            let base = journal.retained(at(5)).await.unwrap().base;
            let removed = kind == "pruned" && happened;
            assert_eq!(base, if removed { covers } else { Head::EMPTY });
            // What is behind the snapshot is there in any case.
            let behind = kept.taken.covers.position;
            let rest = journal.decided("c1", behind, 10).await.unwrap();
            assert_eq!(rest.len(), usize::from(!newest));
        }
    }
}

/// A journal of which nothing was removed opens with a program that knows of no removals; afterwards it says why not.
#[tokio::test]
async fn r6_removing_raises_the_version_of_the_file_and_only_that() {
    let (_directory, path) = directory();
    let version = async || {
        let options = sqlx::sqlite::SqliteConnectOptions::new().filename(&path);
        let mut connection = options.connect().await.unwrap();
        let version: i64 = sqlx::query_scalar("PRAGMA user_version")
            .fetch_one(&mut connection)
            .await
            .unwrap();
        connection.close().await.unwrap();
        version
    };
    let journal = open(&path).await;
    history(&journal).await;
    journal.close().await;
    assert_eq!(version().await, 1);
    let journal = open(&path).await;
    let _pruned = journal.prune(at(5), ALL, None).await.unwrap();
    journal.close().await;
    assert_eq!(version().await, 2);
}

#[tokio::test]
async fn r6_many_records_go_in_steps() {
    let (_directory, path) = directory();
    let journal = open(&path).await;
    let appends = (0..2_500).map(|n| journal.append(at(1), audit(n)));
    // Not more at once than may wait.
    for append in appends {
        let _kept = append.await.unwrap();
    }
    let mut steps = Vec::new();
    loop {
        let pruned = journal.prune(at(2), ALL.max(Position(2_400)), None).await;
        let removed = pruned.unwrap().removed;
        if removed == 0 {
            break;
        }
        steps.push(removed);
    }
    assert_eq!(steps, [1_000, 1_000, 400]);
    let gone = journal.page(Position::START, 1).await.unwrap();
    assert_eq!(gone[0].position, Position(2_401));
    let absent = journal.decided("c1", Position::START, 0).await;
    assert!(matches!(absent, Err(ReadError::Limit { .. })));
    journal.close().await;
    assert!(verify(&path, None).await.is_ok());
}
