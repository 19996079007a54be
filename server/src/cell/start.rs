use std::collections::BTreeMap;
use std::ops::ControlFlow;
use std::sync::Arc;

use api::Tier;
use tokio::sync::watch;
use tokio_util::sync::CancellationToken;
use tokio_util::task::TaskTracker;
use workflow::{Input, Setup};

use super::arm::ArmPort;
use super::clock::CellClock;
use super::driver::Driver;
use super::handle::{CellHandle, Refused};
use super::in_use::in_use;
use super::motion_arm::MotionArm;
use super::observe::observe;
use super::recovered::{Recovered, StartError};
use crate::authority::{CellControl, Claim};
use crate::clock::WallClock;
use crate::journal::SharedJournal;
use crate::motions::InFlight;
use crate::setup::{Kept, Resource, SetupBook};
use crate::state::{Robot, RobotLink};

/// The parts a cell works with.
pub(crate) struct Parts<'a> {
    pub(crate) id: &'a str,
    pub(crate) robots: &'a [Arc<Robot>],
    pub(crate) setup: &'a Arc<SetupBook>,
    pub(crate) control: &'a Arc<CellControl>,
    pub(crate) journal: &'a SharedJournal,
    pub(crate) wall: &'a Arc<dyn WallClock>,
    pub(crate) keys: &'a InFlight,
    pub(crate) tracker: &'a TaskTracker,
    pub(crate) stop: &'a CancellationToken,
}

impl Parts<'_> {
    /// Takes up what the journal knows of the cell, and starts its driver. Nothing moves before the recovery has
    /// asked what became of everything that was under way.
    ///
    /// # Errors
    /// The cell's decisions cannot be read or understood.
    pub(crate) async fn start(self) -> Result<CellHandle, StartError> {
        let scales = self.robots.iter().map(|robot| robot.plan.time_scale);
        let scale = scales.fold(1.0, f64::max);
        // Every set-up is itself a decision, so that what comes after it can be folded again.
        let recovered =
            Recovered::read(self.id, Setup::default(), self.journal, self.wall.now()).await?;
        tracing::info!(
            cell.id = self.id,
            decisions = recovered.decisions,
            snapshot_bytes = recovered.snapshot_bytes,
            "the cell's work was taken up"
        );
        let handle = Driver {
            id: self.id.to_owned(),
            journal: self.journal.clone(),
            clock: CellClock::new(self.wall, scale),
            wall: Arc::clone(self.wall),
            arms: self.arms(),
            tracker: self.tracker.clone(),
            stop: self.stop.clone(),
        }
        .spawn(recovered);
        let view = handle.clone();
        let asked = move |part: &Resource| in_use(&view.view(), part);
        self.setup.refuse_while(Arc::new(asked));
        // The first time before anybody is served: a job that is asked for at once finds its point.
        let mut changes = self.setup.watch();
        if tell_setup(self.id, &handle, &mut changes)
            .await
            .is_continue()
        {
            drop(self.tracker.spawn(tell_setups(
                self.id.to_owned(),
                handle.clone(),
                changes,
                self.stop.clone(),
            )));
        }
        drop(self.tracker.spawn(tell_control(
            handle.clone(),
            Arc::clone(self.control),
            self.stop.clone(),
        )));
        Ok(handle)
    }

    /// The arms whose controllers number their commands. The others have no way to say what became of a motion, so
    /// no workflow uses them.
    fn arms(&self) -> BTreeMap<String, Arc<dyn ArmPort>> {
        let numbered = self.robots.iter().filter_map(|robot| match &robot.link {
            RobotLink::CellServer(link) if robot.plan.tier == Tier::CellServer => {
                Some((robot, link))
            }
            RobotLink::CellServer(_) | RobotLink::Seed(_) => None,
        });
        numbered
            .map(|(robot, link)| {
                let control = Claim::of_jobs(Arc::clone(self.control));
                let seen = observe(
                    Arc::clone(robot),
                    link,
                    Arc::clone(self.setup),
                    control.actor().to_owned(),
                    self.tracker,
                    self.stop.clone(),
                );
                let arm = MotionArm {
                    robot: Arc::clone(robot),
                    link: link.clone(),
                    setup: Arc::clone(self.setup),
                    control,
                    keys: self.keys.clone(),
                    seen,
                };
                let port: Arc<dyn ArmPort> = Arc::new(arm);
                (robot.plan.id.clone(), port)
            })
            .collect()
    }
}

/// Tells the cell of every further change to its set-up.
async fn tell_setups(
    id: String,
    handle: CellHandle,
    mut changes: watch::Receiver<Arc<Kept>>,
    stop: CancellationToken,
) {
    while let Some(Ok(())) = stop.run_until_cancelled(changes.changed()).await {
        if tell_setup(&id, &handle, &mut changes).await.is_break() {
            return;
        }
    }
}

/// Tells the cell of its set-up as it is now; breaks when the cell has stopped.
async fn tell_setup(
    id: &str,
    handle: &CellHandle,
    changes: &mut watch::Receiver<Arc<Kept>>,
) -> ControlFlow<()> {
    let wanted = changes.borrow_and_update().setup.for_workflows();
    if *handle.view().setup() == wanted {
        return ControlFlow::Continue(());
    }
    match handle.ask(Input::SetupChanged(Box::new(wanted))).await {
        Ok(_) => tracing::info!(cell.id = id, "the workflows have the new set-up"),
        Err(Refused::Stopping) => return ControlFlow::Break(()),
        Err(refused) => tracing::warn!(
            cell.id = id,
            ?refused,
            "the workflows keep the set-up they had"
        ),
    }
    ControlFlow::Continue(())
}

/// Tells the cell whether its jobs have control: while nobody else holds it.
async fn tell_control(handle: CellHandle, control: Arc<CellControl>, stop: CancellationToken) {
    let mut news = control.watch();
    loop {
        let jobs_may_act = {
            let _seen = news.borrow_and_update();
            control.jobs_may_act()
        };
        if matches!(
            handle.ask(Input::Control { jobs_may_act }).await,
            Err(Refused::Stopping)
        ) {
            return;
        }
        let changed = stop.run_until_cancelled(news.changed()).await;
        if !matches!(changed, Some(Ok(()))) {
            return;
        }
    }
}
