//! A journal as lines of JSON: written out, checked without a file, and read in again.

use std::collections::BTreeMap;
use std::io::{self, BufRead, Write};
use std::path::Path;

use sqlx::Connection as _;

use super::super::lock::Lock;
use super::super::store::{CommitError, Store};
use super::super::{OpenError, SqliteOptions, open, reader, upkeep};
use super::{VerifyError, read_only};
use crate::export::{Beside, Line, read_any};
use crate::index::Index;
use crate::{
    Head, MAX_BODY, MAX_PAGE, MotionId, Position, Record, Row, Stored, Walker, write_line,
};

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
/// A journal whose [`base`](super::Report::base) is that head is what follows.
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
