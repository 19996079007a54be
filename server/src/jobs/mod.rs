//! The jobs of a cell as callers see them: what they may ask for, what is shown, what is told of the past.
//!
//! [`workflow`] decides, [`crate::cell`] drives and keeps; nothing is decided here.

mod admit;
mod body;
mod events;
mod questions;
mod refused;
mod report;
mod shown;
mod story;
mod telling;
#[cfg(test)]
mod tests;

pub(crate) use admit::admit;
pub(crate) use body::{command, job_of_parts, location, new_job, principal, reason};
pub(crate) use events::events;
pub(crate) use questions::{answer, intervention};
pub(crate) use refused::{problem, told};
pub(crate) use report::report;
pub(crate) use shown::{job, load, permits, session, state_of, summary};
pub(crate) use story::{History, history_of_load, remembered, story};
pub(crate) use telling::{Telling, all_chapters};
