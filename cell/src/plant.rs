//! The virtual parts of a configuration: controllers, mobile robots, and the world between them.

use std::collections::BTreeMap;
use std::net::SocketAddr;
use std::sync::Arc;

use anyhow::{Context as _, Result};
use api::setup::SetupFile;
use karel_emulator::PeerLabels;
use mobile_emulator::MobileRobot;
use serde::{Deserialize, Serialize};
use server::config::{CellSection, SetupSource};
use tokio_util::sync::CancellationToken;
use tokio_util::task::TaskTracker;

use crate::config::Loaded;
use crate::mobile_robots;
use crate::virtual_controllers::{self, Running};
use crate::world::World;

/// Why a plant does not start: what is wrong with the configuration, or a port that is taken.
pub type PlantError = anyhow::Error;

/// Where the ports of a virtual controller are.
#[derive(Clone, Copy, Debug, Deserialize, Serialize)]
pub(crate) struct ControllerAt {
    pub(crate) command: SocketAddr,
    /// Of a cell server.
    pub(crate) status: Option<SocketAddr>,
}

/// Every virtual part of a configuration, checked and not started.
#[derive(Debug)]
pub(crate) struct Prepared {
    controllers: Vec<virtual_controllers::Prepared>,
    mobile_robots: Vec<mobile_robots::Prepared>,
    /// One of each cell with a set-up.
    worlds: BTreeMap<String, World>,
}

/// The virtual parts, running. Dropping them stops them.
#[derive(Debug)]
pub struct Plant {
    pub(crate) controllers: Vec<Running>,
    mobile_robots: Vec<mobile_robots::Prepared>,
    running: Vec<Arc<MobileRobot>>,
    worlds: BTreeMap<String, World>,
    tracker: TaskTracker,
    stop: CancellationToken,
}

impl Prepared {
    /// Checks every section.
    ///
    /// # Errors
    /// The first key that does not fit.
    pub(crate) fn of(loaded: &Loaded) -> Result<Self> {
        let file = &loaded.file;
        let mut setups = BTreeMap::new();
        for cell in &file.cells {
            if let Some(setup) = setup_of(cell)? {
                let _one = setups.insert(cell.id.clone(), setup);
            }
        }
        let mut worlds = BTreeMap::new();
        for (id, setup) in &setups {
            let arms = controllers_of(&file.cells, id);
            let world = World::try_new(setup, &arms)
                .with_context(|| format!("the set-up of cell `{id}`"))?;
            let _one = worlds.insert(id.clone(), world);
        }
        let world_of = |controller: &str| {
            let cell = file.cells.iter().find(|cell| {
                let mut robots = cell.robots.iter();
                robots.any(|robot| virtual_controllers::name_of(robot) == Some(controller))
            })?;
            worlds.get(&cell.id).cloned()
        };
        let controllers =
            virtual_controllers::prepare_all(&file.virtual_controllers, &loaded.folder, &world_of)?;
        let mut robots = Vec::new();
        for (index, section) in file.virtual_mobile_robots.iter().enumerate() {
            let key = format!("virtual_mobile_robots[{index}]");
            let setup = setups
                .get(&section.cell)
                .with_context(|| format!("{key}.cell: `{}` has no set-up", section.cell))?;
            robots.push(mobile_robots::prepare(
                section,
                setup,
                &loaded.folder,
                &key,
            )?);
        }
        Ok(Self {
            controllers,
            mobile_robots: robots,
            worlds,
        })
    }

    /// Names with addresses that stand for the real ones until they are known.
    pub(crate) fn placeholders(&self) -> BTreeMap<String, ControllerAt> {
        let at = ControllerAt {
            command: SocketAddr::from(([127, 0, 0, 1], 1)),
            status: Some(SocketAddr::from(([127, 0, 0, 1], 2))),
        };
        let names = self.controllers.iter().map(|part| part.name().to_owned());
        names.map(|name| (name, at)).collect()
    }

    /// Starts the controllers.
    ///
    /// # Errors
    /// The first that does not start, by its name.
    pub(crate) async fn start(self, labels: &PeerLabels) -> Result<Plant> {
        Ok(Plant {
            controllers: virtual_controllers::start_all(self.controllers, labels).await?,
            mobile_robots: self.mobile_robots,
            running: Vec::new(),
            worlds: self.worlds,
            tracker: TaskTracker::new(),
            stop: CancellationToken::new(),
        })
    }
}

impl Plant {
    /// Where the controllers are, by their names.
    pub(crate) fn addresses(&self) -> BTreeMap<String, ControllerAt> {
        let parts = self.controllers.iter();
        parts.map(|part| (part.name.clone(), part.at)).collect()
    }

    /// Starts the mobile robots of `server`, which need not answer yet.
    ///
    /// # Errors
    /// The first that does not start, by its name.
    pub(crate) fn start_mobile_robots(&mut self, server: &str) -> Result<()> {
        for prepared in self.mobile_robots.drain(..) {
            let Some(world) = self.worlds.get(&prepared.cell) else {
                continue;
            };
            let robot = prepared.start(server, world, &self.tracker, &self.stop)?;
            self.running.push(robot);
        }
        Ok(())
    }

    /// The mobile robots that run.
    #[must_use]
    pub fn mobile_robots(&self) -> &[Arc<MobileRobot>] {
        &self.running
    }

    /// The parts between grippers and slots of a cell.
    #[must_use]
    pub fn world(&self, cell: &str) -> Option<&World> {
        self.worlds.get(cell)
    }

    /// Stops everything.
    pub async fn shutdown(self) {
        self.stop.cancel();
        drop(self.running);
        let _closed = self.tracker.close();
        self.tracker.wait().await;
        for Running { controller, .. } in self.controllers {
            controller.shutdown().await;
        }
    }
}

/// Which virtual controller moves which arm of a cell.
fn controllers_of(cells: &[CellSection], cell: &str) -> BTreeMap<String, String> {
    let cell = cells.iter().find(|known| known.id == cell);
    let robots = cell.into_iter().flat_map(|cell| &cell.robots);
    robots
        .filter_map(|robot| {
            let controller = virtual_controllers::name_of(robot)?;
            Some((robot.id.clone(), controller.to_owned()))
        })
        .collect()
}

/// The set-up a cell begins with. What is wrong with it the server tells in full; here it only has to be read.
fn setup_of(cell: &CellSection) -> Result<Option<SetupFile>> {
    let text = match &cell.setup {
        None => return Ok(None),
        Some(SetupSource::Memory(text)) => text.clone(),
        Some(SetupSource::File(path)) => match std::fs::read_to_string(path) {
            Ok(text) => text,
            Err(error) if error.kind() == std::io::ErrorKind::NotFound => return Ok(None),
            Err(error) => {
                return Err(error).with_context(|| format!("reading {}", path.display()));
            }
        },
    };
    toml::from_str(&text)
        .map(Some)
        .with_context(|| format!("in the set-up of cell `{}`", cell.id))
}
