//! KAREL programs against a scripted host.
#![expect(
    clippy::unwrap_used,
    reason = "helpers of tests, where a failure is a failed test"
)]

mod assumptions;
mod cmos;
mod golden;
mod host;
mod listings;
mod robustness;
mod semantics;
mod sock_server;
mod tasks;
mod tp_cases;
