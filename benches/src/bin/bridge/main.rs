//! A tier-0 move beside raw TCP, a minimal bridge and a bare axum route: requests a second, all in one run.
//!
//! Robot, server and load are processes of their own, as in a plant, and share the machine's cores. Each repeat runs
//! every variant in turn; the ratios are medians over the repeats, because absolute figures drift.

mod bare;
mod http;
mod load;
mod minimal;
mod raw;
mod report;
mod robot;
mod served;

use std::time::Duration;

use anyhow::Result;
use benches::processes;
use clap::{Parser, Subcommand};

/// A tier-0 move beside raw TCP and a bare axum route.
#[derive(Debug, Parser)]
struct Cli {
    #[command(subcommand)]
    role: Option<Role>,
    /// Seconds each variant runs in each repeat.
    #[arg(long, default_value_t = 2.0)]
    seconds: f64,
    /// How often every variant is run.
    #[arg(long, default_value_t = 5)]
    repeats: usize,
    /// Connections that send at the same time.
    #[arg(long, value_delimiter = ',', default_value = "1,8,64")]
    connections: Vec<usize>,
    /// Measures these alone, e.g. under a profiler.
    #[arg(long, value_delimiter = ',')]
    only: Vec<report::Variant>,
}

/// The parts that run as processes of their own.
#[derive(Clone, Copy, Debug, Subcommand)]
enum Role {
    /// A trivial robot: reads a line, answers, closes.
    Robot {
        /// How many ports it listens on.
        ports: usize,
    },
    /// The server, as shipped, with one robot for each of `ports`.
    Served {
        /// The trivial robot's first port.
        first_port: u16,
        /// How many robots.
        robots: usize,
    },
    /// A bare axum route.
    Bare,
    /// The least that can be called a bridge.
    Minimal {
        /// The trivial robot's first port.
        first_port: u16,
    },
}

fn main() -> Result<()> {
    let cli = Cli::parse();
    let runtime = tokio::runtime::Builder::new_multi_thread()
        .enable_all()
        .build()?;
    runtime.block_on(async {
        match cli.role {
            Some(Role::Robot { ports }) => robot::run(ports).await,
            Some(Role::Served { first_port, robots }) => served::run(first_port, robots).await,
            Some(Role::Bare) => bare::run().await,
            Some(Role::Minimal { first_port }) => minimal::run(first_port).await,
            None => {
                let plan = report::Plan {
                    repeats: cli.repeats,
                    slice: Duration::from_secs_f64(cli.seconds),
                    only: cli.only,
                };
                report::compare(&cli.connections, &plan).await
            }
        }
    })
}
