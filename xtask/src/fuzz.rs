//! `cargo xtask fuzz`: every fuzz target under libFuzzer for a while, on the stable compiler of this workspace.
//!
//! libFuzzer is guided by coverage. The nightly switch for that (`-Z sanitizer`) is not needed: LLVM's pass is asked for
//! by name, as `cargo fuzz --sanitizer none` does. What was learned is kept in `target/fuzz/corpus`; an input that finds
//! something is saved in `target/fuzz/findings`, printed, and ends the run with an error. Once it is mended, the input
//! belongs into `fuzz/findings/TARGET`, where the tests of the package run it for ever.

use std::collections::VecDeque;
use std::fmt::Write as _;
use std::fs;
use std::path::{Path, PathBuf};
use std::process::{Child, Command, Stdio};
use std::time::Duration;

use anyhow::{Context as _, Result, bail};
use clap::Args;

use crate::command::{cargo_with, root};

/// Targets that run at a time.
const AT_A_TIME: usize = 2;
/// Longest an input may take. The machine may be busy.
const TIMEOUT_S: u32 = 20;
/// Most memory that a target may use.
const MEMORY_MIB: u32 = 2_048;
/// Lines of a report that are shown when something was found.
const LINES: usize = 60;

/// LLVM's coverage pass, with what libFuzzer understands of it.
const RUSTFLAGS: &str = "-Cpasses=sancov-module -Cllvm-args=-sanitizer-coverage-level=4 \
    -Cllvm-args=-sanitizer-coverage-inline-8bit-counters -Cllvm-args=-sanitizer-coverage-pc-table \
    -Cllvm-args=-sanitizer-coverage-trace-compares --cfg fuzzing";

/// What `cargo xtask fuzz` takes.
#[derive(Debug, Args)]
pub(crate) struct Options {
    /// How long each target runs.
    #[arg(long, default_value_t = 60)]
    seconds: u64,
    /// The seed of the random numbers, another one each time where absent.
    #[arg(long)]
    seed: Option<u32>,
    /// Only these targets.
    #[arg(value_name = "TARGET")]
    targets: Vec<String>,
}

/// What CI runs: every target for its minute, with one seed, so that the same commit draws the same inputs again.
pub(crate) fn ci() -> Result<()> {
    run(&Options {
        seconds: 60,
        seed: Some(1),
        targets: Vec::new(),
    })
}

/// Builds the targets, and runs them two at a time.
pub(crate) fn run(options: &Options) -> Result<()> {
    let host = host()?;
    let build = [
        "build",
        "--locked",
        "--package",
        "fuzz",
        "--bin",
        "fuzz",
        "--profile",
        "fuzz",
        "--target",
        &host,
    ];
    cargo_with(&build, &[], &[("RUSTFLAGS", RUSTFLAGS)])?;
    let target = target_folder();
    let built = target.join(&host).join("fuzz");
    let mut waiting = wanted(&built, &options.targets)?;
    let mut running: Vec<Run> = Vec::new();
    let mut found = Vec::new();
    while !waiting.is_empty() || !running.is_empty() {
        while running.len() < AT_A_TIME
            && let Some(name) = waiting.pop_front()
        {
            running.push(Run::start(&built, &target, name, options)?);
        }
        // Whoever ends first is asked first; a fifth of a second more or less does not matter.
        let mut still = Vec::new();
        for mut run in running {
            match run.child.try_wait().context("waiting for a target")? {
                None => still.push(run),
                Some(status) => {
                    run.report(status.success())?;
                    if !status.success() {
                        found.push(run.name);
                    }
                }
            }
        }
        running = still;
        std::thread::park_timeout(Duration::from_millis(200));
    }
    if !found.is_empty() {
        bail!("something was found: {}", found.join(", "));
    }
    Ok(())
}

/// A target that runs.
struct Run {
    name: String,
    child: Child,
    log: PathBuf,
    findings: PathBuf,
}

impl Run {
    fn start(built: &Path, target: &Path, name: String, options: &Options) -> Result<Self> {
        let folder = target.join("fuzz");
        let (corpus, findings) = (folder.join("corpus"), folder.join("findings"));
        let (corpus, findings) = (corpus.join(&name), findings.join(&name));
        for folder in [&corpus, &findings] {
            fs::create_dir_all(folder).with_context(|| format!("making {}", folder.display()))?;
        }
        let log = folder.join(format!("{name}.log"));
        let output =
            fs::File::create(&log).with_context(|| format!("opening {}", log.display()))?;
        let also = output.try_clone().context("a second handle of the log")?;
        let mut command = Command::new(built.join("fuzz"));
        let _command = command
            .env("FUZZ_TARGET", &name)
            .env("RUST_BACKTRACE", "1")
            .current_dir(root())
            .arg(&corpus)
            .arg(format!("-max_total_time={}", options.seconds))
            .arg(format!("-timeout={TIMEOUT_S}"))
            .arg(format!("-rss_limit_mb={MEMORY_MIB}"))
            .arg(format!("-artifact_prefix={}/", findings.display()))
            .arg("-print_final_stats=1")
            .stdout(Stdio::from(output))
            .stderr(Stdio::from(also));
        if let Some(seed) = options.seed {
            let _command = command.arg(format!("-seed={seed}"));
        }
        for flag in flags(built, &name)? {
            let _command = command.arg(flag);
        }
        let child = command
            .spawn()
            .with_context(|| format!("starting {name}"))?;
        Ok(Self {
            name,
            child,
            log,
            findings,
        })
    }

    /// Says how it went; shows the input and the end of the log if something was found.
    #[expect(clippy::print_stdout, reason = "this is a command-line tool's report")]
    fn report(&self, passed: bool) -> Result<()> {
        let log = fs::read(&self.log).with_context(|| format!("reading {}", self.log.display()))?;
        let log = String::from_utf8_lossy(&log);
        if passed {
            println!("{}: nothing found, {}", self.name, figures(&log));
            return Ok(());
        }
        let lines: Vec<&str> = log.lines().collect();
        let shown = lines.len().saturating_sub(LINES);
        for line in lines.iter().skip(shown) {
            println!("{line}");
        }
        for input in inputs(&log, &self.findings) {
            let bytes = fs::read(&input).unwrap_or_default();
            println!("{}: {}", input.display(), bytes.escape_ascii());
        }
        println!(
            "{}: FOUND SOMETHING. Once more: cargo xtask fuzz --seconds 10 {}",
            self.name, self.name
        );
        Ok(())
    }
}

/// How many inputs were tried, and how many reach something of their own.
fn figures(log: &str) -> String {
    let figure = |name: &str| {
        let line = log.lines().find_map(|line| line.strip_prefix(name));
        line.map_or("?", str::trim).to_owned()
    };
    let inputs = figure("stat::number_of_executed_units:");
    let new = figure("stat::new_units_added:");
    let covered = log.lines().rev().find_map(|line| {
        let (_, behind) = line.split_once(" cov: ")?;
        behind.split_whitespace().next()
    });
    let covered = covered.unwrap_or("?");
    format!("{inputs} inputs, {new} of them new, {covered} branches")
}

/// The inputs that the log says were saved.
fn inputs(log: &str, findings: &Path) -> Vec<PathBuf> {
    let mut saved = Vec::new();
    for line in log.lines() {
        if let Some((_, path)) = line.split_once("Test unit written to ") {
            saved.push(findings.join(Path::new(path.trim()).file_name().unwrap_or_default()));
        }
    }
    saved
}

/// The names of the targets that shall run, all of them if none is named.
fn wanted(built: &Path, only: &[String]) -> Result<VecDeque<String>> {
    let all = describe(built, "")?;
    let all: VecDeque<String> = all.lines().map(str::to_owned).collect();
    if all.is_empty() {
        bail!("the fuzz package has no targets");
    }
    for name in only {
        if !all.contains(name) {
            let mut known = String::new();
            for name in &all {
                write!(known, " {name}")?;
            }
            bail!("there is no target {name}; there are{known}");
        }
    }
    if only.is_empty() {
        return Ok(all);
    }
    Ok(only.iter().cloned().collect())
}

/// Flags of libFuzzer for one target: where its seeds are, and how long inputs may be.
fn flags(built: &Path, name: &str) -> Result<Vec<String>> {
    let text = describe(built, name)?;
    Ok(text.lines().map(str::to_owned).collect())
}

/// What the fuzz program says when it is asked for its targets, or for the seeds of one.
fn describe(built: &Path, target: &str) -> Result<String> {
    let mut command = Command::new(built.join("fuzz"));
    if !target.is_empty() {
        let seeds = target_folder().join("fuzz").join("seeds");
        let _command = command.env("FUZZ_TARGET", target).env("FUZZ_SEEDS", seeds);
    }
    let output = command
        .current_dir(root())
        .output()
        .context("starting the fuzz program")?;
    let text = String::from_utf8(output.stdout).context("it writes text")?;
    if !output.status.success() {
        bail!("the fuzz program: {text}");
    }
    Ok(text)
}

fn target_folder() -> PathBuf {
    std::env::var_os("CARGO_TARGET_DIR").map_or_else(|| root().join("target"), PathBuf::from)
}

/// The triple of this machine: with it, build scripts and macros are built without the flags.
fn host() -> Result<String> {
    let output = Command::new("rustc")
        .arg("-vV")
        .current_dir(root())
        .output()
        .context("asking rustc for its host")?;
    let text = String::from_utf8(output.stdout).context("rustc writes text")?;
    text.lines()
        .find_map(|line| line.strip_prefix("host: "))
        .map(str::to_owned)
        .context("rustc does not say its host")
}

#[cfg(test)]
mod tests {
    use super::*;

    const LOG: &str = "#2\tINITED cov: 11 ft: 12 corp: 1/1b\n#9\tNEW    cov: 40 ft: 44 corp: 2/3b\n\
        artifact_prefix='x/'; Test unit written to x/crash-12ab\n\
        stat::number_of_executed_units: 9\nstat::new_units_added:          3\n";

    #[test]
    fn the_report_of_libfuzzer_is_read() {
        assert_eq!(figures(LOG), "9 inputs, 3 of them new, 40 branches");
        assert_eq!(figures(""), "? inputs, ? of them new, ? branches");
        assert_eq!(
            inputs(LOG, Path::new("here")),
            [PathBuf::from("here/crash-12ab")]
        );
    }
}
