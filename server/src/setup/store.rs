//! Where a set-up is kept.

use std::fmt;
use std::fs::File;
use std::io::{self, Write as _};
use std::path::{Path, PathBuf};
use std::pin::Pin;

use api::setup::SetupFile;
use thiserror::Error;

use super::document::{DocumentError, Form, parse_setup, write_setup};

/// A change on its way to where it is kept.
pub(crate) type Keeping<'a> = Pin<Box<dyn Future<Output = Result<(), StoreError>> + Send + 'a>>;

/// Where a set-up is kept. One change at a time; each is durable once [`Self::keep`] is done.
pub(crate) trait SetupStore: fmt::Debug + Send + Sync {
    /// Keeps a revision.
    fn keep(&self, revision: u64, file: SetupFile) -> Keeping<'_>;
}

/// Why a set-up could not be read or kept.
#[derive(Debug, Error)]
pub enum StoreError {
    /// The file could not be read.
    #[error("reading the set-up {}", .path.display())]
    Read {
        /// The file.
        path: PathBuf,
        /// Why.
        #[source]
        source: io::Error,
    },
    /// The file is no set-up.
    #[error("the set-up {}: {reason}", .path.display())]
    Unfit {
        /// The file, or what it stands for.
        path: PathBuf,
        /// Everything wrong with it.
        reason: String,
    },
    /// The file could not be written; the one before is still there.
    #[error("{step} {}: nothing was changed", .path.display())]
    Write {
        /// What was being done.
        step: &'static str,
        /// The file.
        path: PathBuf,
        /// Why it failed.
        #[source]
        source: io::Error,
    },
    /// The file was replaced, but the folder could not be flushed: a power failure now may bring the old one back.
    #[error("flushing {}: the set-up was changed, but may not survive a power failure", .folder.display())]
    InDoubt {
        /// The folder.
        folder: PathBuf,
        /// Why it failed.
        #[source]
        source: io::Error,
    },
}

/// Keeps nothing: what is changed is lost when the server ends.
#[derive(Debug)]
pub(super) struct MemoryStore;

impl SetupStore for MemoryStore {
    fn keep(&self, _: u64, _: SetupFile) -> Keeping<'_> {
        Box::pin(async { Ok(()) })
    }
}

/// Keeps the set-up in a TOML file: a new file, flushed, takes the place of the one before, and the folder is flushed.
/// So there is always one whole file. The revision stands in its first line.
#[derive(Debug)]
pub(super) struct FileStore {
    path: PathBuf,
}

const HEADER: &str = "# robocell set-up, revision ";

impl FileStore {
    pub(super) fn new(path: PathBuf) -> Self {
        Self { path }
    }

    /// The revision and the set-up in the file; `None` where there is no file. A file that was written by hand is
    /// revision 1.
    pub(super) fn read(&self) -> Result<Option<(u64, SetupFile)>, StoreError> {
        let path = self.path.clone();
        let text = match std::fs::read(&path) {
            Ok(text) => text,
            Err(error) if error.kind() == io::ErrorKind::NotFound => return Ok(None),
            Err(source) => return Err(StoreError::Read { path, source }),
        };
        let file = parse(&text, &path)?;
        let revision = str::from_utf8(&text)
            .ok()
            .and_then(|text| text.lines().next()?.strip_prefix(HEADER)?.parse().ok());
        Ok(Some((revision.unwrap_or(1), file)))
    }
}

/// Reads the TOML of a file, or of what stands for one.
pub(super) fn parse(text: &[u8], path: &Path) -> Result<SetupFile, StoreError> {
    parse_setup(text, Form::Toml).map_err(|error: DocumentError| StoreError::Unfit {
        path: path.to_owned(),
        reason: error.to_string(),
    })
}

impl SetupStore for FileStore {
    fn keep(&self, revision: u64, file: SetupFile) -> Keeping<'_> {
        let path = self.path.clone();
        Box::pin(async move {
            let writing = tokio::task::spawn_blocking(move || {
                let text = format!("{HEADER}{revision}\n{}", write_setup(&file, Form::Toml));
                replace(&path, text.as_bytes())
            });
            match writing.await {
                Ok(written) => written,
                Err(_) => Err(StoreError::Write {
                    step: "writing",
                    path: self.path.clone(),
                    source: io::Error::other("the writing task ended early"),
                }),
            }
        })
    }
}

/// Puts a text in the place of a file, or fails and leaves it as it was.
fn replace(path: &Path, text: &[u8]) -> Result<(), StoreError> {
    let folder = match path.parent() {
        Some(folder) if !folder.as_os_str().is_empty() => folder,
        Some(_) | None => Path::new("."),
    };
    let mut name = path.file_name().unwrap_or_default().to_owned();
    name.push(".new");
    let new = folder.join(name);
    let failed = |step| {
        let path = path.to_owned();
        move |source| StoreError::Write { step, path, source }
    };
    let write = || {
        let mut file = File::create(&new)?;
        file.write_all(text)?;
        file.sync_all()
    };
    write().map_err(failed("writing"))?;
    std::fs::rename(&new, path).map_err(failed("replacing"))?;
    let flushed = File::open(folder).and_then(|folder| folder.sync_all());
    flushed.map_err(|source| StoreError::InDoubt {
        folder: folder.to_owned(),
        source,
    })
}
