//! What is done so that a journal stays small and a start short, as the configuration says.

use std::path::PathBuf;

use serde::de::Error as _;
use serde::{Deserialize, Deserializer};

/// Decisions between two snapshots of a cell, where nothing else is said. Folding them takes some ten milliseconds.
const SNAPSHOT_AFTER: u32 = 1_000;
/// Records that stay whatever their age, where nothing else is said.
const KEEP_RECORDS: u32 = 100_000;

/// When snapshots are taken and old records removed.
#[derive(Clone, Debug, Eq, PartialEq)]
pub struct Upkeep {
    /// After so many decisions of a cell what they amount to is kept.
    pub snapshot_after: u32,
    /// Which records are removed; none where absent.
    pub retention: Option<Retention>,
}

/// Which old records are removed.
#[derive(Clone, Debug, Eq, PartialEq)]
pub struct Retention {
    /// Only those older than so many days, by the wall clock.
    pub days: u32,
    /// The newest so many stay, whatever their age: a clock that was set wrong does not empty a journal.
    pub records: u32,
    /// The folder they are written out to before.
    pub archive: Option<PathBuf>,
}

impl Default for Upkeep {
    /// A snapshot after 1,000 decisions; every record is kept.
    fn default() -> Self {
        Self {
            snapshot_after: SNAPSHOT_AFTER,
            retention: None,
        }
    }
}

pub(crate) fn snapshot_after<'de, D: Deserializer<'de>>(deserializer: D) -> Result<u32, D::Error> {
    within(deserializer, "journal.snapshot_after", 1, 1_000_000)
}

pub(crate) fn keep_days<'de, D: Deserializer<'de>>(
    deserializer: D,
) -> Result<Option<u32>, D::Error> {
    within(deserializer, "journal.keep_days", 1, 36_500).map(Some)
}

pub(crate) fn keep_records<'de, D: Deserializer<'de>>(deserializer: D) -> Result<u32, D::Error> {
    within(deserializer, "journal.keep_records", 1_000, 1_000_000_000)
}

pub(crate) const fn default_snapshot_after() -> u32 {
    SNAPSHOT_AFTER
}

pub(crate) const fn default_keep_records() -> u32 {
    KEEP_RECORDS
}

fn within<'de, D: Deserializer<'de>>(
    deserializer: D,
    key: &str,
    least: u32,
    most: u32,
) -> Result<u32, D::Error> {
    let value = i64::deserialize(deserializer)?;
    u32::try_from(value)
        .ok()
        .filter(|value| (least..=most).contains(value))
        .ok_or_else(|| D::Error::custom(format!("{key}: {value} is not {least} to {most}")))
}
