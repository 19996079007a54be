//! What a start reads, and what may be removed behind it.

use std::sync::Arc;

use jiff::{SignedDuration, Timestamp};
use journal::{
    Head, Kept, MemoryDisk, NewSnapshot, Position, VerifyError, Walker, verify_archives,
};
use tokio_util::sync::CancellationToken;
use workflow::{Setup, SignalKind};

use super::{World, opened_with};
use crate::cell::recovered::{Recovered, StartError};
use crate::clock::{SystemClock, WallClock};
use crate::journal::{Retaining, Retention, SharedJournal, Upkeep};

const AFTER: u32 = 20;

fn upkeep() -> Upkeep {
    Upkeep {
        snapshot_after: AFTER,
        retention: None,
    }
}

/// So many days from now.
#[derive(Debug)]
struct InDays(i64);

impl WallClock for InDays {
    fn now(&self) -> Timestamp {
        SystemClock.now() + SignedDuration::from_hours(24 * self.0)
    }
}

impl World {
    /// Reports of loads, each of which is a decision.
    async fn reports(&mut self, count: u32) {
        for _ in 0..count {
            self.says(SignalKind::LoadChanged, None).await;
        }
    }
}

async fn whole(journal: &SharedJournal) -> journal::Snapshot {
    let mut news = journal.watch();
    loop {
        if let Some(Kept::Whole(snapshot)) = journal.snapshot("c1").await.unwrap() {
            return snapshot;
        }
        news.changed().await.unwrap();
    }
}

async fn recovered(journal: &SharedJournal) -> Result<Recovered, StartError> {
    Recovered::read("c1", Setup::default(), journal, SystemClock.now()).await
}

/// A cell with a job under way, a snapshot, and decisions behind it; and its journal, which is closed.
async fn history(disk: &MemoryDisk) -> (SharedJournal, Arc<workflow::Cell>) {
    let (journal, world) = at_work(disk).await;
    (journal, world.work.view())
}

async fn at_work(disk: &MemoryDisk) -> (SharedJournal, World) {
    let journal = opened_with(disk, upkeep());
    let mut world = World::on_journal(&journal).await;
    world.reports(AFTER).await;
    let _job = world.pickup().await;
    let order = world.message("TRANSPORT_ORDER").await;
    world.says(SignalKind::MrAssigned, order.session).await;
    let _snapshot = whole(&journal).await;
    world.reports(5).await;
    (journal, world)
}

#[tokio::test]
async fn r6_a_start_folds_only_what_came_behind_the_snapshot_and_is_the_same() {
    let disk = MemoryDisk::new();
    let (journal, before) = history(&disk).await;
    let decided = journal.decided("c1", Position::START, 1_000).await.unwrap();
    let snapshot = whole(&journal).await;
    let behind = decided
        .iter()
        .filter(|stored| stored.position > snapshot.taken.covers.position)
        .count();
    let now = recovered(&journal).await.unwrap();
    assert_eq!(now.decisions, behind);
    assert!(behind < decided.len());
    assert!(now.cell.same_book(&before));
    // What is beside the state, too: where jobs are told of, and when messages were written.
    let job = before.jobs(0)[0].id;
    let span = now.places.of(job).unwrap();
    let created = decided.iter().find(|stored| {
        let journal::Record::CellDecided(decided) = &stored.record else {
            return false;
        };
        decided.facts.contains("job_created")
    });
    assert_eq!(span.first, created.unwrap().position);
    let first = before.outbox("mr1", 0)[0].n;
    assert!(now.told.at("mr1", first).is_some());
}

/// Keeps a snapshot as another program would.
async fn replace(journal: &SharedJournal, format: u32, body: &str) {
    let snapshot = whole(journal).await;
    let before = Position(snapshot.taken.covers.position.0 - 1);
    let row = journal.rows(before, 1).await.unwrap().remove(0);
    let covers = Head {
        position: row.position,
        hash: row.hash,
    };
    let snapshot = NewSnapshot {
        cell: "c1".into(),
        covers,
        format,
        body: body.into(),
    };
    let kept = journal.keep_snapshot(SystemClock.now(), snapshot).await;
    let _receipt = kept.unwrap();
}

#[tokio::test]
async fn r6_a_snapshot_of_another_version_is_passed_over_while_the_decisions_are_there() {
    for (format, body) in [(1_000_000, "{}"), (1_001, "{\"state\":")] {
        let disk = MemoryDisk::new();
        let (journal, before) = history(&disk).await;
        let all = journal.decided("c1", Position::START, 1_000).await.unwrap();
        replace(&journal, format, body).await;
        let now = recovered(&journal).await.unwrap();
        assert_eq!(now.decisions, all.len());
        assert!(now.cell.same_book(&before));
        // Without them nothing is guessed.
        let through = journal.retained(SystemClock.now()).await.unwrap().removable;
        let pruned = journal.prune(SystemClock.now(), through, None).await;
        assert!(pruned.unwrap().removed > 0);
        let refused = recovered(&journal).await.unwrap_err();
        assert!(
            matches!(&refused, StartError::Snapshot { cell, .. } if cell == "c1"),
            "{refused}"
        );
    }
}

fn retaining(journal: &SharedJournal, world: &World, days: i64) -> Retaining {
    Retaining {
        journal: journal.clone(),
        clock: Arc::new(InDays(days)),
        cells: vec![("c1".into(), world.work.clone())],
    }
}

fn retention(archive: Option<&std::path::Path>) -> Retention {
    Retention {
        days: 30,
        records: 10,
        archive: archive.map(std::path::Path::to_owned),
    }
}

#[tokio::test]
async fn r6_old_records_are_written_out_and_removed_and_an_open_job_keeps_its_own() {
    let disk = MemoryDisk::new();
    let folder = tempfile::tempdir().unwrap();
    let journal = opened_with(&disk, upkeep());
    let mut world = World::on_journal(&journal).await;
    world.reports(2 * AFTER).await;
    let job = world.pickup().await;
    let first = world.work.span(job).unwrap().first;
    world.reports(4 * AFTER).await;
    let snapshot = whole(&journal).await;
    assert!(snapshot.taken.covers.position > Position::START);
    // A month has not passed.
    let archive = Some(folder.path());
    let early = retaining(&journal, &world, 29);
    assert_eq!(early.once(&retention(archive)).await.unwrap(), 0);
    let later = retaining(&journal, &world, 31);
    let removed = later.once(&retention(archive)).await.unwrap();
    let base = journal.retained(SystemClock.now()).await.unwrap().base;
    assert_eq!(base.position.0, removed);
    assert!(base.position < first, "the job is still told as a whole");
    assert!(world.work.span(job).is_some());
    let files: Vec<_> = std::fs::read_dir(folder.path()).unwrap().collect();
    assert_eq!(files.len(), 1);
    let text = std::fs::read(files[0].as_ref().unwrap().path()).unwrap();
    assert_eq!(verify_archives([text.as_slice()]).unwrap(), base);
    // What is left is a chain behind it, and a start on it is the same.
    let mut walker = Walker::new(base);
    for row in disk.rows() {
        let _stored = walker.step(&row).unwrap();
    }
    let now = recovered(&journal).await.unwrap();
    assert!(now.cell.same_book(&world.work.view()));
    assert_eq!(now.places.of(job), world.work.span(job));
}

/// A file that was written and whose records were not removed, because the power went in between, is written again.
#[tokio::test]
async fn r6_a_power_loss_between_writing_out_and_removing_loses_nothing() {
    let disk = MemoryDisk::new();
    let folder = tempfile::tempdir().unwrap();
    let journal = opened_with(&disk, upkeep());
    let mut world = World::on_journal(&journal).await;
    world.reports(4 * AFTER).await;
    let _snapshot = whole(&journal).await;
    disk.fail_next("pruned", journal::Fault::PowerLossBefore);
    let archive = Some(folder.path());
    let broken = retaining(&journal, &world, 31);
    assert!(broken.once(&retention(archive)).await.is_err());
    let before = world.work.view();
    drop((world, broken, journal));
    let journal = opened_with(&disk, upkeep());
    let now = recovered(&journal).await.unwrap();
    assert!(now.cell.same_book(&before));
    let world = World::on_journal(&journal).await;
    let again = retaining(&journal, &world, 31);
    assert!(again.once(&retention(archive)).await.unwrap() > 0);
    let base = journal.retained(SystemClock.now()).await.unwrap().base;
    let mut archives = Vec::new();
    for file in std::fs::read_dir(folder.path()).unwrap() {
        archives.push(std::fs::read(file.unwrap().path()).unwrap());
    }
    let proved: Result<Head, VerifyError> = verify_archives(archives.iter().map(Vec::as_slice));
    assert_eq!(proved.unwrap(), base);
}

/// A snapshot that a start could not use keeps the decisions it stands for.
#[tokio::test]
async fn r6_nothing_is_removed_behind_a_snapshot_that_cannot_be_read() {
    let disk = MemoryDisk::new();
    let (journal, world) = at_work(&disk).await;
    replace(&journal, 1_000_000, "{}").await;
    let retaining = retaining(&journal, &world, 31);
    let refused = retaining.once(&retention(None)).await.unwrap_err();
    assert!(refused.to_string().contains("format"), "{refused}");
    let base = journal.retained(SystemClock.now()).await.unwrap().base;
    assert_eq!(base, Head::EMPTY);
    // Stopping ends the task wherever it is.
    let stop = CancellationToken::new();
    stop.cancel();
    retaining.run(stop).await;
}
