//! The project's commands. `cargo xtask run` starts the whole demo cell; `cargo xtask test` runs every test.

mod bench;
mod ci;
mod command;
mod conformance;
mod failures;
mod fidelity;
mod fuzz;
mod openapi;
mod pinocchio;
mod plots;
mod python;

use anyhow::Result;
use clap::{Parser, Subcommand};

/// The project's commands.
#[derive(Debug, Parser)]
#[command(name = "cargo xtask", bin_name = "cargo xtask")]
struct Cli {
    #[command(subcommand)]
    task: Task,
}

#[derive(Debug, Subcommand)]
enum Task {
    /// Build and start the whole demo cell: server and virtual controller in one process.
    Run {
        /// Arguments for `robocell`, e.g. `--config plant.toml`.
        #[arg(trailing_var_arg = true, allow_hyphen_values = true)]
        args: Vec<String>,
    },
    /// Run every test of the workspace.
    Test {
        /// Arguments for `cargo test`, e.g. a test's name.
        #[arg(trailing_var_arg = true, allow_hyphen_values = true)]
        args: Vec<String>,
    },
    /// Everything a change has to pass: format, lints, documentation, dependencies, tests.
    Ci,
    /// Run the three public KAREL drivers, unmodified, on the virtual controller, each with its usual client.
    Conformance {
        /// Folder with checkouts of sitar777/fanuc-control, torayeff/fanucpy and ros-industrial/fanuc.
        #[arg(long, value_name = "DIR")]
        sources: String,
        /// More arguments, e.g. `--only t3`.
        #[arg(trailing_var_arg = true, allow_hyphen_values = true)]
        args: Vec<String>,
    },
    /// Write openapi.yaml from the server's routes.
    Openapi,
    /// Draw the pictures of docs/robotics.md by the commands in it.
    Plots,
    /// Write docs/failures.md from docs/failures.toml and the tests.
    Failures,
    /// Write docs/fidelity.md from docs/fidelity.toml and the source.
    Fidelity,
    /// Fuzz what comes from outside, each target for a while.
    Fuzz(fuzz::Options),
    /// Run a benchmark against the peer, both in one run.
    Bench {
        /// Which one.
        #[arg(value_enum)]
        which: bench::Which,
        /// Arguments for the benchmark.
        #[arg(trailing_var_arg = true, allow_hyphen_values = true)]
        args: Vec<String>,
    },
}

fn main() -> Result<()> {
    match Cli::parse().task {
        Task::Run { args } => run(&args),
        Task::Test { args } => ci::test(&args),
        Task::Ci => ci::all(),
        Task::Conformance { sources, args } => conformance::run(&sources, &args),
        Task::Openapi => openapi::write(),
        Task::Plots => plots::draw(),
        Task::Failures => failures::write(),
        Task::Fidelity => fidelity::write(),
        Task::Fuzz(options) => fuzz::run(&options),
        Task::Bench { which, args } => bench::run(which, &args),
    }
}

/// The demo cell is a demo; a configuration of one's own says itself who may call.
fn run(args: &[String]) -> Result<()> {
    let mut fixed = vec!["run", "--release", "--package", "cell", "--"];
    let configured = std::env::var_os("ROBOCELL_CONFIG").is_some()
        || args
            .iter()
            .any(|arg| arg == "--config" || arg.starts_with("--config="));
    if !configured && !args.iter().any(|arg| arg == "--demo") {
        fixed.push("--demo");
        // The server's plug can be pulled while the virtual world goes on.
        fixed.push("--supervised");
    }
    command::cargo(&fixed, args)
}

#[cfg(test)]
mod tests {
    use clap::CommandFactory as _;

    #[test]
    fn the_command_line_is_consistent() {
        super::Cli::command().debug_assert();
    }
}
