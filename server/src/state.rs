use std::sync::Arc;

use ::journal::ReadError;
use api::{LinkState, Tier};
use metrics_exporter_prometheus::BuildError;
use thiserror::Error;
use tokio_util::sync::CancellationToken;
use tokio_util::task::TaskTracker;

use crate::clock::WallClock;
use crate::config::{Plan, RobotPlan, ServerPlan};
use crate::journal::SharedJournal;
use crate::link::cell_server::{self, CellServerLink, CellServerPlan};
use crate::link::{self, Connector, Link, Owner};
use crate::metrics::{LinkMetrics, Metrics};
use crate::motions::{self, InFlight, Motions};
use crate::problem::Problem;

/// What the handlers work on.
#[derive(Debug)]
pub(crate) struct App {
    pub(crate) server: ServerPlan,
    pub(crate) cells: Vec<Cell>,
    pub(crate) legacy: Arc<Robot>,
    pub(crate) metrics: Metrics,
    pub(crate) clock: Arc<dyn WallClock>,
    pub(crate) journal: SharedJournal,
    pub(crate) keys: InFlight,
}

#[derive(Debug)]
pub(crate) struct Cell {
    pub(crate) id: String,
    pub(crate) name: String,
    pub(crate) robots: Vec<Arc<Robot>>,
}

#[derive(Debug)]
pub(crate) struct Robot {
    pub(crate) plan: Arc<RobotPlan>,
    pub(crate) link: RobotLink,
    pub(crate) motions: Arc<Motions>,
    pub(crate) metrics: LinkMetrics,
}

/// The way to a robot's controller, by the program on it.
#[derive(Clone, Debug)]
pub(crate) enum RobotLink {
    Seed(Link),
    CellServer(CellServerLink),
}

impl RobotLink {
    /// Orders waiting, and how many may.
    pub(crate) fn depth(&self) -> (usize, usize) {
        match self {
            Self::Seed(link) => link.depth(),
            Self::CellServer(link) => link.depth(),
        }
    }

    /// Whether the link takes orders.
    pub(crate) fn is_running(&self) -> bool {
        match self {
            Self::Seed(link) => link.is_running(),
            Self::CellServer(link) => link.is_running(),
        }
    }

    pub(crate) fn state(&self) -> LinkState {
        match self {
            Self::Seed(link) => link.status().state,
            Self::CellServer(link) => link.view().state,
        }
    }
}

/// What the server is given from outside, so that a test can give something else.
#[derive(Clone, Debug)]
pub struct Seams<C> {
    /// How controllers are reached.
    pub connector: C,
    /// What time it is, for the records people read.
    pub clock: Arc<dyn WallClock>,
    /// Where intents and outcomes are kept.
    pub journal: SharedJournal,
}

/// Why the parts of a server did not start.
#[derive(Debug, Error)]
pub(crate) enum StartError {
    #[error(transparent)]
    Metrics(BuildError),
    #[error(transparent)]
    Journal(ReadError),
}

impl App {
    /// Takes up what the journal knows, and starts the links. They end once `stop` is cancelled; `tracker` waits for them.
    pub(crate) async fn start<C: Connector>(
        plan: Plan,
        seams: Seams<C>,
        routes: impl Iterator<Item = String>,
        tracker: &TaskTracker,
        stop: &CancellationToken,
    ) -> Result<Self, StartError> {
        let metrics = Metrics::new(routes).map_err(StartError::Metrics)?;
        let connector = Arc::new(seams.connector);
        let clock = seams.clock;
        let journal = seams.journal;
        let start_robot = |plan: RobotPlan| {
            let plan = Arc::new(plan);
            let motions = Arc::new(Motions::new(
                Arc::clone(&plan),
                Arc::clone(&clock),
                journal.clone(),
                tracker.clone(),
            ));
            let controller = metrics.controller_link(&plan);
            let metrics = metrics.link(&plan);
            let link = match plan.tier {
                Tier::Seed | Tier::SeedStatus => {
                    let owner = Owner {
                        plan: Arc::clone(&plan),
                        motions: Arc::clone(&motions),
                        connector: Arc::clone(&connector),
                        metrics: metrics.clone(),
                    };
                    RobotLink::Seed(link::spawn(owner, tracker, stop.clone()))
                }
                Tier::CellServer => RobotLink::CellServer(cell_server::spawn(
                    CellServerPlan::of(&plan, controller),
                    Arc::clone(&connector),
                    Arc::clone(&motions),
                    journal.epoch().0,
                    tracker,
                    stop.clone(),
                )),
            };
            Arc::new(Robot {
                plan,
                link,
                motions,
                metrics,
            })
        };
        let cells: Vec<_> = plan
            .cells
            .into_iter()
            .map(|cell| Cell {
                id: cell.id,
                name: cell.name,
                robots: cell.robots.into_iter().map(start_robot).collect(),
            })
            .collect();
        let all: Vec<_> = cells
            .iter()
            .flat_map(|cell: &Cell| &cell.robots)
            .map(|robot: &Arc<Robot>| Arc::clone(&robot.motions))
            .collect();
        motions::recover(&journal, &all)
            .await
            .map_err(StartError::Journal)?;
        for robot in cells.iter().flat_map(|cell: &Cell| &cell.robots) {
            if let RobotLink::CellServer(link) = &robot.link {
                let motions = Arc::clone(&robot.motions);
                drop(tracker.spawn(motions.reconcile(link.clone(), stop.clone())));
            }
        }
        let (cell, robot) = plan.legacy;
        let legacy = cells.get(cell).and_then(|cell| cell.robots.get(robot));
        let Some(legacy) = legacy.map(Arc::clone) else {
            unreachable!("a plan's legacy robot is one of its robots");
        };
        Ok(Self {
            server: plan.server,
            cells,
            legacy,
            metrics,
            clock,
            journal,
            keys: InFlight::default(),
        })
    }

    pub(crate) fn cell(&self, cell: &str) -> Result<&Cell, Problem> {
        self.cells
            .iter()
            .find(|known| known.id == cell)
            .ok_or_else(|| Problem::not_found(format!("there is no cell `{}`", shown(cell))))
    }

    pub(crate) fn robot(&self, cell: &str, robot: &str) -> Result<&Arc<Robot>, Problem> {
        self.cell(cell)?
            .robots
            .iter()
            .find(|known| known.plan.id == robot)
            .ok_or_else(|| {
                Problem::not_found(format!(
                    "there is no robot `{}` in cell `{cell}`",
                    shown(robot)
                ))
            })
    }
}

/// The beginning of a text from outside, safe to repeat.
pub(crate) fn shown(name: &str) -> String {
    name.chars()
        .take(64)
        .flat_map(char::escape_default)
        .collect()
}
