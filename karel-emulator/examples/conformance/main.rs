//! Runs the three public KAREL drivers, unmodified, drives each with its usual client, and says what was seen.
//!
//! `cargo xtask conformance --sources DIR` calls it. `DIR` has a checkout of each driver; nothing of theirs is part of
//! this repository.

mod checks;

use std::path::{Path, PathBuf};
use std::process::ExitCode;

use anyhow::{Context as _, Result, anyhow, bail};
use clap::Parser;

use checks::mappdk::{Programs, with_called};
use checks::rig::Files;
use checks::table::Table;
use checks::{mappdk, ros, seed};

/// Run the three public KAREL drivers, unmodified, and check what their clients see.
#[derive(Debug, Parser)]
struct Arguments {
    /// Folder with checkouts of `fanuc-control`, `fanucpy` and `fanuc` (ROS-Industrial), at any depth up to three.
    #[arg(long, value_name = "DIR")]
    sources: PathBuf,
    /// A Python interpreter that has fanucpy 0.1.14.
    #[arg(long, value_name = "FILE", env = "FANUCPY_PYTHON")]
    python: Option<PathBuf>,
    /// Only these: t1, t2, t3.
    #[arg(long, value_delimiter = ',', value_name = "DRIVER")]
    only: Vec<String>,
}

#[tokio::main(flavor = "current_thread")]
async fn main() -> Result<ExitCode> {
    let arguments = Arguments::parse();
    for name in &arguments.only {
        if !["t1", "t2", "t3"].contains(&name.to_ascii_lowercase().as_str()) {
            bail!("there is no driver {name:?}; there are t1, t2, t3");
        }
    }
    let wanted = |name: &str| {
        arguments.only.is_empty()
            || arguments
                .only
                .iter()
                .any(|only| only.eq_ignore_ascii_case(name))
    };
    let mut failed = 0;
    if wanted("t1") {
        failed += report("T1  fanuc-control", t1(&arguments).await);
    }
    if wanted("t2") {
        failed += report(
            "T2  fanucpy, driven by the real client",
            t2(&arguments).await,
        );
    }
    if wanted("t3") {
        failed += report("T3  ROS-Industrial, simple_message", t3(&arguments).await);
    }
    if failed == 0 {
        say("Everything is as expected.");
        return Ok(ExitCode::SUCCESS);
    }
    say(&format!("{failed} observations differ."));
    Ok(ExitCode::FAILURE)
}

async fn t1(arguments: &Arguments) -> Result<Table> {
    let folder = folder_of(&arguments.sources, "servers/sock_server.kl")?;
    seed::observe(&Files::read(&folder, &["sock_server.kl"])?).await
}

async fn t2(arguments: &Arguments) -> Result<Table> {
    let python = arguments.python.as_ref();
    let python = python.context("--python is missing: fanucpy's client is a Python package")?;
    let folder = folder_of(&arguments.sources, "fanuc-driver/mappdk_server.kl")?;
    let programs = [
        "mappdk.ls",
        "mappdk_server.kl",
        "mappdk_logger.kl",
        "mappdk_move.ls",
        "mappdk_movel.ls",
    ];
    let files = with_called(Files::read(&folder, &programs)?);
    mappdk::observe(&files, Programs::Theirs, python).await
}

async fn t3(arguments: &Arguments) -> Result<Table> {
    let folder = folder_of(&arguments.sources, "karel/ros_relay.kl")?;
    let listings = folder_of(&arguments.sources, "tpe/ros_movesm.ls")?;
    let programs = [
        "libssock.kl",
        "libind_hdr.kl",
        "libind_log.kl",
        "libind_mth.kl",
        "libind_pkt.kl",
        "libind_rs.kl",
        "ros_relay.kl",
        "ros_state.kl",
    ];
    let listed = ["ros.ls", "ros_movesm.ls", "rosrelay.ls", "rosstate.ls"];
    let files = Files::read(&folder, &programs)?.and(Files::read(&listings, &listed)?);
    ros::observe(&files).await
}

/// The folder of a file that is known by the end of its path.
fn folder_of(sources: &Path, end: &str) -> Result<PathBuf> {
    let found = find(sources, Path::new(end), 6);
    let path = found.ok_or_else(|| anyhow!("there is no {end} in {}", sources.display()))?;
    let folder = path.parent().context("a file has a folder")?;
    Ok(folder.to_owned())
}

fn find(folder: &Path, end: &Path, depth: usize) -> Option<PathBuf> {
    let path = folder.join(end);
    if path.is_file() {
        return Some(path);
    }
    if depth == 0 {
        return None;
    }
    let mut folders: Vec<PathBuf> = std::fs::read_dir(folder)
        .ok()?
        .flatten()
        .filter(|entry| entry.file_type().is_ok_and(|kind| kind.is_dir()))
        .map(|entry| entry.path())
        .collect();
    folders.sort();
    folders.iter().find_map(|inner| find(inner, end, depth - 1))
}

/// Prints a driver's table; how much of it differs. A driver that could not be tried differs, too.
fn report(title: &str, table: Result<Table>) -> usize {
    say(&format!("\n{title}"));
    match table {
        Ok(table) => {
            say(&table.to_string());
            table.failed().count()
        }
        Err(error) => {
            say(&format!("could not be tried: {error:#}"));
            1
        }
    }
}

#[expect(clippy::print_stdout, reason = "this is a command's report")]
fn say(text: &str) {
    println!("{text}");
}
