//! `cellctl`: a robot cell from the command line.

mod audit;
mod cell;
mod cells;
mod cli;
mod context;
mod control;
mod credentials;
mod delta;
mod describe;
mod doubts;
mod emulator;
mod emulator_control;
mod failure;
mod fk;
mod gantt;
mod home;
mod ik;
mod interventions;
mod job;
mod journal;
mod loads;
mod login;
mod mobile_robot;
mod motions;
mod move_to;
mod numbers;
mod questions;
mod report;

mod simulation;
mod speed_override;
mod state;
mod stop;
mod teach;
mod text;
mod tokens;
mod watch;

use std::io::Write;
use std::process::ExitCode;

use clap::Parser;

use crate::cli::{Cli, Command};
use crate::context::Context;
use crate::failure::Failure;
use crate::report::Report;

#[tokio::main(flavor = "current_thread")]
async fn main() -> ExitCode {
    let cli = Cli::parse();
    let json = cli.global.json;
    let report = match run(cli).await {
        Ok(report) => report,
        Err(failure) => failure.report(json),
    };
    // A reader that has gone away (`cellctl … | head`) takes nothing from what was done.
    let _ = std::io::stdout().write_all(report.stdout.as_bytes());
    let _ = std::io::stderr().write_all(report.stderr.as_bytes());
    report.exit.into()
}

async fn run(cli: Cli) -> Result<Report, Failure> {
    let json = cli.global.json;
    // A login asks for its own, and must be possible where what is kept is of no use.
    // A question that is answered here needs none.
    let answered_here = cli.global.server.is_none()
        && (matches!(cli.command, Command::Arm(_) | Command::Plan(_))
            || matches!(&cli.command, Command::Route(args) if !args.asks_a_server()));
    let wants_token = !answered_here && !matches!(cli.command, Command::Login | Command::Logout);
    let context = Context::new(cli.global, wants_token)?;
    match cli.command {
        Command::Move(args) => move_to::run(args, &context).await,
        Command::Home(args) => home::run(args, &context).await,
        Command::Delta(args) => delta::run(args, &context).await,
        Command::Fk(args) => fk::run(args, &context).await,
        Command::Ik(args) => ik::run(args, &context).await,
        Command::State => state::run(&context).await,
        Command::Cell(args) => cell::run(args, &context).await,
        Command::Teach(args) => teach::run(args, &context).await,
        Command::Cells => cells::run(&context).await,
        Command::Describe => describe::run(&context).await,
        Command::Motions(args) => motions::run(args, &context).await,
        Command::Control(args) => control::run(args, &context).await,
        Command::Login => login::login(&context).await,
        Command::Logout => login::logout(&context),
        Command::Whoami => login::whoami(&context).await,
        Command::Audit(args) => audit::run(args, &context).await,
        Command::Tokens(args) => tokens::run(args, &context).await,
        Command::Stop(args) => stop::run(args, &context).await,
        Command::Override(args) => speed_override::run(args, &context).await,
        Command::Doubts(args) => doubts::run(args, &context).await,
        Command::Job(args) => job::run(args, &context).await,
        Command::Loads(args) => loads::run(args, &context).await,
        Command::MobileRobot(args) => mobile_robot::run(args, &context).await,
        Command::Sessions => loads::sessions(&context).await,
        Command::Interventions(args) => interventions::run(args, &context).await,
        Command::Watch(args) => watch::run(args, &context).await,
        Command::Journal(args) => journal::run(args, json).await,
        Command::Emulator(args) => emulator::run(args, &context).await,
        Command::Arm(args) => questions::arm(args, &context).await,
        Command::Plan(args) => questions::plan(args, &context).await,
        Command::Route(args) => questions::route(args, &context).await,
    }
}
