//! Files of the controller: `RD:`, `MC:` and their like, and pipes (`PIP:`), all in memory.
//!
//! The core stays deterministic: a folder outside is read before it starts ([`Folder::read`]) and written by the
//! driver when a program closes a file it has written ([`crate::effects::Effect::Keep`]). No name reaches out of its
//! device: `..`, drives, and letters that a file system could misread are refused.

use std::collections::BTreeMap;
use std::io;
use std::path::PathBuf;

use karel::{FileId, FileOperation, Input, InputEnd, OpenMode, Status};

/// Devices that hold files.
///
/// ASSUMPTION: all of them are there and empty at first, and all but `RD:` keep their files without power.
const DEVICES: [&str; 7] = ["RD", "MC", "FR", "UD1", "UT1", "MD", "FRA"];

/// The device of a name without one.
const DEFAULT_DEVICE: &str = "MC";

/// Bytes of all files, of one file, and of one pipe.
const MAX_BYTES: usize = 2 << 20;
const MAX_FILE: usize = 1 << 20;
const MAX_PIPE: usize = 64 << 10;

/// Files and pipes that may exist.
const MAX_FILES: usize = 512;
const MAX_PIPES: usize = 32;

/// A file by its device and its name in capitals.
#[derive(Clone, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub struct FileName {
    device: String,
    name: String,
}

impl std::fmt::Display for FileName {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "{}:{}", self.device, self.name)
    }
}

impl FileName {
    /// Reads `MC:log.txt`, `RD:\\dir\\x.dt`, `PIP:queue`; `None` if the name is none or reaches out of its device.
    #[must_use]
    pub fn parse(text: &str) -> Option<Self> {
        let text = text.trim().to_ascii_uppercase();
        let (device, name) = text.split_once(':').unwrap_or((DEFAULT_DEVICE, &text));
        let name = name.replace('\\', "/");
        let name = name.strip_prefix('/').unwrap_or(&name);
        let parts: Vec<&str> = name.split('/').collect();
        let good = |part: &&str| {
            let plain = |c: char| c.is_ascii_alphanumeric() || "_-.$~#@ ".contains(c);
            !part.is_empty()
                && part.len() <= 64
                && !part.starts_with(['.', ' '])
                && !part.ends_with(['.', ' '])
                && part.chars().all(plain)
        };
        if parts.len() > 8 || !parts.iter().all(good) {
            return None;
        }
        Some(Self {
            device: device.trim().to_owned(),
            name: name.to_owned(),
        })
    }

    fn is_pipe(&self) -> bool {
        self.device == "PIP"
    }

    fn checked(text: &str) -> Result<Self, Status> {
        let name = Self::parse(text).ok_or(Status::FILE_ILLEGAL_PARAMETER)?;
        if name.is_pipe() || DEVICES.contains(&name.device.as_str()) {
            Ok(name)
        } else {
            Err(Status::FILE_NO_DEVICE)
        }
    }
}

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

#[cfg(test)]
mod tests {
    use super::*;

    fn opened(devices: &mut Devices, number: u32, mode: OpenMode, name: &str) -> FileId {
        let file = FileId(number);
        devices.open(file, mode, name).unwrap();
        file
    }

    #[test]
    fn names_stay_inside_of_their_device() {
        for good in [
            "RD:log.txt",
            "mc:\\dir\\x.dt",
            "plain",
            "PIP:q",
            "FR:a/b/c.kl",
        ] {
            assert!(FileName::parse(good).is_some(), "{good}");
        }
        for bad in [
            "MC:..\\x",
            "MC:../x",
            "MC:a/../../x",
            "MC:",
            "RD:a//b",
            "MC:.hidden",
            "MC:a:b",
            "MC:x\0y",
            "MC:a/..",
            "MC:C:\\x",
            "MC:a?b",
            "MC://x",
        ] {
            assert_eq!(FileName::parse(bad), None, "{bad:?}");
        }
        let mut devices = Devices::default();
        let outside = devices.open(FileId(1), OpenMode::ReadWrite, "MC:../../etc/passwd");
        assert_eq!(outside, Err(Status::FILE_ILLEGAL_PARAMETER));
        let elsewhere = devices.open(FileId(1), OpenMode::ReadWrite, "XYZ:a");
        assert_eq!(elsewhere, Err(Status::FILE_NO_DEVICE));
    }

    #[test]
    fn a_file_is_written_read_added_to_and_deleted() {
        let mut devices = Devices::default();
        let missing = devices.open(FileId(1), OpenMode::ReadOnly, "RD:a.txt");
        assert_eq!(missing, Err(Status::FILE_NOT_FOUND));
        let file = opened(&mut devices, 1, OpenMode::ReadWrite, "RD:a.txt");
        assert_eq!(devices.write(file, b"one").0, Status::OK);
        devices.close(file);
        let file = opened(&mut devices, 2, OpenMode::Append, "rd:A.TXT");
        assert_eq!(devices.write(file, b"two").0, Status::OK);
        devices.close(file);
        let file = opened(&mut devices, 3, OpenMode::ReadOnly, "RD:A.TXT");
        assert_eq!(devices.input(file).bytes, b"onetwo");
        devices.consume(file, 4);
        assert_eq!(devices.input(file).bytes, b"wo");
        assert_eq!(devices.write(file, b"x").0, Status::INTP_WRITE_FAILED);
        devices.close(file);
        let changed: Vec<String> = devices
            .take_changed()
            .into_iter()
            .map(|(name, bytes)| format!("{name} {:?}", bytes.map(|bytes| bytes.len())))
            .collect();
        assert_eq!(changed, ["RD:A.TXT Some(3)", "RD:A.TXT Some(6)"]);
        assert_eq!(
            devices.operate(FileOperation::Delete("RD:a.txt")),
            Status::OK
        );
        let again = devices.operate(FileOperation::Delete("RD:a.txt"));
        assert_eq!(again, Status::FILE_NOT_FOUND);
    }

    #[test]
    fn a_device_is_full_at_its_limit() {
        let mut devices = Devices::default();
        let file = opened(&mut devices, 1, OpenMode::ReadWrite, "MC:big");
        let chunk = vec![0; MAX_FILE];
        assert_eq!(devices.write(file, &chunk).0, Status::OK);
        assert_eq!(devices.write(file, b"x").0, Status::FILE_DEVICE_FULL);
    }

    #[test]
    fn assumed_pipe_loses_its_oldest_bytes() {
        let mut devices = Devices::default();
        let writer = opened(&mut devices, 1, OpenMode::ReadWrite, "PIP:q");
        let reader = opened(&mut devices, 2, OpenMode::ReadOnly, "pip:Q");
        let (status, readers) = devices.write(writer, &vec![b'a'; MAX_PIPE]);
        assert_eq!((status, readers.contains(&reader)), (Status::OK, true));
        assert_eq!(devices.write(writer, b"end").0, Status::OK);
        let input = devices.input(reader);
        assert_eq!(input.bytes.len(), MAX_PIPE);
        assert!(input.bytes.ends_with(b"aend"));
    }

    #[test]
    fn patterns_have_stars() {
        assert!(matches(b"*.TXT", b"A.TXT"));
        assert!(matches(b"*", b""));
        assert!(matches(b"A*B*C", b"AXXBYYBC"));
        assert!(!matches(b"*.TXT", b"A.DT"));
        // Many stars cost little.
        let many = b"*A".repeat(30);
        assert!(!matches(&many, &[b'A'; 20]));
    }

    #[test]
    fn a_folder_gets_what_programs_close_and_nothing_outside() {
        let root = std::env::temp_dir().join(format!("robocell-devices-{}", std::process::id()));
        std::fs::create_dir_all(root.join("MC")).unwrap();
        std::fs::write(root.join("MC/old.txt"), b"old").unwrap();
        let folder = Folder::try_new(&root).unwrap();
        let name = FileName::parse("MC:new.txt").unwrap();
        folder.keep(&name, Some(b"new")).unwrap();
        let read = folder.read().unwrap();
        let names: Vec<String> = read.iter().map(|(name, _)| name.to_string()).collect();
        assert!(names.contains(&"MC:OLD.TXT".to_owned()), "{names:?}");
        assert!(names.contains(&"MC:NEW.TXT".to_owned()), "{names:?}");
        #[cfg(unix)]
        {
            std::os::unix::fs::symlink("/tmp", root.join("RD")).unwrap();
            let name = FileName::parse("RD:out.txt").unwrap();
            let refused = folder.keep(&name, Some(b"x")).unwrap_err();
            assert_eq!(refused.kind(), io::ErrorKind::PermissionDenied);
        }
        folder.keep(&name, None).unwrap();
        std::fs::remove_dir_all(&root).unwrap();
    }
}
