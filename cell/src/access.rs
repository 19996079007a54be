//! Who may call this server: the tokens of the configuration, or everybody in a demo.

use std::path::Path;

use anyhow::{Context as _, Result, bail};
use api::NewToken;
use jiff::Timestamp;
use server::identity::Identity;

use crate::config::{File, Loaded};

const NEITHER: &str = "\
identity: is absent, so nobody would be asked who they are. Either add

    [identity]
    path = \"tokens.json\"

to the configuration: the first start makes an admin token and shows it once. Or start with --demo: everybody on this \
machine may do everything then";

/// Who callers are, and the admin token that was made on the way.
#[derive(Debug)]
pub(crate) struct Access {
    pub(crate) identity: Identity,
    pub(crate) first: Option<NewToken>,
}

/// Checks what can be checked without making anything.
///
/// # Errors
/// The configuration says neither who may call nor that it is a demo, or both; or its file of tokens is of no use.
pub(crate) fn check(loaded: &Loaded) -> Result<()> {
    match (&loaded.file.identity, loaded.file.server.demo) {
        (None, false) => bail!(NEITHER),
        (None, true) => Ok(()),
        (Some(_), true) => bail!(
            "identity: a demo asks nobody for a token, so --demo (or server.demo) and an [identity] section exclude one another"
        ),
        (Some(section), false) => {
            Identity::check(&loaded.folder.join(&section.path)).context("identity.path")
        }
    }
}

/// Opens the tokens.
///
/// # Errors
/// As [`check`], and where the file cannot be written.
pub(crate) fn open(file: &File, folder: &Path, new_admin_token: bool) -> Result<Access> {
    let Some(section) = &file.identity else {
        return Ok(Access {
            identity: Identity::demo(),
            first: None,
        });
    };
    let path = folder.join(&section.path);
    let now = Timestamp::now();
    let opened = if new_admin_token {
        Identity::open_with_new_admin(path, now)
    } else {
        Identity::open(path, now)
    };
    let (identity, first) = opened.context("identity.path")?;
    Ok(Access { identity, first })
}
