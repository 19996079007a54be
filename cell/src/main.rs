//! `robocell`: the server and its virtual parts.

use std::process::ExitCode;

use clap::Parser as _;

fn main() -> ExitCode {
    match cell::start(&cell::Cli::parse()) {
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
