//! What the kernel says of a process.

use std::fs;

use anyhow::{Context as _, Result};

/// A line of `/proc/PID/status` in KiB, e.g. `VmRSS`, as MiB.
pub(crate) fn memory_mib(process: u32, line: &str) -> Result<f64> {
    let status = fs::read_to_string(format!("/proc/{process}/status"))?;
    let number: u32 = status
        .lines()
        .find_map(|found| found.strip_prefix(line)?.strip_prefix(':'))
        .and_then(|rest| rest.split_whitespace().next())
        .with_context(|| format!("{line} of {process}"))?
        .parse()?;
    Ok(f64::from(number) / 1024.0)
}

/// How many files it has open.
pub(crate) fn open_files(process: u32) -> Result<usize> {
    Ok(fs::read_dir(format!("/proc/{process}/fd"))?.count())
}
