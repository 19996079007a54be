//! INTEGER codes of the motion variables.
//!
//! ASSUMPTION: the numbers; programs use the predefined constants `JOINT`, `FINE` and so on.

/// Values of `$MOTYPE`.
pub mod motype {
    /// All axes start and stop together.
    pub const JOINT: i32 = 6;
    /// The tool center point on a straight line.
    pub const LINEAR: i32 = 7;
    /// The tool center point on an arc.
    pub const CIRCULAR: i32 = 8;
}

/// Values of `$TERMTYPE`.
///
/// ASSUMPTION: this version ends every motion at a standstill, whatever the variable says.
pub mod termtype {
    /// The next motion starts when the arm stands still.
    pub const FINE: i32 = 1;
}
