use std::fmt;
use std::future::Future;
use std::pin::Pin;

use tokio::sync::watch;
use uuid::Uuid;
use workflow::{Action, ArmSeen, Millis, OpResult};

/// What an operation comes to, some time.
pub(crate) type Later<T> = Pin<Box<dyn Future<Output = T> + Send>>;

/// One operation of an arm, as the cell decided it.
#[derive(Clone, Debug)]
pub(crate) struct Operation {
    /// Its id: what it is asked for by after a restart.
    pub(crate) op: Uuid,
    pub(crate) job: Uuid,
    pub(crate) action: Action,
}

/// What the driver needs of an arm: operations that end, and what is seen of it.
pub(crate) trait ArmPort: Send + Sync + fmt::Debug {
    /// How long an operation is planned to take, where that can be said beforehand.
    fn expected(&self, operation: &Operation) -> Option<Millis>;

    /// Carries an operation out, once, and says how it ended.
    fn operate(&self, operation: Operation) -> Later<OpResult>;

    /// Finds out what became of an operation of an earlier time.
    fn reconcile(&self, operation: Operation) -> Later<OpResult>;

    /// Stops the arm, and issues nothing more of what waits.
    fn stop(&self) -> Later<()>;

    /// What is seen of the arm, as it changes.
    fn watch(&self) -> watch::Receiver<ArmSeen>;
}
