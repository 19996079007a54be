//! What a process has cost: the time its threads ran, which depends less on who else is busy than how long it took.

use std::fs;
use std::time::Duration;

use anyhow::{Context as _, Result};

/// The time all threads of the process `id` have run so far, in user and kernel, to a hundredth of a second.
///
/// # Errors
/// There is no such process, or its system says it in another way than Linux.
pub fn time(id: u32) -> Result<Duration> {
    /// The unit of these numbers, on every Linux.
    const TICK: Duration = Duration::from_millis(10);
    let stat = fs::read_to_string(format!("/proc/{id}/stat"))?;
    // The name, in parentheses, may hold anything; user and kernel time are the 14th and 15th of all.
    let (_, rest) = stat.rsplit_once(')').context("a name in parentheses")?;
    let ticks = rest.split_ascii_whitespace().skip(11).take(2);
    let ticks = ticks.map(str::parse::<u32>).sum::<Result<u32, _>>()?;
    Ok(TICK * ticks)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_process_that_works_costs_time() {
        let own = std::process::id();
        let before = time(own).unwrap();
        let mut sum = 0_u64;
        while time(own).unwrap() < before + Duration::from_millis(20) {
            sum = std::hint::black_box(sum.wrapping_add(1));
        }
        assert!(sum > 0);
    }

    #[test]
    fn a_process_that_is_not_there_has_no_time() {
        assert!(time(u32::MAX).is_err());
    }
}
