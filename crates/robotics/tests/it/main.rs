//! The questions, each answered once with numbers by hand, and every item of bad input.

mod bad_input;
mod common;
mod dynamics;
mod paths;
mod postures;
mod tools;
mod trajectories;
mod velocities;
