//! The server's way to its journal: one handle for all that write to it, whatever store is behind.
//!
//! Every record goes through here, so that one place knows whether the journal can be written, and notices a wall
//! clock that was set.

mod audit;
mod boxed;
mod epochs;
mod open;
mod retention;
mod trouble;
pub(crate) mod upkeep;

use std::fmt;
use std::sync::{Arc, Mutex, OnceLock, PoisonError};
use std::time::Duration;

use jiff::Timestamp;
use journal::{
    Appended, Audit, AuditResult, Begun, CellDecided, Claim, Clocks, Epoch, Head, Intent, Journal,
    Kept, LookupError, MemoryDisk, MemoryJournal, MotionEntry, MotionId, MotionPhase, MotionStory,
    NewSnapshot, Opening, Position, Pruning, ReadError, Receipt, Record, Replay, Retained, Row,
    Stored,
};
use tokio::sync::watch;
use tokio::time::Instant;

pub(crate) use audit::{AuditHealth, JournalAudit};
use boxed::AnyJournal;
pub(crate) use epochs::JournalEpochs;
pub use open::{JournalError, open};
pub(crate) use retention::Retaining;
pub(crate) use trouble::Trouble;
pub use upkeep::{Retention, Upkeep};

/// How many records a journal without a file keeps before it forgets the oldest.
const KEPT_IN_MEMORY: usize = 20_000;
/// A difference between the two clocks that no drift explains.
const CLOCK_STEP: Duration = Duration::from_secs(2);

/// The journal of a server, shared by all that write to it.
#[derive(Clone)]
pub struct SharedJournal(Arc<Inner>);

struct Inner {
    journal: Box<dyn AnyJournal>,
    keeps: Keeps,
    upkeep: Upkeep,
    started: Instant,
    /// Why it can no longer be written, once it cannot.
    broken: OnceLock<Trouble>,
    clocks: Mutex<Option<Clocks>>,
    /// Moves on after each record that was kept.
    news: watch::Sender<Position>,
}

/// Whether a journal outlives the process.
#[derive(Clone, Copy, Debug, Eq, PartialEq)]
pub(crate) enum Keeps {
    OverRestarts,
    UntilTheEnd,
}

impl SharedJournal {
    /// A journal that outlives the process.
    pub fn durable(journal: impl Journal) -> Self {
        Self::durable_with(journal, Upkeep::default())
    }

    /// A journal that outlives the process, of which snapshots are taken and records removed as `upkeep` says.
    pub fn durable_with(journal: impl Journal, upkeep: Upkeep) -> Self {
        Self::new(journal, Keeps::OverRestarts, upkeep)
    }

    /// A journal in memory: it has the newest records, and nothing of it survives a restart.
    ///
    /// # Panics
    /// Never: an empty disk in memory can be opened.
    #[must_use]
    pub fn volatile() -> Self {
        let opening = Opening {
            at: Clocks {
                wall: Timestamp::UNIX_EPOCH,
                monotonic: Duration::ZERO,
            },
            program: open::program(),
            keys: journal::KeyRetention::default(),
        };
        let journal = MemoryJournal::open(&MemoryDisk::forgetful(KEPT_IN_MEMORY), &opening)
            .expect("an empty disk in memory can be opened");
        // Nobody will start on it: what it forgets it forgets by itself, and no snapshot is read.
        let upkeep = Upkeep {
            snapshot_after: u32::MAX,
            retention: None,
        };
        Self::new(journal, Keeps::UntilTheEnd, upkeep)
    }

    fn new(journal: impl Journal, keeps: Keeps, upkeep: Upkeep) -> Self {
        let news = watch::Sender::new(journal.head().position);
        Self(Arc::new(Inner {
            news,
            journal: Box::new(journal),
            keeps,
            upkeep,
            started: Instant::now(),
            broken: OnceLock::new(),
            clocks: Mutex::new(None),
        }))
    }

    pub(crate) fn keeps(&self) -> Keeps {
        self.0.keeps
    }

    pub(crate) fn upkeep(&self) -> &Upkeep {
        &self.0.upkeep
    }

    pub(crate) fn epoch(&self) -> Epoch {
        self.0.journal.epoch()
    }

    pub(crate) fn head(&self) -> Head {
        self.0.journal.head()
    }

    /// Why nothing can be written any more, if so.
    pub(crate) fn broken(&self) -> Option<&Trouble> {
        self.0.broken.get()
    }

    /// Whether there is room for what begins something; if not, why not.
    pub(crate) fn room(&self) -> Result<(), Trouble> {
        let refusal = self.0.journal.room().refusal();
        refusal.map_or(Ok(()), |error| Err(Trouble::of(&error)))
    }

    /// Both clocks, for a record that is appended later.
    pub(crate) fn reading(&self, wall: Timestamp) -> Clocks {
        Clocks {
            wall,
            monotonic: self.0.started.elapsed(),
        }
    }

    /// Keeps a record; returns when it is durable.
    pub(crate) async fn append(&self, now: Timestamp, record: Record) -> Result<Appended, Trouble> {
        self.append_at(self.reading(now), record).await
    }

    /// Keeps a record of an earlier moment.
    pub(crate) async fn append_at(&self, at: Clocks, record: Record) -> Result<Appended, Trouble> {
        let at = self.clocks(at).await;
        let appended = self.0.journal.append(at, record).await;
        self.tell();
        appended.map_err(|error| self.noted(&error))
    }

    /// Keeps an intent; returns the permission to send it once it is durable.
    pub(crate) async fn begin_motion(
        &self,
        now: Timestamp,
        intent: Intent,
    ) -> Result<Begun, Trouble> {
        let at = self.clocks(self.reading(now)).await;
        let begun = self.0.journal.begin_motion(at, intent).await;
        self.tell();
        begun.map_err(|error| self.noted(&error))
    }

    /// Tells of every record that was kept: the place of the last one.
    pub(crate) fn watch(&self) -> watch::Receiver<Position> {
        self.0.news.subscribe()
    }

    /// Also after a failure: others may have got further.
    fn tell(&self) {
        let last = self.head().position;
        let _changed = self.0.news.send_if_modified(|known| {
            let further = last > *known;
            *known = last.max(*known);
            further
        });
    }

    /// Records behind `after`, a page of them.
    pub(crate) async fn page(
        &self,
        after: Position,
        limit: usize,
    ) -> Result<Vec<Stored>, ReadError> {
        self.0.journal.page(after, limit).await
    }

    /// Keeps a decision of a cell's state machines.
    pub(crate) async fn decide_cell(
        &self,
        now: Timestamp,
        decided: CellDecided,
    ) -> Result<Appended, Trouble> {
        self.append(now, Record::CellDecided(decided)).await
    }

    /// Keeps what a cell's decisions amount to.
    pub(crate) async fn keep_snapshot(
        &self,
        now: Timestamp,
        snapshot: NewSnapshot,
    ) -> Result<Receipt, Trouble> {
        let at = self.reading(now);
        let kept = self.0.journal.keep_snapshot(at, snapshot).await;
        self.tell();
        kept.map_err(|error| self.noted(&error))
    }

    /// What was kept last of a cell.
    pub(crate) async fn snapshot(&self, cell: &str) -> Result<Option<Kept>, ReadError> {
        self.0.journal.snapshot(cell).await
    }

    /// Which records there are, and which of them the journal itself needs.
    pub(crate) async fn retained(&self, now: Timestamp) -> Result<Retained, ReadError> {
        self.0.journal.retained(self.reading(now)).await
    }

    /// Records as they are kept.
    pub(crate) async fn rows(&self, after: Position, limit: usize) -> Result<Vec<Row>, ReadError> {
        self.0.journal.rows(after, limit).await
    }

    /// Removes the oldest records, up to `through` at most, some thousand at a time.
    pub(crate) async fn prune(
        &self,
        now: Timestamp,
        through: Position,
        archive: Option<String>,
    ) -> Result<Pruning, Trouble> {
        let at = self.reading(now);
        let pruned = self.0.journal.prune(at, through, archive).await;
        self.tell();
        pruned.map_err(|error| self.noted(&error))
    }

    pub(crate) async fn lookup(
        &self,
        claim: &Claim,
        now: Timestamp,
    ) -> Result<Option<Replay>, LookupError> {
        self.0.journal.lookup(claim, self.reading(now)).await
    }

    pub(crate) async fn motion(&self, motion: MotionId) -> Result<Option<MotionStory>, ReadError> {
        self.0.journal.motion(motion).await
    }

    pub(crate) async fn motions(
        &self,
        phases: &[MotionPhase],
        after: Position,
        limit: usize,
    ) -> Result<Vec<MotionEntry>, ReadError> {
        self.0.journal.motions(phases, after, limit).await
    }

    pub(crate) async fn latest_motions(
        &self,
        before: Position,
        limit: usize,
    ) -> Result<Vec<MotionEntry>, ReadError> {
        self.0.journal.latest_motions(before, limit).await
    }

    /// The decisions of a cell's state machines, a page of them.
    pub(crate) async fn decided(
        &self,
        cell: &str,
        after: Position,
        limit: usize,
    ) -> Result<Vec<Stored>, ReadError> {
        self.0.journal.decided(cell, after, limit).await
    }

    /// Who did what before `before`, the newest first.
    pub(crate) async fn audits(
        &self,
        before: Position,
        limit: usize,
    ) -> Result<Vec<Stored>, ReadError> {
        self.0.journal.audits(before, limit).await
    }

    fn noted(&self, error: &journal::AppendError) -> Trouble {
        let trouble = Trouble::of(error);
        if error.is_fatal() && self.0.broken.set(trouble.clone()).is_ok() {
            tracing::error!(
                error = %trouble,
                "the journal cannot be written: nothing moves until the server is started again"
            );
        }
        trouble
    }

    /// Both clocks. Where the wall clock was set since the last record, that is written down first.
    async fn clocks(&self, now: Clocks) -> Clocks {
        let before = {
            let mut seen = self.0.clocks.lock().unwrap_or_else(PoisonError::into_inner);
            // What is written down late tells nothing of the clock.
            if seen.is_some_and(|seen| seen.monotonic > now.monotonic) {
                return now;
            }
            seen.replace(now)
        };
        let Some(step) = before.and_then(|before| clock_step(before, now)) else {
            return now;
        };
        tracing::warn!(step_s = step.as_secs_f64(), "the wall clock was set");
        let audit = Record::Audit(Audit {
            principal: "server".into(),
            action: "clock.step".into(),
            object: "wall clock".into(),
            result: AuditResult::Done,
            request_id: None,
            cell: None,
            role: None,
            source: None,
            lease: None,
            before: before.map(|before| before.wall.to_string()),
            after: Some(now.wall.to_string()),
        });
        // If it cannot be written, the record that follows cannot either, and its writer hears of it.
        if let Err(error) = self.0.journal.append(now, audit).await {
            let _noted = self.noted(&error);
        }
        now
    }
}

/// How far the wall clock was set between two readings, either way.
fn clock_step(before: Clocks, now: Clocks) -> Option<Duration> {
    let passed = now.monotonic.saturating_sub(before.monotonic);
    let wall = now.wall.duration_since(before.wall);
    let passed = jiff::SignedDuration::try_from(passed).ok()?;
    let step = (wall - passed).unsigned_abs();
    (step > CLOCK_STEP).then_some(step)
}

impl fmt::Debug for SharedJournal {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("SharedJournal")
            .field("keeps", &self.0.keeps)
            .field("epoch", &self.epoch())
            .field("head", &self.head().position)
            .finish_non_exhaustive()
    }
}
