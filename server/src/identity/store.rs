//! The file of tokens: hashes, never secrets; readable by its owner only; replaced whole or not at all.

use std::fs::{self, File, OpenOptions};
use std::io::{self, Read as _, Write as _};
use std::path::{Path, PathBuf};

use api::{Role, TokenInfo, TokenScope, TokenState};
use jiff::Timestamp;
use serde::{Deserialize, Serialize};
use thiserror::Error;

use super::token::{RandomError, SecretHash, TokenId};

/// The layout of the file.
const VERSION: u32 = 1;
/// The largest file read: far more than [`super::tokens::MAX_TOKENS`] need.
const MAX_BYTES: u64 = 4 << 20;

/// What is kept of a token.
#[derive(Clone, Debug, Deserialize, PartialEq, Serialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct Kept {
    #[serde(with = "id_text")]
    pub(crate) id: TokenId,
    pub(crate) name: String,
    pub(crate) role: Role,
    #[serde(default)]
    pub(crate) scope: TokenScope,
    #[serde(with = "hash_text")]
    pub(crate) hash: SecretHash,
    pub(crate) created_at: Timestamp,
    pub(crate) created_by: String,
    pub(crate) expires_at: Timestamp,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub(crate) revoked_at: Option<Timestamp>,
}

#[derive(Deserialize, Serialize)]
#[serde(deny_unknown_fields)]
struct Contents {
    version: u32,
    tokens: Vec<Kept>,
}

/// Why the file of tokens is not used, or was not changed.
#[derive(Debug, Error)]
#[non_exhaustive]
pub enum StoreError {
    /// Reading it failed.
    #[error("reading the tokens in {path}")]
    Read {
        /// The file.
        path: PathBuf,
        /// The cause.
        #[source]
        source: io::Error,
    },
    /// Writing it failed; it is as it was.
    #[error("writing the tokens to {path}")]
    Write {
        /// The file.
        path: PathBuf,
        /// The cause.
        #[source]
        source: io::Error,
    },
    /// Others may read or write it.
    #[error(
        "{path} has mode {mode:o}: others on this machine may read or change it; `chmod 600` it"
    )]
    NotPrivate {
        /// The file.
        path: PathBuf,
        /// Its permission bits.
        mode: u32,
    },
    /// It is no such file.
    #[error("{path} is no file of tokens: {problem}")]
    Format {
        /// The file.
        path: PathBuf,
        /// What does not fit.
        problem: String,
    },
    /// No secret could be made.
    #[error(transparent)]
    Random(#[from] RandomError),
}

impl Kept {
    pub(crate) fn state(&self, now: Timestamp) -> TokenState {
        if self.revoked_at.is_some() {
            TokenState::Revoked
        } else if now >= self.expires_at {
            TokenState::Expired
        } else {
            TokenState::Active
        }
    }

    pub(crate) fn info(&self, now: Timestamp) -> TokenInfo {
        TokenInfo {
            id: self.id.to_string(),
            name: self.name.clone(),
            role: self.role,
            scope: self.scope.clone(),
            state: self.state(now),
            created_at: self.created_at,
            created_by: self.created_by.clone(),
            expires_at: self.expires_at,
            revoked_at: self.revoked_at,
        }
    }
}

/// Reads the file; `None` where there is none.
pub(crate) fn load(path: &Path) -> Result<Option<Vec<Kept>>, StoreError> {
    let failed = |source| StoreError::Read {
        path: path.to_owned(),
        source,
    };
    let file = match File::open(path) {
        Ok(file) => file,
        Err(error) if error.kind() == io::ErrorKind::NotFound => return Ok(None),
        Err(error) => return Err(failed(error)),
    };
    // Of the opened file, so that it cannot be another one.
    check_private(path, &file.metadata().map_err(failed)?)?;
    let wrong = |problem: String| StoreError::Format {
        path: path.to_owned(),
        problem,
    };
    let mut text = String::new();
    let read = file.take(MAX_BYTES + 1).read_to_string(&mut text);
    if read.map_err(failed)? as u64 > MAX_BYTES {
        return Err(wrong(format!("it is larger than {MAX_BYTES} bytes")));
    }
    let contents: Contents =
        serde_json::from_str(&text).map_err(|error| wrong(error.to_string()))?;
    if contents.version != VERSION {
        return Err(wrong(format!(
            "its version is {}; this program knows {VERSION}",
            contents.version
        )));
    }
    for (index, token) in contents.tokens.iter().enumerate() {
        let earlier = contents.tokens.iter().take(index);
        if earlier.into_iter().any(|other| other.id == token.id) {
            return Err(wrong(format!("it has token {} twice", token.id)));
        }
        super::rules::check_name(&token.name)
            .map_err(|problem| wrong(format!("token {}: its name {problem}", token.id)))?;
    }
    Ok(Some(contents.tokens))
}

/// Replaces the file: whoever reads it sees the old one or the new one, after a power cut, too.
pub(crate) fn save(path: &Path, tokens: &[Kept]) -> Result<(), StoreError> {
    write(path, tokens).map_err(|source| StoreError::Write {
        path: path.to_owned(),
        source,
    })
}

fn write(path: &Path, tokens: &[Kept]) -> io::Result<()> {
    let contents = Contents {
        version: VERSION,
        tokens: tokens.to_vec(),
    };
    let mut text = serde_json::to_vec_pretty(&contents)?;
    text.push(b'\n');
    let folder = match path.parent() {
        Some(folder) if !folder.as_os_str().is_empty() => folder,
        Some(_) | None => Path::new("."),
    };
    let name = path.file_name().ok_or(io::ErrorKind::InvalidInput)?;
    let mut new_name = name.to_owned();
    new_name.push(format!(".new-{}", std::process::id()));
    let new = folder.join(new_name);
    let written = write_new(&new, &text).and_then(|()| fs::rename(&new, path));
    if written.is_err() {
        // What is left of it is of no use; that it cannot be removed either changes nothing.
        let _ = fs::remove_file(&new);
        return written;
    }
    // The name is durable only once its folder is.
    File::open(folder)?.sync_all()
}

fn write_new(path: &Path, text: &[u8]) -> io::Result<()> {
    // Of a process that had this number and was killed in the middle.
    match fs::remove_file(path) {
        Err(error) if error.kind() != io::ErrorKind::NotFound => return Err(error),
        Ok(()) | Err(_) => {}
    }
    let mut options = OpenOptions::new();
    let _options = options.write(true).create_new(true);
    private(&mut options);
    let mut file = options.open(path)?;
    file.write_all(text)?;
    file.sync_all()
}

#[cfg(unix)]
fn private(options: &mut OpenOptions) {
    use std::os::unix::fs::OpenOptionsExt as _;
    let _options = options.mode(0o600);
}

#[cfg(not(unix))]
fn private(_: &mut OpenOptions) {}

#[cfg(unix)]
fn check_private(path: &Path, metadata: &fs::Metadata) -> Result<(), StoreError> {
    use std::os::unix::fs::PermissionsExt as _;
    let mode = metadata.permissions().mode() & 0o777;
    // Nothing for the group, nothing for others.
    if mode.trailing_zeros() >= 6 {
        return Ok(());
    }
    Err(StoreError::NotPrivate {
        path: path.to_owned(),
        mode,
    })
}

#[cfg(not(unix))]
fn check_private(_: &Path, _: &fs::Metadata) -> Result<(), StoreError> {
    Ok(())
}

mod id_text {
    use serde::{Deserialize as _, Deserializer, Serializer, de::Error as _};

    use super::TokenId;

    pub(super) fn serialize<S: Serializer>(id: &TokenId, serializer: S) -> Result<S::Ok, S::Error> {
        serializer.serialize_str(id.as_str())
    }

    pub(super) fn deserialize<'de, D: Deserializer<'de>>(text: D) -> Result<TokenId, D::Error> {
        let text = String::deserialize(text)?;
        TokenId::parse(&text).ok_or_else(|| D::Error::custom("the id is not 16 digits of base 16"))
    }
}

mod hash_text {
    use serde::{Deserialize as _, Deserializer, Serializer, de::Error as _};

    use super::SecretHash;

    pub(super) fn serialize<S: Serializer>(
        hash: &SecretHash,
        serializer: S,
    ) -> Result<S::Ok, S::Error> {
        serializer.serialize_str(&hash.to_hex())
    }

    pub(super) fn deserialize<'de, D: Deserializer<'de>>(text: D) -> Result<SecretHash, D::Error> {
        let text = String::deserialize(text)?;
        SecretHash::parse(&text)
            .ok_or_else(|| D::Error::custom("the hash is not 64 digits of base 16"))
    }
}
