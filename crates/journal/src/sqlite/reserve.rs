//! Room that is held back, so that a full disk leaves no motion without an end.
//!
//! ```text
//! room for all ── no room for a record: give the reserve up ──▶ on the reserve: nothing new begins, ends are kept
//!      ▲                                                             │
//!      └───────────── the reserve could be made again ◀──────────────┘      no room there either: nothing more
//! ```
//!
//! The reserve is a file of its own beside the journal. Its blocks are really taken, and deleting it frees them for the
//! journal at once. ASSUMPTION: the filesystem overwrites in place, as ext4 and XFS do; one that writes copies may need
//! room to delete, and frees later.

use std::io::{self, Write as _};
use std::path::{Path, PathBuf};

use sqlx::sqlite::SqliteConnection;

use super::SqliteOptions;
use super::columns::unsigned;
use super::store::Store;
use crate::Room;

const PAGE: u64 = 4_096;

/// The file's largest size, in pages.
#[derive(Clone, Copy, Debug, Eq, PartialEq)]
pub(super) struct Pages {
    pub(super) without_reserve: u32,
    most: u32,
}

impl Pages {
    /// None for as large as the disk.
    pub(super) fn of(options: &SqliteOptions) -> Option<Self> {
        let most = options.max_pages?;
        let reserve = u32::try_from(options.reserve.div_ceil(PAGE)).unwrap_or(u32::MAX);
        Some(Self {
            without_reserve: most.saturating_sub(reserve).max(1),
            most,
        })
    }
}

/// The reserve of one journal.
#[derive(Debug)]
pub(super) struct Reserve {
    path: PathBuf,
    /// Zero for none.
    bytes: u64,
    pages: Option<Pages>,
    room: Room,
}

impl Reserve {
    pub(super) fn new(journal: &Path, options: &SqliteOptions) -> Self {
        let mut name = journal.as_os_str().to_owned();
        name.push(".reserve");
        Self {
            path: name.into(),
            bytes: options.reserve,
            pages: Pages::of(options),
            room: Room::Free,
        }
    }

    pub(super) fn room(&self) -> Room {
        self.room
    }

    /// After a transaction that found no room: undoes it and gives the reserve up. Whether there was one.
    pub(super) async fn open(&mut self, store: &mut Store) -> Result<bool, sqlx::Error> {
        if self.bytes == 0 || self.room != Room::Free {
            return Ok(false);
        }
        store.undo().await?;
        remove(&self.path)?;
        if let Some(pages) = self.pages {
            limit(&mut store.connection, pages.most).await?;
        }
        self.room = Room::Reserve { bytes: self.bytes };
        Ok(true)
    }

    /// Makes the reserve again, if there is room for it.
    pub(super) async fn close(&mut self, store: &mut Store) -> Result<(), sqlx::Error> {
        if let Some(pages) = self.pages {
            let used = pages_used(&mut store.connection).await?;
            if used >= u64::from(pages.without_reserve) {
                return Ok(());
            }
        }
        self.stock(store).await
    }

    /// Makes the file. Where that fails there is no room, and what is left of it is for the journal.
    pub(super) async fn stock(&mut self, store: &mut Store) -> Result<(), sqlx::Error> {
        if self.bytes == 0 {
            return Ok(());
        }
        let (path, bytes) = (self.path.clone(), self.bytes);
        let made = tokio::task::spawn_blocking(move || {
            make(&path, bytes).inspect_err(|_| {
                // What cannot be deleted either is still there at the next look.
                let _deleted = remove(&path);
            })
        })
        .await;
        self.room = match made {
            Ok(Ok(())) => Room::Free,
            Ok(Err(_)) | Err(_) => Room::Reserve { bytes },
        };
        let Some(pages) = self.pages else {
            return Ok(());
        };
        let most = match self.room {
            Room::Free => pages.without_reserve,
            Room::Reserve { .. } => pages.most,
        };
        limit(&mut store.connection, most).await
    }
}

/// Takes the blocks: with bytes that no filesystem can make smaller, down to the disk.
fn make(path: &Path, bytes: u64) -> io::Result<()> {
    if is_whole(path, bytes) {
        return Ok(());
    }
    let mut file = io::BufWriter::new(std::fs::File::create(path)?);
    let mut noise = blake3::Hasher::new().finalize_xof();
    let mut chunk = [0; 4_096];
    let mut left = bytes;
    while left > 0 {
        noise.fill(&mut chunk);
        let length = usize::try_from(left).map_or(chunk.len(), |left| left.min(chunk.len()));
        file.write_all(chunk.get(..length).unwrap_or(&chunk))?;
        left -= length as u64;
    }
    file.flush()?;
    file.get_ref().sync_all()
}

/// Whether the file of an earlier start does.
#[cfg(unix)]
fn is_whole(path: &Path, bytes: u64) -> bool {
    use std::os::unix::fs::MetadataExt as _;
    std::fs::metadata(path)
        .is_ok_and(|file| file.len() == bytes && file.blocks().saturating_mul(512) >= bytes)
}

#[cfg(not(unix))]
fn is_whole(_path: &Path, _bytes: u64) -> bool {
    false
}

fn remove(path: &Path) -> io::Result<()> {
    match std::fs::remove_file(path) {
        Err(error) if error.kind() != io::ErrorKind::NotFound => Err(error),
        Ok(()) | Err(_) => Ok(()),
    }
}

async fn pages_used(connection: &mut SqliteConnection) -> Result<u64, sqlx::Error> {
    let row = sqlx::query(
        "SELECT (SELECT page_count FROM pragma_page_count) - \
         (SELECT freelist_count FROM pragma_freelist_count) AS used",
    )
    .fetch_one(connection)
    .await?;
    unsigned(&row, "used")
}

async fn limit(connection: &mut SqliteConnection, pages: u32) -> Result<(), sqlx::Error> {
    // A number of this program, not of the outside; a pragma takes no parameter.
    let pragma = sqlx::AssertSqlSafe(format!("PRAGMA max_page_count = {pages}"));
    let _row = sqlx::raw_sql(pragma).execute(connection).await?;
    Ok(())
}
