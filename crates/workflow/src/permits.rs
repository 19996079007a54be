//! The two permits of a hand-over. One enum with three values: both at once cannot be written down (I1).

use serde::Serialize;

use crate::session::SessionState;

/// Who may move in the zone of a point.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Serialize)]
#[serde(rename_all = "SCREAMING_SNAKE_CASE")]
pub enum Permit {
    /// Nobody.
    #[default]
    None,
    /// The arm: `ARM_ENTRY_PERMIT`.
    ArmEntry,
    /// The mobile robot: `MR_MOVE_PERMIT`.
    MrMove,
}

impl Permit {
    /// The permit that belongs to a state. It is volatile: a state says what may be granted, and
    /// [`crate::Cell`] grants it only when a fact is folded while the process that decided it lives (I7).
    #[must_use]
    pub const fn of(state: SessionState) -> Self {
        match state {
            SessionState::AccessGranted | SessionState::Positioned | SessionState::ExitGranted => {
                Self::MrMove
            }
            SessionState::Transferring => Self::ArmEntry,
            SessionState::Reserved
            | SessionState::AccessPending
            | SessionState::Docked
            | SessionState::TransferReady
            | SessionState::TransferDone
            | SessionState::Exited
            | SessionState::Released
            | SessionState::Faulted
            | SessionState::Canceling
            | SessionState::Canceled => Self::None,
        }
    }
}
