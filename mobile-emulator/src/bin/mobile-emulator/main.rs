//! A virtual mobile robot on the command line.

mod check;
mod file;
mod run;

use std::process::ExitCode;

use clap::{Parser, Subcommand};

/// A virtual mecanum robot that drives, docks and talks to the signal endpoints of a cell.
///
/// It is a simulation: not a safety function, and not a substitute for a test on the real robot.
#[derive(Debug, Parser)]
#[command(version, arg_required_else_help = true)]
struct Cli {
    #[command(subcommand)]
    command: Command,
}

#[derive(Debug, Subcommand)]
enum Command {
    Run(run::Run),
    Check(check::Check),
}

fn main() -> ExitCode {
    let answer = match Cli::parse().command {
        Command::Run(run) => run.run(),
        Command::Check(check) => Ok(check.run()),
    };
    answer.unwrap_or_else(|error| {
        // One sentence with its causes, for people; the log goes elsewhere.
        eprintln!("mobile-emulator: {error:#}");
        ExitCode::from(2)
    })
}

#[cfg(test)]
mod tests {
    use clap::CommandFactory;

    #[test]
    fn the_command_line_is_consistent() {
        super::Cli::command().debug_assert();
    }
}
