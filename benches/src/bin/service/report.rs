//! Runs everything and prints the tables.

use std::path::Path;
use std::time::Duration;

use anyhow::{Context as _, Result};
use api::ControlToken;
use benches::control;
use benches::processes::{self, Part};
use tokio::task::spawn_blocking;

use crate::memory::{TARGET_ATTACKED_MIB, TARGET_MIB};
use crate::schedule::{self, Load, Measured};
use crate::served::CELL;
use crate::{descriptors, disk, echo, memory, motions, plant, probe, restart, state, stops};

const ECHO: usize = 0;
const DISK: usize = 1;

/// Measures and prints; files go into `directory`.
#[expect(clippy::print_stdout, reason = "this is a command-line tool's report")]
pub(crate) async fn run(
    directory: &Path,
    slice: Duration,
    repeats: usize,
    records: u64,
) -> Result<()> {
    let files = tempfile::tempdir_in(directory).context("a folder for the journals")?;
    let (robots, ports) = plant::start().await?;
    let ports: Vec<_> = ports.iter().map(ToString::to_string).collect();
    let journal = files.path().join("served.journal");
    let arguments = [
        "served".to_owned(),
        ports.join(","),
        journal.display().to_string(),
    ];
    let server = processes::start(&arguments).await?;
    let echo = processes::start(&["echo".to_owned()]).await?;
    let process = server.id()?;

    println!(
        "8 robots, of which one is mute and one cannot be reached. Milliseconds from the scheduled time to the whole answer;\n\
         {repeats} slices of {:.0} s each way, by turns.",
        slice.as_secs_f64()
    );
    let memory = blocking(&server, move |port| memory::measure(port, process)).await?;
    let held = control::hold(server.port, CELL).await?;
    let control = held.token();
    let (mut calm, mut attacked) = (Vec::new(), Vec::new());
    let mut made = 0;
    for _ in 0..repeats {
        let alone = load(&server, &echo, control, files.path(), slice).await?;
        add(&mut calm, alone);
        let arguments = [
            "attack".to_owned(),
            server.port.to_string(),
            control.to_string(),
        ];
        let attack = processes::start(&arguments).await?;
        let beside = load(&server, &echo, control, files.path(), slice).await?;
        add(&mut attacked, beside);
        made += attack.finish().await?.trim().parse::<u64>()?;
    }
    let _free = held.release().await?;
    latencies("nothing is wrong", &calm);
    latencies(
        "256 slow connections, both dead robots' queues full",
        &attacked,
    );
    println!("  the attackers had to open {made} connections for their 256");

    println!("\nmemory of the server, MiB");
    bound("  idle, 8 robots", memory.idle_mib, TARGET_MIB);
    let name = if memory.streams {
        "  with 64 streams of events"
    } else {
        "  with 64 idle connections (streams of events: not there yet)"
    };
    bound(name, memory.with_streams_mib, TARGET_MIB);
    let peak = probe::memory_mib(process, "VmHWM")?;
    bound(
        "  the most there was, attacks included",
        peak,
        TARGET_ATTACKED_MIB,
    );

    let (before, after) =
        blocking(&server, move |port| descriptors::measure(port, process)).await?;
    println!("\nfiles open before 10,000 connections: {before}, and after: {after}");
    drop((server, echo));

    let journal = files.path().join("restart.journal");
    let restart = restart::measure(&journal, &ports.join(","), records).await?;
    println!("\nseconds from the start of the process, with {records} records in the journal");
    bound(
        "  answering",
        restart.answering.as_secs_f64(),
        restart::READY_TARGET_S,
    );
    let name = format!(
        "  {} motions of the last process listed as doubts",
        restart.doubts
    );
    bound(&name, restart.listed.as_secs_f64(), restart::TARGET_S);
    drop(robots);
    Ok(())
}

async fn blocking<T: Send + 'static>(
    server: &Part,
    measure: impl FnOnce(u16) -> Result<T> + Send + 'static,
) -> Result<T> {
    let port = server.port;
    spawn_blocking(move || measure(port)).await?
}

async fn load(
    server: &Part,
    echo: &Part,
    control: ControlToken,
    directory: &Path,
    slice: Duration,
) -> Result<Vec<Measured>> {
    let (server, echo, directory) = (server.port, echo.port, directory.to_owned());
    spawn_blocking(move || {
        let mut loads: Vec<Load> = vec![
            echo::load(echo, state::RATE),
            disk::load(&directory, motions::RATE),
            state::load(server),
            motions::load(server, control),
        ];
        loads.extend(stops::load(server));
        schedule::run(&loads, slice)
    })
    .await?
}

fn add(all: &mut Vec<Measured>, more: Vec<Measured>) {
    if all.is_empty() {
        *all = more;
    } else {
        for (sum, part) in all.iter_mut().zip(more) {
            sum.add(part);
        }
    }
}

#[expect(clippy::print_stdout, reason = "this is a command-line tool's report")]
fn latencies(title: &str, all: &[Measured]) {
    println!("\n{title}");
    println!(
        "  {:<16} {:>8} {:>8} {:>8} {:>8}  {:>22}  {:>6} {:>8}",
        "", "asked", "p50", "p99", "max", "p99 over machine's", "failed", "reopened"
    );
    for measured in all {
        let Some(summary) = measured.latencies.summary() else {
            println!("  {:<16} nothing was answered", measured.name);
            continue;
        };
        // The limits themselves have no target.
        let limit = match measured.name {
            "GET state" => Some((ECHO, state::TARGET_MS)),
            "POST motion" => Some((DISK, motions::TARGET_MS)),
            "POST stop" => Some((ECHO, stops::TARGET_MS)),
            _ => None,
        };
        let compared = limit.and_then(|(limit, target)| {
            let machine = all.get(limit)?.latencies.summary()?;
            Some((summary.p99 / machine.p99, target))
        });
        let verdict = compared.map_or_else(String::new, |(ratio, target)| {
            let met = if summary.p99 <= target {
                "met"
            } else {
                "MISSED"
            };
            format!("{ratio:.1}x; {target:.0} ms {met}")
        });
        println!(
            "  {:<16} {:>8} {:>8.2} {:>8.2} {:>8.2}  {verdict:>22}  {:>6} {:>8}",
            measured.name,
            measured.latencies.count(),
            summary.p50,
            summary.p99,
            summary.max,
            measured.failed,
            measured.reopened,
        );
    }
    if !all.iter().any(|measured| measured.name == "POST stop") {
        println!("  POST stop        not there yet");
    }
}

#[expect(clippy::print_stdout, reason = "this is a command-line tool's report")]
fn bound(name: &str, value: f64, target: f64) {
    let met = if value <= target { "met" } else { "MISSED" };
    println!("{name:<62} {value:>7.2}  at most {target}: {met}");
}
