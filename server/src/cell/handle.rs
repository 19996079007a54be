use std::sync::Arc;

use jiff::Timestamp;
use journal::{Claim, Position};
use tokio::sync::{mpsc, oneshot, watch};
use uuid::Uuid;
use workflow::{Cell, Input, Refusal, Reply};

use super::clock::CellClock;
use super::ids::Ids;
use super::places::{Places, Span};
use super::told::TellTimes;
use crate::clock::WallClock;
use crate::journal::Trouble;

/// A way to a cell's driver.
#[derive(Clone, Debug)]
pub(crate) struct CellHandle {
    asks: mpsc::Sender<Ask>,
    view: watch::Receiver<Arc<Cell>>,
    clock: CellClock,
    places: Places,
    pub(super) told: TellTimes,
}

/// Something for the driver.
#[derive(Debug)]
pub(super) struct Ask {
    pub(super) input: Input,
    /// The caller's key: asked with it again, the cell does nothing and says so.
    pub(super) claim: Option<Claim>,
    /// Absent where nobody waits: an arm was looked at, an operation ended.
    pub(super) answer: Option<oneshot::Sender<Result<Told, Refused>>>,
}

/// What a caller is told.
#[derive(Clone, Debug, Eq, PartialEq)]
pub(crate) struct Told {
    pub(crate) reply: Reply,
    /// The key stands for an earlier request, and nothing was done this time.
    pub(crate) replayed: bool,
}

/// Why an input had no effect.
#[derive(Clone, Debug)]
pub(crate) enum Refused {
    /// The cell says no.
    Cell(Refusal),
    /// It could not be kept, so it does not hold.
    NotKept(Trouble),
    /// Too many are waiting.
    Busy,
    /// The server is stopping.
    Stopping,
}

impl CellHandle {
    pub(super) fn new(
        asks: mpsc::Sender<Ask>,
        view: watch::Receiver<Arc<Cell>>,
        clock: CellClock,
        places: Places,
        told: TellTimes,
    ) -> Self {
        Self {
            asks,
            view,
            clock,
            places,
            told,
        }
    }

    /// Asks the cell for something. When this returns `Ok`, it is durable.
    pub(crate) async fn ask(&self, input: Input) -> Result<Reply, Refused> {
        self.put(input, None).await.map(|told| told.reply)
    }

    /// Asks the cell for something under a key, which is kept in the same record as what follows from it. Asked with
    /// the same key and body again, over a restart too, nothing is done and the earlier reply comes back.
    pub(crate) async fn ask_with(&self, input: Input, claim: Claim) -> Result<Told, Refused> {
        self.put(input, Some(claim)).await
    }

    async fn put(&self, input: Input, claim: Option<Claim>) -> Result<Told, Refused> {
        let (answer, answered) = oneshot::channel();
        let ask = Ask {
            input,
            claim,
            answer: Some(answer),
        };
        self.asks.try_send(ask).map_err(|error| match error {
            mpsc::error::TrySendError::Full(_) => Refused::Busy,
            mpsc::error::TrySendError::Closed(_) => Refused::Stopping,
        })?;
        answered.await.unwrap_or(Err(Refused::Stopping))
    }

    /// Whether the cell would take this now. Nothing is done, and nothing is kept.
    pub(crate) fn would_take(
        &self,
        input: Input,
        wall: &Arc<dyn WallClock>,
    ) -> Result<(), Refused> {
        let mut ids = Ids::new(Arc::clone(wall));
        let decided = self.view().decide(self.clock.now(), input, &mut ids);
        decided.map(drop).map_err(Refused::Cell)
    }

    /// The cell's clock, which its deadlines and timers are on.
    pub(crate) fn clock(&self) -> &CellClock {
        &self.clock
    }

    /// Where in the journal a job's facts are.
    pub(crate) fn span(&self, job: Uuid) -> Option<Span> {
        self.places.of(job)
    }

    /// The first record that an open job, session or question needs to be told as a whole.
    pub(crate) fn first_needed(&self) -> Option<Position> {
        let view = self.view();
        self.places.first_needed(|job| view.is_open(job))
    }

    /// The records up to `last` were removed.
    pub(crate) fn forget_through(&self, last: Position) {
        self.places.forget_through(last);
    }

    /// The cell as it is now.
    pub(crate) fn view(&self) -> Arc<Cell> {
        Arc::clone(&self.view.borrow())
    }

    /// The cell as it changes.
    pub(crate) fn watch(&self) -> watch::Receiver<Arc<Cell>> {
        self.view.clone()
    }

    /// Notes that a mobile robot was heard.
    pub(crate) fn heard(&self, mobile_robot: &str, at: Timestamp) {
        self.told.heard(mobile_robot, at);
    }

    /// When a mobile robot was last heard, in this process.
    pub(crate) fn heard_at(&self, mobile_robot: &str) -> Option<Timestamp> {
        self.told.heard_at(mobile_robot)
    }
}
