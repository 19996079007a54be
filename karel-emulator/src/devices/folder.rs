//! The folder of this machine that keeps what programs write.

use std::io;
use std::path::PathBuf;

use super::{DEVICES, FileName, MAX_FILE};

/// A folder of this machine with one folder for each device, `RD`, `MC` and so on.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Folder {
    root: PathBuf,
}

impl Folder {
    /// A folder that exists.
    ///
    /// # Errors
    /// It does not, or is none.
    pub fn try_new(root: impl Into<PathBuf>) -> io::Result<Self> {
        let root = root.into().canonicalize()?;
        if !root.is_dir() {
            let text = format!("{} is not a folder", root.display());
            return Err(io::Error::new(io::ErrorKind::NotADirectory, text));
        }
        Ok(Self { root })
    }

    /// The files that are there, by the names that programs have for them. Links are not followed, and names that
    /// programs cannot write are left out.
    ///
    /// # Errors
    /// A folder or a file cannot be read.
    pub fn read(&self) -> io::Result<Vec<(FileName, Vec<u8>)>> {
        let mut found = Vec::new();
        for device in DEVICES {
            let folder = self.root.join(device);
            if !folder.is_dir() || folder.is_symlink() {
                continue;
            }
            for entry in std::fs::read_dir(&folder)? {
                let entry = entry?;
                let name = entry.file_name();
                let name = format!("{device}:{}", name.to_string_lossy());
                if let Some(name) = FileName::parse(&name)
                    && entry.file_type()?.is_file()
                    && entry.metadata()?.len() <= MAX_FILE as u64
                {
                    found.push((name, std::fs::read(entry.path())?));
                }
            }
        }
        Ok(found)
    }

    /// Writes or deletes a file that a program has closed or deleted.
    ///
    /// # Errors
    /// The file system refuses, or a link would lead out of the folder.
    pub fn keep(&self, name: &FileName, bytes: Option<&[u8]>) -> io::Result<()> {
        let mut path = self.root.join(&name.device);
        let parts: Vec<&str> = name.name.split('/').collect();
        if let Some((_, folders)) = parts.split_last() {
            path.extend(folders);
        }
        std::fs::create_dir_all(&path)?;
        if !path.canonicalize()?.starts_with(&self.root) {
            let text = format!("{name} leads out of the folder");
            return Err(io::Error::new(io::ErrorKind::PermissionDenied, text));
        }
        path.extend(parts.last());
        if path.is_symlink() {
            let text = format!("{name} is a link");
            return Err(io::Error::new(io::ErrorKind::PermissionDenied, text));
        }
        match bytes {
            Some(bytes) => std::fs::write(path, bytes),
            None if path.exists() => std::fs::remove_file(path),
            None => Ok(()),
        }
    }
}
