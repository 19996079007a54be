//! Hand-over sessions (SM-7): one for each point at a time.

use serde::{Deserialize, Serialize};
use uuid::Uuid;

use crate::fact::Rewind;
use crate::faults::Fault;
use crate::setup::BasePose;

/// States of a session. IDLE is: no session.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize, Deserialize)]
#[serde(rename_all = "SCREAMING_SNAKE_CASE")]
pub enum SessionState {
    /// The point is claimed.
    Reserved,
    /// The mobile robot asked for access by taking the order.
    AccessPending,
    /// The zone is free of arms: `MR_MOVE_PERMIT`.
    AccessGranted,
    /// It is at the point and docks: `MR_MOVE_PERMIT`.
    Positioned,
    /// It stands, at the right pose.
    Docked,
    /// It waits, and its loads are right.
    TransferReady,
    /// The arm works: `ARM_ENTRY_PERMIT`.
    Transferring,
    /// The arm is out.
    TransferDone,
    /// It may go: `MR_MOVE_PERMIT`.
    ExitGranted,
    /// It is out.
    Exited,
    /// Closed.
    Released,
    /// Something is wrong: no permit.
    Faulted,
    /// The order was taken back; waiting until the mobile robot is away for certain.
    Canceling,
    /// Closed without a transfer.
    Canceled,
}

impl SessionState {
    /// Nothing more happens in it.
    #[must_use]
    pub const fn is_closed(self) -> bool {
        matches!(self, Self::Released | Self::Canceled)
    }

    /// Where a faulted session goes on: the last state that promises nothing.
    #[must_use]
    pub const fn last_safe(self) -> Self {
        match self {
            Self::AccessGranted | Self::Positioned | Self::AccessPending => Self::AccessPending,
            Self::TransferReady | Self::Transferring | Self::Docked => Self::Docked,
            Self::ExitGranted | Self::TransferDone => Self::TransferDone,
            Self::Reserved
            | Self::Exited
            | Self::Released
            | Self::Faulted
            | Self::Canceling
            | Self::Canceled => self,
        }
    }

    /// The transitions of the table.
    #[must_use]
    pub const fn may_become(self, to: Self) -> bool {
        match to {
            Self::Reserved => matches!(
                self,
                Self::AccessPending
                    | Self::AccessGranted
                    | Self::Positioned
                    | Self::Docked
                    | Self::TransferReady
                    | Self::Canceling
                    | Self::Faulted
            ),
            Self::AccessPending => matches!(self, Self::Reserved | Self::Faulted),
            Self::AccessGranted => matches!(self, Self::AccessPending),
            Self::Positioned => matches!(self, Self::AccessGranted),
            Self::Docked => matches!(self, Self::Positioned | Self::Faulted),
            Self::TransferReady => matches!(self, Self::Docked),
            Self::Transferring => matches!(self, Self::TransferReady),
            Self::TransferDone => {
                matches!(
                    self,
                    Self::Transferring | Self::Docked | Self::TransferReady | Self::Faulted
                )
            }
            Self::ExitGranted => matches!(self, Self::TransferDone | Self::Canceling),
            Self::Exited => !matches!(self, Self::Released | Self::Canceled | Self::Exited),
            Self::Released => matches!(self, Self::Exited),
            Self::Faulted => !self.is_closed(),
            Self::Canceling => !matches!(self, Self::Transferring) && !self.is_closed(),
            Self::Canceled => matches!(self, Self::Reserved | Self::Canceling | Self::Exited),
        }
    }

    /// The mobile robot stands at the point and is not supposed to move.
    #[must_use]
    pub const fn is_docked(self) -> bool {
        matches!(
            self,
            Self::Docked | Self::TransferReady | Self::Transferring
        )
    }
}

/// A session.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[expect(
    clippy::struct_excessive_bools,
    reason = "each is one thing the mobile robot has said"
)]
pub(crate) struct Session {
    pub id: Uuid,
    pub number: u64,
    pub point: String,
    pub job: Uuid,
    pub mobile_robot: String,
    pub state: SessionState,
    /// While FAULTED: where it was, and why.
    pub faulted: Option<(SessionState, Fault)>,
    pub order: Option<Uuid>,
    pub update: u32,
    pub assigned: bool,
    pub arrived: bool,
    /// The pose it reported with `MR_DOCKED`.
    pub docked: Option<BasePose>,
    pub ready: bool,
    pub cleared: bool,
    /// ASSUMPTION: a mobile robot that once reported this order reports it until the order is over.
    /// It repeats the order it works on in its state; then a state without it means that it was dropped.
    pub echoes: bool,
    /// It was seen driving out.
    pub left: bool,
    pub dock_tries: u8,
    /// It was told to give docking up and to drive out.
    pub backs_out: bool,
    pub measured_accepted: bool,
    /// How often the request of this state was sent again.
    pub resends: u8,
}

impl Session {
    /// A session that has just claimed its point.
    pub(crate) fn reserved(
        id: Uuid,
        number: u64,
        job: Uuid,
        point: &str,
        mobile_robot: &str,
    ) -> Self {
        Self {
            id,
            number,
            point: point.to_owned(),
            job,
            mobile_robot: mobile_robot.to_owned(),
            state: SessionState::Reserved,
            faulted: None,
            order: None,
            update: 0,
            assigned: false,
            arrived: false,
            docked: None,
            ready: false,
            cleared: false,
            echoes: false,
            left: false,
            dock_tries: 0,
            backs_out: false,
            measured_accepted: false,
            resends: 0,
        }
    }

    /// As if it had not docked yet, or not even been ordered.
    pub(crate) fn rewind(&mut self, to: Rewind) {
        (self.docked, self.ready, self.measured_accepted) = (None, false, false);
        self.backs_out = false;
        if to == Rewind::Order {
            (self.order, self.update) = (None, 0);
            (self.assigned, self.arrived, self.cleared) = (false, false, false);
            (self.left, self.echoes, self.dock_tries) = (false, false, 0);
        }
    }
}
