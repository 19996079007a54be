//! From the configuration to running parts, and back down in order.

use std::collections::BTreeMap;
use std::io::IsTerminal as _;
use std::net::SocketAddr;
use std::sync::Arc;

use anyhow::{Context as _, Result};
use karel_emulator::PeerLabels;
use server::{Plan, Seams, SystemClock, TcpConnector};
use tokio::net::TcpListener;
use tokio::signal::unix::{SignalKind, signal};
use tokio_util::sync::CancellationToken;

use crate::config::{self, Loaded};
use crate::plant::{ControllerAt, Prepared};
use crate::simulate::{self, Simulator};
use crate::{Cli, access, banner, supervise, virtual_controllers};

/// Runs until it is told to stop.
///
/// # Errors
/// Whatever keeps a part from starting; the message names the file and key, the port, or the program.
pub fn start(cli: &Cli) -> Result<()> {
    if cli.simulate {
        return simulate::child();
    }
    let mut loaded = config::load(cli.config.as_deref())?;
    if let Some(listen) = &cli.listen {
        loaded.file.server.listen.clone_from(listen);
    }
    loaded.file.server.demo |= cli.demo;
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
    runtime.block_on(async {
        let stop = stop_on_signals()?;
        match &cli.parts_at {
            Some(parts) => {
                let parts = serde_json::from_str(parts).context("--parts-at")?;
                serve(loaded, Parts::Elsewhere(parts), cli.new_admin_token, stop).await
            }
            None if cli.supervised => supervise::run(cli, loaded, prepared, stop).await,
            None => serve(loaded, Parts::Here(prepared), cli.new_admin_token, stop).await,
        }
    })
}

/// Where the virtual parts are.
enum Parts {
    /// In this process.
    Here(Prepared),
    /// In the one that supervises this one.
    Elsewhere(BTreeMap<String, ControllerAt>),
}

/// Everything that can be checked before anything starts.
fn check(loaded: &Loaded) -> Result<Prepared> {
    let file = &loaded.file;
    let prepared = Prepared::of(loaded)?;
    let mut cells = file.cells.clone();
    virtual_controllers::resolve(&mut cells, &prepared.placeholders())?;
    access::check(loaded)?;
    Plan::try_new(&file.server, &cells)?.check_setups()?;
    Ok(prepared)
}

async fn serve(
    loaded: Loaded,
    parts: Parts,
    new_admin_token: bool,
    stop: CancellationToken,
) -> Result<()> {
    let Loaded {
        mut file,
        folder,
        name,
    } = loaded;
    let labels = PeerLabels::new();
    let mut plant = match parts {
        Parts::Here(prepared) => {
            let plant = prepared.start(&labels).await?;
            virtual_controllers::resolve(&mut file.cells, &plant.addresses())?;
            Some(plant)
        }
        Parts::Elsewhere(addresses) => {
            virtual_controllers::resolve(&mut file.cells, &addresses)?;
            None
        }
    };
    let plan = Plan::try_new(&file.server, &file.cells).with_context(|| format!("in {name}"))?;
    let listen = plan.server().listen;
    let listener = TcpListener::bind(listen)
        .await
        .with_context(|| format!("serving HTTP on {listen}; is another robocell running?"))?;
    // Late, so that a port in use does not begin an epoch.
    let journal = server::open_journal(&file.journal, &folder, &SystemClock).await?;
    // Once nothing can fail any more that a second start would repair: the token is shown this once.
    let access =
        access::open(&file, &folder, new_admin_token).with_context(|| format!("in {name}"))?;
    let simulator = Simulator::of_this_program(&file, &folder)?;
    let plan = plan
        .with_identity(access.identity)?
        .with_simulator(Arc::new(simulator));
    let address = listener.local_addr()?;
    if let Some(plant) = &mut plant {
        plant.start_mobile_robots(&url_of(address))?;
        banner::print(address, &file, &folder, plant, access.first.as_ref(), None)?;
    } else {
        banner::token(access.first.as_ref())?;
    }
    let connector = TcpConnector::with_label(move |peer, request_id| labels.set(peer, request_id));
    let seams = Seams {
        connector,
        clock: Arc::new(SystemClock),
        journal,
    };
    server::run(listener, plan, seams, stop).await?;
    if let Some(plant) = plant {
        plant.shutdown().await;
    }
    Ok(())
}

/// The server as a mobile robot on this machine reaches it.
pub(crate) fn url_of(listen: SocketAddr) -> String {
    match listen.ip() {
        ip if ip.is_unspecified() => format!("http://127.0.0.1:{}", listen.port()),
        _ => format!("http://{listen}"),
    }
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
