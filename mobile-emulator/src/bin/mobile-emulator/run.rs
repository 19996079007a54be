//! `mobile-emulator run`: a robot until it is interrupted.

use std::io::IsTerminal;
use std::net::SocketAddr;
use std::path::PathBuf;
use std::process::ExitCode;

use anyhow::{Context as _, anyhow};
use mobile_emulator::config::ViewSection;
use mobile_emulator::{CellAddress, Clock, MobileRobot};
use tokio::signal::unix::{SignalKind, signal};

use crate::file::load;

/// Run a virtual mobile robot.
///
/// It drives when its cell says so, and runs until it is interrupted. Its page shows where it is.
#[derive(Debug, clap::Args)]
pub(crate) struct Run {
    /// What the robot is made of.
    #[arg(long, value_name = "FILE")]
    config: PathBuf,
    /// The server, e.g. `http://127.0.0.1:8080`.
    #[arg(long, value_name = "URL", env = "MOBILE_EMULATOR_CELL")]
    cell: String,
    /// The cell's id on that server.
    #[arg(long, value_name = "ID", default_value = "demo")]
    cell_id: String,
    /// Address of the robot's page, or `off`; as in the file where not given.
    #[arg(long, value_name = "ADDRESS|off")]
    view: Option<String>,
    /// Robot seconds in a second, up to 1000.
    #[arg(long, default_value_t = 1.0, value_name = "N")]
    time_scale: f64,
    /// What to log on standard error, such as `info` or `mobile_emulator=debug`.
    #[arg(
        long,
        default_value = "info",
        env = "MOBILE_EMULATOR_LOG",
        value_name = "FILTER"
    )]
    log: String,
}

impl Run {
    pub(crate) fn run(&self) -> anyhow::Result<ExitCode> {
        let filter = tracing_subscriber::EnvFilter::try_new(&self.log)
            .with_context(|| format!("reading the log filter {:?}", self.log))?;
        tracing_subscriber::fmt()
            .with_env_filter(filter)
            .with_writer(std::io::stderr)
            .with_ansi(use_color())
            .init();
        let mut config = load(&self.config)?;
        if let Some(view) = &self.view {
            config.view = parse_view(view, config.view)?;
        }
        let clock = Clock::scaled(self.time_scale).ok_or_else(|| {
            anyhow!(
                "the time scale is {}, it must be above 0 and at most 1000",
                self.time_scale
            )
        })?;
        let cell = CellAddress::new(&self.cell, &self.cell_id).context("--cell")?;
        let runtime = tokio::runtime::Runtime::new().context("starting the runtime")?;
        let file = self.config.display().to_string();
        runtime.block_on(async {
            let mut interrupt =
                signal(SignalKind::interrupt()).context("listening for interrupts")?;
            let mut terminate =
                signal(SignalKind::terminate()).context("listening for termination")?;
            let robot =
                MobileRobot::start(&config, clock, &cell).with_context(|| format!("in {file}"))?;
            if let Some(address) = robot.view_address() {
                tracing::info!("The robot's page is at http://{address}/.");
            }
            tokio::select! {
                _ = interrupt.recv() => {}
                _ = terminate.recv() => {}
            }
            robot.shutdown().await;
            anyhow::Ok(())
        })?;
        Ok(ExitCode::SUCCESS)
    }
}

/// Colors are for a terminal, and only if its owner likes them.
fn use_color() -> bool {
    std::io::stderr().is_terminal() && std::env::var_os("NO_COLOR").is_none_or(|v| v.is_empty())
}

fn parse_view(text: &str, file: Option<ViewSection>) -> anyhow::Result<Option<ViewSection>> {
    if text.eq_ignore_ascii_case("off") {
        return Ok(None);
    }
    let address: SocketAddr = text
        .parse()
        .with_context(|| format!("reading the view's address {text:?}, such as 127.0.0.1:8082"))?;
    Ok(Some(ViewSection {
        address,
        // Who opens it to the network says so in the file.
        expose_to_network: file.is_some_and(|view| view.expose_to_network),
    }))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_view_is_an_address_or_off() {
        assert_eq!(parse_view("OFF", None).unwrap(), None);
        assert!(parse_view("127.0.0.1:0", None).unwrap().is_some());
        assert!(parse_view("nowhere", None).is_err());
    }
}
