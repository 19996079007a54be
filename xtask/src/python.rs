//! Python environments with packages of the Python index, each made once in `target/`: the real fanucpy client, and Pinocchio.

use std::path::PathBuf;
use std::process::Command;

use anyhow::{Context as _, Result, bail};

use crate::command::root;

/// What is installed, pinned with its hash.
const FANUCPY: &str = "karel-emulator/tests/python/requirements.txt";
const PINOCCHIO: &str = "benches/pinocchio/requirements.txt";

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
    // What the client's other modules need is large, and the client itself does without.
    environment("fanucpy", FANUCPY)
}

/// The folder of an environment that has the headers of Pinocchio and of what these need, and that folder's `include`.
///
/// # Errors
/// There is no Python, or the packages cannot be installed.
pub(crate) fn with_pinocchio() -> Result<(PathBuf, PathBuf)> {
    let python = environment("pinocchio", PINOCCHIO)?;
    let place = "import sysconfig; print(sysconfig.get_path('purelib'))";
    let packages = run(Command::new(&python).args(["-c", place]))
        .context("asking Python where its packages are")?;
    let include = PathBuf::from(packages.trim()).join("cmeel.prefix/include");
    let header = include.join("pinocchio/algorithm/jacobian.hpp");
    if !header.is_file() {
        bail!("{} is not where the package puts it", header.display());
    }
    Ok((folder("pinocchio")?, include))
}

/// The interpreter of the environment `name`, which is made if it is not there or not what `requirements` say now. The
/// packages are installed by themselves: what they need beyond has to be in the requirements.
fn environment(name: &str, requirements: &str) -> Result<PathBuf> {
    let requirements = root().join(requirements);
    let wanted = std::fs::read(&requirements).context("reading the requirements")?;
    let folder = folder(name)?;
    let python = folder.join("bin/python");
    let installed = folder.join("installed.txt");
    if python.is_file() && std::fs::read(&installed).is_ok_and(|done| done == wanted) {
        return Ok(python);
    }
    let _ = run(Command::new("python3")
        .args(["-m", "venv", "--clear"])
        .arg(&folder))
    .context("making a Python environment; Debian has it in the package python3-venv")?;
    let _ = run(Command::new(&python)
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
    .with_context(|| format!("installing {name}"))?;
    std::fs::write(&installed, wanted).context("noting what is installed")?;
    Ok(python)
}

fn folder(name: &str) -> Result<PathBuf> {
    let root = root().canonicalize().context("finding the workspace")?;
    let target = std::env::var_os("CARGO_TARGET_DIR").map_or(root.join("target"), PathBuf::from);
    Ok(target.join(name))
}

/// What it says on its standard output.
pub(crate) fn run(command: &mut Command) -> Result<String> {
    let name = command.get_program().to_owned();
    let starting = || format!("starting {}", name.display());
    let output = command.output().with_context(starting)?;
    if !output.status.success() {
        bail!("{}", String::from_utf8_lossy(&output.stderr).trim());
    }
    Ok(String::from_utf8_lossy(&output.stdout).into_owned())
}
