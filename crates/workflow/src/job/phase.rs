//! The phases of both workflows as one table: row, job state, recovery class, timer, fault, undo.

use serde::{Deserialize, Serialize};

use crate::faults::Fault;
use crate::ids::Millis;
use crate::job::params::{NewJob, Workflow};
use crate::timers::Timers;

/// What a step does.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
#[serde(rename_all = "SCREAMING_SNAKE_CASE")]
pub enum Phase {
    /// A1, B1: claims, all or none.
    Reserve,
    /// A2, B2: every pose is planned before anything moves.
    Precheck,
    /// A3, B3: transport order.
    Call,
    /// A4, B5: permit to come in, then wait.
    Await,
    /// A5, B6.
    Dock,
    /// A6.
    VerifyLoad,
    /// B7.
    VerifyEmpty,
    /// A7, B8.
    Permit,
    /// A8, B4: to the load.
    Approach,
    /// A9 **P1**, B4 **Q0**.
    Grip,
    /// A10, B4: lift and leave the zone.
    LiftClear,
    /// A11: the mobile robot may go before the last load is placed.
    ReleaseMr,
    /// A12, B9.
    PlaceApproach,
    /// A13 **P2**, B10 **Q1**.
    Release,
    /// A14, B11.
    Retreat,
    /// B12.
    VerifyOnMr,
    /// A15, B13 and B14 **Q2**: the mobile robot leaves.
    Exit,
    /// B15.
    Transport,
    /// A16, B16.
    Close,
    /// Undo: out of wherever the arm is, without touching a load.
    BackOut,
    /// Undo: no order, no session.
    Dismiss,
}

/// What may be done about a step whose end nobody saw.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "SCREAMING_SNAKE_CASE")]
pub enum Recovery {
    /// Do it again: reading, planning, idempotent.
    Retry,
    /// Read the truth first: motions, grips.
    Reconcile,
    /// It has an inverse.
    Compensate,
    /// Behind a pivot: only forward.
    ForwardOnly,
    /// Never guess.
    Operator,
}

/// `PackML` state of a job while a phase runs.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Shown {
    Starting,
    Execute,
    /// Waiting for somebody outside: SUSPENDED while the arm has nothing to do.
    Waiting,
    Completing,
}

/// One row.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Row {
    pub a: &'static str,
    pub b: &'static str,
    pub shown: Shown,
    pub recovery: Recovery,
    /// The fault if its timer runs out.
    pub late: Fault,
}

impl Phase {
    pub(crate) const fn row(self) -> Row {
        use Recovery::{Compensate, ForwardOnly, Reconcile, Retry};
        use Shown::{Completing, Execute, Starting, Waiting};
        const fn row(
            a: &'static str,
            b: &'static str,
            shown: Shown,
            recovery: Recovery,
            late: Fault,
        ) -> Row {
            Row {
                a,
                b,
                shown,
                recovery,
                late,
            }
        }
        match self {
            Self::Reserve => row("A1", "B1", Starting, Compensate, Fault::Unreachable),
            Self::Precheck => row("A2", "B2", Starting, Retry, Fault::Unreachable),
            Self::Call => row("A3", "B3", Starting, Compensate, Fault::NotAcknowledged),
            Self::Await => row("A4", "B5", Waiting, Compensate, Fault::ArrivalLate),
            Self::Dock => row("A5", "B6", Execute, Compensate, Fault::DockFailed),
            Self::VerifyLoad => row("A6", "", Execute, Retry, Fault::LoadMismatch),
            Self::VerifyEmpty => row("", "B7", Execute, Retry, Fault::SlotOccupied),
            Self::Permit => row("A7", "B8", Execute, Retry, Fault::HeartbeatLost),
            Self::Approach => row("A8", "B4", Execute, Reconcile, Fault::NoAnswer),
            Self::Grip => row("A9", "B4", Execute, Reconcile, Fault::NoAnswer),
            Self::LiftClear => row("A10", "B4", Execute, Reconcile, Fault::NoAnswer),
            Self::ReleaseMr => row("A11", "", Execute, ForwardOnly, Fault::DoesNotLeave),
            Self::PlaceApproach => row("A12", "B9", Execute, Reconcile, Fault::NoAnswer),
            Self::Release => row("A13", "B10", Execute, Reconcile, Fault::NoAnswer),
            Self::Retreat => row("A14", "B11", Execute, Reconcile, Fault::NoAnswer),
            Self::VerifyOnMr => row("", "B12", Execute, Retry, Fault::LoadMismatch),
            Self::Exit => row("A15", "B13-B14", Execute, ForwardOnly, Fault::DoesNotLeave),
            Self::Transport => row("", "B15", Waiting, ForwardOnly, Fault::TransportFailed),
            Self::Close => row("A16", "B16", Completing, Retry, Fault::NoAnswer),
            Self::BackOut => row("undo", "undo", Execute, Reconcile, Fault::NoAnswer),
            Self::Dismiss => row("undo", "undo", Execute, ForwardOnly, Fault::DoesNotLeave),
        }
    }

    /// The row of b.7 or b.8 it stands for.
    #[must_use]
    pub const fn code(self, workflow: Workflow) -> &'static str {
        match workflow {
            Workflow::DeliveryAndPlacement => self.row().a,
            Workflow::PickupAndDelivery => self.row().b,
        }
    }

    /// Its recovery class.
    #[must_use]
    pub const fn recovery(self) -> Recovery {
        self.row().recovery
    }

    /// Whether its work is operations of an arm; their timers are the step's timers.
    #[must_use]
    pub const fn is_arm_work(self) -> bool {
        matches!(
            self,
            Self::Precheck
                | Self::Approach
                | Self::Grip
                | Self::LiftClear
                | Self::PlaceApproach
                | Self::Release
                | Self::Retreat
                | Self::BackOut
        )
    }

    /// Whether a human may skip it: checks, never deeds.
    #[must_use]
    pub const fn may_skip(self) -> bool {
        matches!(
            self,
            Self::VerifyLoad | Self::VerifyEmpty | Self::VerifyOnMr
        )
    }

    /// How long it may take. Every phase has a limit.
    pub(crate) fn limit(self, timers: &Timers, spec: &NewJob) -> Millis {
        match self {
            Self::Reserve => timers.reserve_ms,
            Self::Precheck => timers.precheck_ms,
            Self::Call => timers.acknowledge_ms,
            Self::Await => spec
                .expected_arrival_ms
                .map_or(timers.arrival_ms, |eta| eta.saturating_add(eta / 2)),
            Self::Dock => timers.dock_ms,
            Self::VerifyLoad | Self::VerifyEmpty | Self::VerifyOnMr => timers.verify_ms,
            Self::Permit => timers.ready_ms,
            Self::Grip | Self::Release => timers.grip_ms,
            Self::ReleaseMr => timers.exit_ms,
            // The session's own timers act first; this one only says that the wait is bounded.
            Self::Exit | Self::Dismiss => {
                (timers.exit_ms + timers.clear_ms) * (u64::from(timers.resends) + 2)
            }
            Self::Transport => spec
                .expected_transport_ms
                .map_or(timers.transport_ms, |eta| eta.saturating_mul(2)),
            Self::Close => timers.close_ms,
            Self::Approach
            | Self::LiftClear
            | Self::PlaceApproach
            | Self::Retreat
            | Self::BackOut => timers.motion_unplanned_ms,
        }
    }
}
