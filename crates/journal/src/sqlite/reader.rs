//! Reading, on any connection. Each record that is shown was checked against its own hash.

use std::sync::Arc;

use sqlx::sqlite::SqliteConnection;

use super::columns::{job_entry, motion_entry, phase_name, to_sql};
use super::store::record_row;
use super::upkeep;
use crate::{
    Broken, Head, JobEntry, JobId, Kept, KeyEntry, MotionEntry, MotionId, MotionPhase, MotionStory,
    Position, ReadError, Replay, Row, Stored,
};

/// Rows behind `after`, in their order, as they are.
pub(super) async fn rows(
    connection: &mut SqliteConnection,
    after: Position,
    limit: usize,
) -> Result<Vec<Row>, sqlx::Error> {
    sqlx::query("SELECT * FROM records WHERE position > ? ORDER BY position LIMIT ?")
        .bind(to_sql(after)?)
        .bind(sql_limit(limit))
        .fetch_all(connection)
        .await?
        .iter()
        .map(record_row)
        .collect()
}

pub(super) async fn page(
    connection: &mut SqliteConnection,
    after: Position,
    limit: usize,
) -> Result<Vec<Stored>, ReadError> {
    let rows = rows(connection, after, limit).await.map_err(store)?;
    rows.iter().map(checked).collect()
}

pub(super) async fn record(
    connection: &mut SqliteConnection,
    position: Position,
) -> Result<Stored, ReadError> {
    let row = sqlx::query("SELECT * FROM records WHERE position = ?")
        .bind(to_sql(position).map_err(store)?)
        .fetch_optional(connection)
        .await
        .map_err(store)?
        .ok_or(ReadError::Absent { position })?;
    checked(&record_row(&row).map_err(store)?)
}

async fn optional(
    connection: &mut SqliteConnection,
    position: Option<Position>,
) -> Result<Option<Stored>, ReadError> {
    match position {
        Some(position) => record(connection, position).await.map(Some),
        None => Ok(None),
    }
}

pub(super) async fn replay(
    connection: &mut SqliteConnection,
    entry: &KeyEntry,
) -> Result<Replay, ReadError> {
    let motion = match entry.motion {
        Some(motion) => motion_row(connection, motion).await?,
        None => None,
    };
    Ok(Replay {
        first: record(connection, entry.position).await?,
        accepted: optional(connection, motion.and_then(|motion| motion.accepted)).await?,
        outcome: optional(connection, motion.and_then(|motion| motion.outcome)).await?,
    })
}

pub(super) async fn story(
    connection: &mut SqliteConnection,
    motion: MotionId,
) -> Result<Option<MotionStory>, ReadError> {
    let Some(entry) = motion_row(connection, motion).await? else {
        return Ok(None);
    };
    let intent = match record(connection, entry.intent).await {
        Ok(intent) => intent,
        // It has ended, and its beginning was removed with the old records.
        Err(ReadError::Absent { position })
            if position <= upkeep::base(connection).await.map_err(store)?.head.position =>
        {
            return Ok(None);
        }
        Err(error) => return Err(error),
    };
    Ok(Some(MotionStory {
        phase: entry.phase,
        intent,
        accepted: optional(connection, entry.accepted).await?,
        outcome: optional(connection, entry.outcome).await?,
        decision: optional(connection, entry.decision).await?,
    }))
}

async fn motion_row(
    connection: &mut SqliteConnection,
    motion: MotionId,
) -> Result<Option<MotionEntry>, ReadError> {
    let row = sqlx::query("SELECT * FROM motions WHERE motion = ?")
        .bind(motion.to_string())
        .fetch_optional(connection)
        .await
        .map_err(store)?;
    row.as_ref().map(motion_entry).transpose().map_err(store)
}

pub(super) async fn motions(
    connection: &mut SqliteConnection,
    phases: &[MotionPhase],
    after: Position,
    limit: usize,
) -> Result<Vec<MotionEntry>, ReadError> {
    // The condition on `closed` is the one of the partial index: the few that are open among many that are not.
    let mut query = if phases.contains(&MotionPhase::Closed) {
        sqlx::query(
            "SELECT * FROM motions WHERE intent > ? AND phase IN (?, ?, ?, ?, ?) \
             AND intent > (SELECT coalesce(max(position), 0) FROM base) ORDER BY intent LIMIT ?",
        )
    } else {
        sqlx::query(
            "SELECT * FROM motions WHERE phase <> 'closed' AND intent > ? \
             AND phase IN (?, ?, ?, ?, ?) ORDER BY intent LIMIT ?",
        )
    };
    query = query.bind(to_sql(after).map_err(store)?);
    for phase in [
        MotionPhase::Open,
        MotionPhase::Accepted,
        MotionPhase::InDoubt,
        MotionPhase::Decided,
        MotionPhase::Closed,
    ] {
        query = query.bind(phases.contains(&phase).then(|| phase_name(phase)));
    }
    let rows = query
        .bind(sql_limit(limit))
        .fetch_all(connection)
        .await
        .map_err(store)?;
    rows.iter()
        .map(|row| motion_entry(row).map_err(store))
        .collect()
}

pub(super) async fn job(
    connection: &mut SqliteConnection,
    job: JobId,
) -> Result<Option<JobEntry>, ReadError> {
    let row = sqlx::query("SELECT * FROM jobs WHERE job = ?")
        .bind(job.to_string())
        .fetch_optional(connection)
        .await
        .map_err(store)?;
    row.as_ref().map(job_entry).transpose().map_err(store)
}

pub(super) async fn open_jobs(
    connection: &mut SqliteConnection,
    after: Position,
    limit: usize,
) -> Result<Vec<JobEntry>, ReadError> {
    let rows = sqlx::query(
        "SELECT * FROM jobs WHERE ended IS NULL AND created > ? ORDER BY created LIMIT ?",
    )
    .bind(to_sql(after).map_err(store)?)
    .bind(sql_limit(limit))
    .fetch_all(connection)
    .await
    .map_err(store)?;
    rows.iter()
        .map(|row| job_entry(row).map_err(store))
        .collect()
}

pub(super) async fn latest_motions(
    connection: &mut SqliteConnection,
    before: Position,
    limit: usize,
) -> Result<Vec<MotionEntry>, ReadError> {
    let rows = sqlx::query(
        "SELECT * FROM motions WHERE intent < ? \
         AND intent > (SELECT coalesce(max(position), 0) FROM base) ORDER BY intent DESC LIMIT ?",
    )
    .bind(to_sql(before).map_err(store)?)
    .bind(sql_limit(limit))
    .fetch_all(connection)
    .await
    .map_err(store)?;
    rows.iter()
        .map(|row| motion_entry(row).map_err(store))
        .collect()
}

pub(super) async fn decided(
    connection: &mut SqliteConnection,
    cell: &str,
    after: Position,
    limit: usize,
) -> Result<Vec<Stored>, ReadError> {
    let rows = sqlx::query(
        "SELECT records.* FROM decided JOIN records USING (position) \
         WHERE decided.cell = ? AND decided.position > ? ORDER BY decided.position LIMIT ?",
    )
    .bind(cell.to_owned())
    .bind(to_sql(after).map_err(store)?)
    .bind(sql_limit(limit))
    .fetch_all(connection)
    .await
    .map_err(store)?;
    rows.iter()
        .map(|row| checked(&record_row(row).map_err(store)?))
        .collect()
}

/// What was kept of a cell, compared with its record.
pub(super) async fn snapshot(
    connection: &mut SqliteConnection,
    cell: &str,
) -> Result<Option<Kept>, ReadError> {
    let found = upkeep::snapshot(connection, cell).await.map_err(store)?;
    let Some((at, body)) = found else {
        return Ok(None);
    };
    let told = match record(connection, at).await {
        Ok(told) => told,
        Err(error @ (ReadError::Absent { .. } | ReadError::Broken(_))) => {
            let how = error.to_string();
            return Ok(Some(Kept::Damaged { how }));
        }
        Err(error) => return Err(error),
    };
    Ok(Some(upkeep::judged(cell, at, &told.record, body)))
}

pub(super) async fn audits(
    connection: &mut SqliteConnection,
    before: Position,
    limit: usize,
) -> Result<Vec<Stored>, ReadError> {
    // The condition is the one of the partial index.
    let rows = sqlx::query(
        "SELECT * FROM records INDEXED BY records_audit \
         WHERE instr(body, '\"record\":{\"kind\":\"audit\"') > 0 AND position < ? \
         ORDER BY position DESC LIMIT ?",
    )
    .bind(to_sql(before).map_err(store)?)
    .bind(sql_limit(limit))
    .fetch_all(connection)
    .await
    .map_err(store)?;
    rows.iter()
        .map(|row| checked(&record_row(row).map_err(store)?))
        .collect()
}

/// What a row says, if it is what was hashed.
fn checked(row: &Row) -> Result<Stored, ReadError> {
    let before = Head {
        position: Position(row.position.0.saturating_sub(1)),
        hash: row.previous,
    };
    crate::Walker::new(before)
        .step(row)
        .map_err(|broken: Broken| ReadError::Broken(Arc::new(broken)))
}

fn sql_limit(limit: usize) -> i64 {
    i64::try_from(limit).unwrap_or(i64::MAX)
}

pub(super) fn store(error: sqlx::Error) -> ReadError {
    ReadError::Store(Arc::new(error))
}
