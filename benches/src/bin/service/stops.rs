//! Stops: 20 a second, of two robots that answer and of both dead ones.

use crate::client::{Client, post};
use crate::plant::NOT_STOPPED;
use crate::schedule::Load;
use crate::served::CELL;

pub(crate) const RATE: f64 = 20.0;
/// The 99th percentile at most, in milliseconds.
pub(crate) const TARGET_MS: f64 = 20.0;

const BODY: &str = r#"{"category":"STOP_1"}"#;

/// `None` where the server has no such route.
pub(crate) fn load(port: u16) -> Option<Load> {
    let request = |robot: usize| {
        let path = format!("/api/v1/cells/{CELL}/robots/r{robot}/stop");
        post(&path, &format!("stop-{}", super::motions::run_id()), BODY)
    };
    let status = Client::new(port).status(&request(0)).ok()?;
    if status == 404 || status == 405 {
        return None;
    }
    Some(Load::new("POST stop", RATE, 8, move |worker| {
        let mut client = Client::new(port);
        Box::new(move |_number| client.http(&request(NOT_STOPPED + worker % 4), status))
    }))
}
