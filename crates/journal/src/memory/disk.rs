//! The disk under the in-memory journal, and what may happen to it.

use std::collections::{BTreeMap, VecDeque};
use std::io;
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

use tokio::sync::oneshot;

use super::MemoryOpenError;
use crate::error::Cause;
use crate::index::{Base, Index};
use crate::rules::{Change, MotionPhase, Verdict, wall_ms};
use crate::{
    AppendError, Appended, Clocks, Digest, Effect, Epoch, Head, KeyEntry, NewSnapshot, Opening,
    Position, Receipt, Record, Refusal, Retained, Room, Row, ServerStarted, Stored, Walker,
};

/// What the reserve is said to be; nothing is really held back in memory.
const RESERVE: u64 = 16 << 20;

/// A disk that outlives the journals opened on it, one after the other.
#[derive(Clone, Debug, Default)]
pub struct MemoryDisk(Arc<Mutex<State>>);

/// What happens at a write.
#[derive(Clone, Copy, Debug, Eq, PartialEq)]
pub enum Fault {
    /// It fails and keeps nothing: a full disk.
    Refuse,
    /// It fails, and yet the record is there after the next opening: a failed fsync.
    RefuseAndKeep,
    /// The power goes before it is durable.
    PowerLossBefore,
    /// The power goes after it is durable and before anyone hears of it.
    PowerLossAfter,
}

#[derive(Debug, Default)]
pub(super) struct State {
    rows: VecDeque<Row>,
    /// The last record that was forgotten, and how many are kept before some are; none for all.
    forgotten: Head,
    keep: Option<usize>,
    /// Of the last record that was removed on demand.
    base: Base,
    /// Texts of snapshots.
    bodies: BTreeMap<Digest, String>,
    durable: Index,
    /// The durable records and those that wait for their sync.
    ahead: Index,
    ahead_head: Head,
    waiting: Vec<Waiting>,
    holding: Holding,
    pub(super) room: Room,
    faults: BTreeMap<u64, Fault>,
    faults_of_kind: BTreeMap<&'static str, Fault>,
    writes: u64,
    openings: u64,
    open: Option<u64>,
    poison: Option<Cause>,
}

#[derive(Clone, Copy, Debug, Default, Eq, PartialEq)]
enum Holding {
    #[default]
    Syncing,
    Held,
}

type Answer = oneshot::Sender<Result<Appended, AppendError>>;

#[derive(Debug)]
enum Waiting {
    Write(Row, Box<Stored>, Answer),
    Replay(KeyEntry, Answer),
}

pub(super) enum Wait {
    Ready(Appended),
    Held(oneshot::Receiver<Result<Appended, AppendError>>),
}

impl MemoryDisk {
    /// An empty disk.
    #[must_use]
    pub fn new() -> Self {
        Self::default()
    }

    /// An empty disk that forgets its oldest records: it keeps the newest `keep`, and at times up to twice as many.
    ///
    /// What a motion or job that has not ended refers to may be gone from it; that it has not ended is remembered.
    #[must_use]
    pub fn forgetful(keep: usize) -> Self {
        let disk = Self::default();
        disk.lock().keep = Some(keep.max(1));
        disk
    }

    /// Lets something happen at a write: 1 is the first one of this disk. An opening writes one record.
    pub fn fail_write(&self, nth: u64, fault: Fault) {
        let _before = self.lock().faults.insert(nth, fault);
    }

    /// Lets something happen at the next write of a record of a kind, as [`Record::kind`] names it, whatever else is
    /// written before it.
    pub fn fail_next(&self, kind: &'static str, fault: Fault) {
        let _before = self.lock().faults_of_kind.insert(kind, fault);
    }

    /// How many writes there were, those that failed among them.
    #[must_use]
    pub fn writes(&self) -> u64 {
        self.lock().writes
    }

    /// From here on the disk is full, and the journal lives on its reserve.
    pub fn fill(&self) {
        self.lock().room = Room::Reserve { bytes: RESERVE };
    }

    /// There is room again.
    pub fn make_room(&self) {
        self.lock().room = Room::Free;
    }

    /// From here on writes wait for their sync, as on a disk that stalls.
    pub fn hold_syncs(&self) {
        self.lock().holding = Holding::Held;
    }

    /// Makes durable what waits, in its order, and holds no more.
    pub fn release_syncs(&self) {
        self.lock().release();
    }

    /// What is not durable is gone, and the journal that was open is dead.
    pub fn lose_power(&self) {
        self.lock().lose_power();
    }

    /// The durable records.
    #[must_use]
    pub fn rows(&self) -> Vec<Row> {
        self.lock().rows.iter().cloned().collect()
    }

    pub(super) fn lock(&self) -> MutexGuard<'_, State> {
        // Of use to tests only, and a test that has panicked has failed.
        self.0.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

impl State {
    pub(super) fn open(&mut self, opening: &Opening) -> Result<(u64, Epoch), MemoryOpenError> {
        if self.open.is_some() {
            return Err(MemoryOpenError::InUse);
        }
        let mut walker = Walker::new(self.forgotten);
        for row in &self.rows {
            let _stored = walker.step(row).map_err(MemoryOpenError::Broken)?;
        }
        self.ahead = self.durable.clone();
        self.ahead_head = walker.head();
        self.poison = None;
        self.openings += 1;
        self.open = Some(self.openings);
        let started = ServerStarted {
            epoch: Epoch(self.durable.epoch.0 + 1),
            program: opening.program.clone(),
            keys: opening.keys,
        };
        self.ahead.start(&started);
        let epoch = started.epoch;
        let stored = Stored {
            position: self.ahead_head.position.next(),
            epoch,
            at: opening.at,
            record: Record::ServerStarted(started),
        };
        let written = self.encode(stored).map_err(AppendError::Refused);
        let written = written.and_then(|(row, stored)| self.write(row, &stored, None));
        if let Err(error) = written {
            self.open = None;
            return Err(MemoryOpenError::Write(error));
        }
        Ok((self.openings, epoch))
    }

    pub(super) fn is_open(&self, opening: u64) -> bool {
        self.open == Some(opening)
    }

    pub(super) fn close(&mut self, opening: u64) {
        if self.is_open(opening) {
            self.release();
            self.open = None;
        }
    }

    pub(super) fn head(&self) -> Head {
        self.rows.back().map_or(self.forgotten, |row| Head {
            position: row.position,
            hash: row.hash,
        })
    }

    #[cfg(test)]
    pub(super) fn waiting(&self) -> usize {
        self.waiting.len()
    }

    pub(super) fn rows_behind(&self, after: Position) -> impl Iterator<Item = &Row> {
        let passed = after.0.saturating_sub(self.forgotten.position.0);
        self.rows
            .iter()
            .skip(usize::try_from(passed).unwrap_or(usize::MAX))
    }

    pub(super) fn rows(&self) -> impl DoubleEndedIterator<Item = &Row> {
        self.rows.iter()
    }

    pub(super) fn row(&self, position: Position) -> Option<&Row> {
        let before = self.forgotten.position.next();
        let index = usize::try_from(position.0.checked_sub(before.0)?).ok()?;
        self.rows.get(index)
    }

    pub(super) fn base(&self) -> Head {
        self.forgotten
    }

    /// Whether what a snapshot covers is a decision of its cell.
    pub(super) fn covers(&self, snapshot: &NewSnapshot) -> bool {
        let decided = self.durable.decided.get(&snapshot.covers.position);
        let there = self.row(snapshot.covers.position).map(head_of);
        decided == Some(&snapshot.cell) && there == Some(snapshot.covers)
    }

    pub(super) fn keep_body(&mut self, digest: Digest, body: String) {
        let _same = self.bodies.insert(digest, body);
    }

    pub(super) fn body(&self, digest: &Digest) -> Option<&str> {
        self.bodies.get(digest).map(String::as_str)
    }

    /// Texts no record tells of any more.
    fn forget_bodies(&mut self) {
        let told = self.durable.snapshots.values();
        let told: Vec<_> = told.map(|(_, taken)| taken.digest).collect();
        self.bodies.retain(|digest, _| told.contains(digest));
    }

    /// Which records there are, and which are needed.
    pub(super) fn retained(&self, now: &Clocks) -> Retained {
        let index = &self.durable;
        let motions = index.motions.values();
        let open = motions.filter(|entry| entry.phase != MotionPhase::Closed);
        let jobs = index.jobs.values().filter(|entry| entry.ended.is_none());
        let until = index.keys.expired_until(wall_ms(now));
        let is_open = |entry: &&KeyEntry| {
            let motion = entry.motion.and_then(|motion| index.motions.get(&motion));
            motion.is_some_and(|motion| motion.phase == MotionPhase::Open)
        };
        let keys = index.claims.values();
        let keys = keys.filter(|entry| entry.used_ms > until || is_open(entry));
        let undone = index.decided.iter().filter(|(position, cell)| {
            let kept = index.snapshots.get(*cell);
            kept.is_none_or(|(_, taken)| **position > taken.covers.position)
        });
        let needed = open
            .map(|entry| entry.intent)
            .chain(jobs.map(|entry| entry.created))
            .chain(keys.map(|entry| entry.position))
            .chain(undone.map(|(position, _)| *position))
            .fold(self.head().position, Position::min);
        Retained {
            base: self.forgotten,
            removable: Position(needed.0.saturating_sub(1)).max(self.forgotten.position),
        }
    }

    /// What the journal begins behind if `last` is the last record that is removed.
    pub(super) fn base_at(&self, last: Position) -> Option<Base> {
        let head = head_of(self.row(last)?);
        let mut base = Base { head, ..self.base };
        for row in self.rows.iter().take_while(|row| row.position <= last) {
            let stored = Stored::decode(&row.body).ok()?;
            base.epoch = stored.epoch;
            if let Record::ServerStarted(started) = &stored.record {
                base.keys = started.keys;
            }
        }
        Some(base)
    }

    fn forget_through(&mut self, base: Base) {
        let last = base.head;
        while self
            .rows
            .front()
            .is_some_and(|row| row.position <= last.position)
        {
            let _oldest = self.rows.pop_front();
        }
        (self.forgotten, self.base) = (last, base);
        let first = last.position.next();
        self.durable.forget_before(first);
        self.ahead.forget_before(first);
    }

    fn forget_old(&mut self) {
        let Some(keep) = self.keep else { return };
        if self.rows.len() < keep.saturating_mul(2) {
            return;
        }
        let surplus = self.rows.len() - keep;
        if let Some(last) = self.rows.drain(..surplus).next_back() {
            self.forgotten = head_of(&last);
        }
        let first = self.forgotten.position.next();
        self.durable.forget_before(first);
        self.ahead.forget_before(first);
    }

    pub(super) fn durable(&self) -> &Index {
        &self.durable
    }

    pub(super) fn append(
        &mut self,
        opening: u64,
        at: Clocks,
        record: Record,
    ) -> Result<Wait, AppendError> {
        if !self.is_open(opening) {
            return Err(AppendError::Closed {
                effect: Effect::None,
            });
        }
        if let Some(cause) = &self.poison {
            return Err(AppendError::Poisoned(Arc::clone(cause)));
        }
        let position = self.ahead_head.position.next();
        let verdict = self.ahead.judge(&record, at, position);
        let change = match verdict.map_err(AppendError::Refused)? {
            Verdict::Keep(change) => change,
            Verdict::Replay(entry) => {
                // What waits for its sync is not promised to anyone yet.
                if self.holding == Holding::Held {
                    let (answer, wait) = oneshot::channel();
                    self.waiting.push(Waiting::Replay(entry, answer));
                    return Ok(Wait::Held(wait));
                }
                return self.replayed(&entry).map(Wait::Ready);
            }
        };
        if let Some(refusal) = self.room.refusal()
            && record.begins_work()
        {
            return Err(refusal);
        }
        let stored = Stored {
            position,
            epoch: self.ahead.epoch,
            at,
            record,
        };
        let (row, stored) = self.encode(stored).map_err(AppendError::Refused)?;
        self.ahead.apply(change.clone(), &at);
        if self.holding == Holding::Held {
            self.ahead_head = head_of(&row);
            let (answer, wait) = oneshot::channel();
            self.waiting
                .push(Waiting::Write(row, Box::new(stored), answer));
            return Ok(Wait::Held(wait));
        }
        self.write(row, &stored, Some(change)).map(Wait::Ready)
    }

    fn encode(&self, stored: Stored) -> Result<(Row, Stored), Refusal> {
        let body = stored.encode().map_err(Refusal::TooLarge)?;
        // Kept for long, so no larger than it is.
        let body = body.as_bytes().to_vec();
        let head = self.ahead_head.extend(&body);
        let row = Row {
            position: head.position,
            previous: self.ahead_head.hash,
            body,
            hash: head.hash,
        };
        Ok((row, stored))
    }

    /// Makes a record durable, or lets happen what was asked for. `change` is what it was judged to change, where
    /// nothing has been made durable since.
    fn write(
        &mut self,
        row: Row,
        stored: &Stored,
        change: Option<Change>,
    ) -> Result<Appended, AppendError> {
        if let Some(cause) = &self.poison {
            return Err(AppendError::Poisoned(Arc::clone(cause)));
        }
        self.writes += 1;
        let fault = self
            .faults
            .remove(&self.writes)
            .or_else(|| self.faults_of_kind.remove(stored.record.kind()));
        let receipt = Receipt {
            head: head_of(&row),
            epoch: stored.epoch,
        };
        let kept = match fault {
            None | Some(Fault::RefuseAndKeep | Fault::PowerLossAfter) => true,
            Some(Fault::Refuse | Fault::PowerLossBefore) => false,
        };
        if kept {
            self.ahead_head = receipt.head;
            self.rows.push_back(row);
            match change {
                Some(change) => self.durable.keep(stored, change),
                None => {
                    let _change = self
                        .durable
                        .replay(stored)
                        .expect("a record that was judged once is judged the same again");
                }
            }
            match &stored.record {
                Record::Pruned(pruned) => self.forget_through(Base::of(pruned)),
                Record::SnapshotTaken(_) => self.forget_bodies(),
                Record::ServerStarted(_)
                | Record::Intent(_)
                | Record::Accepted(_)
                | Record::Outcome(_)
                | Record::JobCreated(_)
                | Record::JobStep(_)
                | Record::JobEnded(_)
                | Record::SignalReceived(_)
                | Record::Decision(_)
                | Record::Audit(_)
                | Record::CellDecided(_) => self.forget_old(),
            }
        }
        match fault {
            None => Ok(Appended::New(receipt)),
            Some(Fault::Refuse) => {
                let full = io::Error::new(io::ErrorKind::StorageFull, "an injected fault");
                Err(self.fail("writing", Effect::None, full))
            }
            Some(Fault::RefuseAndKeep) => {
                let fault = io::Error::other("an injected fault");
                Err(self.fail("syncing", Effect::Unknown, fault))
            }
            Some(Fault::PowerLossBefore | Fault::PowerLossAfter) => {
                self.lose_power();
                Err(AppendError::Closed {
                    effect: Effect::Unknown,
                })
            }
        }
    }

    fn fail(&mut self, step: &'static str, effect: Effect, source: io::Error) -> AppendError {
        let source: Cause = Arc::new(source);
        self.poison = Some(Arc::clone(&source));
        AppendError::Failed {
            step,
            effect,
            source,
        }
    }

    fn release(&mut self) {
        self.holding = Holding::Syncing;
        for waiting in std::mem::take(&mut self.waiting) {
            let (answer, appended) = match waiting {
                Waiting::Write(row, stored, answer) => (answer, self.write(row, &stored, None)),
                Waiting::Replay(entry, answer) => (answer, self.replayed(&entry)),
            };
            // Whoever has gone away learns it from a read.
            let _gone = answer.send(appended);
        }
    }

    fn replayed(&self, entry: &KeyEntry) -> Result<Appended, AppendError> {
        let replay = self.replay(entry).map_err(|error| AppendError::Failed {
            step: "reading what the key stands for",
            effect: Effect::None,
            source: Arc::new(error),
        })?;
        Ok(Appended::Replayed(Box::new(replay)))
    }

    fn lose_power(&mut self) {
        // Dropping the answers tells those who wait.
        self.waiting.clear();
        self.holding = Holding::Syncing;
        self.open = None;
    }
}

pub(super) fn head_of(row: &Row) -> Head {
    Head {
        position: row.position,
        hash: row.hash,
    }
}
