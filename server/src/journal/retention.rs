//! The removal of old records, some thousand at a time, now and then.
//!
//! ```text
//! what is old enough ── and needed by no cell, motion or key ──▶ written out, synced ──▶ removed, step by step
//! ```
//! A crash anywhere on the way leaves records that are in both places, or a file that the next time writes again.

use std::fs::File;
use std::io::{self, BufWriter, Write as _};
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::time::Duration;

use jiff::Timestamp;
use journal::{MAX_PAGE, Position, ReadError, Row, write_line};
use thiserror::Error;
use tokio_util::sync::CancellationToken;

use super::{Retention, SharedJournal, Trouble};
use crate::cell::{self, CellHandle};
use crate::clock::WallClock;

/// How often it is looked whether something is old enough.
const EVERY: Duration = Duration::from_mins(10);
/// A journal with more records than this is worth a word where none is ever removed.
const MANY: u64 = 5_000_000;

/// The task that removes old records.
pub(crate) struct Retaining {
    pub(crate) journal: SharedJournal,
    pub(crate) clock: Arc<dyn WallClock>,
    pub(crate) cells: Vec<(String, CellHandle)>,
}

/// Why nothing more was removed.
#[derive(Debug, Error)]
pub(crate) enum RetentionError {
    #[error("reading the journal")]
    Read(#[source] ReadError),
    #[error("the snapshot of cell `{cell}` cannot be used: {how}")]
    Snapshot { cell: String, how: String },
    #[error("writing {}", path.display())]
    Archive {
        path: PathBuf,
        #[source]
        source: io::Error,
    },
    #[error("{0}")]
    Journal(Trouble),
}

impl Retaining {
    /// Looks now and then, until `stop`.
    pub(crate) async fn run(self, stop: CancellationToken) {
        let Some(retention) = self.journal.upkeep().retention.clone() else {
            let records = self.journal.head().position.0;
            if records > MANY {
                tracing::warn!(
                    records,
                    "the journal keeps every record; journal.keep_days removes old ones"
                );
            }
            return;
        };
        loop {
            match stop.run_until_cancelled(self.once(&retention)).await {
                None => return,
                Some(Ok(0)) => {}
                Some(Ok(removed)) => tracing::info!(removed, "old records were removed"),
                Some(Err(error)) => tracing::warn!(
                    error = &error as &dyn std::error::Error,
                    "old records stay for now"
                ),
            }
            let sleep = tokio::time::sleep(EVERY);
            if stop.run_until_cancelled(sleep).await.is_none() {
                return;
            }
        }
    }

    /// Removes what may go by now; how many records.
    pub(crate) async fn once(&self, retention: &Retention) -> Result<u64, RetentionError> {
        let through = self.removable(retention).await?;
        let now = self.clock.now();
        let retained = self.journal.retained(now).await;
        let mut base = retained.map_err(RetentionError::Read)?.base.position;
        if through <= base {
            return Ok(0);
        }
        let archive = match &retention.archive {
            Some(folder) => Some(self.write_out(folder, base, through).await?),
            None => None,
        };
        let mut removed = 0;
        loop {
            let pruned = self.journal.prune(now, through, archive.clone()).await;
            let pruned = match pruned {
                Ok(pruned) => pruned,
                Err(Trouble::Busy(_)) => {
                    tokio::time::sleep(Duration::from_millis(20)).await;
                    continue;
                }
                Err(trouble) => return Err(RetentionError::Journal(trouble)),
            };
            removed += pruned.removed;
            base = pruned.base.position.max(base);
            for (_, cell) in &self.cells {
                cell.forget_through(base);
            }
            if pruned.removed == 0 || base >= through {
                return Ok(removed);
            }
            // Whoever waits to write comes first.
            tokio::task::yield_now().await;
        }
    }

    /// The last record that is old enough and that nobody needs.
    async fn removable(&self, retention: &Retention) -> Result<Position, RetentionError> {
        let now = self.clock.now();
        let retained = self.journal.retained(now).await;
        let retained = retained.map_err(RetentionError::Read)?;
        let newest = self.journal.head().position.0;
        let mut last = retained
            .removable
            .min(Position(newest.saturating_sub(retention.records.into())));
        for (id, cell) in &self.cells {
            let kept = self.journal.snapshot(id).await;
            if let Some(kept) = kept.map_err(RetentionError::Read)?
                && let Err(how) = cell::readable(&kept)
            {
                // As long as the decisions are there, they are what a start reads.
                return Err(RetentionError::Snapshot {
                    cell: id.clone(),
                    how,
                });
            }
            if let Some(needed) = cell.first_needed() {
                last = last.min(Position(needed.0.saturating_sub(1)));
            }
        }
        let age = jiff::SignedDuration::from_hours(i64::from(retention.days) * 24);
        let Ok(until) = now.checked_sub(age) else {
            return Ok(retained.base.position);
        };
        self.last_before(until, retained.base.position, last).await
    }

    /// The last record of `base..=last` that is older than `until`. Times in a journal grow, but for clocks that were
    /// set; then it is a place where they cross `until`.
    async fn last_before(
        &self,
        until: Timestamp,
        base: Position,
        last: Position,
    ) -> Result<Position, RetentionError> {
        let (mut old, mut young) = (base.0, last.0 + 1);
        while old + 1 < young {
            let middle = old + (young - old) / 2;
            let page = self.journal.page(Position(middle - 1), 1).await;
            let page = page.map_err(RetentionError::Read)?;
            let is_old = page.first().is_some_and(|stored| stored.at.wall < until);
            if is_old {
                old = middle;
            } else {
                young = middle;
            }
        }
        Ok(Position(old))
    }

    /// Writes the records behind `base` up to `through` into a file of their own, durably; its name.
    async fn write_out(
        &self,
        folder: &Path,
        base: Position,
        through: Position,
    ) -> Result<String, RetentionError> {
        let name = format!("journal-from-{:012}.jsonl", base.next().0);
        let path = folder.join(&name);
        let failed = |source| RetentionError::Archive {
            path: path.clone(),
            source,
        };
        let part = folder.join(format!("{name}.part"));
        let at = part.clone();
        let made = blocking(move || {
            std::fs::create_dir_all(at.parent().unwrap_or(&at))?;
            Ok(BufWriter::new(File::create(&at)?))
        });
        let mut file = made.await.map_err(failed)?;
        let mut after = base;
        while after < through {
            let rows = self.journal.rows(after, MAX_PAGE).await;
            let mut rows = rows.map_err(RetentionError::Read)?;
            rows.retain(|row| row.position <= through);
            let Some(last) = rows.last() else { break };
            after = last.position;
            file = blocking(move || write(file, &rows)).await.map_err(failed)?;
        }
        let to = path.clone();
        let durable = blocking(move || {
            let file = file.into_inner().map_err(io::IntoInnerError::into_error)?;
            file.sync_all()?;
            std::fs::rename(&part, &to)?;
            sync_folder(&to)
        });
        durable.await.map_err(failed)?;
        Ok(name)
    }
}

fn write(mut file: BufWriter<File>, rows: &[Row]) -> io::Result<BufWriter<File>> {
    for row in rows {
        let line = write_line(row).map_err(io::Error::other)?;
        writeln!(file, "{line}")?;
    }
    Ok(file)
}

async fn blocking<T: Send + 'static>(
    work: impl FnOnce() -> io::Result<T> + Send + 'static,
) -> io::Result<T> {
    tokio::task::spawn_blocking(work)
        .await
        .map_err(io::Error::other)?
}

/// A file whose folder was not synced may be gone after a power loss.
#[cfg(unix)]
fn sync_folder(path: &Path) -> io::Result<()> {
    File::open(path.parent().unwrap_or(path))?.sync_all()
}

#[cfg(not(unix))]
fn sync_folder(_path: &Path) -> io::Result<()> {
    Ok(())
}
