//! The server over real sockets, against robots that do what a test says.

#![expect(
    clippy::unwrap_used,
    clippy::indexing_slicing,
    reason = "helpers of tests: a failure here fails the test"
)]

mod access_matrix;
mod arms;
mod audit;
mod bad_bodies;
mod bounds;
mod config;
mod connections;
mod control;
mod deltas;
mod document;
mod events;
mod full_disk;
mod health;
mod identity;
mod job_refusals;
mod jobs;
mod kept_motions;
mod keys;
mod kinematics;
mod legacy_moves;
mod link_failures;
mod link_queue;
mod loads;
mod mobile_signals;
mod motions;
mod other_pages;
mod refusals;
mod serving;
mod setup;
mod simulated;
mod slow_reader;
mod support;
