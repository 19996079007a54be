//! The tokens `cellctl login` keeps: one a server, in a file that is its owner's alone.

use std::collections::BTreeMap;
use std::fs::{self, File, OpenOptions};
use std::io::{self, Read as _, Write as _};
use std::path::{Path, PathBuf};

use api::TokenSecret;
use serde::{Deserialize, Serialize};

use crate::failure::Failure;

/// The most bytes of a file with tokens.
const MAX_BYTES: u64 = 1 << 20;

/// What is kept.
#[derive(Debug, Default, Deserialize, Serialize)]
#[serde(deny_unknown_fields)]
struct Contents {
    /// By the server's address, as it was given.
    servers: BTreeMap<String, Kept>,
}

#[derive(Debug, Deserialize, Serialize)]
#[serde(deny_unknown_fields)]
struct Kept {
    /// Who the server took the token's holder for.
    name: String,
    token: TokenSecret,
}

/// The token to use with a server: of the file named, of `ROBOCELL_TOKEN`, or kept by a login, in this order.
pub(crate) fn token_for(server: &str, file: Option<&Path>) -> Result<Option<TokenSecret>, Failure> {
    if let Some(file) = file {
        return read_token(file).map(Some);
    }
    // Not an option of the command line: that is for everybody on the machine to read.
    match std::env::var("ROBOCELL_TOKEN") {
        Ok(token) if !token.trim().is_empty() => {
            return Ok(Some(TokenSecret::new(token.trim().to_owned())));
        }
        Ok(_) | Err(std::env::VarError::NotPresent) => {}
        Err(std::env::VarError::NotUnicode(_)) => {
            return Err(Failure::Usage("ROBOCELL_TOKEN is no token".to_owned()));
        }
    }
    let Some(path) = path() else {
        return Ok(None);
    };
    let mut contents = load(&path)?;
    let kept = contents.servers.remove(key(server));
    Ok(kept.map(|kept| kept.token))
}

/// Reads a token from a file.
pub(crate) fn read_token(path: &Path) -> Result<TokenSecret, Failure> {
    let text = read_private(path).map_err(|error| unusable(path, &error))?;
    Ok(TokenSecret::new(text.trim().to_owned()))
}

/// Keeps a token; answers where.
pub(crate) fn keep(server: &str, name: &str, token: TokenSecret) -> Result<PathBuf, Failure> {
    let path = path().ok_or_else(|| {
        Failure::Usage(
            "there is no place for it: neither XDG_CONFIG_HOME nor HOME is set".to_owned(),
        )
    })?;
    let mut contents = load(&path)?;
    let kept = Kept {
        name: name.to_owned(),
        token,
    };
    let _old = contents.servers.insert(key(server).to_owned(), kept);
    save(&path, &contents).map_err(|error| unusable(&path, &error))?;
    Ok(path)
}

/// Forgets the token of a server; answers whose it was.
pub(crate) fn forget(server: &str) -> Result<Option<String>, Failure> {
    let Some(path) = path() else {
        return Ok(None);
    };
    let mut contents = load(&path)?;
    let Some(kept) = contents.servers.remove(key(server)) else {
        return Ok(None);
    };
    save(&path, &contents).map_err(|error| unusable(&path, &error))?;
    Ok(Some(kept.name))
}

fn key(server: &str) -> &str {
    server.trim_end_matches('/')
}

fn path() -> Option<PathBuf> {
    let folder = |name: &str| {
        let folder = std::env::var_os(name).filter(|folder| !folder.is_empty());
        folder.map(PathBuf::from)
    };
    let config = folder("XDG_CONFIG_HOME").or_else(|| Some(folder("HOME")?.join(".config")))?;
    Some(config.join("robocell").join("credentials.json"))
}

fn load(path: &Path) -> Result<Contents, Failure> {
    let text = match read_private(path) {
        Ok(text) => text,
        Err(error) if error.kind() == io::ErrorKind::NotFound => return Ok(Contents::default()),
        Err(error) => return Err(unusable(path, &error)),
    };
    serde_json::from_str(&text).map_err(|error| unusable(path, &error))
}

fn read_private(path: &Path) -> io::Result<String> {
    let file = File::open(path)?;
    check_private(&file.metadata()?)?;
    let mut text = String::new();
    let length = file.take(MAX_BYTES + 1).read_to_string(&mut text)?;
    if length as u64 > MAX_BYTES {
        return Err(io::Error::other("it is far too large"));
    }
    Ok(text)
}

fn save(path: &Path, contents: &Contents) -> io::Result<()> {
    let folder = path.parent().ok_or(io::ErrorKind::InvalidInput)?;
    fs::create_dir_all(folder)?;
    let new = path.with_extension(format!("new-{}", std::process::id()));
    let mut options = OpenOptions::new();
    let _options = options.write(true).create_new(true);
    private(&mut options);
    let written = options.open(&new).and_then(|mut file| {
        file.write_all(&serde_json::to_vec_pretty(contents)?)?;
        file.sync_all()
    });
    let saved = written.and_then(|()| fs::rename(&new, path));
    if saved.is_err() {
        // What is left of it is of no use.
        let _ = fs::remove_file(&new);
    }
    saved
}

#[cfg(unix)]
fn private(options: &mut OpenOptions) {
    use std::os::unix::fs::OpenOptionsExt as _;
    let _options = options.mode(0o600);
}

#[cfg(not(unix))]
fn private(_: &mut OpenOptions) {}

#[cfg(unix)]
fn check_private(metadata: &fs::Metadata) -> io::Result<()> {
    use std::os::unix::fs::PermissionsExt as _;
    let mode = metadata.permissions().mode() & 0o777;
    // What is no file, as a pipe of the shell, is nobody else's to read.
    if !metadata.is_file() || mode.trailing_zeros() >= 6 {
        return Ok(());
    }
    Err(io::Error::other(format!(
        "its mode is {mode:o}: others on this machine may read or change it; `chmod 600` it"
    )))
}

#[cfg(not(unix))]
fn check_private(_: &fs::Metadata) -> io::Result<()> {
    Ok(())
}

fn unusable(path: &Path, why: &dyn std::fmt::Display) -> Failure {
    Failure::Usage(format!("the tokens in {}: {why}", path.display()))
}
