//! How many seconds of controller time pass in a second, idle and with a moving arm.

use std::hint::black_box;
use std::time::Duration;

use anyhow::{Context as _, Result};
use karel_emulator::{
    Clock, Controller, ControllerConfig, PeerLabels, ProgramSource, VirtualController,
};
use kinematics::ArmModel;

use crate::median;
use crate::process::thread_time;

/// Measures a factor.
type Measure<'a> = Box<dyn Fn() -> Result<f64> + 'a>;

const SERVER: &str = include_str!("../../../programs/sock_server.kl");

/// Moves to and fro for ever.
pub(crate) const SHUTTLE: &str = "PROGRAM shuttle
VAR a, b : XYZWPR
BEGIN
  a = CURPOS(0, 0)
  b = a
  b.z = b.z - 300
  $SPEED = 300
  WHILE TRUE DO
    MOVE TO b
    MOVE TO a
  ENDWHILE
END shuttle
";

/// The interpolation period at which the moving arm is looked at.
const PERIOD: Duration = Duration::from_millis(8);

pub(crate) fn config(program: &str) -> Result<ControllerConfig> {
    let model = ArmModel::builtin("fanuc-m20ia").context("the arm is built in")?;
    Ok(ControllerConfig::new("bench", model)
        .with_program(ProgramSource::new("program.kl", program))
        .with_port(59_002, 0))
}

#[expect(clippy::print_stdout, reason = "this is a command-line tool's report")]
pub(crate) fn run(repeats: usize) -> Result<()> {
    let runtime = tokio::runtime::Builder::new_current_thread()
        .enable_all()
        .build()
        .context("a runtime")?;
    let rows: [(&str, Measure<'_>, &str); 3] = [
        (
            "idle, with its socket server and the driver",
            Box::new(|| runtime.block_on(over_the_driver(SERVER, Duration::from_secs(1), 10_000))),
            "1,000",
        ),
        (
            "a moving arm, through the driver, read every 8 ms",
            Box::new(|| runtime.block_on(over_the_driver(SHUTTLE, PERIOD, 40_000))),
            "200",
        ),
        (
            "a moving arm, the core alone, joints read every 8 ms",
            Box::new(|| in_the_core(200_000)),
            "",
        ),
    ];
    for (name, measure, target) in rows {
        let rates: Result<Vec<f64>> = (0..repeats).map(|_| measure()).collect();
        println!(
            "| {name}, simulated seconds a second | {:.0} | {target} |",
            median(rates?)
        );
    }
    Ok(())
}

async fn over_the_driver(program: &str, step: Duration, steps: u32) -> Result<f64> {
    let (clock, stepper) = Clock::stepped();
    let controller = VirtualController::start(&config(program)?, clock, PeerLabels::new())?;
    let begin = thread_time();
    for _ in 0..steps {
        let _now = stepper.advance(step).await?;
    }
    let rate = (step * steps).as_secs_f64() / thread_time().saturating_sub(begin).as_secs_f64();
    controller.shutdown().await;
    Ok(rate)
}

fn in_the_core(steps: u32) -> Result<f64> {
    let mut core = Controller::try_new(&config(SHUTTLE)?)?;
    let begin = thread_time();
    for step in 1..=steps {
        core.advance_fully(PERIOD * step);
        let _joints = black_box(core.joints_deg());
    }
    Ok((PERIOD * steps).as_secs_f64() / thread_time().saturating_sub(begin).as_secs_f64())
}
