use std::collections::BTreeMap;
use std::sync::Arc;

use api::{LinkState, Tier};
use axum::http::Uri;
use kinematics::PendantJoints;
use tokio::sync::Semaphore;
use tokio_util::sync::CancellationToken;
use tokio_util::task::TaskTracker;

use crate::authority::{AtLoss, CellControl, EpochStore, LeaseClock};
use crate::cell::{self, CellHandle};
use crate::clock::WallClock;
use crate::config::{CellPlan, Plan, RobotPlan, ServerPlan};
use crate::events::Events;
use crate::identity::{AuditSink, Identity, Refusals};
use crate::journal::{AuditHealth, JournalAudit, JournalEpochs, Retaining, SharedJournal};
use crate::link::cell_server::{self, CellServerLink, CellServerPlan};
use crate::link::{self, Connector, Link, Owner};
use crate::metrics::{LinkMetrics, Metrics};
use crate::motions::{self, InFlight, Motions};
use crate::problem::Problem;
use crate::serve::ServeError;
use crate::setup::SetupBook;
use crate::simulation::JobSimulator;

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
    pub(crate) audit_health: AuditHealth,
    /// Keeps refused requests from flooding the audit.
    pub(crate) refusals: Refusals,
    /// Places for streams of events.
    pub(crate) streams: Arc<Semaphore>,
    /// Places for bodies that are larger than most.
    pub(crate) large_bodies: Arc<Semaphore>,
    /// One place for what computes for long: all else goes on beside it.
    pub(crate) computing: Arc<Semaphore>,
    pub(crate) journal: SharedJournal,
    pub(crate) keys: InFlight,
    /// What happens, for streams.
    pub(crate) events: Events,
    /// What plays jobs in virtual time, if anything does.
    pub(crate) simulator: Option<Arc<dyn JobSimulator>>,
    /// The place for one simulation.
    pub(crate) simulating: Semaphore,
}

/// How many large bodies are read and worked on at a time.
const LARGE_BODIES: usize = 4;

#[derive(Debug)]
pub(crate) struct Cell {
    pub(crate) id: String,
    pub(crate) name: String,
    pub(crate) control: Arc<CellControl>,
    pub(crate) robots: Vec<Arc<Robot>>,
    pub(crate) setup: Arc<SetupBook>,
    /// Jobs, hand-over sessions, mobile robots, custody.
    pub(crate) work: CellHandle,
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
    /// The seed's pose server alone.
    Seed(Link),
    /// A status program is beside it: the cell server's own, or that of the pose server.
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

impl Robot {
    /// Where the arm is, as its controller reports it.
    ///
    /// # Errors
    /// Why that is not known, in a sentence.
    pub(crate) fn actual_joints(&self) -> Result<PendantJoints, String> {
        match &self.link {
            RobotLink::Seed(_) => Err(format!(
                "the controller of `{}` reports no position; the target it last accepted is not where the arm is",
                self.plan.id
            )),
            RobotLink::CellServer(link) => motions::actual(self, link)
                .map(|actual| actual.joints)
                .map_err(|problem| problem.detail().to_owned()),
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

/// Takes up the motions of earlier processes, and has those asked about that may have been under way.
async fn take_up(
    journal: &SharedJournal,
    robots: Vec<Arc<Robot>>,
    tracker: &TaskTracker,
    stop: &CancellationToken,
) -> Result<(), ServeError> {
    let all: Vec<_> = robots
        .iter()
        .map(|robot| Arc::clone(&robot.motions))
        .collect();
    motions::recover(journal, &all)
        .await
        .map_err(ServeError::Journal)?;
    for robot in robots {
        if let RobotLink::CellServer(link) = &robot.link {
            let motions = Arc::clone(&robot.motions);
            drop(tracker.spawn(motions.reconcile(link.clone(), stop.clone())));
        }
    }
    Ok(())
}

/// What is told when control is lost.
fn at_loss(robots: &[Arc<Robot>], tracker: &TaskTracker) -> Arc<AtLoss> {
    let robots = robots.iter().map(|robot| {
        let link = match &robot.link {
            RobotLink::Seed(_) => None,
            RobotLink::CellServer(link) => Some(link.clone()),
        };
        (Arc::clone(&robot.motions), link)
    });
    Arc::new(AtLoss {
        robots: robots.collect(),
        tracker: tracker.clone(),
    })
}

/// What a robot's parts are made of.
struct RobotParts<'a, C> {
    metrics: &'a Metrics,
    connector: &'a Arc<C>,
    clock: &'a Arc<dyn WallClock>,
    journal: &'a SharedJournal,
    tracker: &'a TaskTracker,
    stop: &'a CancellationToken,
}

impl<C: Connector> RobotParts<'_, C> {
    fn start(&self, plan: RobotPlan) -> Arc<Robot> {
        let plan = Arc::new(plan);
        let motions = Arc::new(Motions::new(
            Arc::clone(&plan),
            Arc::clone(self.clock),
            self.journal.clone(),
            self.tracker.clone(),
        ));
        let metrics = self.metrics.link(&plan);
        let link = match plan.tier {
            Tier::Seed => {
                let owner = Owner {
                    plan: Arc::clone(&plan),
                    motions: Arc::clone(&motions),
                    connector: Arc::clone(self.connector),
                    metrics: metrics.clone(),
                };
                RobotLink::Seed(link::spawn(owner, self.tracker, self.stop.clone()))
            }
            Tier::SeedStatus | Tier::CellServer => RobotLink::CellServer(cell_server::spawn(
                CellServerPlan::of(&plan, self.metrics.controller_link(&plan)),
                Arc::clone(self.connector),
                Arc::clone(&motions),
                self.journal.epoch().0,
                self.tracker,
                self.stop.clone(),
            )),
        };
        Arc::new(Robot {
            plan,
            link,
            motions,
            metrics,
        })
    }
}

/// A cell whose robots' links run, and whose work has not begun.
struct Ready {
    id: String,
    name: String,
    control: Arc<CellControl>,
    robots: Vec<Arc<Robot>>,
    setup: Arc<SetupBook>,
    push_urls: BTreeMap<String, Uri>,
}

impl Ready {
    fn of<C: Connector>(
        plan: CellPlan,
        control: Arc<CellControl>,
        parts: &RobotParts<'_, C>,
    ) -> Result<Self, ServeError> {
        let robots: Vec<_> = plan
            .robots
            .into_iter()
            .map(|plan| parts.start(plan))
            .collect();
        let plans = robots.iter().map(|robot| Arc::clone(&robot.plan)).collect();
        let setup = SetupBook::open(plan.setup.as_ref(), plans);
        Ok(Self {
            id: plan.id,
            name: plan.name,
            control,
            robots,
            setup: Arc::new(setup.map_err(ServeError::Setup)?),
            push_urls: plan.push_urls,
        })
    }

    /// Starts the cell's work, after what its robots were doing was taken up.
    async fn start<C: Connector>(
        self,
        parts: &RobotParts<'_, C>,
        keys: &InFlight,
    ) -> Result<Cell, ServeError> {
        let work = cell::Parts {
            id: &self.id,
            robots: &self.robots,
            setup: &self.setup,
            control: &self.control,
            journal: parts.journal,
            wall: parts.clock,
            keys,
            tracker: parts.tracker,
            stop: parts.stop,
        };
        let work = work.start().await.map_err(ServeError::Cell)?;
        self.control.observe(at_loss(&self.robots, parts.tracker));
        let outboxes = cell::Outboxes::new(work.clone(), Arc::clone(&self.setup));
        for (robot, url) in self.push_urls {
            let pushing = cell::push(robot, url.to_string(), outboxes.clone(), parts.stop.clone());
            drop(parts.tracker.spawn(pushing));
        }
        Ok(Cell {
            id: self.id,
            name: self.name,
            control: self.control,
            robots: self.robots,
            setup: self.setup,
            work,
        })
    }
}

impl App {
    /// Takes up what the journal knows, and starts the links. They end once `stop` is cancelled; `tracker` waits for them.
    pub(crate) async fn start<C: Connector>(
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
        let journal = seams.journal;
        let parts = RobotParts {
            metrics: &metrics,
            connector: &connector,
            clock: &clock,
            journal: &journal,
            tracker,
            stop,
        };
        let audit = JournalAudit::spawn(
            journal.clone(),
            Arc::clone(&clock),
            plan.server.shutdown_timeout,
            tracker,
            stop.clone(),
        );
        let audit_health = audit.health();
        let audit: Arc<dyn AuditSink> = Arc::new(audit);
        let epochs: Arc<dyn EpochStore> = Arc::new(JournalEpochs::new(journal.clone()));
        let start_control = |cell: &str| {
            let time = LeaseClock::new(Arc::clone(&clock));
            let control = CellControl::new(cell, time, Arc::clone(&epochs), Arc::clone(&audit));
            let control = Arc::new(control);
            drop(tracker.spawn(Arc::clone(&control).keep_time(stop.clone())));
            control
        };
        let ready: Vec<_> = plan
            .cells
            .into_iter()
            .map(|cell| {
                let control = start_control(&cell.id);
                Ready::of(cell, control, &parts)
            })
            .collect::<Result<_, ServeError>>()?;

        let robots = ready.iter().flat_map(|cell| &cell.robots);
        take_up(&journal, robots.cloned().collect(), tracker, stop).await?;
        let keys = InFlight::default();
        let mut cells = Vec::with_capacity(ready.len());
        for cell in ready {
            cells.push(cell.start(&parts, &keys).await?);
        }
        let watched = cells
            .iter()
            .map(|cell: &Cell| (Arc::from(&*cell.id), cell.work.clone()));
        let events = Events::start(
            journal.clone(),
            clock.now(),
            watched.collect(),
            tracker,
            stop.clone(),
        );
        let retaining = Retaining {
            journal: journal.clone(),
            clock: Arc::clone(&clock),
            cells: cells
                .iter()
                .map(|cell| (cell.id.clone(), cell.work.clone()))
                .collect(),
        };
        drop(tracker.spawn(retaining.run(stop.clone())));
        let (cell, robot) = plan.legacy;
        let legacy = cells.get(cell).and_then(|cell| cell.robots.get(robot));
        let Some(legacy) = legacy.map(Arc::clone) else {
            unreachable!("a plan's legacy robot is one of its robots");
        };
        Ok(Self {
            streams: Arc::new(Semaphore::new(plan.server.max_event_streams)),
            simulator: plan.simulator,
            simulating: Semaphore::new(1),
            large_bodies: Arc::new(Semaphore::new(LARGE_BODIES)),
            computing: Arc::new(Semaphore::new(1)),
            server: plan.server,
            cells,
            legacy,
            metrics,
            clock,
            identity,
            audit,
            audit_health,
            refusals: Refusals::default(),
            events,
            journal,
            keys,
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
