//! Who may open a journal, and what is found in it afterwards.
#![allow(
    clippy::unwrap_used,
    clippy::indexing_slicing,
    reason = "a test's helpers fail as its tests do"
)]

mod common;

use common::{
    accepted, at, audit, directory, in_doubt, intent, job, job_created, job_ended, motion,
    not_sent, open, opening, options, outcome,
};
use journal::{
    AppendError, Completion, Epoch, Filesystem, History, Journal, MotionPhase, OpenError, Position,
    ReadError, Record, Refusal, SqliteJournal, SqliteOptions, verify,
};

/// Covers: D8.
#[tokio::test]
async fn a_second_process_is_told_that_the_journal_is_in_use() {
    let (_directory, path) = directory();
    let first = open(&path).await;
    let error = SqliteJournal::open(&path, &opening(), &options())
        .await
        .unwrap_err();
    assert!(matches!(error, OpenError::InUse { .. }));
    assert!(error.to_string().ends_with("is in use by another process"));
    first.close().await;
    assert_eq!(open(&path).await.epoch(), Epoch(2));
}

#[tokio::test]
async fn each_opening_is_a_new_epoch_and_its_first_record() {
    let (_directory, path) = directory();
    for epoch in 1..=3 {
        let journal = open(&path).await;
        assert_eq!(journal.epoch(), Epoch(epoch));
        let records = journal.page(Position(epoch - 1), 10).await.unwrap();
        let [record] = &records[..] else {
            panic!("{records:?}")
        };
        assert!(matches!(&record.record, Record::ServerStarted(started)
            if started.epoch == Epoch(epoch) && started.program == "test"));
        journal.close().await;
    }
}

#[tokio::test]
async fn what_the_last_process_left_behind_is_listed_page_by_page() {
    let (_directory, path) = directory();
    let journal = open(&path).await;
    let epoch = journal.epoch();
    for n in 1..=5 {
        let _begun = journal.begin_motion(at(1), intent(epoch, n, None)).await;
    }
    let done = [
        outcome(1, not_sent()),
        accepted(2, Completion::NotObservable),
        accepted(3, Completion::Observable),
        outcome(4, in_doubt()),
        job_created(1, None),
        job_created(2, None),
        job_ended(1),
    ];
    for record in done {
        let _receipt = journal.append(at(2), record).await.unwrap();
    }
    journal.close().await;

    let journal = open(&path).await;
    let left = [MotionPhase::Open, MotionPhase::Accepted];
    let first = journal.motions(&left, Position::START, 1).await.unwrap();
    assert_eq!(
        (first[0].motion, first[0].phase),
        (motion(3), MotionPhase::Accepted)
    );
    let second = journal.motions(&left, first[0].intent, 9).await.unwrap();
    assert_eq!(second.len(), 1);
    assert_eq!(
        (second[0].motion, second[0].phase),
        (motion(5), MotionPhase::Open)
    );
    let doubts = [MotionPhase::InDoubt];
    let doubts = journal.motions(&doubts, Position::START, 9).await.unwrap();
    assert_eq!(doubts.len(), 1);
    let story = journal.motion(motion(4)).await.unwrap().unwrap();
    assert_eq!(story.intent.epoch, Epoch(1));
    assert_eq!(story.outcome.unwrap().record, outcome(4, in_doubt()));
    let jobs = journal.open_jobs(Position::START, 9).await.unwrap();
    assert_eq!(jobs.iter().map(|job| job.job).collect::<Vec<_>>(), [job(2)]);
    let closed = [MotionPhase::Closed];
    let closed = journal.motions(&closed, Position::START, 9).await.unwrap();
    assert_eq!(closed.len(), 2);
}

#[tokio::test]
async fn a_motion_of_another_epoch_is_refused_and_the_journal_goes_on() {
    let (_directory, path) = directory();
    let journal = open(&path).await;
    let old = intent(Epoch(7), 1, None);
    let error = journal.begin_motion(at(1), old).await.unwrap_err();
    assert!(!error.is_fatal());
    assert!(matches!(
        error,
        AppendError::Refused(Refusal::WrongEpoch {
            found: Epoch(7),
            epoch: Epoch(1)
        })
    ));
    assert!(journal.append(at(1), audit(1)).await.is_ok());
}

/// Covers: D5.
#[tokio::test]
async fn an_older_journal_in_the_place_of_a_newer_one_is_noticed() {
    let (directory, path) = directory();
    open(&path).await.close().await;
    let backup = directory.path().join("backup");
    let _bytes = std::fs::copy(&path, &backup).unwrap();
    open(&path).await.close().await;
    let _bytes = std::fs::copy(&backup, &path).unwrap();
    let error = SqliteJournal::open(&path, &opening(), &options())
        .await
        .unwrap_err();
    assert!(matches!(
        error,
        OpenError::RolledBack {
            found: Epoch(1),
            known: Epoch(2),
            ..
        }
    ));
    let restored = SqliteOptions {
        history: History::Restored,
        ..options()
    };
    let journal = SqliteJournal::open(&path, &opening(), &restored).await;
    assert_eq!(journal.unwrap().epoch(), Epoch(3));
}

/// Covers: D5.
#[tokio::test]
async fn a_deleted_journal_is_noticed() {
    let (_directory, path) = directory();
    open(&path).await.close().await;
    std::fs::remove_file(&path).unwrap();
    let error = SqliteJournal::open(&path, &opening(), &options()).await;
    assert!(matches!(error, Err(OpenError::RolledBack { .. })));
}

#[tokio::test]
async fn a_file_of_something_else_is_left_alone() {
    let (_directory, path) = directory();
    std::fs::write(&path, "a letter to grandmother, of more than one hundred bytes, because a shorter file might be taken for an empty one").unwrap();
    let before = std::fs::read(&path).unwrap();
    assert!(
        SqliteJournal::open(&path, &opening(), &options())
            .await
            .is_err()
    );
    assert_eq!(std::fs::read(&path).unwrap(), before);
}

#[cfg(target_os = "linux")]
#[tokio::test]
async fn a_directory_in_memory_is_refused() {
    let shared_memory = std::path::Path::new("/dev/shm");
    let Ok(directory) = tempfile::tempdir_in(shared_memory) else {
        return;
    };
    let checked = SqliteOptions {
        filesystem: Filesystem::Checked,
        ..options()
    };
    let path = directory.path().join("cell.journal");
    let error = SqliteJournal::open(&path, &opening(), &checked).await;
    assert!(matches!(error, Err(OpenError::Volatile { kind, .. }) if kind == "tmpfs"));
}

#[tokio::test]
async fn a_page_has_a_limit_and_the_journal_can_be_checked_while_it_is_open() {
    let (_directory, path) = directory();
    let journal = open(&path).await;
    for n in 0..10 {
        let _receipt = journal.append(at(n), audit(n)).await.unwrap();
    }
    for limit in [0, 1_001] {
        let error = journal.page(Position::START, limit).await;
        assert!(matches!(error, Err(ReadError::Limit { .. })));
    }
    let page = journal.page(Position(3), 4).await.unwrap();
    let places: Vec<_> = page.iter().map(|record| record.position.0).collect();
    assert_eq!(places, [4, 5, 6, 7]);
    let report = verify(&path, Some(journal.head())).await.unwrap();
    assert_eq!(report.head, journal.head());
}

#[tokio::test]
async fn a_journal_that_is_being_written_holds_at_every_moment() {
    let (_directory, path) = directory();
    let journal = open(&path).await;
    let epoch = journal.epoch();
    let write = async {
        for n in 1..=100 {
            let begun = journal.begin_motion(at(1), intent(epoch, n, None)).await;
            assert!(begun.is_ok());
        }
    };
    let check = async {
        for _ in 0..10 {
            let known = journal.head();
            let report = verify(&path, Some(known)).await.unwrap();
            assert!(report.head.position >= known.position);
        }
    };
    let ((), ()) = tokio::join!(write, check);
}

/// Covers: R3.
#[tokio::test]
async fn a_full_queue_is_said_at_once_and_the_journal_goes_on() {
    let (_directory, path) = directory();
    let narrow = SqliteOptions {
        queue: 1,
        ..options()
    };
    let journal = SqliteJournal::open(&path, &opening(), &narrow)
        .await
        .unwrap();
    // The writer runs on the same thread, so it has not taken the first when the second comes.
    let (first, second) = tokio::join!(
        journal.append(at(1), audit(1)),
        journal.append(at(1), audit(2))
    );
    assert!(first.is_ok());
    assert!(matches!(second, Err(AppendError::Busy { capacity: 1 })));
    assert!(journal.append(at(2), audit(2)).await.is_ok());
}
