//! Both implementations beside each other under criterion; the ratios to quote are
//! `kinematics_ratio`'s.

use std::hint::black_box;

use benches::arms::{arm, cases, peer};
use criterion::{Criterion, Throughput, criterion_group, criterion_main};
use rs_opw_kinematics::kinematic_traits::Kinematics;

const POSES: usize = 10_000;

fn inverse(criterion: &mut Criterion) {
    let (arm, peer, cases) = (arm(), peer(), cases(POSES));
    let mut group = criterion.benchmark_group("inverse, all branches, checked");
    let _ = group
        .throughput(Throughput::Elements(POSES as u64))
        .sample_size(20);
    let _ = group.bench_function("robocell", |bencher| {
        bencher.iter(|| {
            for case in &cases {
                let _ = black_box(arm.inverse_all(black_box(&case.pose)));
            }
        });
    });
    let _ = group.bench_function("rs-opw-kinematics 3.0.0", |bencher| {
        bencher.iter(|| {
            for case in &cases {
                let _ = black_box(peer.inverse(black_box(&case.peer_pose)));
            }
        });
    });
    group.finish();
}

fn forward(criterion: &mut Criterion) {
    let (arm, peer, cases) = (arm(), peer(), cases(POSES));
    let mut group = criterion.benchmark_group("forward");
    let _ = group
        .throughput(Throughput::Elements(POSES as u64))
        .sample_size(20);
    let _ = group.bench_function("robocell", |bencher| {
        bencher.iter(|| {
            for case in &cases {
                let _ = black_box(arm.forward(black_box(&case.joints)));
            }
        });
    });
    let _ = group.bench_function("rs-opw-kinematics 3.0.0", |bencher| {
        bencher.iter(|| {
            for case in &cases {
                let _ = black_box(peer.forward(black_box(&case.peer_joints)));
            }
        });
    });
    group.finish();
}

criterion_group!(kinematics, inverse, forward);
criterion_main!(kinematics);
