//! Snapshots and the removal of old records. Each function is part of the caller's transaction.
//!
//! ```text
//!  removed        kept: chain, tables                      head
//! ─────────┤base├──────────────┬────────────┬─────────────▶
//!                              covers       its record        what is behind `covers` is folded at a start
//! ```
//! The base grows and never goes beyond what a motion without an end, a key or a start still needs. A program that
//! does not know of it would take the rest for the whole, so that the first removal raises the file's version.

use sqlx::Row as _;
use sqlx::sqlite::SqliteConnection;

use super::columns::{self, digest, int, position, to_sql};
use super::store::{Store, record_row};
use crate::index::Base;
use crate::rules::wall_ms;
use crate::{
    Clocks, Digest, Epoch, Head, Kept, KeyRetention, NewSnapshot, Position, Record, Refusal,
    Retained, Snapshot, SnapshotTaken, Stored,
};

/// Records removed at a time: some ten milliseconds.
const STEP: u64 = 1_000;

/// The version of a file of which records were removed.
pub(super) const PRUNED_VERSION: i64 = 2;

/// Where the records begin. A journal that no newer program has opened yet has no such table.
pub(super) async fn base(connection: &mut SqliteConnection) -> Result<Base, sqlx::Error> {
    if !is_there(connection, "base").await? {
        return Ok(Base::default());
    }
    let row = sqlx::query("SELECT * FROM base")
        .fetch_optional(connection)
        .await?;
    row.map_or(Ok(Base::default()), |row| {
        Ok(Base {
            head: columns::head_of(&row)?,
            epoch: Epoch(columns::unsigned(&row, "epoch")?),
            keys: columns::keys_of(&row)?,
        })
    })
}

pub(super) async fn is_there(
    connection: &mut SqliteConnection,
    table: &'static str,
) -> Result<bool, sqlx::Error> {
    let found = sqlx::query("SELECT 1 FROM sqlite_schema WHERE type = 'table' AND name = ?")
        .bind(table)
        .fetch_optional(connection)
        .await?;
    Ok(found.is_some())
}

/// The last record nobody needs any more, as far as the tables tell.
pub(super) async fn retained(
    connection: &mut SqliteConnection,
    keys: KeyRetention,
    now: Clocks,
) -> Result<Retained, sqlx::Error> {
    let base = base(connection).await?;
    // The newest one always stays: the chain goes on behind it. Before a cell's first snapshot all its decisions are
    // needed, afterwards those behind what it covers. The cells are stepped through along their index.
    let row = sqlx::query(
        "WITH RECURSIVE cells (cell) AS (\
           SELECT min(cell) FROM decided UNION ALL \
           SELECT (SELECT min(decided.cell) FROM decided WHERE decided.cell > cells.cell) FROM cells \
             WHERE cells.cell IS NOT NULL) \
         SELECT min(needed) AS needed FROM (\
           SELECT position AS needed FROM head \
           UNION ALL SELECT min(intent) FROM motions WHERE phase <> 'closed' \
           UNION ALL SELECT min(created) FROM jobs WHERE ended IS NULL \
           UNION ALL SELECT min(keys.position) FROM keys LEFT JOIN motions USING (motion) \
             WHERE used_ms > ? OR phase = 'open' \
           UNION ALL SELECT (SELECT min(position) FROM decided WHERE decided.cell = cells.cell \
             AND position > coalesce((SELECT covers FROM snapshots WHERE snapshots.cell = cells.cell), 0)) \
             FROM cells)",
    )
    .bind(keys.expired_until(wall_ms(&now)))
    .fetch_one(connection)
    .await?;
    let needed: Option<i64> = row.try_get("needed")?;
    let needed = needed.and_then(|at| u64::try_from(at).ok()).unwrap_or(0);
    Ok(Retained {
        base: base.head,
        removable: Position(needed.saturating_sub(1)).max(base.head.position),
    })
}

/// What was kept of a cell, compared with its record.
pub(super) async fn snapshot(
    connection: &mut SqliteConnection,
    cell: &str,
) -> Result<Option<(Position, String)>, sqlx::Error> {
    let row = sqlx::query("SELECT position, body FROM snapshots WHERE cell = ?")
        .bind(cell.to_owned())
        .fetch_optional(connection)
        .await?;
    row.map(|row| {
        // As bytes: a damaged text may be no text any more.
        let body: Vec<u8> = row.try_get_unchecked("body")?;
        let body = String::from_utf8_lossy(&body).into_owned();
        Ok((position(&row, "position")?, body))
    })
    .transpose()
}

/// A snapshot against the record that tells of it.
pub(super) fn judged(cell: &str, at: Position, record: &Record, body: String) -> Kept {
    let Record::SnapshotTaken(taken) = record else {
        let how = format!("record {at} tells of no snapshot");
        return Kept::Damaged { how };
    };
    if taken.cell != cell || taken.digest != Digest::of(body.as_bytes()) {
        let how = format!("the snapshot of cell `{cell}` is not the one that record {at} tells of");
        return Kept::Damaged { how };
    }
    Kept::Whole(Snapshot {
        position: at,
        taken: taken.clone(),
        body,
    })
}

impl Store {
    /// Whether a snapshot covers what it says; the record that tells of it.
    pub(super) async fn judge_snapshot(
        &mut self,
        snapshot: &NewSnapshot,
    ) -> Result<Result<Record, Refusal>, sqlx::Error> {
        let covered = sqlx::query(
            "SELECT hash FROM records JOIN decided USING (position) WHERE position = ? AND cell = ?",
        )
        .bind(to_sql(snapshot.covers.position)?)
        .bind(snapshot.cell.clone())
        .fetch_optional(&mut self.connection)
        .await?;
        let hash = covered.map(|row| digest(&row, "hash")).transpose()?;
        if hash != Some(snapshot.covers.hash) {
            return Ok(Err(Refusal::NotCovered {
                cell: snapshot.cell.clone(),
                covers: snapshot.covers.position,
            }));
        }
        Ok(Ok(Record::SnapshotTaken(SnapshotTaken {
            cell: snapshot.cell.clone(),
            covers: snapshot.covers,
            format: snapshot.format,
            bytes: snapshot.body.len() as u64,
            digest: Digest::of(snapshot.body.as_bytes()),
        })))
    }

    /// Keeps the text of the snapshot that the last record tells of.
    pub(super) async fn keep_snapshot(
        &mut self,
        cell: &str,
        covers: Position,
        body: &str,
    ) -> Result<(), sqlx::Error> {
        let position = self.head.position;
        self.keep_snapshot_of(cell, position, covers, body).await
    }

    /// Keeps the text of the snapshot that a record tells of.
    pub(super) async fn keep_snapshot_of(
        &mut self,
        cell: &str,
        position: Position,
        covers: Position,
        body: &str,
    ) -> Result<(), sqlx::Error> {
        self.run(
            sqlx::query("INSERT OR REPLACE INTO snapshots VALUES (?, ?, ?, ?)")
                .bind(cell.to_owned())
                .bind(to_sql(position)?)
                .bind(to_sql(covers)?)
                .bind(body.to_owned()),
        )
        .await
    }

    /// How far the next removal goes: what is there up to then, and how many that are; none if nothing can go.
    pub(super) async fn removable(
        &mut self,
        now: Clocks,
        through: Position,
    ) -> Result<(Retained, Option<Base>), sqlx::Error> {
        let keys = self.keys;
        let retained = retained(&mut self.connection, keys, now).await?;
        let step = Position(retained.base.position.0 + STEP);
        let last = through.min(retained.removable).min(step);
        if last <= retained.base.position {
            return Ok((retained, None));
        }
        let row = sqlx::query("SELECT * FROM records WHERE position = ?")
            .bind(to_sql(last)?)
            .fetch_one(&mut self.connection)
            .await?;
        let row = record_row(&row)?;
        // The same condition as a decoding, at a hundredth of its time.
        let started = sqlx::query(
            "SELECT * FROM records WHERE position <= ? \
             AND instr(body, '\"record\":{\"kind\":\"server_started\"') > 0 \
             ORDER BY position DESC LIMIT 1",
        )
        .bind(to_sql(last)?)
        .fetch_optional(&mut self.connection)
        .await?;
        let decode = |body: &[u8]| {
            Stored::decode(body).map_err(|error| sqlx::Error::Decode(Box::new(error)))
        };
        let keys = match started {
            None => base(&mut self.connection).await?.keys,
            Some(started) => {
                let started = decode(&record_row(&started)?.body)?.record;
                if let Record::ServerStarted(started) = started {
                    started.keys
                } else {
                    keys
                }
            }
        };
        let base = Base {
            epoch: decode(&row.body)?.epoch,
            keys,
            head: Head {
                position: row.position,
                hash: row.hash,
            },
        };
        Ok((retained, Some(base)))
    }

    /// The snapshots whose records stand up to `last`.
    pub(super) async fn snapshots_told_by(
        &mut self,
        last: Position,
    ) -> Result<Vec<(String, Record)>, sqlx::Error> {
        let rows = sqlx::query(
            "SELECT records.*, cell FROM snapshots JOIN records USING (position) \
             WHERE position <= ? ORDER BY cell",
        )
        .bind(to_sql(last)?)
        .fetch_all(&mut self.connection)
        .await?;
        rows.iter()
            .map(|row| {
                let stored = Stored::decode(&record_row(row)?.body)
                    .map_err(|error| sqlx::Error::Decode(Box::new(error)))?;
                Ok((row.try_get("cell")?, stored.record))
            })
            .collect()
    }

    /// The last record tells of a cell's snapshot from now on.
    pub(super) async fn retell_snapshot(&mut self, cell: &str) -> Result<(), sqlx::Error> {
        self.run(
            sqlx::query("UPDATE snapshots SET position = ? WHERE cell = ?")
                .bind(to_sql(self.head.position)?)
                .bind(cell.to_owned()),
        )
        .await
    }

    /// Removes what stands up to `last`, and what is known of it alone.
    pub(super) async fn remove_through(&mut self, last: Base) -> Result<(), sqlx::Error> {
        let at = to_sql(last.head.position)?;
        for statement in [
            "DELETE FROM records WHERE position <= ?",
            "DELETE FROM decided WHERE position <= ?",
            "DELETE FROM keys WHERE position <= ?",
            // One that began before and ended behind is still to be recognized.
            "DELETE FROM motions WHERE intent <= ?1 AND phase = 'closed' AND coalesce(accepted, 0) <= ?1 \
             AND coalesce(outcome, 0) <= ?1 AND coalesce(decision, 0) <= ?1",
            "DELETE FROM jobs WHERE latest <= ? AND ended IS NOT NULL",
        ] {
            self.run(sqlx::query(statement).bind(at)).await?;
        }
        self.set_base(last).await?;
        self.count_keys_again().await
    }
}

/// The texts of all snapshots, for an export.
pub(super) async fn snapshots(
    connection: &mut SqliteConnection,
) -> Result<Vec<(String, Position, String)>, sqlx::Error> {
    if !is_there(connection, "snapshots").await? {
        return Ok(Vec::new());
    }
    let rows = sqlx::query("SELECT * FROM snapshots ORDER BY cell")
        .fetch_all(connection)
        .await?;
    rows.iter()
        .map(|row| {
            let body: Vec<u8> = row.try_get_unchecked("body")?;
            let body = String::from_utf8_lossy(&body).into_owned();
            Ok((row.try_get("cell")?, position(row, "position")?, body))
        })
        .collect()
}

impl Store {
    /// Begins an empty journal behind `base`.
    pub(super) async fn begin_behind(&mut self, base: Base) -> Result<(), sqlx::Error> {
        (self.head, self.epoch, self.keys) = (base.head, base.epoch, base.keys);
        self.set_base(base).await
    }

    async fn set_base(&mut self, base: Base) -> Result<(), sqlx::Error> {
        self.run(
            sqlx::query("INSERT OR REPLACE INTO base VALUES (1, ?, ?, ?, ?, ?)")
                .bind(to_sql(base.head.position)?)
                .bind(base.head.hash.as_bytes().to_vec())
                .bind(int(base.epoch.0)?)
                .bind(i64::from(base.keys.max_age_s))
                .bind(i64::from(base.keys.max_count)),
        )
        .await?;
        // A number of this module; a pragma takes no parameter.
        let _done = sqlx::raw_sql("PRAGMA user_version = 2")
            .execute(&mut self.connection)
            .await?;
        Ok(())
    }
}
