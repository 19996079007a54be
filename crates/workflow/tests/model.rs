//! The model of the hand-over, explored to the end inside small bounds, and every weakened design is caught.
//! The big run: `cargo run --release -p workflow --example model`.

#[path = "model/protocol.rs"]
mod protocol;

use protocol::{Bounds, Handover, Weakened};
use stateright::{Checker, Model};

const SMALL: Bounds = Bounds { crashes: 1, losses: 1, doubles: 1, jogs: 1, drives: 1, lies: 1 };

#[test]
fn the_design_holds_inside_small_bounds() {
    let model = Handover {
        weakened: Weakened::No,
        bounds: Bounds { crashes: 1, losses: 1, doubles: 0, jogs: 1, drives: 0, lies: 0 },
    };
    let checker = model.checker().spawn_bfs().join();
    println!("{} unique states", checker.unique_state_count());
    checker.assert_properties();
}

#[test]
fn every_weakened_design_is_caught() {
    let all = [
        (Weakened::ResendOnRestart, "no motion twice"),
        (Weakened::TrustTheReply, "done means done"),
        (Weakened::NoFence, "no motion twice"),
        (Weakened::PermitsSurviveTheBoot, "one in the zone"),
        (Weakened::NoSecondEvidence, "one in the zone"),
        (Weakened::PoseOnly, "no motion twice"),
    ];
    for (weakened, property) in all {
        let checker = Handover { weakened, bounds: SMALL }
            .checker()
            .target_state_count(400_000)
            .finish_when(stateright::HasDiscoveries::AnyOf(std::iter::once(property).collect()))
            .spawn_bfs()
            .join();
        let path = checker.discovery(property);
        assert!(path.is_some(), "{weakened:?} was not caught: {} states", checker.unique_state_count());
        println!("{weakened:?}: {} steps", path.unwrap().into_actions().len());
    }
}
