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

/// Values of `$TERMTYPE`; 2 is COARSE and 3 NOSETTLE, which end as FINE does.
pub mod termtype {
    /// The next motion starts when the arm stands still.
    pub const FINE: i32 = 1;
    /// The next motion starts when the arm begins to decelerate.
    pub const NODECEL: i32 = 4;
    /// The next motion starts while the arm decelerates.
    pub const VARDECEL: i32 = 5;
}
