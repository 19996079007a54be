//! A journal whose disk does what a test wants, at the record it names.

use std::path::Path;
use std::sync::{Arc, Mutex};
use std::time::Duration;

use journal::{
    AppendError, Appended, CellDecided, Claim, Clocks, Epoch, Filesystem, Head, JobEntry, JobId,
    Journal, Kept, KeyRetention, LookupError, MotionEntry, MotionId, MotionPhase, MotionStory,
    NewSnapshot, Opening, Position, Pruning, ReadError, Receipt, Record, Replay, Retained, Room,
    Row, SqliteJournal, SqliteOptions, Stored,
};
use server::{SharedJournal, Upkeep};
use tokio::sync::watch;

/// What happens to a record before it is kept, or after.
#[derive(Clone, Copy, Debug, Default, Eq, PartialEq)]
enum Mode {
    #[default]
    Sound,
    /// Nothing is taken, and nothing is lost: too much waits to be written.
    Busy,
    /// The first decision that says this is never written, and its writer never hears anything: the power may go now.
    StallsBefore(&'static str),
    /// It is written, and its writer never hears of it.
    StallsAfter(&'static str),
    /// A snapshot is never written.
    StallsAtSnapshots,
}

/// The disk of a cell, over every start of its server.
#[derive(Clone, Debug, Default)]
pub(crate) struct Disk(Arc<Inner>);

#[derive(Debug, Default)]
struct Inner {
    mode: Mutex<Mode>,
    pages: Mutex<Option<u32>>,
    /// How often something was refused or stalled.
    struck: watch::Sender<usize>,
    snapshots: watch::Sender<usize>,
}

impl Disk {
    /// The next openings take so many pages of 4 KiB.
    pub(crate) fn limit(&self, pages: Option<u32>) {
        *self.0.pages.lock().unwrap() = pages;
    }

    pub(crate) fn is_sound(&self) {
        self.set(Mode::Sound);
    }

    pub(crate) fn takes_nothing(&self) {
        self.set(Mode::Busy);
    }

    pub(crate) fn stalls_before(&self, words: &'static str) {
        self.set(Mode::StallsBefore(words));
    }

    pub(crate) fn stalls_at_snapshots(&self) {
        self.set(Mode::StallsAtSnapshots);
    }

    /// How many snapshots were kept so far.
    pub(crate) fn snapshots(&self) -> usize {
        *self.0.snapshots.borrow()
    }

    pub(crate) fn stalls_after(&self, words: &'static str) {
        self.set(Mode::StallsAfter(words));
    }

    fn set(&self, mode: Mode) {
        *self.0.mode.lock().unwrap() = mode;
    }

    fn mode(&self) -> Mode {
        *self.0.mode.lock().unwrap()
    }

    /// How often something happened so far.
    pub(crate) fn struck(&self) -> usize {
        *self.0.struck.borrow()
    }

    fn strike(&self) {
        self.0.struck.send_modify(|count| *count += 1);
    }

    /// Waits for the lock of a server that was killed a moment ago, and opens the journal.
    pub(crate) async fn open(&self, path: &Path) -> SharedJournal {
        let journal = self.try_open(path).await;
        let journal = Fickle {
            journal: journal.unwrap_or_else(|error| panic!("{error}")),
            disk: self.clone(),
        };
        // So often that a start finds one in the middle of anything.
        let upkeep = Upkeep {
            snapshot_after: 7,
            retention: None,
        };
        SharedJournal::durable_with(journal, upkeep)
    }

    /// Why the journal is not opened.
    pub(crate) async fn refused(&self, path: &Path) -> String {
        let opened = self.try_open(path).await;
        match opened {
            Ok(_journal) => panic!("the journal should not be opened"),
            Err(error) => error,
        }
    }

    /// Adds a decision of the cell, as another program would.
    pub(crate) async fn decide(&self, path: &Path, facts: &str) {
        let journal = self.try_open(path).await.unwrap();
        let decided = CellDecided {
            cell: "demo".to_owned(),
            facts: facts.to_owned(),
            claim: None,
        };
        let record = Record::CellDecided(decided);
        let _kept = journal.append(now(), record).await.unwrap();
        journal.close().await;
    }

    async fn try_open(&self, path: &Path) -> Result<SqliteJournal, String> {
        let opening = Opening {
            at: now(),
            program: "robocell, in a test".to_owned(),
            keys: KeyRetention::default(),
        };
        let options = SqliteOptions {
            // The directory for temporary files may be in memory.
            filesystem: Filesystem::Trusted,
            max_pages: *self.0.pages.lock().unwrap(),
            ..SqliteOptions::default()
        };
        loop {
            match SqliteJournal::open(path, &opening, &options).await {
                Ok(journal) => return Ok(journal),
                Err(error) if format!("{error:?}").contains("InUse") => {
                    tokio::time::sleep(Duration::from_millis(1)).await;
                }
                Err(error) => return Err(format!("{error:?}")),
            }
        }
    }
}

fn now() -> Clocks {
    Clocks {
        wall: jiff::Timestamp::now(),
        monotonic: Duration::ZERO,
    }
}

struct Fickle {
    journal: SqliteJournal,
    disk: Disk,
}

impl Journal for Fickle {
    fn epoch(&self) -> Epoch {
        self.journal.epoch()
    }

    fn head(&self) -> Head {
        self.journal.head()
    }

    fn room(&self) -> Room {
        self.journal.room()
    }

    async fn audits(&self, before: Position, limit: usize) -> Result<Vec<Stored>, ReadError> {
        self.journal.audits(before, limit).await
    }

    async fn append(&self, at: Clocks, record: Record) -> Result<Appended, AppendError> {
        let says = |words: &str| {
            let Record::CellDecided(decided) = &record else {
                return false;
            };
            decided.facts.contains(words)
        };
        let mode = self.disk.mode();
        match mode {
            Mode::Busy => {
                self.disk.strike();
                return Err(AppendError::Busy { capacity: 0 });
            }
            Mode::StallsBefore(words) | Mode::StallsAfter(words) if says(words) => {
                if let Mode::StallsAfter(_) = mode {
                    let _kept = self.journal.append(at, record).await?;
                }
                self.disk.strike();
                return std::future::pending().await;
            }
            Mode::Sound
            | Mode::StallsBefore(_)
            | Mode::StallsAfter(_)
            | Mode::StallsAtSnapshots => {}
        }
        self.journal.append(at, record).await
    }

    async fn keep_snapshot(
        &self,
        at: Clocks,
        snapshot: NewSnapshot,
    ) -> Result<Receipt, AppendError> {
        if self.disk.mode() == Mode::StallsAtSnapshots {
            self.disk.strike();
            return std::future::pending().await;
        }
        let kept = self.journal.keep_snapshot(at, snapshot).await;
        self.disk.0.snapshots.send_modify(|count| *count += 1);
        kept
    }

    async fn snapshot(&self, cell: &str) -> Result<Option<Kept>, ReadError> {
        self.journal.snapshot(cell).await
    }

    async fn rows(&self, after: Position, limit: usize) -> Result<Vec<Row>, ReadError> {
        self.journal.rows(after, limit).await
    }

    async fn retained(&self, now: Clocks) -> Result<Retained, ReadError> {
        self.journal.retained(now).await
    }

    async fn prune(
        &self,
        at: Clocks,
        through: Position,
        archive: Option<String>,
    ) -> Result<Pruning, AppendError> {
        self.journal.prune(at, through, archive).await
    }

    async fn page(&self, after: Position, limit: usize) -> Result<Vec<Stored>, ReadError> {
        self.journal.page(after, limit).await
    }

    async fn lookup(&self, claim: &Claim, now: Clocks) -> Result<Option<Replay>, LookupError> {
        self.journal.lookup(claim, now).await
    }

    async fn motion(&self, motion: MotionId) -> Result<Option<MotionStory>, ReadError> {
        self.journal.motion(motion).await
    }

    async fn motions(
        &self,
        phases: &[MotionPhase],
        after: Position,
        limit: usize,
    ) -> Result<Vec<MotionEntry>, ReadError> {
        self.journal.motions(phases, after, limit).await
    }

    async fn job(&self, job: JobId) -> Result<Option<JobEntry>, ReadError> {
        self.journal.job(job).await
    }

    async fn open_jobs(&self, after: Position, limit: usize) -> Result<Vec<JobEntry>, ReadError> {
        self.journal.open_jobs(after, limit).await
    }

    async fn latest_motions(
        &self,
        before: Position,
        limit: usize,
    ) -> Result<Vec<MotionEntry>, ReadError> {
        self.journal.latest_motions(before, limit).await
    }

    async fn decided(
        &self,
        cell: &str,
        after: Position,
        limit: usize,
    ) -> Result<Vec<Stored>, ReadError> {
        self.journal.decided(cell, after, limit).await
    }
}
