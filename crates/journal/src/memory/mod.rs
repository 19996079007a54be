//! A journal without a disk, for tests of logic: same rules, same chain, and every failure at will.

mod disk;
#[cfg(test)]
mod tests;

use std::sync::Arc;

use thiserror::Error;
use tokio::sync::oneshot;

pub use disk::{Fault, MemoryDisk};
use disk::{State, Wait};

use crate::error::check_limit;
use crate::rules::judge_claim;
use crate::{
    AppendError, Appended, Broken, Claim, Clocks, Digest, Effect, Epoch, Head, JobEntry, JobId,
    Journal, Kept, KeyEntry, LookupError, MotionEntry, MotionId, MotionPhase, MotionStory,
    NewSnapshot, Opening, Position, Pruned, Pruning, ReadError, Receipt, Record, Refusal, Replay,
    Retained, Room, Row, Snapshot, SnapshotTaken, Stored,
};

/// A journal on a [`MemoryDisk`].
#[derive(Debug)]
pub struct MemoryJournal {
    disk: MemoryDisk,
    /// The opening this journal is; the disk's may be a later one.
    opening: u64,
    epoch: Epoch,
}

/// The journal was not opened.
#[derive(Debug, Error)]
pub enum MemoryOpenError {
    /// Another one is open on the same disk.
    #[error("another journal is open on this disk")]
    InUse,
    /// What is on the disk does not hold.
    #[error("the journal is damaged")]
    Broken(#[source] Broken),
    /// The opening itself could not be written.
    #[error("writing the opening")]
    Write(#[source] AppendError),
}

impl MemoryJournal {
    /// Opens the journal on `disk`: checks the chain, and begins the next epoch.
    ///
    /// # Errors
    /// [`MemoryOpenError`] if it is open already, damaged, or an injected fault hits the opening.
    pub fn open(disk: &MemoryDisk, opening: &Opening) -> Result<Self, MemoryOpenError> {
        let (number, epoch) = disk.lock().open(opening)?;
        Ok(Self {
            disk: disk.clone(),
            opening: number,
            epoch,
        })
    }

    async fn put(&self, at: Clocks, record: Record) -> Result<Appended, AppendError> {
        let wait = self.disk.lock().append(self.opening, at, record)?;
        match wait {
            Wait::Ready(appended) => Ok(appended),
            Wait::Held(answer) => held(answer).await,
        }
    }

    fn with<T>(&self, read: impl FnOnce(&State) -> Result<T, ReadError>) -> Result<T, ReadError> {
        let state = self.disk.lock();
        if state.is_open(self.opening) {
            read(&state)
        } else {
            Err(ReadError::Closed)
        }
    }
}

impl Drop for MemoryJournal {
    fn drop(&mut self) {
        self.disk.lock().close(self.opening);
    }
}

impl Journal for MemoryJournal {
    fn epoch(&self) -> Epoch {
        self.epoch
    }

    fn head(&self) -> Head {
        self.disk.lock().head()
    }

    fn room(&self) -> Room {
        self.disk.lock().room
    }

    async fn append(&self, at: Clocks, record: Record) -> Result<Appended, AppendError> {
        if record.is_reserved() {
            return Err(AppendError::Refused(Refusal::Reserved {
                kind: record.kind(),
            }));
        }
        self.put(at, record).await
    }

    async fn keep_snapshot(
        &self,
        at: Clocks,
        snapshot: NewSnapshot,
    ) -> Result<Receipt, AppendError> {
        let taken = SnapshotTaken {
            cell: snapshot.cell.clone(),
            covers: snapshot.covers,
            format: snapshot.format,
            bytes: snapshot.body.len() as u64,
            digest: Digest::of(snapshot.body.as_bytes()),
        };
        {
            let mut state = self.disk.lock();
            if let Some(refusal) = state.room.refusal() {
                return Err(refusal);
            }
            if !state.covers(&snapshot) {
                return Err(AppendError::Refused(Refusal::NotCovered {
                    cell: snapshot.cell,
                    covers: snapshot.covers.position,
                }));
            }
            // Of no use until its record is there.
            state.keep_body(taken.digest, snapshot.body);
        }
        match self.put(at, Record::SnapshotTaken(taken)).await? {
            Appended::New(receipt) => Ok(receipt),
            Appended::Replayed(_) => Err(AppendError::Closed {
                effect: Effect::Unknown,
            }),
        }
    }

    async fn snapshot(&self, cell: &str) -> Result<Option<Kept>, ReadError> {
        self.with(|state| {
            let Some((position, taken)) = state.durable().snapshots.get(cell) else {
                return Ok(None);
            };
            Ok(Some(match state.body(&taken.digest) {
                Some(body) => Kept::Whole(Snapshot {
                    position: *position,
                    taken: taken.clone(),
                    body: body.to_owned(),
                }),
                None => Kept::Damaged {
                    how: format!("the snapshot of cell `{cell}` is missing"),
                },
            }))
        })
    }

    async fn rows(&self, after: Position, limit: usize) -> Result<Vec<Row>, ReadError> {
        check_limit(limit)?;
        self.with(|state| Ok(state.rows_behind(after).take(limit).cloned().collect()))
    }

    async fn retained(&self, now: Clocks) -> Result<Retained, ReadError> {
        self.with(|state| Ok(state.retained(&now)))
    }

    async fn prune(
        &self,
        at: Clocks,
        through: Position,
        archive: Option<String>,
    ) -> Result<Pruning, AppendError> {
        let (retained, last) = {
            let state = self.disk.lock();
            let retained = state.retained(&at);
            let last = through.min(retained.removable);
            (retained, state.base_at(last))
        };
        let told: Vec<_> = {
            let state = self.disk.lock();
            let snapshots = state.durable().snapshots.values();
            let gone =
                snapshots.filter(|(at, _)| last.is_some_and(|last| *at <= last.head.position));
            gone.map(|(_, taken)| taken.clone()).collect()
        };
        for taken in told {
            let _receipt = self.put(at, Record::SnapshotTaken(taken)).await?;
        }
        let none = Pruning {
            base: retained.base,
            removed: 0,
        };
        let Some(last) = last else { return Ok(none) };
        let removed = last.head.position.0 - retained.base.position.0;
        let record = Record::Pruned(Pruned {
            through: last.head,
            records: removed,
            epoch: last.epoch,
            keys: last.keys,
            archive,
        });
        let _receipt = self.put(at, record).await?;
        Ok(Pruning {
            base: last.head,
            removed,
        })
    }

    async fn page(&self, after: Position, limit: usize) -> Result<Vec<Stored>, ReadError> {
        check_limit(limit)?;
        self.with(|state| {
            let rows = state.rows_behind(after);
            rows.take(limit)
                .map(|row| state.read(row.position))
                .collect()
        })
    }

    async fn lookup(&self, claim: &Claim, now: Clocks) -> Result<Option<Replay>, LookupError> {
        self.with(|state| {
            let index = state.durable();
            let known = index.key_facts(claim);
            match judge_claim(claim, known.as_ref(), index.keys, &now) {
                Ok(None) => Ok(Ok(None)),
                Ok(Some(entry)) => state.replay(&entry).map(|replay| Ok(Some(replay))),
                Err(refusal) => Ok(Err(LookupError::Refused(refusal))),
            }
        })
        .map_err(LookupError::Read)?
    }

    async fn motion(&self, motion: MotionId) -> Result<Option<MotionStory>, ReadError> {
        self.with(|state| {
            let Some(entry) = state.durable().motions.get(&motion) else {
                return Ok(None);
            };
            let read = |position: Option<Position>| position.map(|at| state.read(at)).transpose();
            if entry.intent <= state.base().position {
                return Ok(None);
            }
            Ok(Some(MotionStory {
                phase: entry.phase,
                intent: state.read(entry.intent)?,
                accepted: read(entry.accepted)?,
                outcome: read(entry.outcome)?,
                decision: read(entry.decision)?,
            }))
        })
    }

    async fn motions(
        &self,
        phases: &[MotionPhase],
        after: Position,
        limit: usize,
    ) -> Result<Vec<MotionEntry>, ReadError> {
        check_limit(limit)?;
        self.with(|state| {
            let motions = state.durable().motions.values();
            let mut found: Vec<_> = motions
                .filter(|entry| entry.intent > after && phases.contains(&entry.phase))
                .filter(|entry| {
                    // Of what is over the beginning may have been removed.
                    entry.phase != MotionPhase::Closed || entry.intent > state.base().position
                })
                .copied()
                .collect();
            found.sort_by_key(|entry| entry.intent);
            found.truncate(limit);
            Ok(found)
        })
    }

    async fn job(&self, job: JobId) -> Result<Option<JobEntry>, ReadError> {
        self.with(|state| Ok(state.durable().jobs.get(&job).copied()))
    }

    async fn open_jobs(&self, after: Position, limit: usize) -> Result<Vec<JobEntry>, ReadError> {
        check_limit(limit)?;
        self.with(|state| {
            let jobs = state.durable().jobs.values();
            let mut found: Vec<_> = jobs
                .filter(|entry| entry.created > after && entry.ended.is_none())
                .copied()
                .collect();
            found.sort_by_key(|entry| entry.created);
            found.truncate(limit);
            Ok(found)
        })
    }

    async fn latest_motions(
        &self,
        before: Position,
        limit: usize,
    ) -> Result<Vec<MotionEntry>, ReadError> {
        check_limit(limit)?;
        self.with(|state| {
            let motions = state.durable().motions.values();
            let mut found: Vec<_> = motions
                .filter(|entry| entry.intent < before && entry.intent > state.base().position)
                .copied()
                .collect();
            found.sort_by_key(|entry| std::cmp::Reverse(entry.intent));
            found.truncate(limit);
            Ok(found)
        })
    }

    async fn decided(
        &self,
        cell: &str,
        after: Position,
        limit: usize,
    ) -> Result<Vec<Stored>, ReadError> {
        check_limit(limit)?;
        self.with(|state| {
            let decided = state.durable().decided.range(after.next()..);
            decided
                .filter(|(_, of)| *of == cell)
                .take(limit)
                .map(|(position, _)| state.read(*position))
                .collect()
        })
    }

    async fn audits(&self, before: Position, limit: usize) -> Result<Vec<Stored>, ReadError> {
        check_limit(limit)?;
        self.with(|state| {
            let rows = state.rows().rev().filter(|row| row.position < before);
            let audits = rows.filter_map(|row| match state.read(row.position) {
                Ok(stored) => matches!(stored.record, Record::Audit(_)).then_some(Ok(stored)),
                Err(error) => Some(Err(error)),
            });
            audits.take(limit).collect()
        })
    }
}

async fn held(
    answer: oneshot::Receiver<Result<Appended, AppendError>>,
) -> Result<Appended, AppendError> {
    answer.await.unwrap_or(Err(AppendError::Closed {
        effect: Effect::Unknown,
    }))
}

impl State {
    fn read(&self, position: Position) -> Result<Stored, ReadError> {
        let row = self.row(position).ok_or(ReadError::Absent { position })?;
        Stored::decode(&row.body)
            .map_err(|source| ReadError::Broken(Arc::new(Broken::Unreadable { position, source })))
    }

    fn replay(&self, entry: &KeyEntry) -> Result<Replay, ReadError> {
        let motion = entry
            .motion
            .and_then(|motion| self.durable().motions.get(&motion));
        let read = |position: Option<Position>| position.map(|at| self.read(at)).transpose();
        Ok(Replay {
            first: self.read(entry.position)?,
            accepted: read(motion.and_then(|motion| motion.accepted))?,
            outcome: read(motion.and_then(|motion| motion.outcome))?,
        })
    }
}
