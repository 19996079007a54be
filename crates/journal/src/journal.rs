//! The trait: what the logic of motions and jobs needs of a journal.

use std::future::Future;

use crate::{
    AppendError, Claim, Clocks, Epoch, Head, Intent, JobEntry, JobId, LookupError, MotionEntry,
    MotionId, MotionPhase, Position, ReadError, Record, Row, SnapshotTaken, Stored,
};

/// Most records of one page.
pub const MAX_PAGE: usize = 1_000;

/// A journal that is open for writing; there is at most one of each.
///
/// Each method may be called from any task. A caller that goes away while it waits does not take its record with it:
/// the record is kept or not, and a later read tells.
pub trait Journal: Send + Sync + 'static {
    /// The epoch of this opening.
    fn epoch(&self) -> Epoch;

    /// The last durable record. Kept elsewhere, it shows a cut or replaced end.
    fn head(&self) -> Head;

    /// Whether there is room for what begins something.
    fn room(&self) -> Room;

    /// Keeps a record; returns when it is durable.
    ///
    /// # Errors
    /// [`AppendError`]; its [`effect`](AppendError::effect) says whether the record may be found later all the same.
    fn append(
        &self,
        at: Clocks,
        record: Record,
    ) -> impl Future<Output = Result<Appended, AppendError>> + Send;

    /// Up to `limit` (at most [`MAX_PAGE`]) records behind `after`, in their order.
    ///
    /// # Errors
    /// [`ReadError`] if they cannot be read.
    fn page(
        &self,
        after: Position,
        limit: usize,
    ) -> impl Future<Output = Result<Vec<Stored>, ReadError>> + Send;

    /// What a key stands for, if it was used with this body and is not forgotten.
    ///
    /// # Errors
    /// [`LookupError::Refused`] if it was used with another body, or stands for a motion that has no answer yet.
    fn lookup(
        &self,
        claim: &Claim,
        now: Clocks,
    ) -> impl Future<Output = Result<Option<Replay>, LookupError>> + Send;

    /// The records of a motion.
    ///
    /// # Errors
    /// [`ReadError`] if they cannot be read.
    fn motion(
        &self,
        motion: MotionId,
    ) -> impl Future<Output = Result<Option<MotionStory>, ReadError>> + Send;

    /// Up to `limit` (at most [`MAX_PAGE`]) motions that are in one of `phases`, whose intents stand behind `after`.
    ///
    /// After an opening, [`MotionPhase::Open`] and [`MotionPhase::Accepted`] are what the last process left behind.
    ///
    /// # Errors
    /// [`ReadError`] if they cannot be read.
    fn motions(
        &self,
        phases: &[MotionPhase],
        after: Position,
        limit: usize,
    ) -> impl Future<Output = Result<Vec<MotionEntry>, ReadError>> + Send;

    /// The places of a job's records.
    ///
    /// # Errors
    /// [`ReadError`] if they cannot be read.
    fn job(&self, job: JobId) -> impl Future<Output = Result<Option<JobEntry>, ReadError>> + Send;

    /// Up to `limit` (at most [`MAX_PAGE`]) jobs that have not ended and were created behind `after`.
    ///
    /// # Errors
    /// [`ReadError`] if they cannot be read.
    fn open_jobs(
        &self,
        after: Position,
        limit: usize,
    ) -> impl Future<Output = Result<Vec<JobEntry>, ReadError>> + Send;

    /// Up to `limit` (at most [`MAX_PAGE`]) motions whose intents stand before `before`, the newest first.
    ///
    /// # Errors
    /// [`ReadError`] if they cannot be read.
    fn latest_motions(
        &self,
        before: Position,
        limit: usize,
    ) -> impl Future<Output = Result<Vec<MotionEntry>, ReadError>> + Send;

    /// Up to `limit` (at most [`MAX_PAGE`]) [`CellDecided`](Record::CellDecided) records of `cell` behind `after`, in
    /// their order. The other records are not read.
    ///
    /// # Errors
    /// [`ReadError`] if they cannot be read.
    fn decided(
        &self,
        cell: &str,
        after: Position,
        limit: usize,
    ) -> impl Future<Output = Result<Vec<Stored>, ReadError>> + Send;

    /// Up to `limit` (at most [`MAX_PAGE`]) [`Audit`](Record::Audit) records before `before`, the newest first.
    ///
    /// # Errors
    /// [`ReadError`] if they cannot be read.
    fn audits(
        &self,
        before: Position,
        limit: usize,
    ) -> impl Future<Output = Result<Vec<Stored>, ReadError>> + Send;

    /// Keeps what the decisions of a cell amount to, in place of what was kept of it before, together with its record.
    ///
    /// # Errors
    /// As [`append`](Self::append); [`NotCovered`](crate::Refusal::NotCovered) if `covers` is no decision of the cell.
    fn keep_snapshot(
        &self,
        at: Clocks,
        snapshot: NewSnapshot,
    ) -> impl Future<Output = Result<Receipt, AppendError>> + Send;

    /// What was kept last of a cell.
    ///
    /// # Errors
    /// [`ReadError`] if it cannot be read.
    fn snapshot(&self, cell: &str) -> impl Future<Output = Result<Option<Kept>, ReadError>> + Send;

    /// Up to `limit` (at most [`MAX_PAGE`]) records behind `after` as they are kept, to be written out.
    ///
    /// # Errors
    /// [`ReadError`] if they cannot be read.
    fn rows(
        &self,
        after: Position,
        limit: usize,
    ) -> impl Future<Output = Result<Vec<Row>, ReadError>> + Send;

    /// Which records there are, and which of them the journal itself still needs.
    ///
    /// # Errors
    /// [`ReadError`] if that cannot be read.
    fn retained(&self, now: Clocks) -> impl Future<Output = Result<Retained, ReadError>> + Send;

    /// Removes the oldest records up to and including `through`, or fewer: never one that a motion or job without an
    /// end needs, or a key that may be asked for again, or a cell of which no snapshot covers it; and not more than
    /// some thousand at a time, so that nobody waits long behind it. What is removed and the record that says so are
    /// one transaction. `archive` is where they were written out to.
    ///
    /// # Errors
    /// As [`append`](Self::append).
    fn prune(
        &self,
        at: Clocks,
        through: Position,
        archive: Option<String>,
    ) -> impl Future<Output = Result<Pruning, AppendError>> + Send;

    /// Keeps an intent, and returns the permission to send it once it is durable.
    ///
    /// # Errors
    /// As [`append`](Self::append).
    fn begin_motion(
        &self,
        at: Clocks,
        intent: Intent,
    ) -> impl Future<Output = Result<Begun, AppendError>> + Send {
        async move {
            let motion = intent.motion;
            let appended = self.append(at, Record::Intent(Box::new(intent))).await?;
            Ok(match appended {
                Appended::New(receipt) => Begun::New(DurableIntent { motion, receipt }),
                Appended::Replayed(replay) => Begun::Replayed(replay),
            })
        }
    }
}

/// What the decisions of a cell amount to, to be kept.
#[derive(Clone, Debug, Eq, PartialEq)]
pub struct NewSnapshot {
    /// The cell.
    pub cell: String,
    /// The last decision in it.
    pub covers: Head,
    /// How `body` is written.
    pub format: u32,
    /// The journal does not look into it.
    pub body: String,
}

/// What was kept of a cell.
#[derive(Clone, Debug, Eq, PartialEq)]
pub enum Kept {
    /// It is what its record says.
    Whole(Snapshot),
    /// It is not, and is not to be used.
    Damaged {
        /// How it differs.
        how: String,
    },
}

/// What the decisions of a cell amount to, as it was kept.
#[derive(Clone, Debug, Eq, PartialEq)]
pub struct Snapshot {
    /// Where the record of it stands.
    pub position: Position,
    /// What that record says.
    pub taken: SnapshotTaken,
    /// The text.
    pub body: String,
}

/// Which records there are.
#[derive(Clone, Copy, Debug, Default, Eq, PartialEq)]
pub struct Retained {
    /// The last one that was removed.
    pub base: Head,
    /// The last one that may be removed, as far as the journal itself knows.
    pub removable: Position,
}

/// What was removed.
#[derive(Clone, Copy, Debug, Default, Eq, PartialEq)]
pub struct Pruning {
    /// The last record that is not there any more.
    pub base: Head,
    /// How many were removed this time; 0 if none can be.
    pub removed: u64,
}

/// How much room a journal has.
#[derive(Clone, Copy, Debug, Default, Eq, PartialEq)]
pub enum Room {
    /// For everything.
    #[default]
    Free,
    /// The disk is full: for what ends or tells, in the reserve. What [begins](Record::begins_work) something is
    /// [`AppendError::NoRoom`].
    Reserve {
        /// Its size in bytes.
        bytes: u64,
    },
}

impl Room {
    /// What is answered to what would begin something.
    #[must_use]
    pub fn refusal(self) -> Option<AppendError> {
        match self {
            Self::Free => None,
            Self::Reserve { bytes } => Some(AppendError::NoRoom { reserve: bytes }),
        }
    }
}

/// What became of an append.
#[derive(Clone, Debug, Eq, PartialEq)]
pub enum Appended {
    /// The record is durable.
    New(Receipt),
    /// Its key stands for an earlier one; nothing was written.
    Replayed(Box<Replay>),
}

/// What became of a motion's beginning.
#[derive(Debug)]
pub enum Begun {
    /// The intent is durable: it may be sent, once.
    New(DurableIntent),
    /// Its key stands for an earlier one: nothing is to be sent.
    Replayed(Box<Replay>),
}

/// Where a durable record stands.
#[derive(Clone, Copy, Debug, Eq, PartialEq)]
pub struct Receipt {
    /// Its place and its hash.
    pub head: Head,
    /// The epoch it was written in.
    pub epoch: Epoch,
}

/// The permission to send a motion: there is none without a durable intent, and none twice.
///
/// Only the journal makes one, and it cannot be copied.
///
/// ```compile_fail
/// fn twice(intent: journal::DurableIntent) {
///     let send = |_: journal::DurableIntent| ();
///     send(intent);
///     send(intent);
/// }
/// ```
#[derive(Debug)]
pub struct DurableIntent {
    motion: MotionId,
    receipt: Receipt,
}

/// What an idempotency key stands for.
#[derive(Clone, Debug, Eq, PartialEq)]
pub struct Replay {
    /// The record that took the key: an intent, the creation of a job, or a decision of a cell.
    pub first: Stored,
    /// The motion's acceptance, where the first record is an intent.
    pub accepted: Option<Stored>,
    /// The motion's latest outcome, where the first record is an intent.
    pub outcome: Option<Stored>,
}

/// The records of one motion.
#[derive(Clone, Debug, Eq, PartialEq)]
pub struct MotionStory {
    /// How far it has come.
    pub phase: MotionPhase,
    /// Its intent.
    pub intent: Stored,
    /// Its acceptance.
    pub accepted: Option<Stored>,
    /// Its latest outcome.
    pub outcome: Option<Stored>,
    /// The decision about it.
    pub decision: Option<Stored>,
}

impl DurableIntent {
    /// The motion.
    #[must_use]
    pub fn motion(&self) -> MotionId {
        self.motion
    }

    /// Where its intent stands.
    #[must_use]
    pub fn receipt(&self) -> Receipt {
        self.receipt
    }
}
