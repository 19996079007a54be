//! A hundred controllers in one process, in real time, each asked for its state five times a second: once with moving
//! arms, once with the cell server's five programs, which is the most that this project runs on one.

use std::time::Duration;

use anyhow::{Context as _, Result};
use karel_emulator::{Clock, ControllerConfig, PeerLabels, ProgramSource, VirtualController};
use kinematics::ArmModel;
use tokio::time::{Instant, interval};

use crate::process::{processor_seconds, resident_kib};
use crate::virtual_time::SHUTTLE;

const CONTROLLERS: usize = 100;
/// Five times a second.
const TICK: Duration = Duration::from_millis(200);

pub(crate) fn run(seconds: u64) -> Result<()> {
    let runtime = tokio::runtime::Builder::new_multi_thread()
        .worker_threads(2)
        .enable_all()
        .build()
        .context("a runtime")?;
    let model = ArmModel::builtin("fanuc-m20ia").context("the arm is built in")?;
    let moving =
        ControllerConfig::new("arm", model).with_program(ProgramSource::new("shuttle.kl", SHUTTLE));
    runtime.block_on(measure("moving arms", &moving, seconds))?;
    let serving = ControllerConfig::cell_server("cell", model);
    runtime.block_on(measure("the cell server", &serving, seconds))
}

#[expect(clippy::print_stdout, reason = "this is a command-line tool's report")]
#[expect(
    clippy::cast_precision_loss,
    reason = "kilobytes and counts are far below 2^52"
)]
async fn measure(name: &str, config: &ControllerConfig, seconds: u64) -> Result<()> {
    let before_kib = resident_kib()?;
    let mut controllers = Vec::new();
    for _ in 0..CONTROLLERS {
        let started = VirtualController::start(config, Clock::real(), PeerLabels::new())?;
        controllers.push(started);
    }
    let begin = Instant::now();
    let used = processor_seconds()?;
    let mut ticks = interval(TICK);
    let mut latencies = Vec::new();
    while begin.elapsed() < Duration::from_secs(seconds) {
        let _tick = ticks.tick().await;
        for controller in &controllers {
            let asked = Instant::now();
            let _state = controller.state().await?;
            latencies.push(asked.elapsed());
        }
    }
    let share = 100.0 * (processor_seconds()? - used) / begin.elapsed().as_secs_f64();
    let each_mib = resident_kib()?.saturating_sub(before_kib) as f64 / 1024.0 / CONTROLLERS as f64;
    latencies.sort_unstable();
    let at = |permille: usize| {
        let index = (latencies.len() * permille / 1000).min(latencies.len().saturating_sub(1));
        latencies
            .get(index)
            .copied()
            .unwrap_or_default()
            .as_secs_f64()
            * 1e3
    };
    println!("| 100 controllers, {name}, 5 Hz: share of one processor | {share:.1} % | 200 % |");
    println!(
        "| the same: state, p50 / p99 / max, ms | {:.3} / {:.3} / {:.3} | |",
        at(500),
        at(990),
        at(1000)
    );
    println!("| the same: memory a controller | {each_mib:.2} MiB | 4 MiB |");
    for controller in controllers {
        controller.shutdown().await;
    }
    Ok(())
}
