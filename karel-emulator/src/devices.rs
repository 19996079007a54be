//! Files of the controller: `RD:`, `MC:` and their like, and pipes (`PIP:`), all in memory.
//!
//! The core stays deterministic: a folder outside is read before it starts ([`Folder::read`]) and written by the
//! driver when a program closes a file it has written ([`crate::effects::Effect::Keep`]). No name reaches out of its
//! device: `..`, drives, and letters that a file system could misread are refused.

mod folder;
mod name;

use std::collections::BTreeMap;

pub use folder::Folder;
use karel::{FileId, FileOperation, Input, InputEnd, OpenMode, Status};
pub use name::FileName;
use name::{DEFAULT_DEVICE, DEVICES};

/// Bytes of all files, of one file, and of one pipe.
const MAX_BYTES: usize = 2 << 20;
const MAX_FILE: usize = 1 << 20;
const MAX_PIPE: usize = 64 << 10;

/// Files and pipes that may exist.
const MAX_FILES: usize = 512;
const MAX_PIPES: usize = 32;

/// A file that is open.
#[derive(Debug)]
struct Open {
    name: FileName,
    mode: OpenMode,
    position: usize,
    written: bool,
}

/// All files and pipes of a controller.
#[derive(Debug, Default)]
pub(crate) struct Devices {
    files: BTreeMap<FileName, Vec<u8>>,
    pipes: BTreeMap<String, Vec<u8>>,
    open: BTreeMap<FileId, Open>,
    /// Files that are to be kept outside: their bytes, or that they are gone.
    changed: Vec<(FileName, Option<Vec<u8>>)>,
}

impl Devices {
    /// Puts a file there before anything runs. `false` if it cannot be.
    pub(crate) fn insert(&mut self, name: FileName, bytes: Vec<u8>) -> bool {
        let fits = self.files.len() < MAX_FILES
            && bytes.len() <= MAX_FILE
            && self.bytes() + bytes.len() <= MAX_BYTES;
        if fits {
            let _before = self.files.insert(name, bytes);
        }
        fits
    }

    /// The files of a device, by name.
    pub(crate) fn files(&self) -> impl Iterator<Item = (&FileName, &[u8])> {
        self.files
            .iter()
            .map(|(name, bytes)| (name, bytes.as_slice()))
    }

    /// What is to be written outside.
    pub(crate) fn take_changed(&mut self) -> Vec<(FileName, Option<Vec<u8>>)> {
        std::mem::take(&mut self.changed)
    }

    pub(crate) fn holds(&self, file: FileId) -> bool {
        self.open.contains_key(&file)
    }

    pub(crate) fn opened(&self) -> usize {
        self.open.len()
    }

    /// Files of a task that is gone, and everything when the power is switched off.
    pub(crate) fn power_cycle(&mut self) {
        self.open.clear();
        self.pipes.clear();
        self.files.retain(|name, _| name.device != "RD");
    }

    fn bytes(&self) -> usize {
        self.files.values().map(Vec::len).sum()
    }

    /// ASSUMPTION: `RW` makes a file anew, `AP` and `UD` make one that is not there; two programs may have a file
    /// open at the same time.
    pub(crate) fn open(&mut self, file: FileId, mode: OpenMode, text: &str) -> Result<(), Status> {
        let name = FileName::checked(text)?;
        if name.is_pipe() {
            if !self.pipes.contains_key(&name.name) && self.pipes.len() >= MAX_PIPES {
                return Err(Status::INTP_LIMIT);
            }
            let _pipe = self.pipes.entry(name.name.clone()).or_default();
        } else {
            let exists = self.files.contains_key(&name);
            if !exists && mode == OpenMode::ReadOnly {
                return Err(Status::FILE_NOT_FOUND);
            }
            if !exists && self.files.len() >= MAX_FILES {
                return Err(Status::FILE_DEVICE_FULL);
            }
            let bytes = self.files.entry(name.clone()).or_default();
            if mode == OpenMode::ReadWrite {
                bytes.clear();
            }
        }
        let open = Open {
            written: mode == OpenMode::ReadWrite,
            name,
            mode,
            position: 0,
        };
        let _new = self.open.insert(file, open);
        Ok(())
    }

    pub(crate) fn close(&mut self, file: FileId) {
        if let Some(open) = self.open.remove(&file)
            && open.written
            && !open.name.is_pipe()
        {
            let bytes = self.files.get(&open.name).cloned();
            self.changed.push((open.name, bytes));
        }
    }

    pub(crate) fn input(&self, file: FileId) -> Input<'_> {
        let nothing = Input {
            bytes: &[],
            end: InputEnd::Closed(Status::FILE_END),
        };
        let Some(open) = self.open.get(&file) else {
            return nothing;
        };
        if open.name.is_pipe() {
            let bytes = self.pipes.get(&open.name.name);
            return Input {
                bytes: bytes.map(Vec::as_slice).unwrap_or_default(),
                end: InputEnd::Open,
            };
        }
        let bytes = self.files.get(&open.name).map(Vec::as_slice);
        Input {
            bytes: bytes
                .and_then(|bytes| bytes.get(open.position..))
                .unwrap_or_default(),
            end: InputEnd::Closed(Status::FILE_END),
        }
    }

    pub(crate) fn consume(&mut self, file: FileId, count: usize) {
        let Some(open) = self.open.get_mut(&file) else {
            return;
        };
        if !open.name.is_pipe() {
            open.position += count;
        } else if let Some(bytes) = self.pipes.get_mut(&open.name.name) {
            drop(bytes.drain(..count.min(bytes.len())));
        }
    }

    /// The status, and the readers of a pipe that have something now.
    ///
    /// ASSUMPTION: a pipe that is full loses its oldest bytes.
    pub(crate) fn write(&mut self, file: FileId, bytes: &[u8]) -> (Status, Vec<FileId>) {
        let total = self.bytes();
        let Some(open) = self.open.get_mut(&file) else {
            return (Status::INTP_NOT_OPEN, Vec::new());
        };
        if open.mode == OpenMode::ReadOnly {
            return (Status::INTP_WRITE_FAILED, Vec::new());
        }
        if open.name.is_pipe() {
            let name = open.name.clone();
            let pipe = self.pipes.entry(name.name.clone()).or_default();
            pipe.extend_from_slice(bytes);
            let excess = pipe.len().saturating_sub(MAX_PIPE);
            drop(pipe.drain(..excess));
            let readers = self.open.iter().filter(|(_, open)| open.name == name);
            return (Status::OK, readers.map(|(id, _)| *id).collect());
        }
        let Some(content) = self.files.get_mut(&open.name) else {
            return (Status::FILE_NOT_FOUND, Vec::new());
        };
        let at = if open.mode == OpenMode::Append {
            content.len()
        } else {
            open.position.min(content.len())
        };
        let end = at + bytes.len();
        let grows = end.saturating_sub(content.len());
        if end > MAX_FILE || total + grows > MAX_BYTES {
            return (Status::FILE_DEVICE_FULL, Vec::new());
        }
        if content.len() < end {
            content.resize(end, 0);
        }
        if let Some(place) = content.get_mut(at..end) {
            place.copy_from_slice(bytes);
        }
        open.position = end;
        open.written = true;
        (Status::OK, Vec::new())
    }

    pub(crate) fn operate(&mut self, operation: FileOperation<'_>) -> Status {
        self.try_operate(operation).err().unwrap_or(Status::OK)
    }

    fn try_operate(&mut self, operation: FileOperation<'_>) -> Result<(), Status> {
        match operation {
            FileOperation::Copy {
                from,
                to,
                overwrite,
            } => {
                let bytes = self.bytes_of(&FileName::checked(from)?)?;
                let to = FileName::checked(to)?;
                if to.is_pipe() || (self.files.contains_key(&to) && !overwrite) {
                    return Err(Status::FILE_EXISTS);
                }
                self.put(to, bytes)
            }
            FileOperation::Delete(name) => {
                let name = FileName::checked(name)?;
                let _bytes = self.files.remove(&name).ok_or(Status::FILE_NOT_FOUND)?;
                self.changed.push((name, None));
                Ok(())
            }
            FileOperation::Rename { from, to } => {
                let from = FileName::checked(from)?;
                let to = FileName::checked(to)?;
                if self.files.contains_key(&to) || to.is_pipe() {
                    return Err(Status::FILE_EXISTS);
                }
                let bytes = self.files.remove(&from).ok_or(Status::FILE_NOT_FOUND)?;
                self.changed.push((from, None));
                self.put(to, bytes)
            }
            FileOperation::Mount(device) => Self::device(device).map(drop),
            FileOperation::Format(device) => {
                let device = Self::device(device)?;
                let gone: Vec<FileName> = self
                    .files
                    .keys()
                    .filter(|name| name.device == device)
                    .cloned()
                    .collect();
                for name in gone {
                    let _bytes = self.files.remove(&name);
                    self.changed.push((name, None));
                }
                Ok(())
            }
        }
    }

    fn device(text: &str) -> Result<&'static str, Status> {
        let wanted = text.trim().trim_end_matches(':').to_ascii_uppercase();
        let known = DEVICES.into_iter().find(|device| *device == wanted);
        known.ok_or(Status::FILE_NO_DEVICE)
    }

    fn bytes_of(&self, name: &FileName) -> Result<Vec<u8>, Status> {
        self.files.get(name).cloned().ok_or(Status::FILE_NOT_FOUND)
    }

    fn put(&mut self, name: FileName, bytes: Vec<u8>) -> Result<(), Status> {
        if !self.insert(name.clone(), bytes.clone()) {
            return Err(Status::FILE_DEVICE_FULL);
        }
        self.changed.push((name, Some(bytes)));
        Ok(())
    }

    /// Names without their device that a pattern with `*` means.
    pub(crate) fn list(&self, pattern: &str) -> Result<Vec<String>, Status> {
        let pattern = pattern.trim().to_ascii_uppercase();
        let (device, wanted) = pattern
            .split_once(':')
            .unwrap_or((DEFAULT_DEVICE, &pattern));
        let device = Self::device(device)?;
        let wanted = if wanted.is_empty() { "*" } else { wanted };
        let files = self.files.keys().filter(|file| file.device == device);
        let found = files.filter(|file| matches(wanted.as_bytes(), file.name.as_bytes()));
        Ok(found.map(|file| file.name.clone()).collect())
    }
}

/// `*` stands for any bytes, also for none.
fn matches(pattern: &[u8], name: &[u8]) -> bool {
    let (mut p, mut n) = (0, 0);
    // Where the last star was, and what it has taken so far: enough to go back to, without recursion.
    let mut star = None;
    while n < name.len() {
        match (pattern.get(p), name.get(n)) {
            (Some(b'*'), _) => {
                star = Some((p, n));
                p += 1;
            }
            (Some(wanted), Some(found)) if wanted == found => {
                p += 1;
                n += 1;
            }
            _ => {
                let Some((at, taken)) = star else {
                    return false;
                };
                star = Some((at, taken + 1));
                p = at + 1;
                n = taken + 1;
            }
        }
    }
    pattern.iter().skip(p).all(|byte| *byte == b'*')
}

#[cfg(test)]
mod tests;
