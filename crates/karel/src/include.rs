//! Where `%INCLUDE` finds its files.
//!
//! This crate does no I/O, so the caller has the files. A path counts from the folder of the program
//! that is translated, also inside a file that is included itself.

use std::collections::BTreeMap;

/// A file for `%INCLUDE`.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct IncludeFile {
    /// Its name for messages.
    pub name: String,
    /// Its text, Latin-1 bytes.
    pub text: Vec<u8>,
}

/// The caller's files.
pub trait Includes {
    /// The file that a program means by `path`, which is given as the program wrote it.
    ///
    /// Programs take `\` and `/` as one, have no case, and may leave out a last `.kl`; see
    /// [`IncludeFiles::key`].
    fn find(&self, path: &str) -> Option<IncludeFile>;
}

/// Files in memory.
#[derive(Clone, Debug, Default)]
pub struct IncludeFiles {
    files: BTreeMap<String, IncludeFile>,
}

impl IncludeFiles {
    /// Adds a file. `name` is its path from the folder of the program, `include/shared.kl`.
    pub fn insert(&mut self, name: &str, text: impl Into<Vec<u8>>) {
        let file = IncludeFile {
            name: name.to_owned(),
            text: text.into(),
        };
        let _replaced = self.files.insert(IncludeFiles::key(name), file);
    }

    /// What two paths that mean the same file have in common: lower case, `/`, no `.kl`.
    #[must_use]
    pub fn key(path: &str) -> String {
        let path = path.trim().replace('\\', "/").to_ascii_lowercase();
        let path = path.strip_prefix("./").unwrap_or(&path);
        path.strip_suffix(".kl").unwrap_or(path).to_owned()
    }
}

impl Includes for IncludeFiles {
    fn find(&self, path: &str) -> Option<IncludeFile> {
        self.files.get(&IncludeFiles::key(path)).cloned()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_path_has_no_case_either_slash_and_perhaps_an_extension() {
        let mut files = IncludeFiles::default();
        files.insert("include/Shared_T.kl", "-- text");
        for path in [
            "include\\shared_t",
            "INCLUDE/SHARED_T.KL",
            "./include/shared_t",
        ] {
            assert!(files.find(path).is_some(), "{path}");
        }
        assert!(files.find("shared_t").is_none());
    }
}
