//! A virtual FANUC controller on the command line.

mod check;
mod fault;
mod http;
mod includes;
mod operator;
mod remote;
mod run;
mod time;
mod trace;
mod watch;

use std::process::ExitCode;

use clap::{Parser, Subcommand};

/// A virtual FANUC controller that runs KAREL programs.
///
/// It listens where the program listens, moves a simulated arm, enforces its joint limits, and shows everything on a
/// panel. It is a simulation: not a safety function, and not a substitute for a test on the real arm.
#[derive(Debug, Parser)]
#[command(version, arg_required_else_help = true, after_help = AFTER_HELP, max_term_width = 100)]
struct Cli {
    #[command(subcommand)]
    command: Command,
}

const AFTER_HELP: &str = "\
Examples:
  karel-emulator check *.kl *.ls
  karel-emulator run main.kl --until-idle
  karel-emulator run sock_server.kl --port-map 59002=0 &
  karel-emulator watch
  karel-emulator fault delay --ms 200 --port 59002 --times 3

Exit codes:
  0  done
  1  refused, or failed: an error in a program, an alarm, a value beyond its limits
  2  usage, or what was asked for cannot be started
  3  link: no controller answers there";

#[derive(Debug, Subcommand)]
enum Command {
    Run(Box<run::Run>),
    Check(check::Check),
    State(remote::State),
    Get(remote::Get),
    Set(remote::Set),
    Watch(watch::Watch),
    Trace(trace::Trace),
    Operator(operator::Operator),
    Time(time::Time),
    Fault(fault::Fault),
}

fn main() -> ExitCode {
    let answer = match Cli::parse().command {
        Command::Run(run) => run.run(),
        Command::Check(check) => check.run(),
        Command::State(state) => state.run(),
        Command::Get(get) => get.run(),
        Command::Set(set) => set.run(),
        Command::Watch(watch) => watch.run(),
        Command::Trace(trace) => trace.run(),
        Command::Operator(operator) => operator.run(),
        Command::Time(time) => time.run(),
        Command::Fault(fault) => fault.run(),
    };
    answer.unwrap_or_else(|error| {
        // One sentence with its causes, for people; the log goes elsewhere.
        eprintln!("karel-emulator: {error:#}");
        http::exit_of(&error)
    })
}

#[cfg(test)]
mod tests {
    use clap::CommandFactory;

    #[test]
    fn the_command_line_is_consistent() {
        super::Cli::command().debug_assert();
    }

    #[test]
    fn every_command_says_what_it_does() {
        for command in super::Cli::command().get_subcommands() {
            assert!(command.get_about().is_some(), "{}", command.get_name());
        }
    }
}
