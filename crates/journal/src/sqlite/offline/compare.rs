//! What the records amount to, against the tables that say it.

use std::collections::BTreeSet;

use sqlx::Row as _;
use sqlx::sqlite::{SqliteConnection, SqliteRow};

use super::super::columns::{self, job_entry, key_entry, motion_entry};
use super::super::upkeep;
use super::VerifyError;
use crate::index::{Base, Index};
use crate::{Head, Kept, KeyEntry, MotionEntry, Position, Record};

/// What the records amount to, against the tables.
pub(super) struct Comparison<'a> {
    pub(super) index: &'a Index,
    pub(super) base: Base,
}

type Compared<T> = Result<Result<T, VerifyError>, sqlx::Error>;

impl Comparison<'_> {
    /// The tables, one row after the other.
    pub(super) async fn with(&self, connection: &mut SqliteConnection, head: Head) -> Compared<()> {
        let Self { index, .. } = self;
        let differs = |table| Ok(Err(VerifyError::Index { table }));
        if columns::head(connection).await? != (head, index.epoch, index.keys) {
            return differs("head");
        }
        let mut motions = index.motions.values();
        for row in sqlx::query("SELECT * FROM motions ORDER BY motion")
            .fetch_all(&mut *connection)
            .await?
        {
            if motions.next().copied() != Some(self.visible(motion_entry(&row)?)) {
                return differs("motions");
            }
        }
        let mut jobs = index.jobs.values();
        for row in sqlx::query("SELECT * FROM jobs ORDER BY job")
            .fetch_all(&mut *connection)
            .await?
        {
            let mut entry = job_entry(&row)?;
            if entry.created <= self.base.head.position {
                entry.created = Position::START;
            }
            if jobs.next() != Some(&entry) {
                return differs("jobs");
            }
        }
        let keys = sqlx::query("SELECT * FROM keys ORDER BY key")
            .fetch_all(&mut *connection)
            .await?;
        let keys: Result<Vec<_>, _> = keys.iter().map(key_entry).collect();
        if !self.are_keys(&keys?) {
            return differs("keys");
        }
        let mut decided = index.decided.iter();
        for row in decided_rows(connection).await? {
            let position = columns::position(&row, "position")?;
            let cell: String = row.try_get("cell")?;
            if decided.next() != Some((&position, &cell)) {
                return differs("decided");
            }
        }
        if decided.next().is_some() {
            return differs("decided");
        }
        match (motions.next(), jobs.next()) {
            (None, None) => Ok(Ok(())),
            (Some(_), _) => differs("motions"),
            (None, Some(_)) => differs("jobs"),
        }
    }

    /// An entry without what stands in records that were removed.
    fn visible(&self, entry: MotionEntry) -> MotionEntry {
        if entry.intent > self.base.head.position {
            return entry;
        }
        let kept = |at: Option<Position>| at.filter(|at| *at > self.base.head.position);
        MotionEntry {
            intent: Position::START,
            accepted: kept(entry.accepted),
            outcome: kept(entry.outcome),
            decision: kept(entry.decision),
            ..entry
        }
    }

    /// The keys are those of the records. Where old records were removed, the oldest keys behind them may have been
    /// forgotten earlier than the rest alone explains, because more of them counted then.
    fn are_keys(&self, keys: &[KeyEntry]) -> bool {
        let known = &self.index.claims;
        let all_known = keys
            .iter()
            .all(|entry| known.get(&entry.claim.key) == Some(entry));
        if !all_known || keys.len() == known.len() || self.base.is_start() {
            return all_known && keys.len() == known.len();
        }
        let oldest = keys.iter().map(|entry| entry.position).min();
        let there: BTreeSet<_> = keys.iter().map(|entry| &entry.claim.key).collect();
        known
            .values()
            .filter(|entry| !there.contains(&entry.claim.key))
            .all(|entry| oldest.is_none_or(|oldest| entry.position < oldest))
    }

    /// Each snapshot is what its record tells of; how many there are.
    pub(super) async fn snapshots(&self, connection: &mut SqliteConnection) -> Compared<usize> {
        let kept = upkeep::snapshots(connection).await?;
        let wrong = |how| Ok(Err(VerifyError::Snapshot { how }));
        for (cell, at, body) in &kept {
            let Some((told_at, taken)) = self.index.snapshots.get(cell) else {
                return wrong(format!("no record tells of the snapshot of cell `{cell}`"));
            };
            let record = Record::SnapshotTaken(taken.clone());
            if told_at != at {
                return wrong(format!(
                    "the snapshot of cell `{cell}` is of record {at}, the newest of record {told_at}"
                ));
            }
            if let Kept::Damaged { how } = upkeep::judged(cell, *at, &record, body.clone()) {
                return wrong(how);
            }
        }
        // Without the old records a start depends on it.
        let missing = self
            .index
            .snapshots
            .keys()
            .find(|cell| !kept.iter().any(|(kept, ..)| kept == *cell));
        match missing.filter(|_| !self.base.is_start()) {
            Some(cell) => wrong(format!("the snapshot of cell `{cell}` is missing")),
            None => Ok(Ok(kept.len())),
        }
    }
}

/// The table of the decisions. A journal that no newer program has opened yet does not have it.
async fn decided_rows(connection: &mut SqliteConnection) -> Result<Vec<SqliteRow>, sqlx::Error> {
    let there =
        sqlx::query("SELECT 1 FROM sqlite_schema WHERE type = 'table' AND name = 'decided'")
            .fetch_optional(&mut *connection)
            .await?;
    if there.is_none() {
        return Ok(Vec::new());
    }
    sqlx::query("SELECT * FROM decided ORDER BY position")
        .fetch_all(connection)
        .await
}
