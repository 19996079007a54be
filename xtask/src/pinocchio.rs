//! Pinocchio's side of its benchmark: our own small C++ program, compiled against the headers of the package of the Python index.

use std::path::Path;
use std::process::Command;

use anyhow::{Context as _, Result, bail};

use crate::command::root;
use crate::python;

const SOURCE: &str = "benches/pinocchio/peer.cpp";

/// Boost's lists have to be as long as Pinocchio's list of joint types: what its own build sets.
const FLAGS: [&str; 9] = [
    "-std=c++17",
    "-O3",
    "-DNDEBUG",
    "-Wall",
    "-Wextra",
    "-DBOOST_MPL_LIMIT_LIST_SIZE=30",
    "-DBOOST_MPL_LIMIT_VECTOR_SIZE=30",
    "-DBOOST_MPL_CFG_NO_PREPROCESSED_HEADERS",
    "-DBOOST_FUSION_INVOKE_MAX_ARITY=12",
];

/// The arguments of the benchmark that name the peer's programs: for every x86-64, and with AVX2 and fused
/// multiplication.
///
/// # Errors
/// Says what is missing: another kind of machine, no compiler, no Python, no package.
pub(crate) fn peers() -> Result<Vec<String>> {
    if !cfg!(all(target_arch = "x86_64", target_os = "linux")) {
        bail!("Pinocchio's package is taken for Linux on x86-64 only");
    }
    let (folder, include) = python::with_pinocchio()?;
    let mut arguments = Vec::new();
    for (option, march) in [("--portable", "x86-64"), ("--avx2", "haswell")] {
        let program = folder.join(format!("peer-{march}"));
        compile(&include, march, &program)?;
        arguments.extend([option.to_owned(), program.display().to_string()]);
    }
    Ok(arguments)
}

/// Unless it is there already, of the same source, flags and compiler.
fn compile(include: &Path, march: &str, program: &Path) -> Result<()> {
    let compiler = std::env::var("CXX").unwrap_or_else(|_| "c++".to_owned());
    let version = python::run(Command::new(&compiler).arg("--version"))
        .context("a C++ compiler is needed: c++, or the one that CXX names")?;
    let source = root().join(SOURCE);
    let text = std::fs::read_to_string(&source).with_context(|| format!("reading {SOURCE}"))?;
    let made_of = [&version, march, &FLAGS.join(" "), &text].join("\n");
    let note = program.with_extension("made-of");
    if program.is_file() && std::fs::read_to_string(&note).is_ok_and(|done| done == made_of) {
        return Ok(());
    }
    eprintln!("compiling Pinocchio's side for {march}, a minute or so");
    let _ = python::run(
        Command::new(&compiler)
            .args(FLAGS)
            .arg(format!("-march={march}"))
            .arg("-isystem")
            .arg(include)
            .arg("-isystem")
            .arg(include.join("eigen3"))
            .arg(&source)
            .arg("-o")
            .arg(program),
    )
    .with_context(|| format!("compiling {SOURCE} for {march}"))?;
    std::fs::write(&note, made_of).context("noting what was compiled")
}
