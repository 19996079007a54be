//! Opening for writing: who may, whether it is durable, whether it holds, and the next epoch.

use std::io;
use std::path::{Path, PathBuf};
use std::time::Duration;

use sqlx::sqlite::{SqliteConnectOptions, SqliteConnection, SqliteJournalMode, SqliteSynchronous};
use sqlx::{ConnectOptions as _, Row as _};
use thiserror::Error;

use super::filesystem::{self, Filesystem};
use super::lock::Lock;
use super::reserve::{Pages, Reserve};
use super::store::{APPLICATION_ID, SCHEMA_VERSION, Store};
use super::{History, SqliteOptions, reader, upkeep, writer};
use crate::{
    AppendError, Broken, Epoch, Head, MAX_PAGE, Opening, Position, Record, Room, ServerStarted,
    Walker,
};

/// The journal was not opened. Nothing may move.
#[derive(Debug, Error)]
pub enum OpenError {
    /// The directory is not there, or cannot be used.
    #[error("the directory of the journal {path}")]
    Directory {
        /// The journal's file.
        path: PathBuf,
        /// Why.
        #[source]
        source: io::Error,
    },
    /// Another process, or another part of this one, has it open.
    #[error("the journal {path} is in use by another process")]
    InUse {
        /// The journal's file.
        path: PathBuf,
    },
    /// The lock file cannot be used.
    #[error("the lock file {path}")]
    Lock {
        /// The lock file.
        path: PathBuf,
        /// Why.
        #[source]
        source: io::Error,
    },
    /// What is written there may be gone after a power loss.
    #[error("the journal {path} is on a filesystem that does not keep what it was given ({kind})")]
    Volatile {
        /// The journal's file.
        path: PathBuf,
        /// The filesystem.
        kind: String,
    },
    /// SQLite does not do what makes an append durable.
    #[error("SQLite has {pragma} = {found} where the journal needs {wanted}")]
    NotDurable {
        /// The setting.
        pragma: &'static str,
        /// What it must be.
        wanted: &'static str,
        /// What it is.
        found: String,
    },
    /// The file is something else.
    #[error("{path} is not a journal of this program")]
    NotAJournal {
        /// The file.
        path: PathBuf,
    },
    /// A newer program wrote it.
    #[error(
        "the journal has version {found}, this program reads versions {SCHEMA_VERSION} and {}",
        upkeep::PRUNED_VERSION
    )]
    Newer {
        /// Its version.
        found: i64,
    },
    /// The journal is older than what was seen here: deleted, or replaced by a backup.
    #[error(
        "the journal {path} is of epoch {found}, and epoch {known} was begun here: it was deleted or replaced by an \
         older one"
    )]
    RolledBack {
        /// The journal's file.
        path: PathBuf,
        /// Its epoch.
        found: Epoch,
        /// The one the lock file knows.
        known: Epoch,
    },
    /// The end of the chain does not hold.
    #[error("the journal is damaged")]
    Broken(#[source] Broken),
    /// SQLite failed.
    #[error("{step}")]
    Store {
        /// What was being done.
        step: &'static str,
        /// Why.
        #[source]
        source: sqlx::Error,
    },
    /// The opening itself could not be written.
    #[error("writing the opening")]
    Write(#[source] AppendError),
}

pub(super) struct Opened {
    pub(super) store: Store,
    pub(super) lock: Lock,
    pub(super) reserve: Reserve,
    pub(super) path: PathBuf,
}

pub(super) async fn open(
    path: &Path,
    opening: &Opening,
    options: &SqliteOptions,
) -> Result<Opened, OpenError> {
    let path = canonical(path)?;
    if options.filesystem == Filesystem::Checked {
        let directory = path.parent().unwrap_or(&path);
        if let Some(kind) = filesystem::objection(directory) {
            return Err(OpenError::Volatile { path, kind });
        }
    }
    let mut lock = Lock::acquire(&path)?;
    let mut store = load(&path, options).await?;
    let known = lock.epoch()?;
    if known > store.epoch && options.history == History::Whole {
        return Err(OpenError::RolledBack {
            path,
            found: store.epoch,
            known,
        });
    }
    check_end(&mut store, options.verify_last).await?;
    let started = ServerStarted {
        epoch: Epoch(store.epoch.max(known).0 + 1),
        program: opening.program.clone(),
        keys: opening.keys,
    };
    let mut reserve = Reserve::new(&path, options);
    let started = Record::ServerStarted(started);
    let mut written = writer::write_opening(&mut store, opening.at, &started).await;
    if let Err(error) = &written
        && error.is_disk_full()
        && reserve
            .open(&mut store)
            .await
            .map_err(failed("opening the reserve"))?
    {
        written = writer::write_opening(&mut store, opening.at, &started).await;
    }
    written.map_err(OpenError::Write)?;
    lock.keep(store.epoch)?;
    // On a full disk there is none to be made, and the journal is open all the same: doubts can be decided.
    if reserve.room() == Room::Free {
        let stocked = reserve.stock(&mut store).await;
        stocked.map_err(failed("making the reserve"))?;
    }
    Ok(Opened {
        store,
        lock,
        reserve,
        path,
    })
}

/// The file's connection, made durable and checked, with its tables.
pub(super) async fn load(path: &Path, options: &SqliteOptions) -> Result<Store, OpenError> {
    let mut connect = connect_options(path)
        .create_if_missing(true)
        .journal_mode(SqliteJournalMode::Wal)
        .synchronous(SqliteSynchronous::Full)
        // macOS: a plain fsync leaves the bytes in the drive's cache.
        .pragma("fullfsync", "1")
        .pragma("checkpoint_fullfsync", "1");
    if let Some(pages) = Pages::of(options) {
        connect = connect.pragma("max_page_count", pages.without_reserve.to_string());
    }
    let mut connection = connect
        .connect()
        .await
        .map_err(failed("opening the file"))?;
    check_durable(&mut connection).await?;
    prepare(&mut connection, path).await?;
    // After a failed fsync the write-ahead log may be readable from memory and not be on the disk. Copying it into
    // the file and syncing that makes certain that the next record does not stand behind one that a power loss
    // takes away.
    let _done = sqlx::raw_sql("PRAGMA wal_checkpoint(TRUNCATE)")
        .execute(&mut connection)
        .await
        .map_err(failed("copying the write-ahead log"))?;
    sync_directory(path)?;
    Store::load(connection)
        .await
        .map_err(failed("reading the head"))
}

pub(super) fn connect_options(path: &Path) -> SqliteConnectOptions {
    SqliteConnectOptions::new()
        .filename(path)
        .busy_timeout(Duration::from_secs(2))
        // No file in a directory for temporary ones, which may be full, read-only or not there.
        .pragma("temp_store", "MEMORY")
        .pragma("trusted_schema", "0")
        .pragma("cell_size_check", "1")
}

/// The pragmas are read back: SQLite ignores what it cannot do.
async fn check_durable(connection: &mut SqliteConnection) -> Result<(), OpenError> {
    let mode: String = pragma(connection, "PRAGMA journal_mode").await?;
    if mode != "wal" {
        return Err(OpenError::NotDurable {
            pragma: "journal_mode",
            wanted: "wal",
            found: mode,
        });
    }
    let synchronous: i64 = pragma(connection, "PRAGMA synchronous").await?;
    if synchronous < 2 {
        return Err(OpenError::NotDurable {
            pragma: "synchronous",
            wanted: "2 (FULL)",
            found: synchronous.to_string(),
        });
    }
    Ok(())
}

/// Makes the tables in a new file; refuses what is not a journal of this version.
async fn prepare(connection: &mut SqliteConnection, path: &Path) -> Result<(), OpenError> {
    let application: i64 = pragma(connection, "PRAGMA application_id").await?;
    let version: i64 = pragma(connection, "PRAGMA user_version").await?;
    let tables: i64 = pragma(connection, "SELECT count(*) FROM sqlite_schema").await?;
    match (application, version, tables) {
        (0, 0, 0) => Store::create(connection)
            .await
            .map_err(failed("making the tables")),
        (APPLICATION_ID, SCHEMA_VERSION | upkeep::PRUNED_VERSION, _) => {
            Store::add_tables(connection)
                .await
                .map_err(failed("adding a table"))
        }
        (APPLICATION_ID, found, _) => Err(OpenError::Newer { found }),
        _ => Err(OpenError::NotAJournal {
            path: path.to_owned(),
        }),
    }
}

pub(super) async fn pragma<T>(
    connection: &mut SqliteConnection,
    query: &'static str,
) -> Result<T, OpenError>
where
    T: for<'r> sqlx::Decode<'r, sqlx::Sqlite> + sqlx::Type<sqlx::Sqlite>,
{
    let row = sqlx::query(query)
        .fetch_one(connection)
        .await
        .map_err(failed("reading a setting"))?;
    row.try_get(0).map_err(failed("reading a setting"))
}

/// Walks the last `count` records and compares the end with the head.
async fn check_end(store: &mut Store, count: u64) -> Result<(), OpenError> {
    let read = failed("reading the records");
    let base = upkeep::base(&mut store.connection)
        .await
        .map_err(&read)?
        .head;
    let first = store.head.position.0.saturating_sub(count);
    let mut after = Position(first).max(base.position);
    let mut walker: Option<Walker> = None;
    loop {
        let rows = reader::rows(&mut store.connection, after, MAX_PAGE)
            .await
            .map_err(&read)?;
        let Some(last) = rows.last() else { break };
        let before = std::mem::replace(&mut after, last.position);
        for row in rows {
            let walker = walker.get_or_insert_with(|| begin(&row, before, base, store.head));
            let stored = walker.step(&row).map_err(OpenError::Broken)?;
            if stored.epoch > store.epoch {
                return Err(OpenError::Broken(Broken::BehindHead {
                    head: store.head.position,
                    found: stored.position,
                }));
            }
        }
    }
    let walker = walker.unwrap_or_else(|| Walker::new(Head::EMPTY).expecting(store.head));
    let end = walker.finish().map_err(OpenError::Broken)?;
    if end == store.head {
        Ok(())
    } else {
        Err(OpenError::Broken(Broken::BehindHead {
            head: store.head.position,
            found: end.position,
        }))
    }
}

/// The hash before the first row that is looked at is taken from that row, except where the journal begins.
fn begin(first: &crate::Row, before: Position, base: Head, head: Head) -> Walker {
    let before = if before == base.position {
        base
    } else {
        Head {
            position: before,
            hash: first.previous,
        }
    };
    Walker::new(before).expecting(head)
}

fn canonical(path: &Path) -> Result<PathBuf, OpenError> {
    let failed = |source| OpenError::Directory {
        path: path.to_owned(),
        source,
    };
    // Two names of one directory must not give two locks.
    let directory = match path.parent() {
        Some(parent) if parent != Path::new("") => parent,
        Some(_) | None => Path::new("."),
    };
    let name = path
        .file_name()
        .ok_or_else(|| failed(io::Error::other("the path names no file")))?;
    Ok(directory.canonicalize().map_err(failed)?.join(name))
}

/// A file whose directory was not synced may be gone as a whole after a power loss.
#[cfg(unix)]
fn sync_directory(path: &Path) -> Result<(), OpenError> {
    let directory = path.parent().unwrap_or(path);
    std::fs::File::open(directory)
        .and_then(|directory| directory.sync_all())
        .map_err(|source| OpenError::Directory {
            path: path.to_owned(),
            source,
        })
}

#[cfg(not(unix))]
fn sync_directory(_path: &Path) -> Result<(), OpenError> {
    Ok(())
}

pub(super) fn failed(step: &'static str) -> impl Fn(sqlx::Error) -> OpenError {
    move |source| OpenError::Store { step, source }
}

#[cfg(all(test, target_os = "linux"))]
mod tests {
    use super::*;

    /// The files this process has open, those that were deleted among them.
    fn open_files() -> Vec<String> {
        let files = std::fs::read_dir("/proc/self/fd").expect("Linux has it");
        files
            .filter_map(|file| std::fs::read_link(file.ok()?.path()).ok())
            .map(|file| file.to_string_lossy().into_owned())
            .collect()
    }

    /// Covers: D7. What SQLite cannot keep in its cache while it sorts would go into a file in a temporary directory.
    #[tokio::test]
    async fn d7_sqlite_needs_no_directory_for_temporary_files() {
        let directory = tempfile::tempdir().unwrap();
        let path = directory.path().join("cell.journal");
        let mut store = load(&path, &SqliteOptions::default()).await.unwrap();
        let kind: i64 = pragma(&mut store.connection, "PRAGMA temp_store")
            .await
            .unwrap();
        assert_eq!(kind, 2);
        let spill = "CREATE TEMP TABLE spill (text TEXT); PRAGMA temp.cache_size = 1; \
             WITH RECURSIVE n (i) AS (SELECT 1 UNION ALL SELECT i + 1 FROM n WHERE i < 20000) \
             INSERT INTO spill SELECT hex(randomblob(100)) FROM n; \
             CREATE TEMP TABLE sorted AS SELECT text FROM spill ORDER BY text";
        let _done = sqlx::raw_sql(spill)
            .execute(&mut store.connection)
            .await
            .unwrap();
        let files = open_files();
        assert!(
            files.iter().any(|file| file.ends_with("cell.journal")),
            "{files:?}"
        );
        assert!(
            files.iter().all(|file| !file.contains("etilqs")),
            "{files:?}"
        );
    }
}
