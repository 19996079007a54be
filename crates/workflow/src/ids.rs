//! Time and identifiers come from outside: this crate reads no clock and draws no random number.

use uuid::Uuid;

/// The driver's clock, in milliseconds; it never goes backwards within one process.
///
/// A driver whose clock counts from the Unix epoch lets the deadlines of jobs survive a restart; every other
/// timer is armed anew by [`crate::Input::Recover`].
pub type Millis = u64;

/// Where new identifiers come from.
pub trait IdSource {
    /// An identifier that was never given out before.
    fn next_id(&mut self) -> Uuid;
}

/// Identifiers that count upwards, for tests and simulation.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub struct CountingIds(u128);

impl CountingIds {
    /// A source that continues behind `last`.
    #[must_use]
    pub const fn after(last: u128) -> Self {
        Self(last)
    }
}

impl IdSource for CountingIds {
    fn next_id(&mut self) -> Uuid {
        self.0 += 1;
        Uuid::from_u128(self.0)
    }
}
