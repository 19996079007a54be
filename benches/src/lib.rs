//! Benchmarks against the peers: what both sides of a comparison share.
//!
//! Absolute times drift with the machine's mood; only ratios taken side by side in one run count.
//! [`compare`] runs the variants in turn, many times, and gives the median of the per-repeat
//! ratios.

pub mod arms;
pub mod compare;
pub mod control;
pub mod cpu;
pub mod dynamics;
pub mod pinocchio;
pub mod processes;
pub mod targets;
