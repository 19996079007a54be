//! The journal in an SQLite file: write-ahead log, `synchronous = FULL`, one writer.

mod columns;
mod filesystem;
mod lock;
mod offline;
mod open;
mod reader;
mod reserve;
mod store;
mod upkeep;
mod writer;

use std::path::Path;
use std::time::Duration;

use sqlx::SqlitePool;
use sqlx::pool::PoolConnection;
use sqlx::sqlite::SqlitePoolOptions;
use tokio::sync::{mpsc, oneshot, watch};
use tokio::task::JoinHandle;

pub use filesystem::Filesystem;
pub use offline::{Report, VerifyError, export, import, verify, verify_archives};
pub use open::OpenError;

use crate::error::check_limit;
use crate::rules::judge_claim;
use crate::{
    AppendError, Appended, Claim, Clocks, Effect, Epoch, Head, JobEntry, JobId, Journal, Kept,
    KeyRetention, LookupError, MotionEntry, MotionId, MotionPhase, MotionStory, NewSnapshot,
    Opening, Position, Pruning, ReadError, Receipt, Record, Refusal, Replay, Retained, Room, Row,
    Stored,
};
use writer::{Done, Request, Work, Writer};

/// How a journal file is used.
#[derive(Clone, Debug)]
pub struct SqliteOptions {
    /// What is asked of the filesystem.
    pub filesystem: Filesystem,
    /// Records that may wait to be written; one more is [`AppendError::Busy`].
    pub queue: usize,
    /// Whether the journal may be an older one than was open here before.
    pub history: History,
    /// How many of the last records are checked at the opening. `verify` checks all.
    pub verify_last: u64,
    /// The largest size of the file in pages of 4 KiB; none for as large as the disk.
    pub max_pages: Option<u32>,
    /// Bytes that are held back on the disk (and within `max_pages`) for what must still be kept when it is full; 0 for
    /// none: then the journal takes nothing more after the first record that finds no room.
    pub reserve: u64,
    /// How often a journal that lives on its reserve looks whether there is room again.
    pub look_for_room: Duration,
}

/// Whether a journal may be an older one than was open at the same place before.
#[derive(Clone, Copy, Debug, Default, Eq, PartialEq)]
pub enum History {
    /// No: [`OpenError::RolledBack`].
    #[default]
    Whole,
    /// A person has decided that a backup goes on. Its epoch follows the highest one ever begun here, and what was
    /// sent after the backup is not in it: every robot is to be looked at before it moves.
    Restored,
}

impl Default for SqliteOptions {
    /// The filesystem is checked, 1,024 may wait, the last 100,000 are checked (half a second), as large as the disk,
    /// without a reserve.
    fn default() -> Self {
        Self {
            filesystem: Filesystem::Checked,
            history: History::Whole,
            queue: 1_024,
            verify_last: 100_000,
            max_pages: None,
            reserve: 0,
            look_for_room: Duration::from_secs(10),
        }
    }
}

/// A journal in an SQLite file, open for writing.
///
/// Dropping it ends the writer in the background; [`close`](Self::close) waits for that.
#[derive(Debug)]
pub struct SqliteJournal {
    queue: mpsc::Sender<Request>,
    head: watch::Receiver<Head>,
    room: watch::Receiver<Room>,
    epoch: Epoch,
    keys: KeyRetention,
    readers: SqlitePool,
    writer: JoinHandle<()>,
}

impl SqliteJournal {
    /// Opens the journal at `path`, or makes one, and begins the next epoch. Beside it stand SQLite's own files and
    /// `PATH.lock`, which knows the epoch too and tells a journal that was replaced by an older one.
    ///
    /// Must be called within a Tokio runtime that has its timer enabled.
    ///
    /// # Errors
    /// [`OpenError`] if someone else has it open, if it would not be durable, or if it is damaged.
    pub async fn open(
        path: &Path,
        opening: &Opening,
        options: &SqliteOptions,
    ) -> Result<Self, OpenError> {
        let open::Opened {
            store,
            lock,
            reserve,
            path,
        } = open::open(path, opening, options).await?;
        let readers = SqlitePoolOptions::new()
            .max_connections(2)
            .acquire_timeout(Duration::from_secs(5))
            .connect_lazy_with(open::connect_options(&path).read_only(true));
        let (publish, head) = watch::channel(store.head);
        let (epoch, keys) = (store.epoch, store.keys);
        let (queue, requests) = mpsc::channel(options.queue.max(1));
        let (tell_room, room) = watch::channel(reserve.room());
        let writer = Writer {
            store,
            publish,
            room: tell_room,
            reserve,
            look_for_room: options.look_for_room,
            lock,
        };
        Ok(Self {
            queue,
            head,
            room,
            epoch,
            keys,
            readers,
            writer: tokio::spawn(writer.run(requests)),
        })
    }

    /// Writes what waits, closes the file, and gives up the lock.
    ///
    /// # Panics
    /// If the writer task has panicked, which only a defect of this crate can cause.
    pub async fn close(self) {
        self.readers.close().await;
        drop(self.queue);
        if let Err(error) = self.writer.await
            && error.is_panic()
        {
            std::panic::resume_unwind(error.into_panic());
        }
    }

    /// Has the writer do something, and waits until it is durable.
    async fn ask<T>(
        &self,
        at: Clocks,
        work: Work,
        pick: fn(Done) -> Option<T>,
    ) -> Result<T, AppendError> {
        let (answer, answered) = oneshot::channel();
        let request = Request { at, work, answer };
        self.queue.try_send(request).map_err(|error| match error {
            mpsc::error::TrySendError::Full(_) => AppendError::Busy {
                capacity: self.queue.max_capacity(),
            },
            mpsc::error::TrySendError::Closed(_) => AppendError::Closed {
                effect: Effect::None,
            },
        })?;
        let closed = || AppendError::Closed {
            effect: Effect::Unknown,
        };
        let done = answered.await.unwrap_or_else(|_| Err(closed()))?;
        pick(done).ok_or_else(closed)
    }

    async fn reader(&self) -> Result<PoolConnection<sqlx::Sqlite>, ReadError> {
        self.readers.acquire().await.map_err(reader::store)
    }
}

impl Journal for SqliteJournal {
    fn epoch(&self) -> Epoch {
        self.epoch
    }

    fn head(&self) -> Head {
        *self.head.borrow()
    }

    fn room(&self) -> Room {
        *self.room.borrow()
    }

    async fn append(&self, at: Clocks, record: Record) -> Result<Appended, AppendError> {
        if record.is_reserved() {
            return Err(AppendError::Refused(Refusal::Reserved {
                kind: record.kind(),
            }));
        }
        self.ask(at, Work::Record(Box::new(record)), Done::appended)
            .await
    }

    async fn keep_snapshot(
        &self,
        at: Clocks,
        snapshot: NewSnapshot,
    ) -> Result<Receipt, AppendError> {
        self.ask(at, Work::Snapshot(Box::new(snapshot)), Done::snapshot)
            .await
    }

    async fn prune(
        &self,
        at: Clocks,
        through: Position,
        archive: Option<String>,
    ) -> Result<Pruning, AppendError> {
        self.ask(at, Work::Prune { through, archive }, Done::pruned)
            .await
    }

    async fn snapshot(&self, cell: &str) -> Result<Option<Kept>, ReadError> {
        reader::snapshot(&mut *self.reader().await?, cell).await
    }

    async fn rows(&self, after: Position, limit: usize) -> Result<Vec<Row>, ReadError> {
        check_limit(limit)?;
        reader::rows(&mut *self.reader().await?, after, limit)
            .await
            .map_err(reader::store)
    }

    async fn retained(&self, now: Clocks) -> Result<Retained, ReadError> {
        upkeep::retained(&mut *self.reader().await?, self.keys, now)
            .await
            .map_err(reader::store)
    }

    async fn page(&self, after: Position, limit: usize) -> Result<Vec<Stored>, ReadError> {
        check_limit(limit)?;
        reader::page(&mut *self.reader().await?, after, limit).await
    }

    async fn lookup(&self, claim: &Claim, now: Clocks) -> Result<Option<Replay>, LookupError> {
        let mut reader = self.reader().await.map_err(LookupError::Read)?;
        let known = store::key_facts(&mut reader, claim)
            .await
            .map_err(|error| LookupError::Read(reader::store(error)))?;
        let entry = judge_claim(claim, known.as_ref(), self.keys, &now);
        match entry.map_err(LookupError::Refused)? {
            Some(entry) => reader::replay(&mut reader, &entry)
                .await
                .map(Some)
                .map_err(LookupError::Read),
            None => Ok(None),
        }
    }

    async fn motion(&self, motion: MotionId) -> Result<Option<MotionStory>, ReadError> {
        reader::story(&mut *self.reader().await?, motion).await
    }

    async fn motions(
        &self,
        phases: &[MotionPhase],
        after: Position,
        limit: usize,
    ) -> Result<Vec<MotionEntry>, ReadError> {
        check_limit(limit)?;
        reader::motions(&mut *self.reader().await?, phases, after, limit).await
    }

    async fn job(&self, job: JobId) -> Result<Option<JobEntry>, ReadError> {
        reader::job(&mut *self.reader().await?, job).await
    }

    async fn open_jobs(&self, after: Position, limit: usize) -> Result<Vec<JobEntry>, ReadError> {
        check_limit(limit)?;
        reader::open_jobs(&mut *self.reader().await?, after, limit).await
    }

    async fn latest_motions(
        &self,
        before: Position,
        limit: usize,
    ) -> Result<Vec<MotionEntry>, ReadError> {
        check_limit(limit)?;
        reader::latest_motions(&mut *self.reader().await?, before, limit).await
    }

    async fn decided(
        &self,
        cell: &str,
        after: Position,
        limit: usize,
    ) -> Result<Vec<Stored>, ReadError> {
        check_limit(limit)?;
        reader::decided(&mut *self.reader().await?, cell, after, limit).await
    }

    async fn audits(&self, before: Position, limit: usize) -> Result<Vec<Stored>, ReadError> {
        check_limit(limit)?;
        reader::audits(&mut *self.reader().await?, before, limit).await
    }
}
