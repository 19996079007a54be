//! The parts run as processes of their own and tell their port on standard output.

use std::process::Stdio;

use anyhow::{Context as _, Result};
use tokio::io::{AsyncBufReadExt as _, AsyncReadExt as _, BufReader};
use tokio::process::{Child, Command};

/// A part that runs; it ends when this is dropped.
pub(crate) struct Part {
    /// Its (first) port.
    pub(crate) port: u16,
    _process: Child,
}

/// Starts this program again in another role.
pub(crate) async fn start(arguments: &[String]) -> Result<Part> {
    let mut process = Command::new(std::env::current_exe()?)
        .args(arguments)
        .stdin(Stdio::piped())
        .stdout(Stdio::piped())
        // What the server logs is made, and goes nowhere: a terminal is not part of what is measured.
        .stderr(Stdio::null())
        .kill_on_drop(true)
        .spawn()
        .with_context(|| format!("starting {arguments:?}"))?;
    let output = process.stdout.take().context("standard output is piped")?;
    let mut line = String::new();
    let _length = BufReader::new(output).read_line(&mut line).await?;
    let port = line
        .trim()
        .parse()
        .with_context(|| format!("{arguments:?} said {line:?}"))?;
    Ok(Part {
        port,
        _process: process,
    })
}

/// Tells the parent `port`, and waits until the parent has gone.
#[expect(
    clippy::print_stdout,
    reason = "the port goes to the parent over standard output"
)]
pub(crate) async fn announce_and_wait(port: u16) -> Result<()> {
    println!("{port}");
    let mut nothing = [0_u8; 1];
    let _end = tokio::io::stdin().read(&mut nothing).await?;
    Ok(())
}
