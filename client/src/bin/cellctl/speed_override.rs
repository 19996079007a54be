//! `cellctl override`.

use api::SpeedOverride;
use clap::Args;

use crate::context::Context;
use crate::failure::Failure;
use crate::report::{Exit, Report};

/// Show the controller's general speed override, or set it.
#[derive(Args, Debug)]
pub(crate) struct OverrideArgs {
    /// Percent of every programmed speed, 1 to 100; shown where absent.
    #[arg(value_name = "PERCENT", value_parser = clap::value_parser!(u8).range(1..=100))]
    percent: Option<u8>,
}

pub(crate) async fn run(args: OverrideArgs, context: &Context) -> Result<Report, Failure> {
    let robot = context.robot().await?;
    let found = match args.percent {
        Some(percent) => robot.set_speed_override(SpeedOverride { percent }).await?,
        None => robot.speed_override().await?,
    };
    Ok(context.report(Exit::Done, &found, |found| {
        format!("The speed override is {} %.", found.percent)
    }))
}
