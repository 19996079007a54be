//! The three public KAREL drivers, unmodified, on the virtual controller. Their sources are never part of this repository.

use anyhow::Result;

use crate::command::cargo_with;
use crate::python;

/// Runs the drivers of `sources`, each with its usual client.
pub(crate) fn run(sources: &str, more: &[String]) -> Result<()> {
    let python = python::with_fanucpy()?;
    let python = python.to_string_lossy();
    let arguments = [
        "run",
        "--quiet",
        "--package",
        "karel-emulator",
        "--example",
        "conformance",
        "--locked",
        "--",
        "--sources",
        sources,
    ];
    cargo_with(&arguments, more, &[(python::VARIABLE, &python)])
}
