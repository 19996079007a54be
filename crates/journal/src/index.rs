//! What the records amount to: motions, jobs and keys, kept in memory.
//!
//! The in-memory journal lives on it, and checking a journal on disk builds it again and compares.

use std::collections::BTreeMap;

use crate::rules::{Change, Context, Facts, KeyFacts, Verdict, judge, wall_ms};
use crate::{
    Claim, Clocks, Epoch, IdempotencyKey, JobEntry, JobId, KeyEntry, KeyRetention, MotionEntry,
    MotionId, MotionPhase, Position, Record, Refusal, ServerStarted, Stored,
};

#[derive(Clone, Debug, Default, Eq, PartialEq)]
pub(crate) struct Index {
    pub(crate) epoch: Epoch,
    pub(crate) keys: KeyRetention,
    pub(crate) motions: BTreeMap<MotionId, MotionEntry>,
    pub(crate) jobs: BTreeMap<JobId, JobEntry>,
    pub(crate) claims: BTreeMap<IdempotencyKey, KeyEntry>,
    /// Where the decisions of cells stand.
    pub(crate) decided: BTreeMap<Position, String>,
    /// The same keys by the time of their use, and by the place of the record that took them: the wall clock may
    /// have jumped between two records, so these are two orders.
    by_time: BTreeMap<(i64, Position), IdempotencyKey>,
    by_place: BTreeMap<Position, IdempotencyKey>,
}

impl Index {
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
            motion: record
                .motion()
                .and_then(|motion| self.motions.get(&motion).copied()),
            job: record.job().and_then(|job| self.jobs.get(&job).copied()),
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

    /// Takes up a record that was kept before.
    pub(crate) fn replay(&mut self, stored: &Stored) -> Result<(), Refusal> {
        if let Record::ServerStarted(started) = &stored.record {
            self.start(started);
            return Ok(());
        }
        match self.judge(&stored.record, stored.at, stored.position)? {
            Verdict::Keep(change) => {
                self.apply(change, &stored.at);
                Ok(())
            }
            Verdict::Replay(entry) => Err(Refusal::KeyReused {
                first: entry.position,
            }),
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
