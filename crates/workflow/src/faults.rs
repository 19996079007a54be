//! The fault matrix F1 to F24 by name.

use serde::{Deserialize, Serialize};

/// A fault of the matrix (b.9).
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Fault {
    /// F1.
    NotAcknowledged,
    /// F2.
    ArrivalLate,
    /// F3.
    DockFailed,
    /// F4.
    LoadMismatch,
    /// F5.
    SlotOccupied,
    /// F6.
    Unreachable,
    /// F7.
    ControllerAlarm,
    /// F8.
    #[default]
    NoAnswer,
    /// F9.
    GripFailed,
    /// F10.
    PartLost,
    /// F11.
    Interlock,
    /// F12.
    HeartbeatLost,
    /// F13.
    ModeChanged,
    /// F14.
    ProtectiveStop,
    /// F15.
    EmergencyStop,
    /// F16.
    Canceled,
    /// F17.
    CanceledWithLoad,
    /// F18.
    TargetBlocked,
    /// F19.
    DoesNotLeave,
    /// F20.
    TransportFailed,
    /// F21.
    Restarted,
    /// F22.
    ControlLost,
    /// F23.
    StaleSignal,
    /// F24.
    JournalUnwritable,
}

impl Fault {
    /// Its number in the matrix.
    #[must_use]
    pub const fn number(self) -> u8 {
        self as u8 + 1
    }

    /// `F1` to `F24`.
    #[must_use]
    pub fn code(self) -> String {
        format!("F{}", self.number())
    }
}
