//! The command line: every word of it, and its help.

use std::path::PathBuf;

use clap::builder::NonEmptyStringValueParser;
use clap::{Args, Parser, Subcommand};

use crate::{
    audit, cell, control, delta, doubts, emulator, fk, home, ik, interventions, job, journal,
    loads, mobile_robot, motions, move_to, questions, speed_override, stop, teach, tokens, watch,
};

/// Drive a robot cell: move, look, calculate.
///
/// Millimeters, degrees and mm/s everywhere; W, P, R turn about the fixed X, Y, Z axes, as on the pendant.
/// This is not a safety function: emergency stop and guards are wired into the controller.
#[derive(Debug, Parser)]
#[command(name = "cellctl", version, after_help = AFTER_HELP, max_term_width = 100)]
pub(crate) struct Cli {
    #[command(flatten)]
    pub(crate) global: Global,
    #[command(subcommand)]
    pub(crate) command: Command,
}

const AFTER_HELP: &str = "\
Examples:
  cellctl cells
  cellctl move 600 200 600 -180 30 0 --speed 200
  cellctl ik 600 200 600 -180 30 0
  cellctl --cell line job delivery --point handover/front --item load-1=crate:left:rack/d
  cellctl --cell line watch
  cellctl --json state | jq .link.state

Exit codes:
  0  done
  1  refused, by the robot or by the server's checks: nothing was executed
  2  usage
  3  link: no answer, or none that tells; after a command the robot may have moved

With --json, one JSON document goes to the standard output in every case but usage: the answer,
the problem, or what went wrong.";

/// Options that every subcommand takes.
#[derive(Args, Debug)]
#[command(next_help_heading = "Options of every subcommand")]
pub(crate) struct Global {
    /// The server; `http://127.0.0.1:8080` where nobody says. `arm`, `plan` and `route` answer by themselves unless it is said.
    #[arg(long, global = true, env = "ROBOCELL_SERVER", value_name = "URL")]
    pub(crate) server: Option<String>,
    /// The cell; not needed where there is exactly one.
    #[arg(long, global = true, env = "ROBOCELL_CELL", value_name = "ID", value_parser = NonEmptyStringValueParser::new())]
    pub(crate) cell: Option<String>,
    /// The robot; not needed where there is exactly one.
    #[arg(long, global = true, env = "ROBOCELL_ROBOT", value_name = "ID", value_parser = NonEmptyStringValueParser::new())]
    pub(crate) robot: Option<String>,
    /// The virtual controller's panel.
    #[arg(
        long,
        global = true,
        env = "ROBOCELL_EMULATOR",
        default_value = "http://127.0.0.1:8081",
        value_name = "URL"
    )]
    pub(crate) emulator: String,
    /// A file with the token to use, yours alone to read. Else the environment variable `ROBOCELL_TOKEN`, else what `cellctl login` kept.
    #[arg(long, global = true, env = "ROBOCELL_TOKEN_FILE", value_name = "FILE")]
    pub(crate) token_file: Option<PathBuf>,
    /// Give up on an answer after this many milliseconds. A command given up on may have been carried out.
    #[arg(long, global = true, value_name = "MS", value_parser = clap::value_parser!(u64).range(1..=600_000))]
    pub(crate) timeout_ms: Option<u64>,
    /// Print one JSON document instead of sentences and tables.
    #[arg(long, global = true)]
    pub(crate) json: bool,
}

/// What to do.
#[derive(Debug, Subcommand)]
pub(crate) enum Command {
    Move(move_to::MoveArgs),
    Home(home::HomeArgs),
    Delta(delta::DeltaArgs),
    Fk(fk::FkArgs),
    Ik(ik::IkArgs),
    /// Show what the server knows of the robot now: link, pose, queue.
    State,
    Cell(cell::CellArgs),
    Teach(teach::TeachArgs),
    /// List the cells and their robots.
    Cells,
    /// Show what the robot is: arm, limits, home, frames, controller.
    Describe,
    Motions(motions::MotionsArgs),
    Control(control::ControlArgs),
    /// Keep a token for this server: asks for it, tries it, and stores it for you alone.
    Login,
    /// Forget the token kept for this server.
    Logout,
    /// Show who the server takes you for.
    Whoami,
    Tokens(tokens::TokensArgs),
    Audit(audit::AuditArgs),
    Stop(stop::StopArgs),
    Override(speed_override::OverrideArgs),
    Doubts(doubts::DoubtsArgs),
    Job(job::JobArgs),
    Loads(loads::LoadsArgs),
    MobileRobot(mobile_robot::MobileRobotArgs),
    /// List the hand-over sessions: states, permits, what is waited for.
    Sessions,
    Interventions(interventions::InterventionsArgs),
    Watch(watch::WatchArgs),
    Journal(journal::JournalArgs),
    Emulator(emulator::EmulatorArgs),
    Arm(questions::ArmArgs),
    Plan(questions::PlanArgs),
    Route(questions::RouteArgs),
}

#[cfg(test)]
mod tests {
    use clap::CommandFactory;

    use super::*;

    #[test]
    fn the_command_line_is_well_formed() {
        Cli::command().debug_assert();
    }

    #[test]
    fn every_subcommand_says_what_it_does() {
        for subcommand in Cli::command().get_subcommands() {
            assert!(
                subcommand.get_about().is_some(),
                "{} has no help",
                subcommand.get_name()
            );
        }
    }
}
