//! A server on a free port, robots that follow a script, and a client that speaks plain HTTP.

mod cell;
mod client;
mod connector;
mod robot;
mod secured;
mod work;

pub(crate) use cell::{DEMO_SETUP, MODEL, MOTION, MOTIONS, TestServer, fresh_key, robot_section};
pub(crate) use client::HttpReply;
pub(crate) use connector::{Attempt, ScriptedNetwork};
pub(crate) use robot::{ACCEPTED, Act, FakeRobot};
pub(crate) use secured::{Secured, control_of};
pub(crate) use work::{WorkCell, opened};

use std::time::{Duration, Instant};

/// Asks until `condition` is true.
pub(crate) async fn wait_until(what: &str, mut condition: impl FnMut() -> bool) {
    let started = Instant::now();
    while !condition() {
        assert!(
            started.elapsed() < Duration::from_secs(10),
            "timed out waiting until {what}"
        );
        tokio::task::yield_now().await;
    }
}

/// Asks the server until `condition` is true.
pub(crate) async fn until(what: &str, mut condition: impl AsyncFnMut() -> bool) {
    let started = Instant::now();
    while !condition().await {
        assert!(
            started.elapsed() < Duration::from_secs(10),
            "timed out waiting until {what}"
        );
        tokio::task::yield_now().await;
    }
}
