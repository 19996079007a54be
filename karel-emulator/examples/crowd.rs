//! A hundred controllers with moving arms in one process, in real time, each asked for its state five times a second.
//!
//! `cargo run --release -p karel-emulator --example crowd` prints the share of one processor and the memory.

use std::time::Duration;

use anyhow::Context;
use karel_emulator::{Clock, ControllerConfig, PeerLabels, ProgramSource, VirtualController};
use kinematics::ArmModel;
use tokio::time::{Instant, interval};

const CONTROLLERS: u32 = 100;
const ROUNDS: u32 = 25;

/// Moves to and fro for ever.
const SHUTTLE: &str = "PROGRAM shuttle
VAR a, b : XYZWPR
BEGIN
  a = CURPOS(0, 0)
  b = a
  b.z = b.z - 300
  $SPEED = 1000
  WHILE TRUE DO
    MOVE TO b
    MOVE TO a
  ENDWHILE
END shuttle
";

#[tokio::main]
async fn main() -> anyhow::Result<()> {
    let model = ArmModel::builtin("fanuc-m20ia").context("the arm is built in")?;
    let mut controllers = Vec::new();
    for number in 1..=CONTROLLERS {
        let config = ControllerConfig::new(format!("arm-{number}"), model)
            .with_program(ProgramSource::new("shuttle.kl", SHUTTLE));
        controllers.push(VirtualController::start(
            &config,
            Clock::real(),
            PeerLabels::new(),
        )?);
    }
    let begin = Instant::now();
    let before = processor_seconds()?;
    let mut ticks = interval(Duration::from_millis(200));
    let mut slowest = Duration::ZERO;
    for _ in 0..ROUNDS {
        let _tick = ticks.tick().await;
        for controller in &controllers {
            let asked = Instant::now();
            let _state = controller.state().await?;
            slowest = slowest.max(asked.elapsed());
        }
    }
    let share = (processor_seconds()? - before) / begin.elapsed().as_secs_f64();
    eprintln!(
        "{CONTROLLERS} controllers, 5 Hz: {:.1} % of one processor",
        100.0 * share
    );
    eprintln!(
        "slowest state: {slowest:?}; resident: {} KiB",
        resident_kib()?
    );
    Ok(())
}

/// User and system time of this process; the unit of the file is a hundredth of a second.
fn processor_seconds() -> anyhow::Result<f64> {
    let stat = std::fs::read_to_string("/proc/self/stat").context("reading /proc/self/stat")?;
    let fields = stat
        .rsplit(')')
        .next()
        .unwrap_or_default()
        .split_whitespace();
    let ticks = fields
        .skip(11)
        .take(2)
        .map(str::parse::<f64>)
        .sum::<Result<f64, _>>()?;
    Ok(ticks / 100.0)
}

fn resident_kib() -> anyhow::Result<u64> {
    let status = std::fs::read_to_string("/proc/self/status").context("reading the status")?;
    let line = status
        .lines()
        .find_map(|line| line.strip_prefix("VmRSS:"))
        .context("no VmRSS")?;
    line.split_whitespace()
        .next()
        .context("no number")?
        .parse()
        .context("no number")
}
