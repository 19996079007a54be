//! Columns to values and back. What does not fit is an error of the store, never a guess.

use std::str::FromStr;

use sqlx::Row as _;
use sqlx::sqlite::{SqliteConnection, SqliteRow};
use uuid::Uuid;

use crate::{
    Claim, Digest, Epoch, Head, IdempotencyKey, JobEntry, JobId, KeyEntry, KeyRetention,
    MotionEntry, MotionId, MotionPhase, Position,
};

const PHASES: [(MotionPhase, &str); 5] = [
    (MotionPhase::Open, "open"),
    (MotionPhase::Accepted, "accepted"),
    (MotionPhase::InDoubt, "in_doubt"),
    (MotionPhase::Decided, "decided"),
    (MotionPhase::Closed, "closed"),
];

pub(super) fn phase_name(phase: MotionPhase) -> &'static str {
    match phase {
        MotionPhase::Open => "open",
        MotionPhase::Accepted => "accepted",
        MotionPhase::InDoubt => "in_doubt",
        MotionPhase::Decided => "decided",
        MotionPhase::Closed => "closed",
    }
}

pub(super) fn phase(name: &str) -> Result<MotionPhase, sqlx::Error> {
    PHASES
        .iter()
        .find(|(_, known)| *known == name)
        .map(|(phase, _)| *phase)
        .ok_or_else(|| decode(format!("no motion phase is called {name:?}")))
}

/// SQLite's integers are signed; the journal's never reach the sign.
pub(super) fn int(value: u64) -> Result<i64, sqlx::Error> {
    i64::try_from(value).map_err(|error| sqlx::Error::Encode(error.into()))
}

pub(super) fn to_sql(position: Position) -> Result<i64, sqlx::Error> {
    int(position.0)
}

pub(super) fn unsigned(row: &SqliteRow, column: &str) -> Result<u64, sqlx::Error> {
    let value: i64 = row.try_get(column)?;
    u64::try_from(value).map_err(decode)
}

pub(super) fn position(row: &SqliteRow, column: &str) -> Result<Position, sqlx::Error> {
    unsigned(row, column).map(Position)
}

pub(super) fn digest(row: &SqliteRow, column: &str) -> Result<Digest, sqlx::Error> {
    let bytes: Vec<u8> = row.try_get(column)?;
    let bytes = <[u8; 32]>::try_from(bytes)
        .map_err(|bytes| decode(format!("a hash has 32 bytes, not {}", bytes.len())))?;
    Ok(Digest::from_bytes(bytes))
}

pub(super) fn motion_entry(row: &SqliteRow) -> Result<MotionEntry, sqlx::Error> {
    Ok(MotionEntry {
        motion: MotionId(uuid(row, "motion")?),
        phase: phase(row.try_get("phase")?)?,
        intent: position(row, "intent")?,
        accepted: optional(row, "accepted")?,
        outcome: optional(row, "outcome")?,
        decision: optional(row, "decision")?,
    })
}

pub(super) fn job_entry(row: &SqliteRow) -> Result<JobEntry, sqlx::Error> {
    Ok(JobEntry {
        job: JobId(uuid(row, "job")?),
        created: position(row, "created")?,
        latest: position(row, "latest")?,
        ended: optional(row, "ended")?,
    })
}

pub(super) fn key_entry(row: &SqliteRow) -> Result<KeyEntry, sqlx::Error> {
    let key: String = row.try_get("key")?;
    let motion: Option<String> = row.try_get("motion")?;
    Ok(KeyEntry {
        claim: Claim {
            key: IdempotencyKey::try_new(key).map_err(decode)?,
            body: digest(row, "body")?,
        },
        position: position(row, "position")?,
        used_ms: row.try_get("used_ms")?,
        motion: motion
            .map(|text| Uuid::from_str(&text).map(MotionId).map_err(decode))
            .transpose()?,
    })
}

/// The row of `head`.
pub(super) async fn head(
    connection: &mut SqliteConnection,
) -> Result<(Head, Epoch, KeyRetention), sqlx::Error> {
    let row = sqlx::query("SELECT * FROM head")
        .fetch_one(connection)
        .await?;
    Ok((
        head_of(&row)?,
        Epoch(unsigned(&row, "epoch")?),
        keys_of(&row)?,
    ))
}

pub(super) fn head_of(row: &SqliteRow) -> Result<Head, sqlx::Error> {
    Ok(Head {
        position: position(row, "position")?,
        hash: digest(row, "hash")?,
    })
}

pub(super) fn keys_of(row: &SqliteRow) -> Result<KeyRetention, sqlx::Error> {
    let small =
        |column| unsigned(row, column).and_then(|value| u32::try_from(value).map_err(decode));
    Ok(KeyRetention {
        max_age_s: small("max_age_s")?,
        max_count: small("max_count")?,
    })
}

fn optional(row: &SqliteRow, column: &str) -> Result<Option<Position>, sqlx::Error> {
    let value: Option<i64> = row.try_get(column)?;
    value
        .map(|value| u64::try_from(value).map(Position).map_err(decode))
        .transpose()
}

fn uuid(row: &SqliteRow, column: &str) -> Result<Uuid, sqlx::Error> {
    let text: String = row.try_get(column)?;
    text.parse().map_err(decode)
}

fn decode(error: impl Into<Box<dyn std::error::Error + Send + Sync>>) -> sqlx::Error {
    sqlx::Error::Decode(error.into())
}
