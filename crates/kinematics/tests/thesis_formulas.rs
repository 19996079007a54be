//! The source thesis's own inverse kinematics, equations (13) to (18), holds for our forward
//! kinematics, where it is printed rightly. The crate solves the same arm geometrically; this is
//! the second opinion.
//!
//! The paper's letters stay inside this file. Table 1's zeros are put in: d1 = d2 = d3 = 0, alpha2
//! = alpha6 = 0.
#![expect(non_snake_case, reason = "the paper's letters")]

mod support;

use kinematics::PendantJoints;
use nalgebra::Matrix3;
use proptest::prelude::*;
use support::{arm, joints_inside_limits};

const A1: f64 = 150.0;
const A2: f64 = 790.0;
const A3: f64 = 250.0;
const D4: f64 = 835.0;
const D6: f64 = 100.0;

/// The chain's angles, the rotation of the flange, and the wrist center (14).
fn posture(joints: &PendantJoints) -> ([f64; 6], Matrix3<f64>, [f64; 3]) {
    let X_WF = arm().forward(joints);
    let R = X_WF.isometry().rotation.to_rotation_matrix().into_inner();
    let C = X_WF.isometry().translation.vector - D6 * R.column(2);
    (arm().chain(joints).radians(), R, [C.x, C.y, C.z])
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(500))]

    #[test]
    fn the_quartic_15_has_a_root_at_q3(joints in joints_inside_limits()) {
        let ([_, _, q3, ..], _, [x, y, z]) = posture(&joints);
        // Lengths in meters, or the terms differ by too many digits.
        let [a1, a2, a3, d4, x, y, z] = [A1, A2, A3, D4, x, y, z].map(|length| length / 1000.0);
        let (C, D) = (2.0 * a2 * a3, 2.0 * a2 * d4);
        let E = a2 * a2 + a3 * a3 + d4 * d4 - a1 * a1 - x * x - y * y - z * z;
        // alpha1 = 90: J = -(zc - d1) cos alpha1 = 0, and the squares of z come in through E only.
        let (H, I, J) = (0.0, 0.0, 0.0);
        let side = 4.0 * a1 * a1 * (x * x + y * y);
        let R = 4.0 * a1 * a1 * (J - H) * (J - H) + (E - C) * (E - C) - side;
        let S = 4.0 * (4.0 * a1 * a1 * I * (J - H) + D * (E - C));
        let T = 2.0 * (E * E - C * C + 2.0 * D * D - side);
        let U = 4.0 * (4.0 * a1 * a1 * I * (J + H) + D * (E + C));
        let V = 4.0 * a1 * a1 * (H + J) * (H + J) + (E + C) * (E + C) - side;
        // Multiplied by cos^4, so that q3 = 180 degrees is no exception.
        let (s, c) = (q3 / 2.0).sin_cos();
        let quartic = R * s.powi(4) + S * s.powi(3) * c + T * (s * c).powi(2) + U * s * c.powi(3)
            + V * c.powi(4);
        prop_assert!(quartic.abs() < 1e-12, "{quartic} at {joints}");
    }

    #[test]
    fn cos_q2_needs_its_second_term_subtracted(joints in joints_inside_limits()) {
        let ([q1, q2, q3, ..], _, [x, y, z]) = posture(&joints);
        let (A11, A12) = (A2 + A3 * q3.cos() + D4 * q3.sin(), -A3 * q3.sin() + D4 * q3.cos());
        let (u, v) = (x * q1.cos() + y * q1.sin() - A1, z);
        let square = A11 * A11 + A12 * A12;
        prop_assume!(square > 1.0);
        prop_assert!(((A11 * u - A12 * v) / square - q2.cos()).abs() < 1e-9);
        prop_assert!(((A12 * u + A11 * v) / square - q2.sin()).abs() < 1e-9);
        // As printed, with a plus, it is right only where the term is zero.
        if (A12 * v).abs() / square > 1e-3 {
            prop_assert!(((A11 * u + A12 * v) / square - q2.cos()).abs() > 1e-4);
        }
    }

    #[test]
    fn the_wrist_of_17_and_18_holds_as_printed(joints in joints_inside_limits()) {
        let ([q1, q2, q3, q4, q5, q6], R, _) = posture(&joints);
        let (s1, c1) = q1.sin_cos();
        let (s23, c23) = (q2 + q3).sin_cos();
        let R03 = Matrix3::new(c1 * c23, s1, c1 * s23, s1 * c23, -c1, s1 * s23, s23, 0.0, -c23);
        let r = R03.transpose() * R;
        // alpha4 = -90, alpha5 = 90, alpha6 = 0.
        let (s4, c4) = q4.sin_cos();
        let (s5, c5) = q5.sin_cos();
        prop_assert!((r[(0, 2)] * c4 + r[(1, 2)] * s4 - s5).abs() < 1e-12);
        prop_assert!((r[(2, 2)] - c5).abs() < 1e-12);
        let c6 = (r[(0, 0)] * c4 + r[(1, 0)] * s4) * c5 - r[(2, 0)] * s5;
        let s6 = -(r[(0, 0)] * s4 - r[(1, 0)] * c4);
        prop_assert!((c6 - q6.cos()).abs() < 1e-12 && (s6 - q6.sin()).abs() < 1e-12);
        // tau4 of (18) is tan(q4 / 2), for one of the two signs.
        let (xi, eta) = (r[(0, 2)], r[(1, 2)]);
        prop_assume!(eta.abs() > 1e-6);
        let tau = |sign: f64| (-xi + sign * xi.hypot(eta)) / eta;
        let off = |sign| (2.0 * f64::atan(tau(sign)) - q4).sin().abs();
        prop_assert!(off(1.0).min(off(-1.0)) < 1e-6);
    }
}
