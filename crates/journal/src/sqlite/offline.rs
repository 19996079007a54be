//! A journal file that need not be open: checked as a whole, written out, and read in again.

use std::collections::{BTreeMap, BTreeSet};
use std::io::{self, BufRead, Write};
use std::path::{Path, PathBuf};

use sqlx::sqlite::{SqliteConnection, SqliteRow};
use sqlx::{ConnectOptions as _, Connection as _, Row as _};
use thiserror::Error;

use super::columns::{self, job_entry, key_entry, motion_entry};
use super::lock::Lock;
use super::store::{CommitError, Store};
use super::{OpenError, SqliteOptions, open, reader, upkeep};
use crate::export::{Beside, Line, read_any};
use crate::index::{Base, Index};
use crate::{
    Broken, DecodeError, Epoch, Head, Kept, KeyEntry, LineError, MAX_BODY, MAX_PAGE, MotionEntry,
    MotionId, Position, Record, Refusal, Row, Stored, Walker, write_line,
};

/// What a journal that holds contains.
#[derive(Clone, Copy, Debug, Eq, PartialEq)]
pub struct Report {
    /// What its records begin behind: older ones were removed. An archive that ends with this hash is what they were.
    pub base: Head,
    /// Its last record.
    pub head: Head,
    /// How many cells have a snapshot, each the one its record tells of.
    pub snapshots: usize,
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
    /// The beginning is missing, and no record says that it was removed.
    #[error(
        "the records begin behind record {base}, and none of them says that those before were removed"
    )]
    Unexplained {
        /// What is said to be the last one that was removed.
        base: Position,
    },
    /// A snapshot is not what its record tells of.
    #[error("{how}")]
    Snapshot {
        /// How it differs.
        how: String,
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
    let unread = |source| VerifyError::Read {
        after: Position::START,
        source,
    };
    let base = upkeep::base(connection).await.map_err(unread)?;
    let mut walker = Walker::new(base.head);
    if let Some(known) = known {
        if known.position == base.head.position && known.hash != base.head.hash {
            let position = base.head.position;
            return Err(VerifyError::Broken(Broken::Replaced { position }));
        }
        walker = walker.expecting(known);
    }
    let mut index = Index::behind(base);
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
    if !base.is_start() && index.pruned != base {
        return Err(VerifyError::Unexplained {
            base: base.head.position,
        });
    }
    let comparison = Comparison {
        index: &index,
        base,
    };
    let compared = comparison.with(connection, head).await;
    compared.map_err(read)??;
    let snapshots = comparison.snapshots(connection).await.map_err(read)??;
    let finding = sqlx::query("PRAGMA integrity_check(1)")
        .fetch_one(connection)
        .await
        .map_err(read)?;
    let finding: String = finding.try_get(0).map_err(read)?;
    if finding != "ok" {
        return Err(VerifyError::File { finding });
    }
    Ok(Report {
        base: base.head,
        head,
        snapshots,
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
    let _change = index.replay(stored).map_err(|source| VerifyError::Rule {
        position: stored.position,
        source,
    })?;
    Ok(())
}

/// What the records amount to, against the tables.
struct Comparison<'a> {
    index: &'a Index,
    base: Base,
}

type Compared<T> = Result<Result<T, VerifyError>, sqlx::Error>;

impl Comparison<'_> {
    /// The tables, one row after the other.
    async fn with(&self, connection: &mut SqliteConnection, head: Head) -> Compared<()> {
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
    async fn snapshots(&self, connection: &mut SqliteConnection) -> Compared<usize> {
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

/// Writes the journal out as lines of JSON, as [`write_line`] makes them, checking the chain on the way.
///
/// # Errors
/// [`VerifyError`] at the first record that does not hold; the lines before it are written.
pub async fn export(path: &Path, lines: &mut impl Write) -> Result<Head, VerifyError> {
    let mut connection = read_only(path).await?;
    let unread = |source| VerifyError::Read {
        after: Position::START,
        source,
    };
    let base = upkeep::base(&mut connection).await.map_err(unread)?;
    if !base.is_start() {
        write_beside(lines, &Beside::Base(base))?;
    }
    let mut walker = Walker::new(base.head);
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
    if !base.is_start() {
        let kept = upkeep::snapshots(&mut connection).await.map_err(unread)?;
        for (cell, position, body) in kept {
            let snapshot = Beside::Snapshot {
                cell,
                position,
                body,
            };
            write_beside(lines, &snapshot)?;
        }
    }
    // Only read from: what closing says does not matter.
    let _closed = connection.close().await;
    lines.flush().map_err(VerifyError::Lines)?;
    walker.finish().map_err(VerifyError::Broken)
}

fn write_beside(lines: &mut impl Write, beside: &Beside) -> Result<(), VerifyError> {
    let line = serde_json::to_string(beside).map_err(|error| VerifyError::Lines(error.into()))?;
    writeln!(lines, "{line}").map_err(VerifyError::Lines)
}

/// Checks archives of removed records, in their order: one chain from the first record to the head that is returned.
/// A journal whose [`base`](Report::base) is that head is what follows.
///
/// # Errors
/// [`VerifyError`] at the first line that does not hold.
pub fn verify_archives<R: BufRead>(
    archives: impl IntoIterator<Item = R>,
) -> Result<Head, VerifyError> {
    let mut walker = Walker::new(Head::EMPTY);
    for mut lines in archives {
        let mut number = 0;
        loop {
            let page = read_lines(&mut lines, &mut number)?;
            if page.is_empty() {
                break;
            }
            for line in page {
                // The power may have gone between writing out and removing: then the next one begins anew.
                if let Line::Row(row) = line
                    && row.position > walker.head().position
                {
                    let _stored = walker.step(&row).map_err(VerifyError::Broken)?;
                }
            }
        }
    }
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
    let mut index = Index::default();
    let mut begun_before = BTreeMap::new();
    let mut number = 0;
    loop {
        let page = read_lines(lines, &mut number)?;
        if page.is_empty() {
            break;
        }
        store.begin().await.map_err(VerifyError::Write)?;
        for line in page {
            match line {
                Line::Row(row) => {
                    let stored = walker.step(&row).map_err(VerifyError::Broken)?;
                    take(&mut store, &mut index, &mut begun_before, row, &stored).await?;
                }
                Line::Beside(Beside::Base(base)) => {
                    if walker.head() != Head::EMPTY {
                        return Err(VerifyError::Unexplained {
                            base: base.head.position,
                        });
                    }
                    walker = Walker::new(base.head);
                    index = Index::behind(base);
                    let begun = store.begin_behind(base).await;
                    begun.map_err(VerifyError::Write)?;
                }
                Line::Beside(Beside::Snapshot {
                    cell,
                    position,
                    body,
                }) => {
                    let told = index.snapshots.get(&cell).filter(|told| told.0 == position);
                    let Some((_, taken)) = told else {
                        let how = format!("no record tells of the snapshot of cell `{cell}`");
                        return Err(VerifyError::Snapshot { how });
                    };
                    let covers = taken.covers.position;
                    let kept = store.keep_snapshot_of(&cell, position, covers, &body).await;
                    kept.map_err(VerifyError::Write)?;
                }
            }
        }
        store.commit().await.map_err(|error| match error {
            CommitError::Before(source) | CommitError::At(source) => VerifyError::Write(source),
        })?;
    }
    store.connection.close().await.map_err(VerifyError::Write)?;
    walker.finish().map_err(VerifyError::Broken)
}

async fn take(
    store: &mut Store,
    index: &mut Index,
    begun_before: &mut BTreeMap<MotionId, Position>,
    row: Row,
    stored: &Stored,
) -> Result<(), VerifyError> {
    if let Record::ServerStarted(started) = &stored.record {
        store.start(started);
    }
    let mut change = index.replay(stored).map_err(|source| VerifyError::Rule {
        position: stored.position,
        source,
    })?;
    if let Some(motion) = &mut change.motion
        && motion.intent == Position::START
    {
        // It began before the lines do. Where exactly is not known, and no two may begin at one place.
        let next = Position(begun_before.len() as u64 + 1);
        motion.intent = *begun_before.entry(motion.motion).or_insert(next);
    }
    store
        .keep(row, change, &stored.at)
        .await
        .map_err(VerifyError::Write)
}

/// The next lines, a page of them, each with a bound on its length.
fn read_lines(lines: &mut impl BufRead, number: &mut u64) -> Result<Vec<Line>, VerifyError> {
    // A record, two hashes, and the names of the three; or a snapshot, which is a text in a text.
    const MAX_RECORD: usize = MAX_BODY + 256;
    const MAX_LINE: u64 = 64 << 20;
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
        let line = read_any(&line, *number).map_err(VerifyError::Line)?;
        if matches!(line, Line::Row(_)) && length > MAX_RECORD {
            return Err(VerifyError::Lines(io::Error::other("a line is too long")));
        }
        page.push(line);
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
