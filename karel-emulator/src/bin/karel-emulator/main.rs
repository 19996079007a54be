//! A virtual FANUC controller on the command line.

mod check;
mod includes;
mod run;

use std::process::ExitCode;

use clap::{Parser, Subcommand};

/// A virtual FANUC controller that runs KAREL programs.
///
/// It listens where the program listens, moves a simulated arm, enforces its joint limits, and shows everything on a
/// panel. It is a simulation: not a safety function, and not a substitute for a test on the real arm.
#[derive(Debug, Parser)]
#[command(version, arg_required_else_help = true)]
struct Cli {
    #[command(subcommand)]
    command: Command,
}

#[derive(Debug, Subcommand)]
enum Command {
    Run(Box<run::Run>),
    Check(check::Check),
}

fn main() -> ExitCode {
    let answer = match Cli::parse().command {
        Command::Run(run) => run.run(),
        Command::Check(check) => check.run(),
    };
    answer.unwrap_or_else(|error| {
        // One sentence with its causes, for people; the log goes elsewhere.
        eprintln!("karel-emulator: {error:#}");
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
