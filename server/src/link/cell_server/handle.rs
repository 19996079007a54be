use std::fmt;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};

use api::StopEffect;
use protocol::v2::{FinishStatus, Percent, StatusLine, Verb};
use tokio::sync::{Notify, mpsc, oneshot, watch};
use tokio_util::sync::CancellationToken;
use tokio_util::task::TaskTracker;

use super::command_task::{CommandTask, Queued};
use super::error::LinkError;
use super::follow::Follower;
use super::judge::Open;
use super::order::{Instruction, MotionEnd, MotionObserver, MotionOrder};
use super::plan::CellServerPlan;
use super::status_task::{Ask, StatusTask, Wanted};
use super::view::ControllerView;
use crate::link::{Connector, Turned};

/// Requests that may wait for the status port. Each waits for one line; a poll comes between.
const ASKS: usize = 16;

/// A handle on the link to a tier-2 controller.
#[derive(Clone)]
pub(crate) struct CellServerLink {
    shared: Arc<Shared>,
    queue: mpsc::Sender<Queued>,
}

/// What the tasks and the handles share.
pub(super) struct Shared {
    pub(super) plan: CellServerPlan,
    pub(super) view: watch::Sender<ControllerView>,
    /// Counts the stops asked for. An order queued before the last one is not sent.
    pub(super) stops: watch::Sender<u64>,
    /// Asks for a status line now rather than at the next poll.
    pub(super) nudge: Notify,
    /// Whether anything was queued in this generation of the link.
    pub(super) used: AtomicBool,
    asks: mpsc::Sender<Ask>,
    /// Stops have a way of their own.
    urgent: mpsc::Sender<Ask>,
}

/// A stop the controller has confirmed.
#[cfg_attr(
    not(test),
    expect(
        dead_code,
        reason = "part of the report; so far only its tests read all of it"
    )
)]
#[derive(Clone, Copy, Debug)]
pub(crate) struct StopReport {
    pub(crate) effect: StopEffect,
    /// The controller right after it took the stop: the arm may still be slowing down.
    pub(crate) status: StatusLine,
}

/// A fence the controller has confirmed: nothing numbered before it will ever start.
#[cfg_attr(
    not(test),
    expect(
        dead_code,
        reason = "part of the report; so far only its tests read all of it"
    )
)]
#[derive(Clone, Copy, Debug)]
pub(crate) struct Fenced {
    /// The epoch of the orders from now on.
    pub(crate) wire_epoch: u32,
    pub(crate) status: StatusLine,
}

/// Starts the two tasks of a link. They end once `stop` is cancelled; a motion in flight is followed for a short while
/// longer.
///
/// `base_epoch` is the journal's: at most 2147482, each start of the server a higher one.
pub(crate) fn spawn<C: Connector, O: MotionObserver>(
    plan: CellServerPlan,
    connector: Arc<C>,
    observer: Arc<O>,
    base_epoch: u64,
    tracker: &TaskTracker,
    stop: CancellationToken,
) -> CellServerLink {
    let (asks, asked) = mpsc::channel(ASKS);
    let (urgent, urgently_asked) = mpsc::channel(ASKS);
    let (queue, orders) = mpsc::channel(plan.queue_capacity);
    let shared = Arc::new(Shared {
        plan,
        view: watch::Sender::new(ControllerView::new()),
        stops: watch::Sender::new(0),
        nudge: Notify::new(),
        used: AtomicBool::new(false),
        asks,
        urgent,
    });
    // The status task outlives the command task, which needs it to the end.
    let status_stop = CancellationToken::new();
    let status = StatusTask::new(
        Arc::clone(&shared),
        Arc::clone(&connector),
        base_epoch,
        status_stop.clone(),
    );
    drop(tracker.spawn(status.run(asked, urgently_asked)));
    let commands = CommandTask {
        shared: Arc::clone(&shared),
        connector,
        observer,
        stop,
        seed_fenced: None,
    };
    drop(tracker.spawn(async move {
        let _ended = status_stop.drop_guard();
        commands.run(orders).await;
    }));
    CellServerLink { shared, queue }
}

impl CellServerLink {
    /// What is known of the controller, as it changes.
    pub(crate) fn watch(&self) -> watch::Receiver<ControllerView> {
        self.shared.view.subscribe()
    }

    /// What is known of the controller now.
    pub(crate) fn view(&self) -> ControllerView {
        self.shared.view.borrow().clone()
    }

    /// Queues an order, or says at once that there is no room: then it is proven not sent.
    pub(crate) fn submit(&self, order: MotionOrder) -> Result<(), Turned> {
        let stops = *self.shared.stops.borrow();
        self.shared.used.store(true, Ordering::SeqCst);
        let queued = Queued { order, stops };
        let submitted = self.queue.try_send(queued).map_err(|error| match error {
            mpsc::error::TrySendError::Full(_) => Turned::Busy,
            mpsc::error::TrySendError::Closed(_) => Turned::Stopping,
        });
        self.shared.plan.metrics.queued(self.depth().0);
        submitted
    }

    /// Orders waiting, and how many may.
    pub(crate) fn depth(&self) -> (usize, usize) {
        let capacity = self.queue.max_capacity();
        (capacity - self.queue.capacity(), capacity)
    }

    /// Whether the link takes orders.
    pub(crate) fn is_running(&self) -> bool {
        !self.queue.is_closed()
    }

    /// Stops the arm. What waits in the queue is not sent; what moves is slowed down and ends as interrupted. It goes
    /// over the status port at once and waits behind nothing.
    ///
    /// # Errors
    /// The controller has not confirmed it; the error says what it does all the same.
    pub(crate) async fn stop(&self) -> Result<StopReport, LinkError> {
        self.shared.stops.send_modify(|stops| *stops += 1);
        match self.shared.ask_urgently(Wanted::Verb(Verb::Stop)).await {
            Ok(status) => Ok(StopReport {
                effect: StopEffect::HaltsMotion,
                status,
            }),
            Err(source) => {
                let effect = if matches!(source, LinkError::Unconfirmed { .. }) {
                    StopEffect::HaltsMotion
                } else {
                    StopEffect::IssuesNothingMore
                };
                Err(LinkError::StopUnconfirmed {
                    effect,
                    source: Box::new(source),
                })
            }
        }
    }

    /// Holds the running motion.
    ///
    /// # Errors
    /// The controller has not confirmed it.
    pub(crate) async fn hold(&self) -> Result<StatusLine, LinkError> {
        self.shared.ask(Wanted::Verb(Verb::Hold)).await
    }

    /// Lets the motion on hold go on.
    ///
    /// # Errors
    /// The controller has not confirmed it.
    pub(crate) async fn resume(&self) -> Result<StatusLine, LinkError> {
        self.shared.ask(Wanted::Verb(Verb::Continue)).await
    }

    /// Sets the general override.
    ///
    /// # Errors
    /// The controller has not confirmed it.
    pub(crate) async fn set_override(&self, percent: Percent) -> Result<StatusLine, LinkError> {
        self.shared.ask(Wanted::Verb(Verb::Override(percent))).await
    }

    /// Fences the controller with the next epoch: nothing that was numbered before will start. A motion that runs
    /// goes on.
    ///
    /// # Errors
    /// The controller has not confirmed it.
    pub(crate) async fn fence(&self) -> Result<Fenced, LinkError> {
        let status = self.shared.ask(Wanted::Fence).await?;
        Ok(Fenced {
            wire_epoch: status.epoch_max,
            status,
        })
    }

    /// What became of a command of an earlier epoch, by what the controller says behind a fence. It waits for a
    /// motion that still runs.
    ///
    /// # Errors
    /// The controller is not connected, or could not be fenced.
    pub(crate) async fn reconcile(&self, open: Open) -> Result<MotionEnd, LinkError> {
        let mut watch = self.watch();
        let (connected, wire_epoch) = {
            let view = watch.borrow();
            (view.is_connected(), view.wire_epoch)
        };
        if !connected {
            return Err(self.shared.status_down());
        }
        if wire_epoch.is_none_or(|epoch| epoch <= open.number.epoch) {
            let _fenced = self.fence().await?;
        }
        let mut follower = Follower::new(&self.shared.plan, open);
        loop {
            let look = follower.look(&watch.borrow_and_update());
            if let Some(end) = look.end {
                let is_seed = matches!(open.command, Instruction::Seed(_));
                return Ok(self.shared.concluded(end, is_seed).await);
            }
            let again = follower.deadline();
            tokio::select! {
                changed = watch.changed() => {
                    // The sender lives as long as this handle.
                    let _ = changed;
                }
                () = at(again) => {}
            }
        }
    }
}

/// Waits for a time, or for ever.
pub(super) async fn at(when: Option<tokio::time::Instant>) {
    match when {
        Some(when) => tokio::time::sleep_until(when).await,
        None => std::future::pending().await,
    }
}

impl Shared {
    /// Has the status task carry something out; the status line that answers it.
    pub(super) async fn ask(&self, wanted: Wanted) -> Result<StatusLine, LinkError> {
        self.ask_over(&self.asks, wanted).await
    }

    async fn ask_urgently(&self, wanted: Wanted) -> Result<StatusLine, LinkError> {
        self.ask_over(&self.urgent, wanted).await
    }

    async fn ask_over(
        &self,
        asks: &mpsc::Sender<Ask>,
        wanted: Wanted,
    ) -> Result<StatusLine, LinkError> {
        let (answer, answered) = oneshot::channel();
        let ask = Ask { wanted, answer };
        asks.try_send(ask).map_err(|error| match error {
            mpsc::error::TrySendError::Full(_) => LinkError::Busy,
            mpsc::error::TrySendError::Closed(_) => LinkError::Stopping,
        })?;
        answered.await.unwrap_or(Err(LinkError::Stopping))
    }

    /// What an alarm has interrupted goes on when the alarm is reset, unless the program that moves is ended: the
    /// cell server does that by itself, the seed's pose server has to be told.
    pub(super) async fn concluded(&self, end: MotionEnd, is_seed: bool) -> MotionEnd {
        let MotionEnd::Interrupted {
            fin_status: FinishStatus::Alarm,
            status,
        } = end
        else {
            return end;
        };
        if !is_seed {
            return end;
        }
        match self.ask(Wanted::Verb(Verb::Stop)).await {
            Ok(_ended) => end,
            Err(error) => MotionEnd::InDoubt {
                error,
                status: Some(status),
            },
        }
    }

    pub(super) fn status_down(&self) -> LinkError {
        LinkError::StatusDown {
            address: self.plan.status.to_string(),
        }
    }
}

impl fmt::Debug for CellServerLink {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("CellServerLink")
            .field("robot", &self.shared.plan.robot)
            .field("depth", &self.depth())
            .finish_non_exhaustive()
    }
}
