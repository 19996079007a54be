//! From the configuration to running parts, and back down in order.

use std::io::IsTerminal as _;
use std::sync::Arc;

use anyhow::{Context as _, Result};
use karel_emulator::PeerLabels;
use server::{Plan, Seams, SystemClock, TcpConnector};
use tokio::net::TcpListener;
use tokio::signal::unix::{SignalKind, signal};
use tokio_util::sync::CancellationToken;

use crate::config::{self, Loaded};
use crate::virtual_controllers::{self, Prepared, Running};
use crate::{Cli, banner};

/// Runs until it is told to stop.
///
/// # Errors
/// Whatever keeps a part from starting; the message names the file and key, the port, or the program.
pub(crate) fn start(cli: &Cli) -> Result<()> {
    let mut loaded = config::load(cli.config.as_deref())?;
    if let Some(listen) = &cli.listen {
        loaded.file.server.listen.clone_from(listen);
    }
    let prepared = check(&loaded).with_context(|| format!("in {}", loaded.name))?;
    if cli.check {
        return banner::checked(&loaded);
    }
    let filter = tracing_subscriber::EnvFilter::try_new(&cli.log)
        .with_context(|| format!("reading the log filter `{}`", cli.log))?;
    tracing_subscriber::fmt()
        .with_env_filter(filter)
        .with_writer(std::io::stderr)
        .with_ansi(std::io::stderr().is_terminal())
        .init();
    let runtime = tokio::runtime::Builder::new_multi_thread()
        .enable_all()
        .build()?;
    runtime.block_on(run(loaded, prepared))
}

/// Everything that can be checked before anything starts.
fn check(loaded: &Loaded) -> Result<Vec<Prepared>> {
    let file = &loaded.file;
    let prepared = virtual_controllers::prepare_all(&file.virtual_controllers, &loaded.folder)?;
    let mut cells = file.cells.clone();
    virtual_controllers::resolve(&mut cells, &virtual_controllers::placeholders(&prepared))?;
    let _plan = Plan::try_new(&file.server, &cells)?;
    Ok(prepared)
}

async fn run(loaded: Loaded, prepared: Vec<Prepared>) -> Result<()> {
    let Loaded {
        mut file,
        name,
        folder,
    } = loaded;
    let stop = stop_on_signals()?;
    let labels = PeerLabels::new();
    let controllers = virtual_controllers::start_all(prepared, &labels).await?;
    let addresses: Vec<_> = controllers
        .iter()
        .map(|part| (part.name.clone(), part.robot_address))
        .collect();
    virtual_controllers::resolve(&mut file.cells, &addresses)?;
    let plan = Plan::try_new(&file.server, &file.cells).with_context(|| format!("in {name}"))?;
    let listen = plan.server().listen;
    let listener = TcpListener::bind(listen)
        .await
        .with_context(|| format!("serving HTTP on {listen}; is another robocell running?"))?;
    // Last, so that a port in use does not begin an epoch.
    let clock = SystemClock;
    let journal = server::open_journal(&file.journal, &folder, &clock).await?;
    banner::print(listener.local_addr()?, &file, &controllers)?;
    let connector = TcpConnector::with_label(move |peer, request_id| labels.set(peer, request_id));
    server::run(
        listener,
        plan,
        Seams {
            connector,
            clock: Arc::new(clock),
            journal,
        },
        stop,
    )
    .await?;
    for Running { controller, .. } in controllers {
        controller.shutdown().await;
    }
    Ok(())
}

/// A token that is cancelled by the first SIGINT or SIGTERM.
fn stop_on_signals() -> Result<CancellationToken> {
    let mut interrupt = signal(SignalKind::interrupt()).context("listening for interrupts")?;
    let mut terminate = signal(SignalKind::terminate()).context("listening for termination")?;
    let stop = CancellationToken::new();
    let token = stop.clone();
    drop(tokio::spawn(async move {
        tokio::select! {
            _ = interrupt.recv() => {}
            _ = terminate.recv() => {}
        }
        token.cancel();
    }));
    Ok(stop)
}
