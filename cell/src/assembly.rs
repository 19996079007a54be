//! A plant and the servers that come and go before it: what the program does, for callers with a listener and a
//! journal of their own.

use std::net::SocketAddr;
use std::path::PathBuf;
use std::sync::Arc;
use std::time::Duration;

use anyhow::{Context as _, Result};
use karel_emulator::{PeerLabels, VirtualController};
use server::identity::Identity;
use server::{Plan, Seams, SharedJournal, SystemClock, TcpConnector, WallClock};
use tokio::net::TcpListener;
use tokio_util::sync::CancellationToken;

use crate::config::Loaded;
use crate::plant::{Plant, Prepared};
use crate::simulate::Simulator;
use crate::start::url_of;
use crate::virtual_controllers;

/// How long a simulation may take: all of this is virtual, so there is nothing to spare the machine for.
const SIMULATION: Duration = Duration::from_mins(1);

/// The running virtual parts of a configuration. Servers may be started before it, and killed, one after the other.
#[derive(Debug)]
pub struct Assembly {
    loaded: Loaded,
    plant: Plant,
    labels: PeerLabels,
    simulator: Option<PathBuf>,
}

impl Assembly {
    /// Starts the virtual controllers of a configuration in TOML; all its cells begin with `setup`.
    ///
    /// # Errors
    /// What does not fit in either text, or a part that does not start.
    pub async fn start(config: &str, setup: &str) -> Result<Self> {
        let mut loaded = Loaded::from_text(config, setup)?;
        let labels = PeerLabels::new();
        let plant = Prepared::of(&loaded)?.start(&labels).await?;
        virtual_controllers::resolve(&mut loaded.file.cells, &plant.addresses())?;
        Ok(Self {
            loaded,
            plant,
            labels,
            simulator: None,
        })
    }

    /// Lets the servers simulate jobs with `program`, which is `robocell`.
    pub fn simulate_with(&mut self, program: impl Into<PathBuf>) {
        self.simulator = Some(program.into());
    }

    /// Switches the mobile robots on. The server they talk to need not answer yet.
    ///
    /// # Errors
    /// The first that does not start.
    pub fn start_mobile_robots(&mut self, server: SocketAddr) -> Result<()> {
        self.plant.start_mobile_robots(&url_of(server))
    }

    /// A server in demo mode before this plant, until `stop` is cancelled.
    ///
    /// # Errors
    /// It does not start.
    pub fn serve(
        &self,
        listener: TcpListener,
        journal: SharedJournal,
        stop: CancellationToken,
    ) -> Result<impl Future<Output = Result<()>> + Send + use<>> {
        self.serve_by(Arc::new(SystemClock), listener, journal, stop)
    }

    /// The same by a clock of its own.
    pub(crate) fn serve_by(
        &self,
        clock: Arc<dyn WallClock>,
        listener: TcpListener,
        journal: SharedJournal,
        stop: CancellationToken,
    ) -> Result<impl Future<Output = Result<()>> + Send + use<>> {
        let file = &self.loaded.file;
        let mut plan = Plan::try_new(&file.server, &file.cells)?.with_identity(Identity::demo())?;
        if let Some(program) = &self.simulator {
            let simulator = Simulator::new(program.clone(), file, &self.loaded.folder)
                .with_patience(SIMULATION);
            plan = plan.with_simulator(Arc::new(simulator));
        }
        let labels = self.labels.clone();
        let connector = TcpConnector::with_label(move |peer, id| labels.set(peer, id));
        let seams = Seams {
            connector,
            clock,
            journal,
        };
        Ok(async move {
            server::run(listener, plan, seams, stop)
                .await
                .context("serving")
        })
    }

    /// Lets the servers to come reach a robot's controller somewhere else, e.g. through what breaks the line to it.
    /// False where no robot is named so.
    pub fn reroute(&mut self, robot: &str, command: SocketAddr, status: SocketAddr) -> bool {
        let cells = self.loaded.file.cells.iter_mut();
        let mut robots = cells.flat_map(|cell| cell.robots.iter_mut());
        let Some(found) = robots.find(|found| found.id == robot) else {
            return false;
        };
        found.controller = command.to_string();
        found.status_controller = Some(status.to_string());
        true
    }

    /// Where the virtual controllers are, as `--parts-at` of the program takes it.
    ///
    /// # Errors
    /// Never, as far as is known: addresses are plain data.
    pub fn parts_at(&self) -> Result<String> {
        Ok(serde_json::to_string(&self.plant.addresses())?)
    }

    /// A virtual controller by its name.
    #[must_use]
    pub fn controller(&self, name: &str) -> Option<&VirtualController> {
        let mut parts = self.plant.controllers.iter();
        parts
            .find(|part| part.name == name)
            .map(|part| &part.controller)
    }

    /// The virtual parts.
    #[must_use]
    pub fn plant(&self) -> &Plant {
        &self.plant
    }

    /// Stops every part.
    pub async fn shutdown(self) {
        self.plant.shutdown().await;
    }
}
