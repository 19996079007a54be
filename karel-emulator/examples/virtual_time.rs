//! How many seconds of controller time pass in a second, idle and with a moving arm.
//!
//! `cargo run --release -p karel-emulator --example virtual_time`

use std::hint::black_box;
use std::time::{Duration, Instant};

use anyhow::Context;
use karel_emulator::{
    Clock, Controller, ControllerConfig, PeerLabels, ProgramSource, VirtualController,
};
use kinematics::ArmModel;

const SERVER: &str = include_str!("../../programs/sock_server.kl");

/// Moves to and fro for ever.
const SHUTTLE: &str = "PROGRAM shuttle
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

#[tokio::main(flavor = "current_thread")]
async fn main() -> anyhow::Result<()> {
    let idle = over_the_driver(SERVER, Duration::from_secs(1), 20_000).await?;
    eprintln!("idle, with its socket server, in steps of 1 s:       {idle:>12.0} s/s");
    let moving = over_the_driver(SHUTTLE, PERIOD, 100_000).await?;
    eprintln!("moving, through the driver, in steps of 8 ms:        {moving:>12.0} s/s");
    let core = in_the_core(SHUTTLE, 500_000)?;
    eprintln!("moving, core only, joints looked at every 8 ms:      {core:>12.0} s/s");
    Ok(())
}

fn config(program: &str) -> anyhow::Result<ControllerConfig> {
    let model = ArmModel::builtin("fanuc-m20ia").context("the arm is built in")?;
    Ok(ControllerConfig::new("bench", model)
        .with_program(ProgramSource::new("program.kl", program))
        .with_port(59_002, 0))
}

async fn over_the_driver(program: &str, step: Duration, steps: u32) -> anyhow::Result<f64> {
    let (clock, stepper) = Clock::stepped();
    let controller = VirtualController::start(&config(program)?, clock, PeerLabels::new())?;
    let begin = Instant::now();
    for _ in 0..steps {
        let _now = stepper.advance(step).await?;
    }
    let rate = (step * steps).as_secs_f64() / begin.elapsed().as_secs_f64();
    controller.shutdown().await;
    Ok(rate)
}

fn in_the_core(program: &str, steps: u32) -> anyhow::Result<f64> {
    let mut core = Controller::try_new(&config(program)?)?;
    let begin = Instant::now();
    for step in 1..=steps {
        core.advance_fully(PERIOD * step);
        let _joints = black_box(core.joints_deg());
    }
    Ok((PERIOD * steps).as_secs_f64() / begin.elapsed().as_secs_f64())
}
