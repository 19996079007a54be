use std::future::Future;

use protocol::v2::{Command, ErrorCode, FinishStatus, MotionNumber, StatusLine};
use protocol::{Reply, WireMove};
use tokio::time::Instant;
use uuid::Uuid;

use super::error::LinkError;
use crate::request_id::RequestId;

/// What a controller is told, in the words of the program on its command port.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Instruction {
    /// To the cell server: with a number, a nonce and a checksum.
    Numbered(Command),
    /// To the seed's pose server: eight numbers. Its number stays here and orders the journal; the wire has no room for
    /// it.
    Seed(WireMove),
}

impl From<Command> for Instruction {
    fn from(command: Command) -> Self {
        Self::Numbered(command)
    }
}

/// A command whose intent is durable: it may be sent, once.
#[derive(Clone, Debug)]
pub(crate) struct MotionOrder {
    /// The motion's id.
    pub(crate) motion: Uuid,
    /// The wire epoch it was numbered in. In any other it is not sent.
    pub(crate) wire_epoch: u32,
    /// Its number in that epoch, from 1, rising.
    pub(crate) seq: u32,
    pub(crate) command: Instruction,
    /// Nothing is sent from here on.
    pub(crate) not_after: Instant,
    pub(crate) request_id: RequestId,
}

impl MotionOrder {
    pub(crate) fn number(&self) -> MotionNumber {
        MotionNumber {
            epoch: self.wire_epoch,
            seq: self.seq,
        }
    }
}

/// Is told what becomes of the orders of a link: by the link's one task, in order. The next command is not sent
/// before `ended` has returned.
pub(crate) trait MotionObserver: Send + Sync + 'static {
    /// Whether the motion is still wanted. Asked before its turn and once more before its first byte.
    fn may_begin(&self, motion: Uuid) -> bool {
        let _ = motion;
        true
    }
    /// From here on bytes may be on their way.
    fn dispatched(&self, motion: Uuid) -> impl Future<Output = ()> + Send;
    /// The controller has stored the number; the seed's pose server has said that it moves.
    fn accepted(&self, motion: Uuid) -> impl Future<Output = ()> + Send;
    /// The arm was seen moving. A short motion may end without it.
    fn executing(&self, motion: Uuid) -> impl Future<Output = ()> + Send;
    /// The end, as far as can be known. Not called for a motion the server leaves in flight when it stops: its intent
    /// stays open, and the next start asks the controller.
    fn ended(&self, motion: Uuid, end: MotionEnd) -> impl Future<Output = ()> + Send;
}

/// What became of an order.
#[derive(Debug)]
pub(crate) enum MotionEnd {
    /// Seen at the target and standing still.
    Arrived { status: StatusLine },
    /// The controller refused it: nothing was stored, nothing happened.
    Rejected { code: Rejection, text: String },
    /// Proven not executed: it was not sent, or the controller's own record, behind a fence, shows that it was not
    /// taken and never will be.
    NotSent { error: LinkError },
    /// The controller ended it before the target. `status` says where the arm stands.
    Interrupted {
        fin_status: FinishStatus,
        status: StatusLine,
    },
    /// It cannot be known. Never sent again; a person looks.
    InDoubt {
        error: LinkError,
        status: Option<StatusLine>,
    },
}

/// How the controller refused.
#[derive(Clone, Copy, Debug, Eq, PartialEq)]
pub(crate) enum Rejection {
    /// The epoch is below the highest it has seen.
    Stale { epoch_max: u32 },
    /// Another motion runs.
    Busy(MotionNumber),
    /// An error code.
    Error(ErrorCode),
    /// A text of the seed's pose server.
    Seed(Reply),
}
