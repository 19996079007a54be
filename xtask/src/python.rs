//! A Python environment with the real fanucpy client, made once in `target/`.

use std::path::PathBuf;
use std::process::{Command, Output};

use anyhow::{Context as _, Result, bail};

use crate::command::root;

/// What is installed, pinned with its hash.
const REQUIREMENTS: &str = "karel-emulator/tests/python/requirements.txt";

/// Says where the environment's interpreter is, to the tests that drive fanucpy.
pub(crate) const VARIABLE: &str = "FANUCPY_PYTHON";

/// The interpreter of an environment that has fanucpy: the one that [`VARIABLE`] names, or one in `target/`, which is
/// made if it is not there.
///
/// # Errors
/// There is no Python, or the package cannot be installed.
pub(crate) fn with_fanucpy() -> Result<PathBuf> {
    if let Some(given) = std::env::var_os(VARIABLE) {
        return Ok(PathBuf::from(given));
    }
    let root = root().canonicalize().context("finding the workspace")?;
    let requirements = root.join(REQUIREMENTS);
    let wanted = std::fs::read(&requirements).context("reading the requirements")?;
    let target = std::env::var_os("CARGO_TARGET_DIR").map_or(root.join("target"), PathBuf::from);
    let folder = target.join("fanucpy");
    let python = folder.join("bin/python");
    let installed = folder.join("installed.txt");
    if python.is_file() && std::fs::read(&installed).is_ok_and(|done| done == wanted) {
        return Ok(python);
    }
    run(Command::new("python3")
        .args(["-m", "venv", "--clear"])
        .arg(&folder))
    .context("making a Python environment; Debian has it in the package python3-venv")?;
    // What the client's other modules need is large, and the client itself does without.
    run(Command::new(&python)
        .args([
            "-m",
            "pip",
            "install",
            "--quiet",
            "--no-deps",
            "--require-hashes",
            "--retries",
            "2",
            "--timeout",
            "20",
        ])
        .arg("--disable-pip-version-check")
        .arg("--requirement")
        .arg(&requirements))
    .context("installing fanucpy")?;
    std::fs::write(&installed, wanted).context("noting what is installed")?;
    Ok(python)
}

fn run(command: &mut Command) -> Result<()> {
    let name = command.get_program().to_owned();
    let starting = || format!("starting {}", name.display());
    let Output { status, stderr, .. } = command.output().with_context(starting)?;
    if !status.success() {
        bail!("{}", String::from_utf8_lossy(&stderr).trim());
    }
    Ok(())
}
