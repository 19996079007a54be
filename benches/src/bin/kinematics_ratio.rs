//! Prints how our kinematics compares with rs-opw-kinematics and with plain code, and whether the
//! targets are met: `cargo xtask bench kinematics`.

use std::hint::black_box;
use std::num::NonZeroUsize;

use benches::arms::{Case, Straight, arm, cases, peer};
use benches::compare::{Comparison, compare, cpu_seconds};
use benches::targets::Table;
use kinematics::{ArmModel, Instructions, PendantJoints, Seed};
use rs_opw_kinematics::kinematic_traits::Kinematics;

// `per_pose` divides by it.
const POSES: usize = 10_000;
const REPEATS: usize = 31;
/// Of the reachability map: this many times the poses.
const MAP: usize = 100;

#[expect(clippy::print_stdout, reason = "the table is what this program is for")]
fn main() {
    let cases = cases(POSES);
    println!("M-20iA, {POSES} random reachable poses, {REPEATS} repeats in turn, median, CPU time");
    let peers: usize = cases
        .iter()
        .map(|case| peer().inverse(&case.peer_pose).len())
        .sum();
    let solutions: usize = cases
        .iter()
        .map(|case| arm().inverse_all(&case.pose).map_or(0, |found| found.len()))
        .sum();
    println!("solutions: ours {solutions}, rs-opw-kinematics 3.0.0 {peers}");
    for (name, instructions, targets) in [
        ("portable", Instructions::Portable, &PORTABLE),
        ("AVX2", Instructions::Avx2, &AVX2),
        ("the best of this machine", Instructions::Best, &AVX2),
    ] {
        match arm().with(instructions) {
            Some(arm) => report(name, &arm, &cases, targets),
            None => println!("\n{name}: not on this machine"),
        }
    }
}

/// How many times faster than the peer, or the straight form, it has to be.
struct Targets {
    inverse: f64,
    inverse_batch: f64,
    forward: f64,
    jacobian: f64,
}

const PORTABLE: Targets = Targets {
    inverse: 4.0,
    inverse_batch: 20.0,
    forward: 2.5,
    jacobian: 1.0,
};
const AVX2: Targets = Targets {
    inverse: 10.0,
    inverse_batch: 40.0,
    forward: 5.0,
    jacobian: 1.0,
};

fn report(name: &str, arm: &ArmModel, cases: &[Case], targets: &Targets) {
    let table = Table::new(name);
    inverse(&table, arm, cases, targets);
    forward(&table, arm, cases, targets);
    jacobian(&table, arm, cases, targets);
    let poses = cases.iter().map(|case| case.pose);
    let many: Vec<_> = std::iter::repeat_n(poses, MAP).flatten().collect();
    let begun = cpu_seconds();
    let map = arm.reachability(&many, NonZeroUsize::MIN);
    let seconds = cpu_seconds() - begun;
    let _ = black_box(&map);
    table.at_most("reachability map of 10^6 poses, one core, s", seconds, 0.5);
    let worst = cases
        .iter()
        .flat_map(|case| errors(arm, case))
        .fold(0.0, f64::max);
    table.at_most("worst position error of a solution, m", worst, 1e-9);
}

fn inverse(table: &Table, arm: &ArmModel, cases: &[Case], targets: &Targets) {
    let peer = peer();
    let home = Case::of(arm.home());
    let poses: Vec<_> = cases.iter().map(|case| case.pose).collect();
    let peer_poses: Vec<_> = cases.iter().map(|case| case.peer_pose).collect();

    table.ratio(
        "inverse, all branches, each checked",
        compare(
            cases,
            REPEATS,
            |case| arm.inverse_all(&case.pose),
            |case| peer.inverse(&case.peer_pose),
        ),
        Some(targets.inverse),
    );
    table.ratio(
        "inverse, a batch",
        per_pose(compare(
            &[()],
            REPEATS,
            |()| {
                arm.inverse_batch(&poses, |_, sets| {
                    let _ = black_box(sets);
                });
            },
            |()| {
                for pose in &peer_poses {
                    let _ = black_box(&peer.inverse(pose));
                }
            },
        )),
        Some(targets.inverse_batch),
    );
    table.ratio(
        "inverse, nearest to home, in the limits",
        compare(
            cases,
            REPEATS,
            |case| arm.inverse(&case.pose, Seed::Near(arm.home())),
            |case| peer.inverse_continuing(&case.peer_pose, &home.peer_joints),
        ),
        None,
    );
}

fn forward(table: &Table, arm: &ArmModel, cases: &[Case], targets: &Targets) {
    let peer = peer();
    let joints: Vec<PendantJoints> = cases.iter().map(|case| case.joints).collect();
    let peer_joints: Vec<_> = cases.iter().map(|case| case.peer_joints).collect();
    table.ratio(
        "forward",
        compare(
            cases,
            REPEATS,
            |case| arm.forward(&case.joints),
            |case| peer.forward(&case.peer_joints),
        ),
        Some(targets.forward),
    );
    table.ratio(
        "forward, a batch",
        per_pose(compare(
            &[()],
            REPEATS,
            |()| {
                arm.forward_batch(&joints, |_, pose| {
                    let _ = black_box(pose);
                });
            },
            |()| {
                for joints in &peer_joints {
                    let _ = black_box(&peer.forward(joints));
                }
            },
        )),
        Some(targets.forward),
    );
}

fn jacobian(table: &Table, arm: &ArmModel, cases: &[Case], targets: &Targets) {
    let straight = Straight::of(arm);
    let joints: Vec<PendantJoints> = cases.iter().map(|case| case.joints).collect();
    table.ratio(
        "Jacobian, beside the straight form",
        compare(
            cases,
            REPEATS,
            |case| arm.jacobian(&case.joints),
            |case| straight.jacobian(&case.joints),
        ),
        Some(targets.jacobian),
    );
    table.ratio(
        "Jacobian, a batch",
        per_pose(compare(
            &[()],
            REPEATS,
            |()| {
                arm.jacobian_batch(&joints, |_, jacobian| {
                    let _ = black_box(jacobian);
                });
            },
            |()| {
                for joints in &joints {
                    let _ = black_box(&straight.jacobian(joints));
                }
            },
        )),
        Some(targets.jacobian),
    );
}

fn per_pose(all: Comparison) -> Comparison {
    Comparison {
        ours_ns: all.ours_ns / 1e4,
        peer_ns: all.peer_ns / 1e4,
        ratio: all.ratio,
    }
}

/// How far each solution's flange is from the pose, in meters; infinitely far if there is none.
fn errors(arm: &ArmModel, case: &Case) -> Vec<f64> {
    arm.inverse_all(&case.pose).map_or_else(
        |_| vec![f64::INFINITY],
        |found| {
            found
                .iter()
                .map(|solution| arm.forward(&solution.joints).distance_to(&case.pose).0.0 / 1000.0)
                .collect()
        },
    )
}
