//! Whatever is changed in a journal is noticed.
#![allow(
    clippy::unwrap_used,
    clippy::indexing_slicing,
    reason = "a test's helpers fail as its tests do"
)]

mod common;

use common::{at, audit, claim, directory, intent, job_created, not_sent, open, outcome};
use journal::{
    Broken, Head, Journal, LineError, Position, Row, VerifyError, Walker, export, read_line, verify,
};
use sqlx::ConnectOptions as _;
use sqlx::sqlite::SqliteConnectOptions;

const RECORDS: u64 = 1_000;

/// A journal of 1,000 records of several kinds, closed.
async fn thousand(path: &std::path::Path) -> Head {
    let journal = open(path).await;
    for n in 1.. {
        let key = claim(&format!("k{n}"), "body");
        let begun = journal.begin_motion(at(n), intent(journal.epoch(), n.into(), Some(key)));
        let _begun = begun.await.unwrap();
        for record in [
            outcome(n.into(), not_sent()),
            audit(n),
            job_created(n.into(), None),
        ] {
            let _receipt = journal.append(at(n), record).await.unwrap();
            if journal.head().position == Position(RECORDS) {
                let head = journal.head();
                journal.close().await;
                return head;
            }
        }
    }
    unreachable!("the loop returns")
}

async fn lines(path: &std::path::Path) -> Vec<u8> {
    let mut lines = Vec::new();
    let _head = export(path, &mut lines).await.unwrap();
    lines
}

/// Behind `before`, does the line hold?
fn holds(before: Head, line: &[u8]) -> bool {
    let check = || {
        let row = read_line(line, 1)?;
        Walker::new(before)
            .step(&row)
            .map_err(|source| LineError::Broken { line: 1, source })
    };
    check().is_ok()
}

/// Covers: D4.
#[tokio::test]
async fn every_flipped_byte_of_a_thousand_records_is_noticed() {
    let (_directory, path) = directory();
    let head = thousand(&path).await;
    let lines = lines(&path).await;
    let mut before = Head::EMPTY;
    let mut mask = 0_u8;
    let mut flips = 0;
    for line in lines
        .split(|byte| *byte == b'\n')
        .filter(|line| !line.is_empty())
    {
        assert!(holds(before, line));
        let mut changed = line.to_vec();
        for place in 0..changed.len() {
            // Each mask from 1 to 255 in turn: single bits, letter cases, line ends, other digits.
            mask = mask % 255 + 1;
            changed[place] ^= mask;
            assert!(
                !holds(before, &changed),
                "{} at byte {place}",
                String::from_utf8_lossy(&changed)
            );
            changed[place] ^= mask;
            flips += 1;
        }
        let row = read_line(line, 1).unwrap();
        before = Head {
            position: row.position,
            hash: row.hash,
        };
    }
    assert_eq!(before, head);
    assert!(flips > 300_000, "{flips}");
}

#[tokio::test]
async fn a_flipped_byte_of_the_file_is_noticed_or_changes_no_record() {
    let (directory, path) = directory();
    let head = thousand(&path).await;
    let lines = lines(&path).await;
    let bytes = std::fs::read(&path).unwrap();
    let copy = directory.path().join("copy");
    let mut noticed = 0;
    // An odd step, so that the places fall on all parts of a page.
    let places: Vec<_> = (0..bytes.len()).step_by((bytes.len() / 150) | 1).collect();
    for place in &places {
        let mut changed = bytes.clone();
        changed[*place] ^= 0x10;
        std::fs::write(&copy, &changed).unwrap();
        if verify(&copy, Some(head)).await.is_err() {
            noticed += 1;
        } else {
            // Free space, or a counter of SQLite's.
            let mut same = Vec::new();
            let _head = export(&copy, &mut same).await.unwrap();
            assert!(same == lines, "byte {place}");
        }
    }
    assert!(noticed * 2 > places.len(), "{noticed} of {}", places.len());
}

async fn tamper(path: &std::path::Path, sql: &'static str) {
    let mut connection = SqliteConnectOptions::new()
        .filename(path)
        .connect()
        .await
        .unwrap();
    let _done = sqlx::raw_sql(sql).execute(&mut connection).await.unwrap();
    sqlx::Connection::close(connection).await.unwrap();
}

async fn verdict(sql: &'static str) -> VerifyError {
    let (_directory, path) = directory();
    let journal = open(&path).await;
    for n in 1..=3 {
        let key = Some(claim(&format!("k{n}"), "body"));
        let begun = journal.begin_motion(at(1), intent(journal.epoch(), n, key));
        let _begun = begun.await.unwrap();
        let _receipt = journal.append(at(1), job_created(n, None)).await.unwrap();
    }
    let head = journal.head();
    journal.close().await;
    assert!(verify(&path, Some(head)).await.is_ok());
    tamper(&path, sql).await;
    verify(&path, Some(head)).await.unwrap_err()
}

/// Covers: X17.
#[tokio::test]
async fn a_changed_moved_or_missing_record_is_named() {
    let error = verdict("UPDATE records SET body = replace(body, 'r1', 'r2') WHERE position = 4");
    assert!(matches!(
        error.await,
        VerifyError::Broken(Broken::WrongHash {
            position: Position(4)
        })
    ));
    let error = verdict("DELETE FROM records WHERE position = 3").await;
    assert!(matches!(
        error,
        VerifyError::Broken(Broken::Missing {
            expected: Position(3),
            found: Position(4)
        })
    ));
    let error = verdict("UPDATE records SET previous = zeroblob(32) WHERE position = 5").await;
    assert!(matches!(
        error,
        VerifyError::Broken(Broken::WrongPrevious {
            position: Position(5)
        })
    ));
}

#[tokio::test]
async fn an_end_cut_off_together_with_its_head_is_known_by_the_head_kept_elsewhere() {
    let error = verdict(
        "DELETE FROM records WHERE position > 6; DELETE FROM jobs WHERE created > 6; \
         UPDATE head SET position = 6, hash = (SELECT hash FROM records WHERE position = 6)",
    );
    assert!(matches!(
        error.await,
        VerifyError::Broken(Broken::Truncated {
            expected: Position(7),
            found: Position(6)
        })
    ));
}

#[tokio::test]
async fn tables_that_are_not_what_the_records_amount_to_are_named() {
    for (sql, name) in [
        ("UPDATE motions SET phase = 'closed'", "motions"),
        ("DELETE FROM motions WHERE intent = 2", "motions"),
        ("DELETE FROM keys WHERE key = 'k2'", "keys"),
        ("UPDATE jobs SET ended = 3", "jobs"),
        ("UPDATE head SET epoch = 0", "head"),
    ] {
        let error = verdict(sql).await;
        assert!(
            matches!(error, VerifyError::Index { table } if table == name),
            "{sql}: {error:?}"
        );
    }
}

/// Covers: D3, D4.
#[tokio::test]
async fn a_damaged_end_is_refused_at_the_opening() {
    for sql in [
        "UPDATE records SET body = replace(body, 'anna', 'otto') WHERE position = 3",
        "DELETE FROM records WHERE position = 4",
        "UPDATE head SET position = 3, hash = (SELECT hash FROM records WHERE position = 3)",
    ] {
        let (_directory, path) = directory();
        let journal = open(&path).await;
        for n in 1..=3 {
            let _receipt = journal.append(at(1), audit(n)).await.unwrap();
        }
        journal.close().await;
        tamper(&path, sql).await;
        let opened =
            journal::SqliteJournal::open(&path, &common::opening(), &common::options()).await;
        let error = opened.unwrap_err();
        assert!(
            matches!(error, journal::OpenError::Broken(_)),
            "{sql}: {error:?}"
        );
    }
}

#[test]
fn a_row_that_is_not_json_is_not_written_out() {
    let row = Row {
        position: Position(1),
        previous: journal::Digest::ZERO,
        body: b"{}}".to_vec(),
        hash: journal::Digest::ZERO,
    };
    assert!(journal::write_line(&row).is_err());
}
