//! Control authority: one party at a time moves the robots of a cell.
//!
//! ```text
//! request ── Claim (Control-Token) ── door: check, then the intent ── link: check, then the first byte
//!                     │
//!                CellControl ── machine (pure) ── epochs (durable)
//!                     └── loss ──▶ links: HOLD, STOP_1 or COMPLETE_STEP
//! ```
//!
//! Whoever moves holds a lease and keeps it alive by heartbeats. `LOCAL` always takes, `REMOTE` never does, an admin
//! may. Jobs and the thesis's own routes act while nobody holds control. Stopping needs none of this.

mod at_loss;
mod claim;
mod clock;
mod control;
#[cfg(test)]
mod control_tests;
mod epochs;
mod machine;
#[cfg(test)]
mod machine_tests;
mod said;

pub(crate) use at_loss::AtLoss;
pub(crate) use claim::{Claim, token};
pub(crate) use clock::LeaseClock;
pub(crate) use control::CellControl;
pub use control::{ControlLoss, ControlNews, ControlObserver};
pub use epochs::{EpochStore, MemoryEpochs, NextEpoch};
pub(crate) use machine::{Force, Terms};
pub(crate) use said::{AcquireError, Refused};
