//! A journal file that need not be open: checked as a whole, written out, and read in again.

use std::io::{self, BufRead, Write};
use std::path::{Path, PathBuf};

use sqlx::sqlite::{SqliteConnection, SqliteRow};
use sqlx::{ConnectOptions as _, Connection as _, Row as _};
use thiserror::Error;

use super::columns::{self, job_entry, key_entry, motion_entry};
use super::lock::Lock;
use super::store::{CommitError, Store};
use super::{OpenError, SqliteOptions, open, reader};
use crate::index::Index;
use crate::rules::{Change, Verdict};
use crate::{
    Broken, DecodeError, Epoch, Head, LineError, MAX_BODY, MAX_PAGE, Position, Record, Refusal,
    Row, Stored, Walker, read_line, write_line,
};

/// What a journal that holds contains.
#[derive(Clone, Copy, Debug, Eq, PartialEq)]
pub struct Report {
    /// Its last record.
    pub head: Head,
    /// The last epoch.
    pub epoch: Epoch,
    /// Motions that have no last word.
    pub open_motions: usize,
    /// Jobs that have not ended.
    pub open_jobs: usize,
}

/// A journal does not hold, or could not be read or written.
#[derive(Debug, Error)]
pub enum VerifyError {
    /// It cannot be opened.
    #[error("opening the journal {path}")]
    Open {
        /// Its file.
        path: PathBuf,
        /// Why.
        #[source]
        source: sqlx::Error,
    },
    /// SQLite cannot read it.
    #[error("reading the journal behind record {after}")]
    Read {
        /// The last record that was read.
        after: Position,
        /// Why.
        #[source]
        source: sqlx::Error,
    },
    /// The chain does not hold.
    #[error("the chain of the journal does not hold")]
    Broken(#[source] Broken),
    /// A record could not have been written by this program.
    #[error("record {position} does not follow from those before it")]
    Rule {
        /// The record.
        position: Position,
        /// The rule it breaks.
        #[source]
        source: Refusal,
    },
    /// The other tables are not what the records amount to.
    #[error("the table `{table}` is not what the records amount to")]
    Index {
        /// The table.
        table: &'static str,
    },
    /// SQLite finds its own structures damaged.
    #[error("the file is damaged: {finding}")]
    File {
        /// What SQLite says.
        finding: String,
    },
    /// A record is not JSON.
    #[error("writing out record {position}")]
    Export {
        /// The record.
        position: Position,
        /// Why.
        #[source]
        source: DecodeError,
    },
    /// A line is no record.
    #[error("reading the lines")]
    Line(#[source] LineError),
    /// The other file cannot be read or written.
    #[error("reading or writing lines")]
    Lines(#[source] io::Error),
    /// The file to import into is there already, or cannot be made.
    #[error("making the journal")]
    Make(#[source] Box<OpenError>),
    /// Writing it failed.
    #[error("writing the journal")]
    Write(#[source] sqlx::Error),
}

/// Checks the whole journal: each record, the tables made from them, and the file. It may be open meanwhile.
///
/// `known` is a head from elsewhere: without one, a journal whose end was cut off together with its own head is not
/// told from a shorter one.
///
/// # Errors
/// [`VerifyError`], naming the first record that does not hold.
pub async fn verify(path: &Path, known: Option<Head>) -> Result<Report, VerifyError> {
    let mut connection = read_only(path).await?;
    let report = verify_in(&mut connection, known).await?;
    // Only read from: what closing says does not matter.
    let _closed = connection.close().await;
    Ok(report)
}

async fn verify_in(
    connection: &mut SqliteConnection,
    known: Option<Head>,
) -> Result<Report, VerifyError> {
    let mut walker = Walker::new(Head::EMPTY);
    if let Some(known) = known {
        walker = walker.expecting(known);
    }
    let mut index = Index::default();
    loop {
        let after = walker.head().position;
        let rows = reader::rows(connection, after, MAX_PAGE)
            .await
            .map_err(|source| VerifyError::Read { after, source })?;
        if rows.is_empty() {
            break;
        }
        for row in &rows {
            let stored = walker.step(row).map_err(VerifyError::Broken)?;
            replay(&mut index, &stored)?;
        }
    }
    let head = walker.finish().map_err(VerifyError::Broken)?;
    let read = |source| VerifyError::Read {
        after: head.position,
        source,
    };
    compare(connection, &index, head).await.map_err(read)??;
    let finding = sqlx::query("PRAGMA integrity_check(1)")
        .fetch_one(connection)
        .await
        .map_err(read)?;
    let finding: String = finding.try_get(0).map_err(read)?;
    if finding != "ok" {
        return Err(VerifyError::File { finding });
    }
    Ok(Report {
        head,
        epoch: index.epoch,
        open_motions: index
            .motions
            .values()
            .filter(|motion| motion.phase != crate::MotionPhase::Closed)
            .count(),
        open_jobs: index
            .jobs
            .values()
            .filter(|job| job.ended.is_none())
            .count(),
    })
}

fn replay(index: &mut Index, stored: &Stored) -> Result<(), VerifyError> {
    index.replay(stored).map_err(|source| VerifyError::Rule {
        position: stored.position,
        source,
    })
}

/// The tables against the records, one row after the other.
async fn compare(
    connection: &mut SqliteConnection,
    index: &Index,
    head: Head,
) -> Result<Result<(), VerifyError>, sqlx::Error> {
    let differs = |table| Ok(Err(VerifyError::Index { table }));
    if columns::head(connection).await? != (head, index.epoch, index.keys) {
        return differs("head");
    }
    let mut motions = index.motions.values();
    for row in sqlx::query("SELECT * FROM motions ORDER BY motion")
        .fetch_all(&mut *connection)
        .await?
    {
        if motions.next() != Some(&motion_entry(&row)?) {
            return differs("motions");
        }
    }
    let mut jobs = index.jobs.values();
    for row in sqlx::query("SELECT * FROM jobs ORDER BY job")
        .fetch_all(&mut *connection)
        .await?
    {
        if jobs.next() != Some(&job_entry(&row)?) {
            return differs("jobs");
        }
    }
    let mut claims = index.claims.values();
    for row in sqlx::query("SELECT * FROM keys ORDER BY key")
        .fetch_all(&mut *connection)
        .await?
    {
        if claims.next() != Some(&key_entry(&row)?) {
            return differs("keys");
        }
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
    match (motions.next(), jobs.next(), claims.next()) {
        (None, None, None) => Ok(Ok(())),
        (Some(_), _, _) => differs("motions"),
        (None, Some(_), _) => differs("jobs"),
        (None, None, Some(_)) => differs("keys"),
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

/// Writes the journal out as lines of JSON, as [`write_line`] makes them, checking the chain on the way.
///
/// # Errors
/// [`VerifyError`] at the first record that does not hold; the lines before it are written.
pub async fn export(path: &Path, lines: &mut impl Write) -> Result<Head, VerifyError> {
    let mut connection = read_only(path).await?;
    let mut walker = Walker::new(Head::EMPTY);
    loop {
        let after = walker.head().position;
        let rows = reader::rows(&mut connection, after, MAX_PAGE)
            .await
            .map_err(|source| VerifyError::Read { after, source })?;
        if rows.is_empty() {
            break;
        }
        for row in &rows {
            let _stored = walker.step(row).map_err(VerifyError::Broken)?;
            let line = write_line(row).map_err(|source| VerifyError::Export {
                position: row.position,
                source,
            })?;
            writeln!(lines, "{line}").map_err(VerifyError::Lines)?;
        }
    }
    // Only read from: what closing says does not matter.
    let _closed = connection.close().await;
    lines.flush().map_err(VerifyError::Lines)?;
    walker.finish().map_err(VerifyError::Broken)
}

/// Makes a journal at `path`, where none may be, from exported lines.
///
/// # Errors
/// [`VerifyError`] at the first line that does not hold; the file then has the lines before it, up to 1,000 fewer.
pub async fn import(path: &Path, lines: &mut impl BufRead) -> Result<Head, VerifyError> {
    let make = |error| VerifyError::Make(Box::new(error));
    let _lock = Lock::acquire(path).map_err(make)?;
    if path.exists() {
        return Err(make(OpenError::NotAJournal {
            path: path.to_owned(),
        }));
    }
    let mut store = open::load(path, &SqliteOptions::default())
        .await
        .map_err(make)?;
    let mut walker = Walker::new(Head::EMPTY);
    let mut number = 0;
    loop {
        let page = read_lines(lines, &mut number)?;
        if page.is_empty() {
            break;
        }
        store.begin().await.map_err(VerifyError::Write)?;
        for row in page {
            let stored = walker.step(&row).map_err(VerifyError::Broken)?;
            take(&mut store, row, &stored).await?;
        }
        store.commit().await.map_err(|error| match error {
            CommitError::Before(source) | CommitError::At(source) => VerifyError::Write(source),
        })?;
    }
    store.connection.close().await.map_err(VerifyError::Write)?;
    walker.finish().map_err(VerifyError::Broken)
}

async fn take(store: &mut Store, row: Row, stored: &Stored) -> Result<(), VerifyError> {
    let change = if let Record::ServerStarted(started) = &stored.record {
        store.start(started);
        Change::default()
    } else {
        let verdict = store.judge(&stored.record, stored.at).await;
        let refused = match verdict.map_err(VerifyError::Write)? {
            Ok(Verdict::Keep(change)) => Ok(change),
            Ok(Verdict::Replay(entry)) => Err(Refusal::KeyReused {
                first: entry.position,
            }),
            Err(refusal) => Err(refusal),
        };
        refused.map_err(|source| VerifyError::Rule {
            position: stored.position,
            source,
        })?
    };
    store
        .keep(row, change, &stored.at)
        .await
        .map_err(VerifyError::Write)
}

/// The next lines, a page of them, each with a bound on its length.
fn read_lines(lines: &mut impl BufRead, number: &mut u64) -> Result<Vec<Row>, VerifyError> {
    // A line is a record, two hashes, and the names of the three.
    const MAX_LINE: u64 = MAX_BODY as u64 + 256;
    let mut page = Vec::new();
    while page.len() < MAX_PAGE {
        let mut line = Vec::new();
        let length = io::Read::take(&mut *lines, MAX_LINE)
            .read_until(b'\n', &mut line)
            .map_err(VerifyError::Lines)?;
        if length == 0 {
            break;
        }
        *number += 1;
        page.push(read_line(&line, *number).map_err(VerifyError::Line)?);
    }
    Ok(page)
}

/// A connection that sees the journal as it is now, whatever is appended meanwhile.
async fn read_only(path: &Path) -> Result<SqliteConnection, VerifyError> {
    let open = |source| VerifyError::Open {
        path: path.to_owned(),
        source,
    };
    let mut connection = open::connect_options(path)
        .read_only(true)
        .connect()
        .await
        .map_err(open)?;
    let _done = sqlx::raw_sql("BEGIN")
        .execute(&mut connection)
        .await
        .map_err(open)?;
    Ok(connection)
}
