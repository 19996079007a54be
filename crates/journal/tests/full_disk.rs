//! A real "disk full": SQLite's own limit on the number of pages.
#![allow(
    clippy::unwrap_used,
    clippy::indexing_slicing,
    reason = "a test's helpers fail as its tests do"
)]

mod common;

use common::{at, audit, directory, open, opening, options};
use journal::{
    AppendError, Effect, Journal, Position, Record, SqliteJournal, SqliteOptions, verify,
};

fn long(n: u64) -> Record {
    let Record::Audit(mut audit) = audit(n) else {
        unreachable!("an audit record")
    };
    audit.after = Some("x".repeat(4_000));
    Record::Audit(audit)
}

/// Covers: D1.
#[tokio::test]
async fn a_full_disk_stops_the_journal_and_leaves_nothing_half_written() {
    let (_directory, path) = directory();
    let small = SqliteOptions {
        max_pages: Some(40),
        ..options()
    };
    let journal = SqliteJournal::open(&path, &opening(), &small)
        .await
        .unwrap();
    let mut confirmed = journal.head();
    let error = loop {
        match journal.append(at(1), long(1)).await {
            Ok(_) => confirmed = journal.head(),
            Err(error) => break error,
        }
    };
    assert!(confirmed.position > Position(10));
    assert!(matches!(
        &error,
        AppendError::Failed {
            effect: Effect::None,
            ..
        }
    ));
    // Even what would still fit is refused: until it is read again, no one knows what is on the disk.
    let after = journal.append(at(2), audit(2)).await.unwrap_err();
    assert!(matches!(after, AppendError::Poisoned(_)));
    assert_eq!(journal.head(), confirmed);
    let page = journal.page(confirmed.position, 10).await.unwrap();
    assert_eq!(page, []);
    journal.close().await;

    let report = verify(&path, Some(confirmed)).await.unwrap();
    assert_eq!(report.head, confirmed);
    let journal = open(&path).await;
    assert!(journal.append(at(3), long(3)).await.is_ok());
}

#[tokio::test]
async fn everyone_in_a_failed_group_hears_of_it() {
    let (_directory, path) = directory();
    let small = SqliteOptions {
        max_pages: Some(40),
        ..options()
    };
    let journal = SqliteJournal::open(&path, &opening(), &small)
        .await
        .unwrap();
    let journal = std::sync::Arc::new(journal);
    let appends: Vec<_> = (0..100)
        .map(|n| {
            let journal = std::sync::Arc::clone(&journal);
            tokio::spawn(async move { journal.append(at(n), long(n)).await })
        })
        .collect();
    let mut confirmed = 0;
    let mut failed = 0;
    for append in appends {
        match append.await.unwrap() {
            Ok(_) => confirmed += 1,
            Err(error) => {
                assert!(error.is_fatal());
                assert_eq!(error.effect(), Effect::None);
                failed += 1;
            }
        }
    }
    assert!(failed > 0);
    assert_eq!(journal.head().position, Position(confirmed + 1));
}

#[tokio::test]
async fn a_record_that_is_too_long_is_refused_alone() {
    let (_directory, path) = directory();
    let journal = open(&path).await;
    let Record::Audit(mut audit) = audit(1) else {
        unreachable!("an audit record")
    };
    audit.after = Some("x".repeat(journal::MAX_BODY));
    let error = journal.append(at(1), Record::Audit(audit)).await;
    assert!(matches!(error, Err(AppendError::Refused(_))));
    assert!(journal.append(at(2), long(2)).await.is_ok());
}
