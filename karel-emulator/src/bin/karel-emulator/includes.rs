//! Files for `%INCLUDE`, from the folder of the program.

use std::cell::RefCell;
use std::path::{Path, PathBuf};

use karel::{IncludeFile, IncludeFiles, Includes};
use karel_emulator::config::ProgramSource;

/// A folder, and what was taken from it.
pub(crate) struct Folder {
    roots: Vec<PathBuf>,
    taken: RefCell<Vec<ProgramSource>>,
}

impl Folder {
    /// The folder of a program.
    pub(crate) fn of(program: &Path) -> Self {
        let parent = program.parent().unwrap_or(Path::new(""));
        let here = parent.as_os_str().is_empty();
        Self {
            roots: vec![if here {
                PathBuf::from(".")
            } else {
                parent.to_owned()
            }],
            taken: RefCell::new(Vec::new()),
        }
    }

    /// Also these folders, in order, behind that of the program.
    pub(crate) fn and(mut self, folders: &[PathBuf]) -> Self {
        self.roots.extend_from_slice(folders);
        self
    }

    /// The files that were found so far.
    pub(crate) fn into_taken(self) -> Vec<ProgramSource> {
        self.taken.into_inner()
    }

    /// Names on a controller have no case, file names here may have.
    fn path(root: &Path, key: &str) -> Option<PathBuf> {
        let mut path = root.to_owned();
        let mut steps = key.split('/').peekable();
        while let Some(step) = steps.next() {
            let is_last = steps.peek().is_none();
            if step == ".." {
                path.push(step);
                continue;
            }
            let mut entries = std::fs::read_dir(&path).ok()?.flatten();
            let found = entries.find(|entry| {
                let name = entry.file_name().to_string_lossy().to_ascii_lowercase();
                name == step || (is_last && name.strip_suffix(".kl") == Some(step))
            });
            path = found?.path();
        }
        Some(path)
    }
}

impl Includes for Folder {
    fn find(&self, path: &str) -> Option<IncludeFile> {
        let key = IncludeFiles::key(path);
        let mut roots = self.roots.iter();
        let found = roots.find_map(|root| Self::path(root, &key))?;
        let text = std::fs::read(&found).ok()?;
        let name = found.display().to_string();
        // The name that the controller looks for is the one that the program writes.
        let source = ProgramSource::new(key, text.clone());
        self.taken.borrow_mut().push(source);
        Some(IncludeFile { name, text })
    }
}
