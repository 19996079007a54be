//! The cell at work: jobs, hand-over sessions, mobile robots, custody.
//!
//! [`workflow::Cell`] decides; this module gives it time, keeps its decisions in the journal before anything follows
//! from them, carries out its effects, and shows what it knows.
//!
//! ```text
//! routes, arms, timers ── Input ─▶ driver (one task a cell) ─▶ decide ─▶ journal ─▶ apply ─▶ effects ─▶ arms, outboxes
//!                                        ▲                                            │
//!                                        └────────────── how an operation ended ◀─────┘
//! ```

mod arm;
mod clock;
mod displaced;
mod driver;
mod handle;
mod ids;
mod in_use;
mod motion_arm;
mod observe;
mod outbox;
mod places;
mod push;
mod recovered;
mod snapshots;
mod start;
mod told;

pub(crate) use clock::CellClock;
pub(crate) use driver::told_before;
pub(crate) use handle::{CellHandle, Refused, Told};
pub(crate) use observe::safety;
pub(crate) use outbox::Outboxes;
pub(crate) use places::{Span, Subject, subject};
pub(crate) use push::push;
pub use recovered::StartError;
pub(crate) use recovered::readable;
pub(crate) use start::Parts;

/// A cell without arms on a journal of its own, for tests of what listens to it.
#[cfg(test)]
pub(crate) async fn test_handle(journal: &crate::journal::SharedJournal) -> CellHandle {
    testing::handle(journal, std::collections::BTreeMap::new()).await
}

#[cfg(test)]
mod testing;
#[cfg(test)]
mod tests;
