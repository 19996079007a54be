//! Prints how our kinematics compares with rs-opw-kinematics: `cargo run --release -p benches --bin
//! kinematics_ratio`.

use std::num::NonZeroUsize;

use benches::arms::{Case, arm, cases, peer};
use benches::compare::{Comparison, compare};
use kinematics::Seed;
use rs_opw_kinematics::kinematic_traits::Kinematics;

// `per_pose` divides by it.
const POSES: usize = 10_000;
const REPEATS: usize = 31;

#[expect(clippy::print_stdout, reason = "the table is what this program is for")]
fn main() {
    let (arm, peer, cases) = (arm(), peer(), cases(POSES));
    let home = Case::of(arm.home());
    let solutions: usize = cases
        .iter()
        .map(|case| arm.inverse_all(&case.pose).map_or(0, |found| found.len()))
        .sum();
    let peers: usize = cases
        .iter()
        .map(|case| peer.inverse(&case.peer_pose).len())
        .sum();
    println!("M-20iA, {POSES} random reachable poses, {REPEATS} repeats in turn, median");
    println!("solutions: ours {solutions}, rs-opw {peers}");
    let worst = cases.iter().flat_map(errors).fold(0.0, f64::max);
    println!("worst position error of a solution: {worst:.1e} m");
    println!(
        "{:<28} {:>9} {:>12} {:>7}",
        "", "ours, ns", "rs-opw, ns", "ratio"
    );
    let row = |name: &str,
               Comparison {
                   ours_ns,
                   peer_ns,
                   ratio,
               }: Comparison| {
        println!("{name:<28} {ours_ns:>9.0} {peer_ns:>12.0} {ratio:>6.2}x");
    };
    row(
        "inverse, all branches",
        compare(
            &cases,
            REPEATS,
            |case| arm.inverse_all(&case.pose),
            |case| peer.inverse(&case.peer_pose),
        ),
    );
    let poses: Vec<_> = cases.iter().map(|case| case.pose).collect();
    let peer_poses: Vec<_> = cases.iter().map(|case| case.peer_pose).collect();
    let whole = [(poses, peer_poses)];
    let per_pose = |all: Comparison| Comparison {
        ours_ns: all.ours_ns / 1e4,
        peer_ns: all.peer_ns / 1e4,
        ratio: all.ratio,
    };
    row(
        "inverse, a batch",
        per_pose(compare(
            &whole,
            REPEATS,
            |(poses, _)| {
                arm.inverse_batch(poses, |_, sets| {
                    let _ = std::hint::black_box(sets);
                });
            },
            |(_, poses)| {
                for pose in poses {
                    let _ = std::hint::black_box(&peer.inverse(pose));
                }
            },
        )),
    );
    row(
        "reachability map, one core",
        per_pose(compare(
            &whole,
            REPEATS,
            |(poses, _)| arm.reachability(poses, NonZeroUsize::MIN),
            |(_, poses)| {
                poses
                    .iter()
                    .filter(|pose| !peer.inverse(pose).is_empty())
                    .count()
            },
        )),
    );
    row(
        "inverse, nearest to home",
        compare(
            &cases,
            REPEATS,
            |case| arm.inverse(&case.pose, Seed::Near(arm.home())),
            |case| peer.inverse_continuing(&case.peer_pose, &home.peer_joints),
        ),
    );
    row(
        "forward",
        compare(
            &cases,
            REPEATS,
            |case| arm.forward(&case.joints),
            |case| peer.forward(&case.peer_joints),
        ),
    );
}

/// How far each solution's flange is from the pose, in meters.
fn errors(case: &Case) -> Vec<f64> {
    arm().inverse_all(&case.pose).map_or_else(
        |_| Vec::new(),
        |found| {
            found
                .iter()
                .map(|solution| {
                    arm().forward(&solution.joints).distance_to(&case.pose).0.0 / 1000.0
                })
                .collect()
        },
    )
}
