//! The same branches as rs-opw-kinematics, an independent implementation.
//!
//! Its arm is described by seven lengths, joint offsets and signs; J2 and J3 are coupled on the
//! pendant only, so the pendant's J3 + J2 is its J3.
#![expect(non_snake_case, reason = "frames are part of a pose's name")]
#![expect(
    clippy::unwrap_used,
    reason = "helpers of tests, where clippy.toml's exception does not reach"
)]

mod support;

use std::f64::consts::{FRAC_PI_2, PI};

use kinematics::{ArmModel, PendantJoints, Pose};
use rs_opw_kinematics::kinematic_traits::Kinematics;
use rs_opw_kinematics::kinematics_impl::OPWKinematics;
use rs_opw_kinematics::parameters::opw_kinematics::Parameters;
use support::{arm, builds, inside};

fn peer() -> OPWKinematics {
    OPWKinematics::new(Parameters {
        a1: 0.150,
        a2: -0.250,
        b: 0.0,
        c1: 0.0,
        c2: 0.790,
        c3: 0.835,
        c4: 0.100,
        offsets: [0.0, 0.0, -FRAC_PI_2, 0.0, 0.0, PI],
        sign_corrections: [1, 1, -1, -1, -1, -1],
        dof: 6,
    })
}

fn to_peer(joints: &PendantJoints) -> [f64; 6] {
    let [j1, j2, j3, j4, j5, j6] = joints.radians();
    [j1, j2, j3 + j2, j4, j5, j6]
}

fn peer_pose(pose: &Pose) -> rs_opw_kinematics::pose::Pose {
    let isometry = pose.isometry();
    let (p, q) = (
        isometry.translation.vector / 1000.0,
        isometry.rotation.coords,
    );
    let mut pose = rs_opw_kinematics::pose::Pose::IDENTITY;
    pose.translation = [p.x, p.y, p.z].into();
    (pose.rotation.x, pose.rotation.y) = (q.x, q.y);
    (pose.rotation.z, pose.rotation.w) = (q.z, q.w);
    pose
}

/// A small linear congruential generator: the same poses every time.
fn random_joints(count: usize) -> Vec<PendantJoints> {
    let mut state: u64 = 20_260_722;
    let mut part = move || {
        state = state
            .wrapping_mul(6_364_136_223_846_793_005)
            .wrapping_add(1_442_695_040_888_963_407);
        f64::from(u32::try_from(state >> 32).unwrap_or(0)) / f64::from(u32::MAX)
    };
    (0..count)
        .map(|_| inside(arm(), [(); 6].map(|()| part())))
        .collect()
}

/// The largest difference in radians, whole turns left out.
fn apart(a: &[f64; 6], b: &[f64; 6]) -> f64 {
    a.iter()
        .zip(b)
        .map(|(a, b)| (a - b).sin().atan2((a - b).cos()).abs())
        .fold(0.0, f64::max)
}

#[test]
fn both_arms_are_the_same() {
    for (joints, arm) in random_joints(100)
        .into_iter()
        .flat_map(|joints| builds().into_iter().map(move |arm| (joints, arm)))
    {
        let ours = peer_pose(&arm.forward(&joints));
        let theirs = peer().forward(&to_peer(&joints));
        assert!(
            (ours.translation - theirs.translation).length() < 1e-12,
            "{joints}"
        );
        assert!(
            ours.rotation.dot(theirs.rotation).abs() > 1.0 - 1e-12,
            "{joints}"
        );
    }
}

#[test]
fn every_branch_of_each_is_found_by_the_other() {
    for arm in builds() {
        assert_same_branches(&arm);
    }
}

fn assert_same_branches(arm: &ArmModel) {
    let peer = peer();
    let mut solutions = 0;
    for joints in random_joints(5000) {
        let X_WF = arm.forward(&joints);
        let ours: Vec<_> = arm
            .inverse_all(&X_WF)
            .unwrap()
            .iter()
            .map(|s| to_peer(&s.joints))
            .collect();
        let theirs = peer.inverse(&peer_pose(&X_WF));
        for (whose, some, others) in [("ours", &ours, &theirs), ("theirs", &theirs, &ours)] {
            for branch in some {
                let nearest = others
                    .iter()
                    .map(|other| apart(branch, other))
                    .fold(9.0, f64::min);
                assert!(
                    nearest < 1e-6,
                    "{whose} at {joints}: {branch:?} is {nearest} from the other's"
                );
            }
        }
        solutions += ours.len();
    }
    assert!(solutions > 30_000, "{solutions} solutions compared");
}
