//! The real fanucpy client in a Python process of its own: a JSON request a line, a JSON answer a line.

use std::io::{BufRead as _, BufReader, Write as _};
use std::net::SocketAddr;
use std::path::Path;
use std::process::{Child, ChildStdin, ChildStdout, Command, Stdio};

use anyhow::{Context as _, Result, anyhow};
use serde_json::{Value, json};

use super::rig::Rig;

/// The version that the driver's users have.
pub(crate) const VERSION: &str = "0.1.14";

const BRIDGE: &str = concat!(
    env!("CARGO_MANIFEST_DIR"),
    "/tests/python/fanucpy_bridge.py"
);

/// What a method of the client did.
#[derive(Debug, PartialEq)]
pub(crate) enum Outcome {
    Returned(Value),
    /// The name of the exception and its text.
    Raised(String),
}

impl std::fmt::Display for Outcome {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self {
            Self::Returned(value) => write!(f, "{value}"),
            Self::Raised(what) => write!(f, "raises {what}"),
        }
    }
}

/// A Python process with any number of the client's robots.
pub(crate) struct Fanucpy {
    child: Child,
    pipes: Option<(ChildStdin, BufReader<ChildStdout>)>,
}

impl Fanucpy {
    /// Starts `python`, which must find fanucpy of the right version.
    pub(crate) fn start(python: &Path) -> Result<Self> {
        let starting = || format!("starting {}", python.display());
        let mut child = Command::new(python)
            .args(["-I", BRIDGE])
            .stdin(Stdio::piped())
            .stdout(Stdio::piped())
            .spawn()
            .with_context(starting)?;
        let input = child.stdin.take().with_context(starting)?;
        let output = child.stdout.take().with_context(starting)?;
        let mut output = BufReader::new(output);
        let hello = line_of(&mut output).with_context(starting)?;
        let version = hello.get("version").and_then(Value::as_str);
        let fanucpy = Self {
            child,
            pipes: Some((input, output)),
        };
        if version != Some(VERSION) {
            return Err(anyhow!("fanucpy is {hello}, it must be {VERSION}"));
        }
        Ok(fanucpy)
    }

    /// A robot of the client's, not connected yet; it gives up an answer after `timeout_s`.
    pub(crate) async fn robot(
        &mut self,
        rig: &Rig,
        name: &str,
        address: SocketAddr,
        timeout_s: f64,
    ) -> Result<()> {
        let gripper = (Some("RDO"), Some(7));
        self.robot_with(rig, name, address, (timeout_s, gripper))
            .await
    }

    /// The same with another gripper.
    pub(crate) async fn robot_with(
        &mut self,
        rig: &Rig,
        name: &str,
        address: SocketAddr,
        (timeout_s, (kind, number)): (f64, (Option<&str>, Option<u16>)),
    ) -> Result<()> {
        let options = json!({
            "robot_model": "Fanuc", "host": address.ip().to_string(), "port": address.port(),
            "ee_DO_type": kind, "ee_DO_num": number, "socket_timeout": timeout_s,
        });
        let request = json!({ "robot": name, "new": options });
        match self.request(rig, request).await? {
            Outcome::Returned(_) => Ok(()),
            Outcome::Raised(what) => Err(anyhow!("Robot() raises {what}")),
        }
    }

    /// Calls a method while controller time passes.
    pub(crate) async fn call(
        &mut self,
        rig: &Rig,
        name: &str,
        method: &str,
        arguments: Value,
    ) -> Result<Outcome> {
        let request = json!({ "robot": name, "call": method, "arguments": arguments });
        self.request(rig, request).await
    }

    async fn request(&mut self, rig: &Rig, request: Value) -> Result<Outcome> {
        let (mut input, mut output) = self.pipes.take().context("the client has gone")?;
        let asked = tokio::task::spawn_blocking(move || {
            let sent = writeln!(input, "{request}").and_then(|()| input.flush());
            let answer = sent
                .context("asking the client")
                .and_then(|()| line_of(&mut output));
            (answer, input, output)
        });
        let (answer, input, output) = rig.drive(asked).await??;
        self.pipes = Some((input, output));
        let answer = answer?;
        if let Some(what) = answer.get("raised").and_then(Value::as_str) {
            return Ok(Outcome::Raised(what.to_owned()));
        }
        let value = answer.get("returned").cloned();
        value
            .map(Outcome::Returned)
            .with_context(|| format!("the client says {answer}"))
    }
}

impl Drop for Fanucpy {
    fn drop(&mut self) {
        // It may have gone by itself.
        let _gone = self.child.kill();
        let _status = self.child.wait();
    }
}

fn line_of(output: &mut BufReader<ChildStdout>) -> Result<Value> {
    let mut line = String::new();
    let count = output.read_line(&mut line)?;
    if count == 0 {
        return Err(anyhow!("the client ended"));
    }
    serde_json::from_str(&line).with_context(|| format!("the client says {line:?}"))
}
