//! How many files the process may have open: connections must not take the last ones, which the links to the
//! controllers and the journal need.

use super::table::CLOSING;
use crate::config::ServerPlan;

/// For the listener, the runtime, the journal and its log, standard streams, and what a program around needs.
const OWN: usize = 64;
/// For each robot: its connections, one that is closing, one that is opening.
const A_ROBOT: usize = 4;

/// How many places for connections there are: as many as configured, or as few as leave enough files for the rest.
pub(super) fn places(limits: &ServerPlan, robots: usize) -> usize {
    let wanted = limits.max_connections;
    let kept = OWN + A_ROBOT * robots + limits.max_event_streams + CLOSING;
    let Some(open_files) = std::fs::read_to_string("/proc/self/limits")
        .ok()
        .and_then(|text| soft_limit(&text))
    else {
        return wanted;
    };
    let places = places_within(open_files, wanted, kept);
    if places < wanted {
        tracing::warn!(
            max_connections = wanted,
            places,
            open_files,
            kept,
            "the process may have too few files open for all its connections"
        );
    }
    places
}

fn places_within(open_files: usize, wanted: usize, kept: usize) -> usize {
    wanted.min(open_files.saturating_sub(kept)).max(1)
}

/// The soft limit of open files in the text of `/proc/self/limits`; absent where it is unlimited.
fn soft_limit(text: &str) -> Option<usize> {
    let line = text
        .lines()
        .find_map(|line| line.strip_prefix("Max open files"))?;
    line.split_whitespace().next()?.parse().ok()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_soft_limit_is_the_first_column() {
        let text = "Limit                     Soft Limit           Hard Limit           Units     \n\
                    Max processes             95927                95927                processes \n\
                    Max open files            1024                 524288               files     \n";
        assert_eq!(soft_limit(text), Some(1_024));
        let unlimited = "Max open files            unlimited            unlimited            files";
        assert_eq!(soft_limit(unlimited), None);
        assert_eq!(soft_limit(""), None);
    }

    /// Covers: R2.
    #[test]
    fn connections_leave_files_for_the_robots() {
        assert_eq!(places_within(1_024, 256, 160), 256);
        assert_eq!(places_within(256, 256, 160), 96);
        assert_eq!(places_within(64, 256, 160), 1);
    }
}
