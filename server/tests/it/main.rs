//! The server over real sockets, against robots that do what a test says.

#![expect(
    clippy::unwrap_used,
    clippy::indexing_slicing,
    reason = "helpers of tests: a failure here fails the test"
)]

mod legacy_moves;
mod support;
