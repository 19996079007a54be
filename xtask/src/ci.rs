//! What a change has to pass. The same steps run at the desk and in CI.

use std::path::Path;
use std::process::Command;
use std::time::Instant;

use anyhow::{Result, bail};

use crate::command::{cargo, cargo_with};
use crate::python;

/// A step: what it is called, and what it does.
type Step = (&'static str, fn() -> Result<()>);

const STEPS: &[Step] = &[
    ("format", || cargo(&["fmt", "--all", "--check"], &[])),
    ("lints", lints),
    ("documentation", documentation),
    ("dependencies", dependencies),
    ("tests", || {
        // Here nothing is left out, and random tests draw the same inputs for the same commit.
        let python = python::with_fanucpy()?;
        test_with(&[], &python, &[("PROPTEST_RNG_SEED", "1")])
    }),
    ("fuzzing", crate::fuzz::ci),
];

/// Every step, in order; stops at the first that fails.
#[expect(clippy::print_stdout, reason = "this is a command-line tool's report")]
pub(crate) fn all() -> Result<()> {
    for (name, step) in STEPS {
        println!("== {name}");
        let start = Instant::now();
        step()?;
        println!(
            "== {name}: passed in {:.0} s",
            start.elapsed().as_secs_f64()
        );
    }
    Ok(())
}

/// Every test of the workspace, the examples in the documentation among them. Without Python, or without a network to
/// fetch fanucpy from the first time, those that drive it are skipped.
#[expect(clippy::print_stdout, reason = "this is a command-line tool's report")]
pub(crate) fn test(args: &[String]) -> Result<()> {
    match python::with_fanucpy() {
        Ok(python) => test_with(args, &python, &[]),
        Err(error) => {
            println!("The tests with the real fanucpy client are skipped: {error:#}");
            cargo(&["test", "--workspace", "--locked"], args)
        }
    }
}

fn test_with(args: &[String], python: &Path, environment: &[(&str, &str)]) -> Result<()> {
    let python = python.to_string_lossy();
    let mut environment = environment.to_vec();
    environment.push((python::VARIABLE, python.as_ref()));
    cargo_with(&["test", "--workspace", "--locked"], args, &environment)
}

fn lints() -> Result<()> {
    cargo(
        &[
            "clippy",
            "--workspace",
            "--all-targets",
            "--locked",
            "--",
            "-D",
            "warnings",
        ],
        &[],
    )
}

fn documentation() -> Result<()> {
    let arguments = [
        "doc",
        "--workspace",
        "--no-deps",
        "--document-private-items",
        "--locked",
    ];
    cargo_with(&arguments, &[], &[("RUSTDOCFLAGS", "-D warnings")])
}

/// Licences, sources and doubled crates. Advisories need a database from the network, so they are not part of this.
fn dependencies() -> Result<()> {
    let installed = Command::new(env!("CARGO"))
        .args(["deny", "--version"])
        .output();
    if !installed.is_ok_and(|output| output.status.success()) {
        bail!("cargo-deny is missing: install it with `cargo install cargo-deny --locked`");
    }
    cargo(&["deny", "check", "bans", "licenses", "sources"], &[])
}
