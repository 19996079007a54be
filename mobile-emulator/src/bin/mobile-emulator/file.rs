//! The configuration file.

use std::path::Path;

use anyhow::{Context as _, Result, bail};
use mobile_emulator::MobileConfig;

/// The longest file that is read.
const MAX_BYTES: u64 = 1024 * 1024;

/// Reads a robot.
///
/// # Errors
/// The file cannot be read, is too long, is not TOML, or has a key that does not fit; the message names file, line and
/// key.
pub(crate) fn load(path: &Path) -> Result<MobileConfig> {
    let name = path.display();
    let length = std::fs::metadata(path)
        .with_context(|| format!("reading {name}"))?
        .len();
    if length > MAX_BYTES {
        bail!("{name} has {length} bytes; the limit is {MAX_BYTES}");
    }
    let text = std::fs::read_to_string(path).with_context(|| format!("reading {name}"))?;
    MobileConfig::from_toml(&text).with_context(|| format!("in {name}"))
}
