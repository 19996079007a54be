//! Control of the cell that is measured, as an operator has it: the versioned motions ask for it.

use anyhow::Result;
use api::{AcquireBody, LossBehavior, Station};
use client::{Client, HeldControl};

/// Takes control of a cell of the server on `port`, and keeps it until it is released or dropped.
///
/// # Errors
/// The server does not answer, or somebody else has control.
pub async fn hold(port: u16, cell: &str) -> Result<HeldControl> {
    let client = Client::new(&format!("http://127.0.0.1:{port}"))?;
    let body = AcquireBody {
        ttl_s: Some(60),
        station: Station::Remote,
        loss_behavior: Some(LossBehavior::CompleteStep),
        preempt: false,
        reason: "a benchmark".to_owned(),
    };
    Ok(client.control(cell).hold(&body).await?)
}
