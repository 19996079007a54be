//! Motions that are accepted: 50 a second on robots that answer and are not told to stop, the durable intent included.

use std::time::SystemTime;

use api::ControlToken;

use crate::client::{Client, post_controlled};
use crate::plant::NOT_STOPPED;
use crate::schedule::Load;
use crate::served::CELL;

pub(crate) const RATE: f64 = 50.0;
/// The 99th percentile at most, in milliseconds.
pub(crate) const TARGET_MS: f64 = 25.0;

/// The thesis's home pose.
pub(crate) const BODY: &str = r#"{"type":"JOINT","target":{"pose":{"x_mm":985,"y_mm":0,"z_mm":940,"w_deg":-180,"p_deg":0,"r_deg":0}},"speed_mm_s":200}"#;

pub(crate) fn load(port: u16, control: ControlToken) -> Load {
    Load::new("POST motion", RATE, 12, move |worker| {
        let mut client = Client::new(port);
        let path = path(worker % NOT_STOPPED);
        let run = run_id();
        Box::new(move |number| {
            let key = format!("{run}-{worker}-{number}");
            client.http(&post_controlled(&path, &key, control, BODY), 202)
        })
    })
}

pub(crate) fn path(robot: usize) -> String {
    format!("/api/v1/cells/{CELL}/robots/r{robot}/motions")
}

/// Another one in each slice, so that no key comes twice.
pub(crate) fn run_id() -> u128 {
    SystemTime::now()
        .duration_since(SystemTime::UNIX_EPOCH)
        .map_or(0, |since| since.as_nanos())
}
