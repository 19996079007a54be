//! The questions, each answered once with numbers by hand, and every item of bad input.

mod common;
mod postures;
mod trajectories;
