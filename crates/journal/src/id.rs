//! Names, places and times: the small types every record is made of.

use std::fmt;
use std::time::Duration;

use jiff::Timestamp;
use serde::{Deserialize, Serialize};
use uuid::Uuid;

/// The place of a record in the journal: 1, 2, 3 and so on, without gaps. Zero stands before the first record.
#[derive(
    Clone, Copy, Debug, Default, Eq, Hash, Ord, PartialEq, PartialOrd, Serialize, Deserialize,
)]
#[serde(transparent)]
pub struct Position(pub u64);

impl Position {
    /// Before the first record.
    pub const START: Self = Self(0);

    /// The place after this one.
    ///
    /// # Panics
    /// After 2^64 - 1 records: at a million a second that is half a million years.
    #[must_use]
    pub fn next(self) -> Self {
        Self(
            self.0
                .checked_add(1)
                .expect("a journal has fewer than 2^64 records"),
        )
    }
}

impl fmt::Display for Position {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        self.0.fmt(f)
    }
}

/// How often the journal has been opened for writing: 1 at the first time, and one more at each.
///
/// A controller that remembers the highest epoch refuses what an older process sends.
#[derive(
    Clone, Copy, Debug, Default, Eq, Hash, Ord, PartialEq, PartialOrd, Serialize, Deserialize,
)]
#[serde(transparent)]
pub struct Epoch(pub u64);

impl fmt::Display for Epoch {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        self.0.fmt(f)
    }
}

/// Both clocks, read by the caller: the journal itself reads none.
///
/// The wall clock is for people and for the age of idempotency keys; it may jump. The monotonic clock counts from
/// the start of the process and orders what happened within one epoch.
#[derive(Clone, Copy, Debug, Eq, PartialEq)]
pub struct Clocks {
    /// What time it is.
    pub wall: Timestamp,
    /// Time since the process started; at most 2^64 - 1 ns (584 years) are kept.
    pub monotonic: Duration,
}

macro_rules! ids {
    ($($(#[$doc:meta])* $name:ident)*) => {$(
        $(#[$doc])*
        #[derive(Clone, Copy, Debug, Eq, Hash, Ord, PartialEq, PartialOrd, Serialize, Deserialize)]
        #[serde(transparent)]
        pub struct $name(pub Uuid);

        impl fmt::Display for $name {
            fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
                self.0.fmt(f)
            }
        }
    )*};
}

ids! {
    /// A motion, from its intent to its outcome.
    MotionId
    /// A job: a run of a workflow.
    JobId
    /// A signal of a mobile robot, as its sender named it.
    SignalId
    /// A decision of a person about something in doubt.
    DecisionId
}
