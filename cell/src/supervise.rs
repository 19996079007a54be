//! The virtual world in this process, the server in one of its own.
//!
//! Pulling the server's plug (`kill -9`) is then what it is in a plant: the arms, the mobile robots and the loads are
//! still there, and go on doing what they were told. The server is started again and finds out what became of
//! everything.

use std::os::unix::process::ExitStatusExt as _;
use std::process::{ExitStatus, Stdio};
use std::time::Duration;

use anyhow::{Context as _, Result, bail};
use karel_emulator::PeerLabels;
use server::Plan;
use tokio::process::{Child, Command};
use tokio::time::{Instant, sleep, timeout};
use tokio_util::sync::CancellationToken;

use crate::config::Loaded;
use crate::plant::Prepared;
use crate::start::url_of;
use crate::{Cli, banner, virtual_controllers};

/// A server that ends by itself sooner than this after its start cannot start.
const TOO_SOON: Duration = Duration::from_secs(1);
/// `kill -9`, on every Unix.
const SIGKILL: i32 = 9;
/// Between the death of a server and its next start.
const PAUSE: Duration = Duration::from_millis(500);
/// How long a server that is told to stop may take.
const PATIENCE: Duration = Duration::from_secs(15);

/// Runs the virtual parts here and the server beside them until `stop` is cancelled.
///
/// # Errors
/// A part does not start, or the server ends right after its start.
pub(crate) async fn run(
    cli: &Cli,
    mut loaded: Loaded,
    prepared: Prepared,
    stop: CancellationToken,
) -> Result<()> {
    let mut plant = prepared.start(&PeerLabels::new()).await?;
    let addresses = plant.addresses();
    let parts_at = serde_json::to_string(&addresses)?;
    virtual_controllers::resolve(&mut loaded.file.cells, &addresses)?;
    let plan = Plan::try_new(&loaded.file.server, &loaded.file.cells)
        .with_context(|| format!("in {}", loaded.name))?;
    let listen = plan.server().listen;
    if listen.port() == 0 {
        bail!(
            "server.listen: a supervised server needs a port of its own, not 0: it is started again on the same one"
        );
    }
    // What the demo keeps lasts as long as the demo.
    let folder = tempfile_folder()?;
    let journal = loaded
        .file
        .journal
        .path
        .is_none()
        .then(|| folder.path().join("cell.journal"));
    plant.start_mobile_robots(&url_of(listen))?;
    let mut is_first = true;
    loop {
        let started = Instant::now();
        let mut server = spawn(cli, &parts_at, journal.as_deref())?;
        let id = server.id().unwrap_or_default();
        if is_first {
            if let Some(path) = &journal {
                loaded.file.journal.path = Some(path.clone());
            }
            banner::print(listen, &loaded.file, &loaded.folder, &plant, None, Some(id))?;
            is_first = false;
        } else {
            banner::again(id)?;
        }
        tokio::select! {
            ended = server.wait() => {
                let status = ended.context("waiting for the server")?;
                if started.elapsed() < TOO_SOON && !was_killed(status) {
                    bail!("the server ended right after its start ({status}); its own words are above");
                }
                tracing::warn!(%status, "the server is gone; the arms, the mobile robots and the loads are not. Starting it again");
                sleep(PAUSE).await;
            }
            () = stop.cancelled() => {
                end(server, id).await;
                break;
            }
        }
    }
    plant.shutdown().await;
    Ok(())
}

/// Somebody else ended it, a person or the system for want of memory: that says nothing about whether it can start.
fn was_killed(status: ExitStatus) -> bool {
    status.signal() == Some(SIGKILL)
}

fn spawn(cli: &Cli, parts_at: &str, journal: Option<&std::path::Path>) -> Result<Child> {
    let program = std::env::current_exe().context("finding this program")?;
    let mut command = Command::new(program);
    let _command = command
        .args(["--parts-at", parts_at, "--log", &cli.log])
        .stdin(Stdio::null())
        .kill_on_drop(true);
    if let Some(config) = &cli.config {
        let _command = command.arg("--config").arg(config);
    }
    if let Some(listen) = &cli.listen {
        let _command = command.args(["--listen", listen]);
    }
    if cli.demo {
        let _command = command.arg("--demo");
    }
    if let Some(journal) = journal {
        let _command = command.env(crate::config::JOURNAL, journal);
    }
    command.spawn().context("starting the server")
}

/// Ends the server in order, and by force if it does not.
async fn end(mut server: Child, id: u32) {
    let told = Command::new("kill").arg(id.to_string()).status().await;
    if told.is_ok_and(|status| status.success()) && timeout(PATIENCE, server.wait()).await.is_ok() {
        return;
    }
    tracing::warn!("the server did not end in time and is killed");
    if let Err(error) = server.kill().await {
        tracing::warn!(%error, "killing the server");
    }
}

fn tempfile_folder() -> Result<tempfile::TempDir> {
    tempfile::Builder::new()
        .prefix("robocell-demo-")
        .tempdir()
        .context("making a folder for the demo's journal")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_server_that_was_killed_right_after_its_start_is_started_again() {
        assert!(was_killed(ExitStatus::from_raw(SIGKILL)));
        let exit_2 = ExitStatus::from_raw(2 << 8);
        assert_eq!(exit_2.code(), Some(2));
        assert!(!was_killed(exit_2));
        let aborted = ExitStatus::from_raw(6);
        assert!(!was_killed(aborted));
    }
}
