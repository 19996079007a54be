//! The way to a controller: a bounded queue in front of the one task that owns the socket.
//!
//! A command waits in the queue until its turn or its deadline. It is sent at most once; see [`LinkError`] for what
//! is known of it when no answer tells. A caller that goes away does not take its command with it: the command is
//! carried out and recorded, because from outside it cannot be told how far it had come.

pub(crate) mod cell_server;
mod connector;
mod error;
mod owner;
mod seed;
mod tcp;
#[cfg(test)]
mod tests;

use std::fmt;
use std::sync::Arc;

use api::{LinkState, ProblemCode};
use jiff::Timestamp;
use protocol::{Reply, WireMove};
use tokio::sync::{mpsc, oneshot, watch};
use tokio::time::Instant;
use units::MmPerSec;
use uuid::Uuid;

pub use connector::{AddressError, Connector, ControllerAddress};
pub(crate) use error::LinkError;
pub(crate) use owner::{Owner, spawn};
pub use tcp::{TcpConnection, TcpConnector};

use crate::authority::Claim;
use crate::journal::Trouble;
use crate::motions::Permit;
use crate::problem::Problem;
use crate::request_id::RequestId;
use crate::target::{Prepared, Refusal};

/// A handle on a robot's link.
#[derive(Clone, Debug)]
pub(crate) struct Link {
    queue: mpsc::Sender<Job>,
    fences: mpsc::Sender<FenceAnswer>,
    status: watch::Receiver<Status>,
}

/// What a caller wants done.
#[derive(Debug)]
pub(crate) enum Order {
    /// A move that was checked and recorded.
    Move { permit: Permit, prepared: Prepared },
    /// A change to the last accepted target. Only the owner of the link knows that target when the turn comes, so
    /// two of these never count from the same one.
    Delta {
        change: [f64; 6],
        speed: MmPerSec,
        principal: Arc<str>,
        check: TargetCheck,
    },
}

/// What a caller wants looked at once the target of a relative move is known, before anything is recorded or sent.
pub(crate) struct TargetCheck(Box<LookAtTarget>);

type LookAtTarget = dyn FnOnce(&Prepared) -> Result<(), Problem> + Send;

impl TargetCheck {
    pub(crate) fn new(
        look: impl FnOnce(&Prepared) -> Result<(), Problem> + Send + 'static,
    ) -> Self {
        Self(Box::new(look))
    }
}

impl fmt::Debug for TargetCheck {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str("TargetCheck")
    }
}

/// An order in the queue.
#[derive(Debug)]
pub(crate) struct Job {
    order: Order,
    /// When its turn must have come.
    begin_by: Instant,
    /// When its answer must have come.
    deadline: Instant,
    request_id: RequestId,
    claim: Claim,
    answer: oneshot::Sender<Answer>,
}

/// What became of an order.
#[derive(Debug)]
pub(crate) enum Answer {
    /// The controller answered.
    Replied { reply: Reply, sent: WireMove },
    /// No answer that tells.
    Failed {
        /// Absent where no motion came to be recorded.
        motion: Option<Uuid>,
        error: LinkError,
    },
    /// The target of a relative move was refused.
    Refused(Refusal),
    /// The target of a relative move did not pass the caller's check.
    Forbidden(Problem),
    /// A relative move has nothing to count from.
    NoBase(Base),
    /// The intent of a relative move could not be kept; nothing was sent.
    Unkept(Trouble),
}

/// What a relative move counts from.
#[derive(Clone, Copy, Debug, Eq, PartialEq)]
pub(crate) enum Base {
    /// No target was accepted yet.
    Nothing,
    /// The target last accepted.
    Target(WireMove),
    /// A later command is in doubt: the arm may be on its way to either target.
    InDoubt,
}

/// What the owner publishes.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Status {
    pub(crate) state: LinkState,
    pub(crate) last_answer_at: Option<Timestamp>,
    pub(crate) last_failure: Option<ProblemCode>,
    pub(crate) base: Base,
    pub(crate) last_motion: Option<Uuid>,
}

/// Why an order did not get into the queue: proven not sent.
#[derive(Clone, Copy, Debug, Eq, PartialEq)]
pub(crate) enum Turned {
    /// The queue is full.
    Busy,
    /// The server is stopping.
    Stopping,
}

/// Who waits for a fence.
type FenceAnswer = oneshot::Sender<Result<(), LinkError>>;

/// A place in the queue that is not filled yet.
#[derive(Debug)]
pub(crate) struct Place<'a>(mpsc::Permit<'a, Job>);

impl Link {
    /// Takes a place in the queue, or says at once that there is none.
    pub(crate) fn reserve(&self) -> Result<Place<'_>, Turned> {
        match self.queue.try_reserve() {
            Ok(permit) => Ok(Place(permit)),
            Err(mpsc::error::TrySendError::Full(())) => Err(Turned::Busy),
            Err(mpsc::error::TrySendError::Closed(())) => Err(Turned::Stopping),
        }
    }

    /// Sends the controller a message it refuses, after the command in hand, and waits for the refusal.
    ///
    /// The seed program serves one connection after the other: once it has answered, no command sent before is still
    /// on its way to it. That is all a fence can say at this tier. A motion that was accepted runs on, an older
    /// process of the server may still write, and the pendant moves the arm as it likes.
    ///
    /// # Errors
    /// The controller did not refuse it: nothing is proven. A refused connection means that it is busy, not that it
    /// has read everything.
    #[cfg_attr(
        not(test),
        expect(
            dead_code,
            reason = "the motion service fences with it after a restart"
        )
    )]
    pub(crate) async fn fence(&self) -> Result<(), LinkError> {
        let (answer, answered) = oneshot::channel();
        if self.fences.send(answer).await.is_err() {
            return Err(LinkError::Stopping);
        }
        answered.await.unwrap_or(Err(LinkError::Stopping))
    }

    /// The link as it is now.
    pub(crate) fn status(&self) -> Status {
        *self.status.borrow()
    }

    /// Orders waiting, and how many may.
    pub(crate) fn depth(&self) -> (usize, usize) {
        let capacity = self.queue.max_capacity();
        (capacity - self.queue.capacity(), capacity)
    }

    /// Whether the owner task takes orders.
    pub(crate) fn is_running(&self) -> bool {
        !self.queue.is_closed()
    }
}

impl Place<'_> {
    /// Queues an order; the answer comes by `deadline` or shortly after. That none comes means that the owner task is
    /// gone, which only a defect of the server can cause.
    pub(crate) fn send(
        self,
        order: Order,
        begin_by: Instant,
        deadline: Instant,
        request_id: RequestId,
        claim: Claim,
    ) -> oneshot::Receiver<Answer> {
        let (answer, answered) = oneshot::channel();
        self.0.send(Job {
            order,
            begin_by,
            deadline,
            request_id,
            claim,
            answer,
        });
        answered
    }
}
