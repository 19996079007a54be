//! The link to a controller that reports: tier 2, which runs the `cell_server` program, and tier 1, which runs the
//! seed's pose server with a status program beside it. What differs is the command port ([`Instruction`]) and how an end
//! is judged: by numbers ([`judge`]), or by where the arm is ([`seed_judge`]).
//!
//! Two tasks own the controller's two ports. The status task keeps one connection open: it polls five times a second,
//! which is the heartbeat too, and a stop never waits behind anything on it. The command task sends one numbered
//! command at a time, at most once, each on a connection of its own, and follows it to its end.
//!
//! ```text
//! DISCONNECTED ─> CONNECTING ─> MONITOR <─> CONTROL        DEGRADED: answers come late
//!      ^  backoff 0.25 to 8 s     │  fenced; nothing is sent, and why     │
//!      └──────────────────────────┴──────────── no answer for 0.7 s ──────┘
//! ```
//!
//! Every connection made fences the controller with an epoch of its own, unless nothing was sent in the last one. So
//! what was queued or on its way before a loss can never start after it. What became of the motion in flight is
//! decided by [`judge`] on what the controller then says. Success is never an answer on the command port: it is the
//! status line that says finished, standing still, and within tolerance of the target.

mod backoff;
mod command_task;
mod error;
mod exchange;
mod follow;
mod handle;
mod judge;
mod order;
mod plan;
mod readiness;
mod report;
mod seed_judge;
mod seed_wire;
mod status_task;
mod stream;
#[cfg(test)]
mod tests;
mod view;

pub(crate) use error::LinkError;
pub(crate) use handle::{CellServerLink, spawn};
pub(crate) use judge::Open;
#[cfg(test)]
pub(crate) use order::Rejection;
pub(crate) use order::{Instruction, MotionEnd, MotionObserver, MotionOrder};
pub(crate) use plan::CellServerPlan;
pub(crate) use readiness::NotReady;
pub(crate) use view::{ControllerView, Observed, Phase};
