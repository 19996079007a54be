//! Starting cargo, from the root of the workspace.

use std::path::{Path, PathBuf};
use std::process::Command;

use anyhow::{Context as _, Result, bail};

/// Runs cargo with `fixed` and then `more` arguments, with its output on the terminal.
///
/// # Errors
/// Where cargo cannot be started, or ends with a failure.
pub(crate) fn cargo(fixed: &[&str], more: &[String]) -> Result<()> {
    cargo_with(fixed, more, &[])
}

/// Like [`cargo`], with `environment` set for it.
pub(crate) fn cargo_with(
    fixed: &[&str],
    more: &[String],
    environment: &[(&str, &str)],
) -> Result<()> {
    let status = Command::new(env!("CARGO"))
        .args(fixed)
        .args(more)
        .envs(environment.iter().copied())
        .current_dir(root())
        .status()
        .with_context(|| format!("starting cargo {}", fixed.join(" ")))?;
    if !status.success() {
        bail!("cargo {} failed ({status})", fixed.join(" "));
    }
    Ok(())
}

/// The root of the workspace.
pub(crate) fn root() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("..")
}
