use std::path::{Path, PathBuf};
use std::time::Duration;

use journal::{
    Clocks, Filesystem, History, KeyRetention, OpenError, Opening, SqliteJournal, SqliteOptions,
};
use thiserror::Error;

use super::{Retention, SharedJournal, Upkeep};
use crate::clock::WallClock;
use crate::config::JournalSection;

/// The journal was not opened, so nothing may move and the server must not start.
#[derive(Debug, Error)]
#[error("opening the journal {}", path.display())]
pub struct JournalError {
    path: PathBuf,
    #[source]
    source: OpenError,
}

/// Opens the journal the configuration names, relative paths in `folder`; one in memory where it names none.
///
/// # Errors
/// [`JournalError`] if another process has it, if it would not be durable, if it is damaged, or if it is older than
/// one that was open at that place before.
pub async fn open(
    section: &JournalSection,
    folder: &Path,
    clock: &dyn WallClock,
) -> Result<SharedJournal, JournalError> {
    let Some(path) = &section.path else {
        return Ok(SharedJournal::volatile());
    };
    let path = folder.join(path);
    let opening = Opening {
        at: Clocks {
            wall: clock.now(),
            monotonic: Duration::ZERO,
        },
        program: program(),
        keys: KeyRetention::default(),
    };
    let options = SqliteOptions {
        filesystem: if section.allow_volatile_filesystem {
            Filesystem::Trusted
        } else {
            Filesystem::Checked
        },
        history: if section.restored {
            History::Restored
        } else {
            History::Whole
        },
        reserve: u64::from(section.reserve_mib) << 20,
        ..SqliteOptions::default()
    };
    let journal = SqliteJournal::open(&path, &opening, &options)
        .await
        .map_err(|source| JournalError { path, source })?;
    let upkeep = Upkeep {
        snapshot_after: section.snapshot_after,
        retention: section.keep_days.map(|days| Retention {
            days,
            records: section.keep_records,
            archive: section.archive.as_ref().map(|path| folder.join(path)),
        }),
    };
    Ok(SharedJournal::durable_with(journal, upkeep))
}

pub(super) fn program() -> String {
    format!("robocell {}", env!("CARGO_PKG_VERSION"))
}
