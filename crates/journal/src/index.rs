//! What the records amount to: motions, jobs and keys, kept in memory.
//!
//! The in-memory journal lives on it, and checking a journal on disk builds it again and compares.

use std::collections::{BTreeMap, HashMap};

use serde::{Deserialize, Serialize};

use crate::rules::{Change, Context, Facts, KeyFacts, Verdict, judge, wall_ms};
use crate::{
    Claim, Clocks, End, Epoch, Head, IdempotencyKey, JobEntry, JobId, KeyEntry, KeyRetention,
    MotionEntry, MotionId, MotionPhase, Position, Pruned, Record, Refusal, ServerStarted,
    SnapshotTaken, Stored,
};

#[derive(Clone, Debug, Default, Eq, PartialEq)]
pub(crate) struct Index {
    pub(crate) epoch: Epoch,
    pub(crate) keys: KeyRetention,
    pub(crate) motions: BTreeMap<MotionId, MotionEntry>,
    pub(crate) jobs: BTreeMap<JobId, JobEntry>,
    /// In no order: keys begin alike, so finding a place by comparing them would cost more than everything else here.
    pub(crate) claims: HashMap<IdempotencyKey, KeyEntry>,
    /// Where the decisions of cells stand.
    pub(crate) decided: BTreeMap<Position, String>,
    /// The newest snapshot of each cell, by where it is told of.
    pub(crate) snapshots: BTreeMap<String, (Position, SnapshotTaken)>,
    /// The last record that was removed, as the newest record about it says.
    pub(crate) pruned: Base,
    /// What the index was begun behind: of motions and jobs that began before, only the rest is known.
    base: Position,
    /// The same keys by the time of their use, and by the place of the record that took them: the wall clock may
    /// have jumped between two records, so these are two orders.
    by_time: BTreeMap<(i64, Position), IdempotencyKey>,
    by_place: BTreeMap<Position, IdempotencyKey>,
}

/// What the records of a journal begin behind, where older ones were removed.
#[derive(Clone, Copy, Debug, Default, Eq, PartialEq, Serialize, Deserialize)]
pub(crate) struct Base {
    /// The last one that was removed.
    #[serde(flatten)]
    pub(crate) head: Head,
    /// The epoch there.
    pub(crate) epoch: Epoch,
    /// How long keys were remembered there.
    pub(crate) keys: KeyRetention,
}

impl Base {
    pub(crate) fn of(pruned: &Pruned) -> Self {
        Self {
            head: pruned.through,
            epoch: pruned.epoch,
            keys: pruned.keys,
        }
    }

    pub(crate) fn is_start(&self) -> bool {
        self.head == Head::EMPTY
    }
}

impl Index {
    /// Of a journal whose records up to `base` are gone.
    pub(crate) fn behind(base: Base) -> Self {
        Self {
            base: base.head.position,
            epoch: base.epoch,
            keys: base.keys,
            ..Self::default()
        }
    }

    pub(crate) fn start(&mut self, started: &ServerStarted) {
        self.epoch = started.epoch;
        self.keys = started.keys;
    }

    pub(crate) fn judge(
        &self,
        record: &Record,
        at: Clocks,
        position: Position,
    ) -> Result<Verdict, Refusal> {
        let facts = Facts {
            motion: record.motion().and_then(|motion| {
                let known = self.motions.get(&motion).copied();
                known.or_else(|| self.begun_before(record, motion))
            }),
            job: record.job().and_then(|job| {
                let known = self.jobs.get(&job).copied();
                known.or_else(|| self.created_before(record, job))
            }),
            key: record.claim().and_then(|claim| self.key_facts(claim)),
        };
        let context = Context {
            epoch: self.epoch,
            keys: self.keys,
            at,
            position,
        };
        judge(record, &facts, &context)
    }

    /// A motion whose intent is gone, as the first record left of it shows it.
    fn begun_before(&self, record: &Record, motion: MotionId) -> Option<MotionEntry> {
        let phase = if let Record::Outcome(outcome) = record {
            match outcome.end {
                End::InDoubt { .. } => MotionPhase::Accepted,
                End::Done { .. }
                | End::Rejected { .. }
                | End::NotExecuted { .. }
                | End::Interrupted { .. } => MotionPhase::Decided,
            }
        } else if matches!(record, Record::Accepted(_)) {
            MotionPhase::Open
        } else if matches!(record, Record::Decision(_)) {
            MotionPhase::InDoubt
        } else {
            return None;
        };
        (self.base > Position::START).then_some(MotionEntry {
            motion,
            phase,
            intent: Position::START,
            accepted: None,
            outcome: None,
            decision: None,
        })
    }

    /// A job whose creation is gone.
    fn created_before(&self, record: &Record, job: JobId) -> Option<JobEntry> {
        let creates = matches!(record, Record::JobCreated(_));
        (self.base > Position::START && !creates).then_some(JobEntry {
            job,
            created: Position::START,
            latest: Position::START,
            ended: None,
        })
    }

    pub(crate) fn key_facts(&self, claim: &Claim) -> Option<KeyFacts> {
        let entry = self.claims.get(&claim.key)?;
        Some(KeyFacts {
            entry: entry.clone(),
            phase: self.phase(entry),
        })
    }

    pub(crate) fn apply(&mut self, change: Change, at: &Clocks) {
        if let Some(motion) = change.motion {
            let _before = self.motions.insert(motion.motion, motion);
        }
        if let Some(job) = change.job {
            let _before = self.jobs.insert(job.job, job);
        }
        if let Some((position, cell)) = change.decided {
            let _before = self.decided.insert(position, cell);
        }
        if let Some(key) = change.key {
            self.forget_expired(at);
            let name = key.claim.key.clone();
            let _before = self
                .by_time
                .insert((key.used_ms, key.position), name.clone());
            let _before = self.by_place.insert(key.position, name);
            let _before = self.claims.insert(key.claim.key.clone(), key);
            self.forget_surplus();
        }
    }

    /// Takes up a record that was kept before; what it changes.
    pub(crate) fn replay(&mut self, stored: &Stored) -> Result<Change, Refusal> {
        if let Record::ServerStarted(started) = &stored.record {
            self.start(started);
            return Ok(Change::default());
        }
        let change = match self.judge(&stored.record, stored.at, stored.position) {
            Ok(Verdict::Keep(change)) => change,
            judged => {
                let refusal = match judged {
                    Err(refusal) => refusal,
                    Ok(Verdict::Keep(_) | Verdict::Replay(_)) => Refusal::KeyReused {
                        first: stored.position,
                    },
                };
                self.judged_without_its_key(stored).ok_or(refusal)?
            }
        };
        self.keep(stored, change.clone());
        Ok(change)
    }

    /// Takes up a record that was judged, and is none of a start.
    pub(crate) fn keep(&mut self, stored: &Stored, change: Change) {
        if let Record::SnapshotTaken(taken) = &stored.record {
            let entry = (stored.position, taken.clone());
            let _before = self.snapshots.insert(taken.cell.clone(), entry);
        }
        if let Record::Pruned(pruned) = &stored.record {
            self.pruned = Base::of(pruned);
        }
        self.apply(change, &stored.at);
    }

    /// Behind removed records a key may have been forgotten earlier than the rest alone explains, because those
    /// before counted too. That it was used again shows it.
    fn judged_without_its_key(&mut self, stored: &Stored) -> Option<Change> {
        let key = stored.record.claim()?.key.clone();
        if self.base == Position::START {
            return None;
        }
        self.forget(vec![key]);
        match self.judge(&stored.record, stored.at, stored.position) {
            Ok(Verdict::Keep(change)) => Some(change),
            Ok(Verdict::Replay(_)) | Err(_) => None,
        }
    }

    /// Forgets what is at its end and stands before `first` as a whole: of use to a journal that keeps no old records.
    pub(crate) fn forget_before(&mut self, first: Position) {
        self.motions.retain(|_, entry| {
            let latest = [entry.accepted, entry.outcome, entry.decision];
            let latest = latest
                .into_iter()
                .flatten()
                .fold(entry.intent, Position::max);
            entry.phase != MotionPhase::Closed || latest >= first
        });
        self.jobs
            .retain(|_, entry| entry.ended.is_none() || entry.latest >= first);
        self.decided = self.decided.split_off(&first);
        let gone: Vec<_> = self
            .by_place
            .range(..first)
            .map(|(_, key)| key)
            .filter(|key| self.may_go(key))
            .cloned()
            .collect();
        self.forget(gone);
    }

    fn phase(&self, entry: &KeyEntry) -> Option<MotionPhase> {
        let motion = entry.motion?;
        self.motions.get(&motion).map(|motion| motion.phase)
    }

    fn forget_expired(&mut self, at: &Clocks) {
        let until = self.keys.expired_until(wall_ms(at));
        let gone: Vec<_> = self
            .by_time
            .range(..=(until, Position(u64::MAX)))
            .map(|(_, key)| key)
            .filter(|key| self.may_go(key))
            .cloned()
            .collect();
        self.forget(gone);
    }

    fn forget_surplus(&mut self) {
        let max = usize::try_from(self.keys.max_count).unwrap_or(usize::MAX);
        let surplus = self.claims.len().saturating_sub(max);
        let gone: Vec<_> = self
            .by_place
            .values()
            .filter(|key| self.may_go(key))
            .take(surplus)
            .cloned()
            .collect();
        self.forget(gone);
    }

    fn may_go(&self, key: &IdempotencyKey) -> bool {
        self.claims
            .get(key)
            .is_some_and(|entry| self.phase(entry) != Some(MotionPhase::Open))
    }

    fn forget(&mut self, keys: Vec<IdempotencyKey>) {
        for key in keys {
            if let Some(entry) = self.claims.remove(&key) {
                drop(self.by_time.remove(&(entry.used_ms, entry.position)));
                drop(self.by_place.remove(&entry.position));
            }
        }
    }
}
