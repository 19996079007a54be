use std::sync::Arc;

use api::{LinkState, ProblemCode};
use protocol::v2::{MotionNumber, StatusLine};
use tokio::time::Instant;
use uuid::Uuid;

use super::readiness::NotReady;

/// What a link publishes of its controller.
#[derive(Clone, Debug)]
pub(crate) struct ControllerView {
    /// The state of SM-1: disconnected, connecting, monitor, control, degraded.
    pub(crate) state: LinkState,
    /// The epoch orders must be numbered in: journal epoch * 1000 + link generation. Absent until the first
    /// connection has fenced the controller; kept while disconnected.
    pub(crate) wire_epoch: Option<u32>,
    /// The last status line. It stays when the link is lost; its age tells.
    pub(crate) status: Option<Observed>,
    /// Why no motion is sent now.
    pub(crate) not_ready: Option<NotReady>,
    /// The order being carried out.
    pub(crate) in_flight: Option<InFlight>,
    /// The order carried out last, or now.
    pub(crate) last_motion: Option<Uuid>,
    /// What went wrong last on the link, until it is well again.
    pub(crate) failure: Option<(ProblemCode, Arc<str>)>,
    /// How often the controller was connected.
    pub(crate) connections: u64,
}

/// A status line and when it came.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Observed {
    pub(crate) line: StatusLine,
    pub(crate) at: Instant,
    /// When it was asked for: what it says is not older.
    pub(crate) asked_at: Instant,
    /// Counts the status lines of this link.
    pub(crate) count: u64,
}

/// The order being carried out.
#[derive(Clone, Copy, Debug, Eq, PartialEq)]
pub(crate) struct InFlight {
    pub(crate) motion: Uuid,
    pub(crate) number: MotionNumber,
    pub(crate) phase: Phase,
}

/// How far an order has come.
#[derive(Clone, Copy, Debug, Eq, PartialEq)]
pub(crate) enum Phase {
    /// Bytes may be on their way.
    Dispatched,
    /// The controller has stored its number.
    Accepted,
    /// The arm was seen moving for it.
    Executing,
}

impl ControllerView {
    pub(super) fn new() -> Self {
        Self {
            state: LinkState::Disconnected,
            wire_epoch: None,
            status: None,
            not_ready: Some(NotReady::Disconnected),
            in_flight: None,
            last_motion: None,
            failure: None,
            connections: 0,
        }
    }

    /// Whether the status port is connected.
    pub(crate) fn is_connected(&self) -> bool {
        match self.state {
            LinkState::Monitor | LinkState::Control | LinkState::Degraded => true,
            LinkState::Disconnected
            | LinkState::Connecting
            | LinkState::Untried
            | LinkState::Busy
            | LinkState::Answering => false,
        }
    }
}
