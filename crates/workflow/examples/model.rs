//! Explores the model of the hand-over to the end, and says how many states that were.

#![allow(clippy::print_stdout, reason = "it is a report")]

#[path = "../tests/model/protocol.rs"]
mod protocol;

use protocol::{Bounds, Handover, Weakened};
use stateright::{Checker, Model};

fn main() {
    let bounds = Bounds {
        crashes: 2,
        losses: 1,
        doubles: 1,
        jogs: 1,
        drives: 1,
        lies: 1,
        give_ups: 1,
    };
    let start = std::time::Instant::now();
    let checker = Handover {
        weakened: Weakened::No,
        bounds,
    }
    .checker()
    .threads(2)
    .target_state_count(20_000_000)
    .spawn_bfs()
    .join();
    println!(
        "{} unique states, depth {}, {:.1} s",
        checker.unique_state_count(),
        checker.max_depth(),
        start.elapsed().as_secs_f64()
    );
    // Breadth first, as far as it went: that both visits can end is shown by the test, inside smaller bounds.
    for bad in [
        "no motion twice",
        "done means done",
        "in order",
        "one in the zone",
    ] {
        assert!(checker.discovery(bad).is_none(), "{bad} is broken");
    }
}
