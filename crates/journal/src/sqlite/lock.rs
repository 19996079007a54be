//! One writer at a time, and a second place that knows the epoch.
//!
//! The lock is on a file beside the data, because closing any other handle of the data file would drop the locks
//! SQLite holds on it (POSIX record locks belong to the process, not to the handle).

use std::fs::{File, OpenOptions, TryLockError};
use std::io::{self, Read as _, Seek as _, SeekFrom, Write as _};
use std::path::{Path, PathBuf};

use super::OpenError;
use crate::Epoch;

/// The right to write a journal, for as long as it lives.
#[derive(Debug)]
pub(super) struct Lock {
    file: File,
    path: PathBuf,
}

impl Lock {
    pub(super) fn acquire(data: &Path) -> Result<Self, OpenError> {
        let mut name = data.as_os_str().to_owned();
        name.push(".lock");
        let path = PathBuf::from(name);
        let file = OpenOptions::new()
            .read(true)
            .write(true)
            .create(true)
            .truncate(false)
            .open(&path)
            .map_err(|source| OpenError::Lock {
                path: path.clone(),
                source,
            })?;
        match file.try_lock() {
            Ok(()) => Ok(Self { file, path }),
            Err(TryLockError::WouldBlock) => Err(OpenError::InUse {
                path: data.to_owned(),
            }),
            Err(TryLockError::Error(source)) => Err(OpenError::Lock { path, source }),
        }
    }

    /// The highest epoch that was ever begun here; zero in a new file.
    pub(super) fn epoch(&mut self) -> Result<Epoch, OpenError> {
        let read = |file: &mut File| -> io::Result<Epoch> {
            let _start = file.seek(SeekFrom::Start(0))?;
            let mut text = String::new();
            let _length = file.take(64).read_to_string(&mut text)?;
            if text.is_empty() {
                return Ok(Epoch(0));
            }
            let number = text.trim().parse().map_err(io::Error::other)?;
            Ok(Epoch(number))
        };
        read(&mut self.file).map_err(|source| OpenError::Lock {
            path: self.path.clone(),
            source,
        })
    }

    /// Keeps the epoch, durably. Always the same number of bytes, in one write: the file is never half empty.
    pub(super) fn keep(&mut self, epoch: Epoch) -> Result<(), OpenError> {
        let write = |file: &mut File| -> io::Result<()> {
            let _start = file.seek(SeekFrom::Start(0))?;
            file.write_all(format!("{:020}\n", epoch.0).as_bytes())?;
            file.sync_all()
        };
        write(&mut self.file).map_err(|source| OpenError::Lock {
            path: self.path.clone(),
            source,
        })
    }
}
