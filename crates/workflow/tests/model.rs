//! The model of the hand-over, explored to the end inside small bounds, and every weakened design is caught.
//! The big run: `cargo run --release -p workflow --example model`.

#[path = "model/protocol.rs"]
mod protocol;

use protocol::{Bounds, Handover, Weakened};
use stateright::{Checker, Model};

const SMALL: Bounds = Bounds {
    crashes: 1,
    losses: 1,
    doubles: 1,
    jogs: 1,
    drives: 1,
    lies: 1,
    give_ups: 1,
};

#[test]
fn the_design_holds_inside_small_bounds() {
    let calm = Bounds {
        crashes: 1,
        losses: 0,
        doubles: 0,
        jogs: 0,
        drives: 0,
        lies: 0,
        give_ups: 1,
    };
    let end = Handover {
        weakened: Weakened::No,
        bounds: calm,
    }
    .checker()
    .spawn_bfs()
    .join();
    end.assert_properties();
    // Everything at once, as far as a test may take: the example goes further.
    let far = Handover {
        weakened: Weakened::No,
        bounds: SMALL,
    }
    .checker()
    .target_state_count(250_000)
    .spawn_bfs()
    .join();
    for bad in [
        "no motion twice",
        "done means done",
        "in order",
        "one in the zone",
    ] {
        assert!(far.discovery(bad).is_none(), "{bad}");
    }
    println!(
        "{} and {} unique states",
        end.unique_state_count(),
        far.unique_state_count()
    );
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
        (Weakened::NoDedupe, "no motion twice"),
        (Weakened::ExitWithoutClearArm, "one in the zone"),
    ];
    for (weakened, property) in all {
        let checker = Handover {
            weakened,
            bounds: SMALL,
        }
        .checker()
        .target_state_count(400_000)
        .finish_when(stateright::HasDiscoveries::AnyOf(
            std::iter::once(property).collect(),
        ))
        .spawn_bfs()
        .join();
        let path = checker.discovery(property);
        assert!(
            path.is_some(),
            "{weakened:?} was not caught: {} states",
            checker.unique_state_count()
        );
        println!("{weakened:?}: {} steps", path.unwrap().into_actions().len());
    }
}
