//! A journal file that need not be open: checked as a whole, written out, and read in again.

mod compare;
mod lines;

use std::io;
use std::path::{Path, PathBuf};

use sqlx::sqlite::SqliteConnection;
use sqlx::{ConnectOptions as _, Connection as _, Row as _};
use thiserror::Error;

use super::{OpenError, open, reader, upkeep};
use crate::index::Index;
use crate::{
    Broken, DecodeError, Epoch, Head, LineError, MAX_PAGE, Position, Refusal, Stored, Walker,
};

use compare::Comparison;
pub use lines::{export, import, verify_archives};

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
