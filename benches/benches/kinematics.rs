//! Both implementations beside each other under criterion; the ratios to quote are
//! `kinematics_ratio`'s.

use std::hint::black_box;

use benches::arms::{Case, arm, cases, peer};
use criterion::{Criterion, Throughput, criterion_group, criterion_main};
use kinematics::ArmModel;
use rs_opw_kinematics::kinematic_traits::Kinematics;
use rs_opw_kinematics::kinematics_impl::OPWKinematics;

const POSES: usize = 10_000;

/// Ours and the peer's in one group, each over all cases.
fn beside_each_other(
    criterion: &mut Criterion,
    name: &str,
    ours: impl Fn(&ArmModel, &Case),
    theirs: impl Fn(&OPWKinematics, &Case),
) {
    let (arm, peer, cases) = (arm(), peer(), cases(POSES));
    let mut group = criterion.benchmark_group(name);
    let _ = group
        .throughput(Throughput::Elements(POSES as u64))
        .sample_size(20);
    let _ = group.bench_function("robocell", |bencher| {
        bencher.iter(|| cases.iter().for_each(|case| ours(arm, case)));
    });
    let _ = group.bench_function("rs-opw-kinematics 3.0.0", |bencher| {
        bencher.iter(|| cases.iter().for_each(|case| theirs(&peer, case)));
    });
    group.finish();
}

fn inverse(criterion: &mut Criterion) {
    beside_each_other(
        criterion,
        "inverse, all branches, checked",
        |arm, case| {
            let _ = black_box(&arm.inverse_all(black_box(&case.pose)));
        },
        |peer, case| {
            let _ = black_box(&peer.inverse(black_box(&case.peer_pose)));
        },
    );
}

fn forward(criterion: &mut Criterion) {
    beside_each_other(
        criterion,
        "forward",
        |arm, case| {
            let _ = black_box(&arm.forward(black_box(&case.joints)));
        },
        |peer, case| {
            let _ = black_box(&peer.forward(black_box(&case.peer_joints)));
        },
    );
}

criterion_group!(kinematics, inverse, forward);
criterion_main!(kinematics);
