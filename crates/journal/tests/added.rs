//! What was added to version 1: decisions of cells, the newest motions, and a disk that forgets.
#![allow(
    clippy::unwrap_used,
    clippy::indexing_slicing,
    reason = "a test's helpers fail as its tests do"
)]

mod common;

use common::{at, audit, claim, directory, in_doubt, intent, motion, open, opening, outcome};
use journal::{
    Appended, CellDecided, End, Journal, MemoryDisk, MemoryJournal, MotionPhase, Position, Record,
    SqliteJournal, export, import, verify,
};
use sqlx::{ConnectOptions as _, Connection as _};

fn decided(cell: &str, n: u64) -> Record {
    Record::CellDecided(CellDecided {
        cell: cell.into(),
        facts: format!("[{n}]"),
        claim: None,
    })
}

fn asked(n: u64, key: &str, body: &str) -> Record {
    Record::CellDecided(CellDecided {
        cell: "c1".into(),
        facts: format!("[{n}]"),
        claim: Some(claim(key, body)),
    })
}

/// Records of two cells and others among them; the facts of `c1` come back alone and in order, page by page.
async fn decisions_are_paged(journal: &impl Journal) {
    for n in 0..10 {
        for record in [decided("c1", n), audit(n), decided("c2", n)] {
            let _new = journal.append(at(n), record).await.unwrap();
        }
    }
    let mut after = Position::START;
    let mut facts = Vec::new();
    loop {
        let page = journal.decided("c1", after, 3).await.unwrap();
        let Some(last) = page.last() else { break };
        after = last.position;
        facts.extend(page.into_iter().map(|stored| stored.record));
    }
    let expected: Vec<_> = (0..10).map(|n| decided("c1", n)).collect();
    assert_eq!(facts, expected);
}

/// The newest motions come first, and those behind the last page follow.
async fn the_newest_motions_come_first(journal: &impl Journal) {
    for n in 1..=5 {
        let intent = intent(journal.epoch(), n, None);
        let _begun = journal.begin_motion(at(1), intent).await.unwrap();
    }
    let ends = Position(u64::from(u32::MAX));
    let page = journal.latest_motions(ends, 3).await.unwrap();
    let ids: Vec<_> = page.iter().map(|entry| entry.motion).collect();
    assert_eq!(ids, [motion(5), motion(4), motion(3)]);
    let rest = journal.latest_motions(page[2].intent, 3).await.unwrap();
    let ids: Vec<_> = rest.iter().map(|entry| entry.motion).collect();
    assert_eq!(ids, [motion(2), motion(1)]);
}

#[tokio::test]
async fn both_stores_page_decisions_and_the_newest_motions() {
    let disk = MemoryDisk::new();
    let memory = MemoryJournal::open(&disk, &opening()).unwrap();
    decisions_are_paged(&memory).await;
    the_newest_motions_come_first(&memory).await;
    let (_directory, path) = directory();
    let sqlite = open(&path).await;
    decisions_are_paged(&sqlite).await;
    the_newest_motions_come_first(&sqlite).await;
    let head = sqlite.head();
    sqlite.close().await;
    assert_eq!(verify(&path, Some(head)).await.unwrap().head, head);
    // They survive being written out and read in.
    let mut lines = Vec::new();
    let _head = export(&path, &mut lines).await.unwrap();
    let (_other, copy) = directory();
    assert_eq!(import(&copy, &mut &lines[..]).await.unwrap(), head);
    assert_eq!(verify(&copy, None).await.unwrap().head, head);
}

async fn run(path: &std::path::Path, sql: &'static str) {
    let mut file = sqlx::sqlite::SqliteConnectOptions::new()
        .filename(path)
        .connect()
        .await
        .unwrap();
    let _done = sqlx::raw_sql(sql).execute(&mut file).await.unwrap();
    file.close().await.unwrap();
}

#[tokio::test]
async fn a_journal_from_before_the_decisions_is_verified_and_opened() {
    let (_directory, path) = directory();
    open(&path).await.close().await;
    run(&path, "DROP TABLE decided").await;
    assert_eq!(verify(&path, None).await.unwrap().head.position.0, 1);
    let journal = open(&path).await;
    let _new = journal.append(at(1), decided("c1", 1)).await.unwrap();
    journal.close().await;
    assert_eq!(verify(&path, None).await.unwrap().head.position.0, 3);
    // The table is checked like the others.
    run(&path, "DELETE FROM decided").await;
    let error = verify(&path, None).await.unwrap_err();
    assert!(error.to_string().contains("`decided`"), "{error}");
}

#[tokio::test]
async fn a_motion_that_was_interrupted_is_at_its_end() {
    let disk = MemoryDisk::new();
    let journal = MemoryJournal::open(&disk, &opening()).unwrap();
    let intent = intent(journal.epoch(), 1, None);
    let _begun = journal.begin_motion(at(1), intent).await.unwrap();
    let end = End::Interrupted {
        reason: "stopped".into(),
        seen: None,
    };
    let _new = journal.append(at(2), outcome(1, end)).await.unwrap();
    let story = journal.motion(motion(1)).await.unwrap().unwrap();
    assert_eq!(story.phase, MotionPhase::Closed);
    assert!(journal.append(at(3), outcome(1, in_doubt())).await.is_err());
}

#[tokio::test]
async fn a_forgetful_disk_stays_small_and_remembers_what_is_open() {
    let disk = MemoryDisk::forgetful(20);
    let journal = MemoryJournal::open(&disk, &opening()).unwrap();
    for n in 1..=100 {
        let claim = (n % 7 == 0).then(|| claim(&format!("k{n}"), "body"));
        let intent = intent(journal.epoch(), n, claim);
        let _begun = journal.begin_motion(at(1), intent).await.unwrap();
        let end = if n == 3 {
            in_doubt()
        } else {
            End::Rejected { text: "no".into() }
        };
        let _new = journal.append(at(1), outcome(n, end)).await.unwrap();
    }
    assert!(disk.rows().len() < 40, "{}", disk.rows().len());
    assert_eq!(journal.head().position, Position(201));
    let doubts = [MotionPhase::InDoubt];
    let doubts = journal.motions(&doubts, Position::START, 9).await.unwrap();
    assert_eq!(doubts.len(), 1);
    assert!(journal.motion(motion(50)).await.unwrap().is_none());
    assert!(journal.motion(motion(100)).await.unwrap().is_some());
    let page = journal.page(Position(199), 9).await.unwrap();
    assert_eq!(page.first().unwrap().position, Position(200));
    assert_eq!(
        journal.page(Position::START, 1_000).await.unwrap().len(),
        disk.rows().len()
    );
    // What is left is a chain, and the next opening goes on with it.
    drop(journal);
    let again = MemoryJournal::open(&disk, &opening()).unwrap();
    assert_eq!(again.epoch().0, 2);
}

/// The head of an [`SqliteJournal`] is what it says, whatever was added.
#[tokio::test]
async fn decisions_come_back_after_an_opening() {
    let (_directory, path) = directory();
    let journal: SqliteJournal = open(&path).await;
    let _new = journal.append(at(1), decided("c1", 1)).await.unwrap();
    journal.close().await;
    let journal = open(&path).await;
    let page = journal.decided("c1", Position::START, 9).await.unwrap();
    assert_eq!(page.len(), 1);
}

/// A request that led to a decision leads to the same one again, and to no other; whatever store it is in.
async fn a_decision_is_found_by_its_key(journal: &impl Journal, first: u64) {
    let record = asked(first, "k1", "body");
    assert!(matches!(
        journal.append(at(1), record.clone()).await.unwrap(),
        Appended::New(_)
    ));
    let again = journal.append(at(2), asked(first + 1, "k1", "body")).await;
    let Appended::Replayed(replay) = again.unwrap() else {
        panic!("it was kept twice");
    };
    assert_eq!(replay.first.record, record);
    let found = journal.lookup(&claim("k1", "body"), at(2)).await.unwrap();
    assert_eq!(found.unwrap().first.record, record);
    let other = journal.append(at(3), asked(first, "k1", "another")).await;
    assert!(other.is_err());
    assert_eq!(
        journal
            .decided("c1", Position::START, 9)
            .await
            .unwrap()
            .len(),
        1
    );
}

/// Covers: H6.
#[tokio::test]
async fn the_key_of_a_decision_is_taken_once_and_survives_an_opening() {
    let disk = MemoryDisk::new();
    let memory = MemoryJournal::open(&disk, &opening()).unwrap();
    a_decision_is_found_by_its_key(&memory, 1).await;
    drop(memory);
    let memory = MemoryJournal::open(&disk, &opening()).unwrap();
    let found = memory.lookup(&claim("k1", "body"), at(4)).await.unwrap();
    assert_eq!(found.unwrap().first.record, asked(1, "k1", "body"));

    let (_directory, path) = directory();
    let sqlite = open(&path).await;
    a_decision_is_found_by_its_key(&sqlite, 1).await;
    sqlite.close().await;
    let sqlite = open(&path).await;
    let found = sqlite.lookup(&claim("k1", "body"), at(4)).await.unwrap();
    assert_eq!(found.unwrap().first.record, asked(1, "k1", "body"));
    sqlite.close().await;
    let head = verify(&path, None).await.unwrap().head;
    let mut lines = Vec::new();
    let _head = export(&path, &mut lines).await.unwrap();
    let (_other, copy) = directory();
    assert_eq!(import(&copy, &mut &lines[..]).await.unwrap(), head);
}

/// What was done comes back alone, the newest first, page by page, whatever other records say in their texts.
async fn audits_are_paged(journal: &impl Journal) {
    let liar = r#"{"record":{"kind":"audit","principal":"nobody"}}"#;
    let facts = CellDecided {
        cell: "c1".into(),
        facts: liar.into(),
        claim: None,
    };
    for n in 0..10 {
        let other = Record::CellDecided(facts.clone());
        for record in [other, audit(n)] {
            let _new = journal.append(at(n), record).await.unwrap();
        }
    }
    let mut before = journal.head().position.next();
    let mut found = Vec::new();
    loop {
        let page = journal.audits(before, 3).await.unwrap();
        let Some(last) = page.last() else { break };
        before = last.position;
        found.extend(page.into_iter().map(|stored| stored.record));
    }
    let expected: Vec<_> = (0..10).rev().map(audit).collect();
    assert_eq!(found, expected);
}

#[tokio::test]
async fn audits_are_paged_in_both_stores() {
    let (_directory, path) = directory();
    audits_are_paged(&open(&path).await).await;
    let memory = MemoryJournal::open(&MemoryDisk::new(), &opening()).unwrap();
    audits_are_paged(&memory).await;
}
