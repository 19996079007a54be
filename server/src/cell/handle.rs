use std::sync::Arc;

use tokio::sync::{mpsc, oneshot, watch};
use workflow::{Cell, Input, Refusal, Reply};

use super::told::Told;
use crate::journal::Trouble;

/// A way to a cell's driver.
#[derive(Clone, Debug)]
pub(crate) struct CellHandle {
    asks: mpsc::Sender<Ask>,
    view: watch::Receiver<Arc<Cell>>,
    pub(super) told: Told,
}

/// Something for the driver.
#[derive(Debug)]
pub(super) struct Ask {
    pub(super) input: Input,
    /// Absent where nobody waits: an arm was looked at, an operation ended.
    pub(super) answer: Option<oneshot::Sender<Result<Reply, Refused>>>,
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
        told: Told,
    ) -> Self {
        Self { asks, view, told }
    }

    /// Asks the cell for something. When this returns `Ok`, it is durable.
    pub(crate) async fn ask(&self, input: Input) -> Result<Reply, Refused> {
        let (answer, answered) = oneshot::channel();
        let ask = Ask {
            input,
            answer: Some(answer),
        };
        self.asks.try_send(ask).map_err(|error| match error {
            mpsc::error::TrySendError::Full(_) => Refused::Busy,
            mpsc::error::TrySendError::Closed(_) => Refused::Stopping,
        })?;
        answered.await.unwrap_or(Err(Refused::Stopping))
    }

    /// The cell as it is now.
    pub(crate) fn view(&self) -> Arc<Cell> {
        Arc::clone(&self.view.borrow())
    }

    /// The cell as it changes.
    pub(crate) fn watch(&self) -> watch::Receiver<Arc<Cell>> {
        self.view.clone()
    }
}
