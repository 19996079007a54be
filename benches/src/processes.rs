//! The parts run as processes of their own and tell their port on standard output.

use std::process::Stdio;

use anyhow::{Context as _, Result, ensure};
use tokio::io::{AsyncBufReadExt as _, AsyncReadExt as _, BufReader};
use tokio::process::{Child, ChildStdout, Command};

/// A part that runs; it ends when this is dropped.
#[derive(Debug)]
pub struct Part {
    /// Its (first) port.
    pub port: u16,
    process: Child,
    output: BufReader<ChildStdout>,
}

impl Part {
    /// The number of its process.
    ///
    /// # Errors
    /// It has ended.
    pub fn id(&self) -> Result<u32> {
        self.process.id().context("the part has ended")
    }

    /// Lets it end by itself, and returns what else it said.
    ///
    /// # Errors
    /// It did not end well.
    pub async fn finish(mut self) -> Result<String> {
        drop(self.process.stdin.take());
        let mut said = String::new();
        let _length = self.output.read_to_string(&mut said).await?;
        let status = self.process.wait().await?;
        ensure!(status.success(), "a part ended with {status}");
        Ok(said)
    }
}

/// Starts this program again in another role.
///
/// # Errors
/// It cannot be started, or says no port.
pub async fn start(arguments: &[String]) -> Result<Part> {
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
    let mut output = BufReader::new(output);
    let mut line = String::new();
    let _length = output.read_line(&mut line).await?;
    let port = line
        .trim()
        .parse()
        .with_context(|| format!("{arguments:?} said {line:?}"))?;
    Ok(Part {
        port,
        process,
        output,
    })
}

/// Tells the parent `port`, and waits until the parent has gone or wants no more.
///
/// # Errors
/// Standard input cannot be read.
#[expect(
    clippy::print_stdout,
    reason = "the port goes to the parent over standard output"
)]
pub async fn announce_and_wait(port: u16) -> Result<()> {
    println!("{port}");
    let mut nothing = [0_u8; 1];
    let _end = tokio::io::stdin().read(&mut nothing).await?;
    Ok(())
}
