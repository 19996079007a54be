use std::sync::Arc;

use tokio_util::sync::CancellationToken;
use tokio_util::task::TaskTracker;

use crate::authority::{CellControl, EpochStore, LeaseClock, MemoryEpochs};
use crate::clock::WallClock;
use crate::config::{Plan, RobotPlan, ServerPlan};
use crate::identity::{AuditSink, Identity, TracingAudit};
use crate::link::{self, Connector, Link, Owner};
use crate::metrics::{LinkMetrics, Metrics};
use crate::motion_store::MotionStore;
use crate::problem::Problem;
use crate::serve::ServeError;

/// What the handlers work on.
#[derive(Debug)]
pub(crate) struct App {
    pub(crate) server: ServerPlan,
    pub(crate) cells: Vec<Cell>,
    pub(crate) legacy: Arc<Robot>,
    pub(crate) metrics: Metrics,
    pub(crate) clock: Arc<dyn WallClock>,
    pub(crate) identity: Identity,
    pub(crate) audit: Arc<dyn AuditSink>,
}

#[derive(Debug)]
pub(crate) struct Cell {
    pub(crate) id: String,
    pub(crate) name: String,
    pub(crate) control: Arc<CellControl>,
    pub(crate) robots: Vec<Arc<Robot>>,
}

#[derive(Debug)]
pub(crate) struct Robot {
    pub(crate) plan: Arc<RobotPlan>,
    pub(crate) link: Link,
    pub(crate) motions: Arc<MotionStore>,
    pub(crate) metrics: LinkMetrics,
}

/// What the server is given from outside, so that a test can give something else.
#[derive(Clone, Debug)]
pub struct Seams<C> {
    /// How controllers are reached.
    pub connector: C,
    /// What time it is, for the records people read.
    pub clock: Arc<dyn WallClock>,
}

impl App {
    /// Starts the links. They end once `stop` is cancelled; `tracker` waits for them.
    pub(crate) fn start<C: Connector>(
        plan: Plan,
        seams: Seams<C>,
        routes: impl Iterator<Item = String>,
        tracker: &TaskTracker,
        stop: &CancellationToken,
    ) -> Result<Self, ServeError> {
        let metrics = Metrics::new(routes).map_err(ServeError::Metrics)?;
        let identity = plan.identity.ok_or(ServeError::NoIdentity)?;
        let connector = Arc::new(seams.connector);
        let clock = seams.clock;
        let start_robot = |plan: RobotPlan| {
            let plan = Arc::new(plan);
            let motions = Arc::new(MotionStore::new(Arc::clone(&clock)));
            let metrics = metrics.link(&plan);
            let owner = Owner {
                plan: Arc::clone(&plan),
                motions: Arc::clone(&motions),
                connector: Arc::clone(&connector),
                metrics: metrics.clone(),
            };
            Arc::new(Robot {
                link: link::spawn(owner, tracker, stop.clone()),
                plan,
                motions,
                metrics,
            })
        };
        let audit: Arc<dyn AuditSink> = Arc::new(TracingAudit);
        let epochs: Arc<dyn EpochStore> = Arc::new(MemoryEpochs::default());
        let start_control = |cell: &str| {
            let time = LeaseClock::new(Arc::clone(&clock));
            let control = CellControl::new(cell, time, Arc::clone(&epochs), Arc::clone(&audit));
            let control = Arc::new(control);
            drop(tracker.spawn(Arc::clone(&control).keep_time(stop.clone())));
            control
        };
        let cells: Vec<_> = plan
            .cells
            .into_iter()
            .map(|cell| Cell {
                control: start_control(&cell.id),
                id: cell.id,
                name: cell.name,
                robots: cell.robots.into_iter().map(start_robot).collect(),
            })
            .collect();
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
            identity,
            audit,
        })
    }

    pub(crate) fn cell(&self, cell: &str) -> Result<&Cell, Problem> {
        self.cells
            .iter()
            .find(|known| known.id == cell)
            .ok_or_else(|| Problem::not_found(format!("there is no cell `{}`", shown(cell))))
    }

    /// Ends the leases of principals whose tokens were revoked, until `stop` is cancelled.
    pub(crate) async fn end_revoked_leases(self: Arc<Self>, stop: CancellationToken) {
        let Some(mut changes) = self.identity.changes() else {
            return;
        };
        while let Some(Ok(())) = stop.run_until_cancelled(changes.changed()).await {
            let now = self.clock.now();
            for cell in &self.cells {
                let known = |holder: &str| self.identity.knows(holder, now);
                cell.control.revoke_unless(known);
            }
        }
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
