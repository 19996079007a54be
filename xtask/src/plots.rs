//! The pictures of docs/robotics.md are drawn by its own commands; a test of the client compares them.

use anyhow::Result;

use crate::command::cargo_with;

/// Draws docs/plots anew.
pub(crate) fn draw() -> Result<()> {
    cargo_with(
        &["test", "--package", "client", "--test", "robotics_document"],
        &[],
        &[("UPDATE_PLOTS", "1")],
    )
}
