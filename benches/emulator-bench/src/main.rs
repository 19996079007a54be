//! The virtual controller: statements a second beside Lua, controller time a second, a hundred controllers, memory.
//!
//! `cargo xtask bench emulator` runs it in release mode. The two interpreters take turns; a ratio is the median of the
//! repeats' ratios. `docs/performance.md` has figures.

mod crowd;
mod machine;
mod process;
mod statements;
mod virtual_time;

use anyhow::Result;
use clap::Parser;

/// What the benchmark takes.
#[derive(Debug, Parser)]
struct Options {
    /// How often each measurement is repeated.
    #[arg(long, default_value_t = 7)]
    repeats: usize,
    /// Seconds for which the hundred controllers run.
    #[arg(long, default_value_t = 10)]
    crowd_seconds: u64,
}

#[expect(clippy::print_stdout, reason = "this is a command-line tool's report")]
fn main() -> Result<()> {
    let options = Options::parse();
    println!("| | measured | target |\n|---|---|---|");
    // Memory first: what others leave behind would be counted.
    crowd::run(options.crowd_seconds)?;
    statements::run(options.repeats)?;
    virtual_time::run(options.repeats)
}

/// The middle one; the upper of two.
fn median(mut values: Vec<f64>) -> f64 {
    values.sort_by(f64::total_cmp);
    let middle = values.len() / 2;
    values.get(middle).copied().unwrap_or(f64::NAN)
}
