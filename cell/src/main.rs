//! `robocell`: the server and its virtual controllers in one process.

mod access;
mod banner;
mod config;
mod start;
mod virtual_controllers;

use std::path::PathBuf;
use std::process::ExitCode;

use clap::Parser;

/// A networked robot-cell server with virtual FANUC controllers.
///
/// Without a configuration file it is the demo cell: one virtual FANUC M-20iA that runs the KAREL socket server,
/// and the HTTP API in front of it; `robocell --demo` starts it. Nothing real moves unless a configuration names a
/// real controller, and only callers with a token move anything: the first start makes one and shows it.
/// This is not a safety function.
#[derive(Debug, Parser)]
#[command(name = "robocell", version)]
pub(crate) struct Cli {
    /// Configuration file (TOML). The demo cell where absent.
    #[arg(long, env = "ROBOCELL_CONFIG", value_name = "FILE")]
    config: Option<PathBuf>,
    /// Where to serve HTTP, `address:port`. Overrides `server.listen`.
    #[arg(long, env = "ROBOCELL_LISTEN", value_name = "ADDRESS")]
    listen: Option<String>,
    /// What to log on standard error, such as `info` or `server=debug`.
    #[arg(
        long,
        env = "ROBOCELL_LOG",
        default_value = "info",
        value_name = "FILTER"
    )]
    log: String,
    /// Let everybody on this machine do everything, without tokens. For trying things out, never for a real robot.
    #[arg(long, env = "ROBOCELL_DEMO")]
    demo: bool,
    /// Make a new admin token and show it once: for whoever has this machine but no token any more.
    #[arg(long, conflicts_with_all = ["demo", "check"])]
    new_admin_token: bool,
    /// Read and check the configuration, and start nothing.
    #[arg(long)]
    check: bool,
}

fn main() -> ExitCode {
    match start::start(&Cli::parse()) {
        Ok(()) => ExitCode::SUCCESS,
        Err(error) => {
            complain(&error);
            ExitCode::from(2)
        }
    }
}

#[expect(
    clippy::print_stderr,
    reason = "the log may not be up when this is needed"
)]
fn complain(error: &anyhow::Error) {
    eprintln!("robocell: {error:#}");
}

#[cfg(test)]
mod tests {
    use clap::CommandFactory as _;

    #[test]
    fn the_command_line_is_consistent() {
        super::Cli::command().debug_assert();
    }
}
