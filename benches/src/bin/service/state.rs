//! `GET` of robots' states: 1,000 a second, of all eight robots.

use crate::client::{Client, get};
use crate::schedule::Load;
use crate::served::CELL;

pub(crate) const RATE: f64 = 1_000.0;
/// The 99th percentile at most, in milliseconds.
pub(crate) const TARGET_MS: f64 = 10.0;

pub(crate) fn load(port: u16) -> Load {
    Load::new("GET state", RATE, 32, move |worker| {
        let mut client = Client::new(port);
        let request = get(&format!(
            "/api/v1/cells/{CELL}/robots/r{}/state",
            worker % 8
        ));
        Box::new(move |_number| client.http(&request, 200))
    })
}
