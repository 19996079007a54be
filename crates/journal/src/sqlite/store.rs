//! Records and what they amount to, in tables. Each function is part of the caller's transaction.

use sqlx::sqlite::{SqliteArguments, SqliteConnection, SqliteRow};
use sqlx::{Row as _, Sqlite};

use super::columns::{
    self, digest, job_entry, key_entry, motion_entry, phase_name, position, to_sql,
};
use crate::rules::{Change, Context, Facts, KeyFacts, Verdict, judge, wall_ms};
use crate::{
    Claim, Clocks, Epoch, Head, JobEntry, JobId, KeyRetention, MotionEntry, MotionId, Record,
    Refusal, Row, ServerStarted,
};

pub(super) const APPLICATION_ID: i64 = 0x526f_624a; // "RobJ"
pub(super) const SCHEMA_VERSION: i64 = 1;
const SCHEMA: &str = include_str!("schema.sql");
const SCHEMA_ADDED: &str = include_str!("schema_added.sql");

pub(super) type Query = sqlx::query::Query<'static, Sqlite, SqliteArguments>;

/// The tables, and what the writer remembers of them.
#[derive(Debug)]
pub(super) struct Store {
    pub(super) connection: SqliteConnection,
    pub(super) head: Head,
    pub(super) epoch: Epoch,
    pub(super) keys: KeyRetention,
    key_count: u64,
}

impl Store {
    /// Makes the tables in an empty file.
    pub(super) async fn create(connection: &mut SqliteConnection) -> Result<(), sqlx::Error> {
        let _done = sqlx::raw_sql("BEGIN IMMEDIATE")
            .execute(&mut *connection)
            .await?;
        let _done = sqlx::raw_sql(SCHEMA).execute(&mut *connection).await?;
        // Numbers of this module, not of the outside; a pragma takes no parameter.
        let _done = sqlx::raw_sql("PRAGMA application_id = 0x526f624a; PRAGMA user_version = 1")
            .execute(&mut *connection)
            .await?;
        let _done = sqlx::raw_sql(SCHEMA_ADDED)
            .execute(&mut *connection)
            .await?;
        let keys = KeyRetention::default();
        let _done = sqlx::query("INSERT INTO head VALUES (1, 0, ?, 0, ?, ?)")
            .bind(Head::EMPTY.hash.as_bytes().to_vec())
            .bind(i64::from(keys.max_age_s))
            .bind(i64::from(keys.max_count))
            .execute(&mut *connection)
            .await?;
        let _done = sqlx::raw_sql("COMMIT").execute(connection).await?;
        Ok(())
    }

    /// Makes the tables that were added after the first journals were written, where they are not there.
    pub(super) async fn add_tables(connection: &mut SqliteConnection) -> Result<(), sqlx::Error> {
        let _done = sqlx::raw_sql(SCHEMA_ADDED).execute(connection).await?;
        Ok(())
    }

    /// Takes over the tables of an existing file.
    pub(super) async fn load(mut connection: SqliteConnection) -> Result<Self, sqlx::Error> {
        let (head, epoch, keys) = columns::head(&mut connection).await?;
        let key_count = count_keys(&mut connection).await?;
        Ok(Self {
            connection,
            head,
            epoch,
            keys,
            key_count,
        })
    }

    /// Undoes a transaction that failed, and takes over again what the file says.
    pub(super) async fn undo(&mut self) -> Result<(), sqlx::Error> {
        // SQLite may have undone it already; then this is an error that tells nothing.
        let _undone = self.run(sqlx::query("ROLLBACK")).await;
        let (head, epoch, keys) = columns::head(&mut self.connection).await?;
        let count = count_keys(&mut self.connection).await?;
        (self.head, self.epoch, self.keys, self.key_count) = (head, epoch, keys, count);
        Ok(())
    }

    pub(super) async fn begin(&mut self) -> Result<(), sqlx::Error> {
        self.run(sqlx::query("BEGIN IMMEDIATE")).await
    }

    /// Keeps the head and ends the transaction. When this returns, it is on the disk.
    pub(super) async fn commit(&mut self) -> Result<(), CommitError> {
        self.keep_head().await.map_err(CommitError::Before)?;
        self.run(sqlx::query("COMMIT"))
            .await
            .map_err(CommitError::At)
    }

    /// Decides about a record.
    pub(super) async fn judge(
        &mut self,
        record: &Record,
        at: Clocks,
    ) -> Result<Result<Verdict, Refusal>, sqlx::Error> {
        let facts = Facts {
            motion: match record.motion() {
                Some(motion) => self.motion(motion).await?,
                None => None,
            },
            job: match record.job() {
                Some(job) => self.job(job).await?,
                None => None,
            },
            key: match record.claim() {
                Some(claim) => key_facts(&mut self.connection, claim).await?,
                None => None,
            },
        };
        let context = Context {
            epoch: self.epoch,
            keys: self.keys,
            at,
            position: self.head.position.next(),
        };
        Ok(judge(record, &facts, &context))
    }

    /// Keeps a record behind the head.
    pub(super) async fn keep(
        &mut self,
        row: Row,
        change: Change,
        at: &Clocks,
    ) -> Result<(), sqlx::Error> {
        let head = Head {
            position: row.position,
            hash: row.hash,
        };
        let body =
            String::from_utf8(row.body).map_err(|error| sqlx::Error::Decode(error.into()))?;
        self.run(
            sqlx::query("INSERT INTO records VALUES (?, ?, ?, ?)")
                .bind(to_sql(row.position)?)
                .bind(row.previous.as_bytes().to_vec())
                .bind(body)
                .bind(row.hash.as_bytes().to_vec()),
        )
        .await?;
        self.head = head;
        self.apply(change, at).await
    }

    /// Takes up what an opening says.
    pub(super) fn start(&mut self, started: &ServerStarted) {
        self.epoch = started.epoch;
        self.keys = started.keys;
    }

    async fn apply(&mut self, change: Change, at: &Clocks) -> Result<(), sqlx::Error> {
        if let Some(motion) = change.motion {
            self.run(
                sqlx::query(
                    "INSERT INTO motions VALUES (?, ?, ?, ?, ?, ?) ON CONFLICT (motion) DO UPDATE SET \
                     phase = excluded.phase, accepted = excluded.accepted, outcome = excluded.outcome, \
                     decision = excluded.decision",
                )
                .bind(motion.motion.to_string())
                .bind(phase_name(motion.phase))
                .bind(to_sql(motion.intent)?)
                .bind(motion.accepted.map(to_sql).transpose()?)
                .bind(motion.outcome.map(to_sql).transpose()?)
                .bind(motion.decision.map(to_sql).transpose()?),
            )
            .await?;
        }
        if let Some(job) = change.job {
            self.run(
                sqlx::query(
                    "INSERT INTO jobs VALUES (?, ?, ?, ?) ON CONFLICT (job) DO UPDATE SET \
                     latest = excluded.latest, ended = excluded.ended",
                )
                .bind(job.job.to_string())
                .bind(to_sql(job.created)?)
                .bind(to_sql(job.latest)?)
                .bind(job.ended.map(to_sql).transpose()?),
            )
            .await?;
        }
        if let Some((position, cell)) = change.decided {
            self.run(
                sqlx::query("INSERT INTO decided VALUES (?, ?)")
                    .bind(to_sql(position)?)
                    .bind(cell),
            )
            .await?;
        }
        if let Some(key) = change.key {
            self.forget_expired(at).await?;
            self.run(
                sqlx::query("INSERT INTO keys VALUES (?, ?, ?, ?, ?)")
                    .bind(key.claim.key.as_str().to_owned())
                    .bind(key.claim.body.as_bytes().to_vec())
                    .bind(to_sql(key.position)?)
                    .bind(key.used_ms)
                    .bind(key.motion.map(|motion| motion.to_string())),
            )
            .await?;
            self.key_count += 1;
            self.forget_surplus().await?;
        }
        Ok(())
    }

    async fn forget_expired(&mut self, at: &Clocks) -> Result<(), sqlx::Error> {
        let until = self.keys.expired_until(wall_ms(at));
        let gone = sqlx::query(
            "DELETE FROM keys WHERE used_ms <= ? AND NOT EXISTS \
             (SELECT 1 FROM motions WHERE motions.motion = keys.motion AND phase = 'open')",
        )
        .bind(until)
        .execute(&mut self.connection)
        .await?;
        self.key_count = self.key_count.saturating_sub(gone.rows_affected());
        Ok(())
    }

    async fn forget_surplus(&mut self) -> Result<(), sqlx::Error> {
        let surplus = self.key_count.saturating_sub(self.keys.max_count.into());
        if surplus == 0 {
            return Ok(());
        }
        let gone = sqlx::query(
            "DELETE FROM keys WHERE key IN (SELECT key FROM keys WHERE NOT EXISTS \
             (SELECT 1 FROM motions WHERE motions.motion = keys.motion AND phase = 'open') \
             ORDER BY position LIMIT ?)",
        )
        .bind(i64::try_from(surplus).unwrap_or(i64::MAX))
        .execute(&mut self.connection)
        .await?;
        self.key_count = self.key_count.saturating_sub(gone.rows_affected());
        Ok(())
    }

    async fn keep_head(&mut self) -> Result<(), sqlx::Error> {
        self.run(
            sqlx::query(
                "UPDATE head SET position = ?, hash = ?, epoch = ?, max_age_s = ?, max_count = ?",
            )
            .bind(to_sql(self.head.position)?)
            .bind(self.head.hash.as_bytes().to_vec())
            .bind(columns::int(self.epoch.0)?)
            .bind(i64::from(self.keys.max_age_s))
            .bind(i64::from(self.keys.max_count)),
        )
        .await
    }

    async fn motion(&mut self, motion: MotionId) -> Result<Option<MotionEntry>, sqlx::Error> {
        let row = sqlx::query("SELECT * FROM motions WHERE motion = ?")
            .bind(motion.to_string())
            .fetch_optional(&mut self.connection)
            .await?;
        row.as_ref().map(motion_entry).transpose()
    }

    async fn job(&mut self, job: JobId) -> Result<Option<JobEntry>, sqlx::Error> {
        let row = sqlx::query("SELECT * FROM jobs WHERE job = ?")
            .bind(job.to_string())
            .fetch_optional(&mut self.connection)
            .await?;
        row.as_ref().map(job_entry).transpose()
    }

    /// After keys were removed otherwise than one by one.
    pub(super) async fn count_keys_again(&mut self) -> Result<(), sqlx::Error> {
        self.key_count = count_keys(&mut self.connection).await?;
        Ok(())
    }

    pub(super) async fn run(&mut self, query: Query) -> Result<(), sqlx::Error> {
        let _done = query.execute(&mut self.connection).await?;
        Ok(())
    }
}

/// Where a transaction failed.
#[derive(Debug)]
pub(super) enum CommitError {
    /// Nothing of it will be found.
    Before(sqlx::Error),
    /// It may be found.
    At(sqlx::Error),
}

async fn count_keys(connection: &mut SqliteConnection) -> Result<u64, sqlx::Error> {
    let count = sqlx::query("SELECT count(*) AS count FROM keys")
        .fetch_one(connection)
        .await?;
    columns::unsigned(&count, "count")
}

pub(super) async fn key_facts(
    connection: &mut SqliteConnection,
    claim: &Claim,
) -> Result<Option<KeyFacts>, sqlx::Error> {
    let row = sqlx::query(
        "SELECT keys.*, motions.phase FROM keys LEFT JOIN motions ON motions.motion = keys.motion \
         WHERE key = ?",
    )
    .bind(claim.key.as_str().to_owned())
    .fetch_optional(connection)
    .await?;
    row.map(|row| {
        let phase: Option<String> = row.try_get("phase")?;
        Ok(KeyFacts {
            entry: key_entry(&row)?,
            phase: phase.as_deref().map(columns::phase).transpose()?,
        })
    })
    .transpose()
}

/// A row of `records`.
pub(super) fn record_row(row: &SqliteRow) -> Result<Row, sqlx::Error> {
    Ok(Row {
        position: position(row, "position")?,
        previous: digest(row, "previous")?,
        // As bytes: a damaged text may be no text any more, and is to be found by its hash.
        body: row.try_get_unchecked("body")?,
        hash: digest(row, "hash")?,
    })
}
