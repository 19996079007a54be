//! The service goals of the server: how long its callers wait while nothing is wrong, and while it is attacked and two
//! of its eight robots are dead.
//!
//! Robots, server, attackers and the bare echo are processes of their own on the machine's cores. Every request has a
//! scheduled time, and its latency counts from there, so that a server that stalls cannot slow down the clock it is
//! measured by. Beside each figure stands the machine's own limit under the same schedule at the same time: a bare TCP
//! echo, and a bare fdatasync.

mod attack;
mod client;
mod descriptors;
mod disk;
mod echo;
mod latencies;
mod memory;
mod motions;
mod plant;
mod probe;
mod report;
mod restart;
mod schedule;
mod served;
mod state;
mod stops;

use std::path::PathBuf;
use std::time::Duration;

use anyhow::Result;
use api::ControlToken;
use clap::{Parser, Subcommand};

/// The service goals, with and without an attack.
#[derive(Debug, Parser)]
struct Cli {
    #[command(subcommand)]
    role: Option<Role>,
    /// Seconds of each slice of load; calm and attacked slices take turns.
    #[arg(long, default_value_t = 10.0)]
    seconds: f64,
    /// How many slices of each.
    #[arg(long, default_value_t = 2)]
    repeats: usize,
    /// Where the journal is and the disk is measured.
    #[arg(long, default_value = "target")]
    disk: PathBuf,
    /// Records of the journal the server is restarted with.
    #[arg(long, default_value_t = 100_000)]
    records: u64,
}

/// The parts that run as processes of their own.
#[derive(Clone, Debug, Subcommand)]
enum Role {
    /// The controllers: six that answer, one that is mute, one that cannot be reached.
    Robots,
    /// The server, as shipped.
    Served {
        /// The robots' ports.
        #[arg(value_delimiter = ',')]
        ports: Vec<u16>,
        /// The journal's file.
        journal: PathBuf,
    },
    /// A bare TCP echo.
    Echo,
    /// Those who hold connections, and those who fill the queues of the dead robots.
    Attack {
        /// The server's port.
        port: u16,
        /// The token of whoever has control of the cell.
        control: ControlToken,
    },
}

fn main() -> Result<()> {
    let cli = Cli::parse();
    let runtime = tokio::runtime::Builder::new_multi_thread()
        .enable_all()
        .build()?;
    runtime.block_on(async {
        match cli.role {
            Some(Role::Robots) => plant::run().await,
            Some(Role::Served { ports, journal }) => served::run(&ports, &journal).await,
            Some(Role::Echo) => echo::run().await,
            Some(Role::Attack { port, control }) => attack::run(port, control).await,
            None => {
                let slice = Duration::from_secs_f64(cli.seconds);
                report::run(&cli.disk, slice, cli.repeats, cli.records).await
            }
        }
    })
}
