//! `cellctl override`.

use api::{ControlToken, SpeedOverride};
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
    /// Control that was taken with `cellctl control take`. Where absent it is taken for setting the override.
    #[arg(long, value_name = "TOKEN", env = "ROBOCELL_CONTROL")]
    control: Option<ControlToken>,
}

pub(crate) async fn run(args: OverrideArgs, context: &Context) -> Result<Report, Failure> {
    let robot = context.robot().await?;
    let found = match args.percent {
        Some(percent) => {
            let why = "the speed override, by cellctl";
            let (robot, held) = context.control_of(&robot, args.control, why).await?;
            let set = robot.set_speed_override(SpeedOverride { percent }).await;
            if let Some(held) = held {
                // It ends by itself soon, if it cannot be given back.
                let _given_back = held.release().await;
            }
            set?
        }
        None => robot.speed_override().await?,
    };
    Ok(context.report(Exit::Done, &found, |found| {
        format!("The speed override is {} %.", found.percent)
    }))
}
