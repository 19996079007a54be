//! What the tests of this crate share.
#![allow(dead_code, reason = "each test file uses its own part of it")]
#![allow(
    clippy::unwrap_used,
    reason = "helpers of tests, where clippy.toml's exception does not reach"
)]

use kinematics::{ArmModel, Axis, PendantJoints, Pose, Xyzwpr};
use proptest::prelude::*;
use units::{Degrees, Millimeters};

/// The M-20iA.
pub(crate) fn arm() -> &'static ArmModel {
    ArmModel::builtin("fanuc-m20ia").unwrap()
}

/// The M-20iA computed with each kind of instructions that this machine has.
pub(crate) fn builds() -> Vec<ArmModel> {
    use kinematics::Instructions::{Avx2, Best, Portable};
    let kinds = [Portable, Avx2, Best].into_iter();
    kinds.filter_map(|kind| arm().with(kind)).collect()
}

pub(crate) fn joints(degrees: [f64; 6]) -> PendantJoints {
    PendantJoints::from_degrees(degrees)
}

pub(crate) fn pose([x, y, z, w, p, r]: [f64; 6]) -> Pose {
    let pose = Xyzwpr::new([x, y, z].map(Millimeters), [w, p, r].map(Degrees));
    Pose::try_from_xyzwpr(&pose).unwrap()
}

/// Joints inside the limits of `arm`, each from 0 to 1 of its range.
pub(crate) fn inside(arm: &ArmModel, parts: [f64; 6]) -> PendantJoints {
    joints(Axis::ALL.map(|axis| {
        let limits = arm.limits(axis);
        limits.min.0 + axis.of(&parts) * (limits.max.0 - limits.min.0)
    }))
}

prop_compose! {
    pub(crate) fn joints_inside_limits()(parts in prop::array::uniform6(0.0..1.0_f64)) -> PendantJoints {
        inside(arm(), parts)
    }
}

/// The largest difference of two joint sets in degrees.
pub(crate) fn apart(a: &PendantJoints, b: &PendantJoints) -> f64 {
    a.degrees()
        .into_iter()
        .zip(b.degrees())
        .map(|(a, b)| (a - b).abs())
        .fold(0.0, f64::max)
}

/// The same, whole turns left out.
pub(crate) fn apart_but_for_turns(a: &PendantJoints, b: &PendantJoints) -> f64 {
    let differences = a.degrees().into_iter().zip(b.degrees());
    differences
        .map(|(a, b)| (a - b - 360.0 * ((a - b) / 360.0).round()).abs())
        .fold(0.0, f64::max)
}

/// As exact as a solution has to be.
pub(crate) fn assert_same_pose(a: &Pose, b: &Pose, what: &str) {
    let (apart, turned) = a.distance_to(b);
    assert!(
        apart.0 <= 1e-6 && turned.0 <= 1e-9,
        "{what}: {apart} and {turned} off"
    );
}
