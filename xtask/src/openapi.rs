//! `openapi.yaml` is written from the server's routes; a test of the server compares the two.

use anyhow::Result;

use crate::command::cargo_with;

/// Writes `openapi.yaml`.
pub(crate) fn write() -> Result<()> {
    cargo_with(
        &[
            "test",
            "--package",
            "server",
            "--test",
            "openapi",
            "--",
            "openapi_yaml_is_current",
        ],
        &[],
        &[("UPDATE_OPENAPI", "1")],
    )
}
