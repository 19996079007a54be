//! Arms of any joints: poses computed by hand, the conventions, the Jacobians, the catalogue's
//! files.

#![expect(
    clippy::unwrap_used,
    reason = "helpers of tests, where clippy.toml's exception does not reach"
)]

mod support;

use std::f64::consts::FRAC_PI_2;

use kinematics::serial::{Angles, RepresentationSingular, SerialArm, SerialError};
use kinematics::{ArmModel, PendantJoints, Pose, ZyzAngles, ZyzBranch};
use nalgebra::{Matrix3, Matrix4, Vector3};
use support::assert_same_pose;

fn arm(name: &str) -> &'static SerialArm {
    SerialArm::builtin(name).unwrap()
}

fn at(arm: &SerialArm, shown: &[f64]) -> Pose {
    arm.forward(&arm.joints(shown).unwrap()).unwrap()
}

/// Joints spread over the ranges of an arm; part `k` of joint `i` is the fraction of
/// `k * 0.618 + i * 0.414`.
fn sample(arm: &SerialArm, k: u32) -> Vec<f64> {
    arm.joint_list()
        .iter()
        .zip(1_u32..)
        .map(|(joint, i)| {
            let part = (f64::from(k) * 0.618_034 * f64::from(i) + f64::from(i) * 0.414_2).fract();
            joint.kind.shown(joint.min + part * (joint.max - joint.min))
        })
        .collect()
}

fn assert_at(pose: &Pose, wanted: [f64; 3], z_axis: [f64; 3]) {
    let p = pose.isometry().translation.vector - Vector3::from(wanted);
    let z = pose.isometry().rotation * Vector3::z() - Vector3::from(z_axis);
    assert!(p.norm() < 1e-9 && z.norm() < 1e-12, "{} {z}", pose.xyzwpr());
}

#[test]
fn the_catalogue_has_the_arms_and_every_file_reads() {
    let names: Vec<_> = SerialArm::catalog().iter().map(SerialArm::name).collect();
    let wanted = [
        "fanuc-m20ia",
        "fanuc-m20ia-machine",
        "textbook-6r",
        "five-link",
        "scara",
        "seven-joint",
    ];
    assert_eq!(names, wanted);
    let joints = SerialArm::catalog()
        .iter()
        .map(SerialArm::degrees_of_freedom);
    assert_eq!(joints.collect::<Vec<_>>(), [6, 6, 6, 5, 4, 7]);
}

/// Both sets of limits: the cell's (thesis, table 2) and the data sheet's.
#[test]
fn the_m20ia_has_both_sets_of_limits() {
    let range = |name: &str, joint: usize| {
        let joint = &arm(name).joint_list()[joint];
        format!(
            "{:.3} to {:.3}",
            joint.min.to_degrees(),
            joint.max.to_degrees()
        )
    };
    assert_eq!(range("fanuc-m20ia", 1), "-70.000 to 90.000");
    assert_eq!(range("fanuc-m20ia", 2), "-70.000 to 200.000");
    assert_eq!(range("fanuc-m20ia-machine", 1), "-100.000 to 160.000");
    assert_eq!(range("fanuc-m20ia-machine", 2), "-185.000 to 273.000");
    assert!(ArmModel::builtin("fanuc-m20ia-machine").is_some());
}

#[test]
fn the_m20ia_of_any_joints_is_the_m20ia_of_the_closed_form() {
    for k in 0..200 {
        let shown = sample(arm("fanuc-m20ia"), k);
        let fixed: [f64; 6] = shown.clone().try_into().unwrap();
        let closed = support::arm().forward(&PendantJoints::from_degrees(fixed));
        assert_same_pose(&at(arm("fanuc-m20ia"), &shown), &closed, "both arms");
    }
    // As on a pendant: home is (985, 0, 940) with the flange down.
    let home = at(arm("fanuc-m20ia"), &[0.0, 0.0, 0.0, 0.0, -90.0, 0.0]);
    assert_at(&home, [985.0, 0.0, 940.0], [0.0, 0.0, -1.0]);
}

/// Table 1.1 with d1 400, a2 500, d4 450, d6 100.
#[test]
fn the_textbook_arm_stands_where_it_does_by_hand() {
    let arm = arm("textbook-6r");
    // All zero: stretched along X at the height d1, 500 + 450 + 100.
    assert_at(&at(arm, &[0.0; 6]), [1050.0, 0.0, 400.0], [1.0, 0.0, 0.0]);
    // Upper arm up, forearm forward, flange down: 450 out, 400 + 500 - 100 high, turned to Y.
    let bent = at(arm, &[90.0, 90.0, -90.0, 0.0, -90.0, 0.0]);
    assert_at(&bent, [0.0, 450.0, 800.0], [0.0, 0.0, -1.0]);
}

/// 325 and 275 long, 400 high, 20 of a spindle.
#[test]
fn the_scara_stands_where_it_does_by_hand() {
    let scara = arm("scara");
    assert_at(
        &at(scara, &[0.0, 90.0, 100.0, 0.0]),
        [325.0, 275.0, 280.0],
        [0.0, 0.0, -1.0],
    );
    assert_at(
        &at(scara, &[-90.0, 90.0, 0.0, 30.0]),
        [275.0, -325.0, 380.0],
        [0.0, 0.0, -1.0],
    );
}

#[test]
fn the_seven_joint_arm_stands_where_it_does_by_hand() {
    let seven = arm("seven-joint");
    // Straight up: 340 + 400 + 400 + 126.
    assert_at(&at(seven, &[0.0; 7]), [0.0, 0.0, 1266.0], [0.0, 0.0, 1.0]);
    // The shoulder by a right angle: all above it lies along X.
    let lying = at(seven, &[0.0, 90.0, 0.0, 0.0, 0.0, 0.0, 0.0]);
    assert_at(&lying, [926.0, 0.0, 340.0], [1.0, 0.0, 0.0]);
    // The elbow too: 400 out and, back, 526 up or down; its twist is the other way round.
    let bent = at(seven, &[0.0, 90.0, 0.0, 90.0, 0.0, 0.0, 0.0]);
    assert_at(&bent, [400.0, 0.0, 866.0], [0.0, 0.0, 1.0]);
}

/// The textbook's (2) in the paper: F of a hand-made posture and of any.
#[test]
fn the_five_link_arm_is_where_the_paper_says() {
    let five = arm("five-link");
    // Hanging: 300 + 250 + 350 + 100 below A.
    assert_at(&at(five, &[0.0; 5]), [0.0, 0.0, -1000.0], [0.0, 0.0, -1.0]);
    let [l1, l2, l34, l5] = [300.0, 250.0, 350.0, 100.0];
    for k in 0..200 {
        let shown = sample(five, k);
        let q: Vec<f64> = shown.iter().map(|v| v.to_radians()).collect();
        let ((s1, c1), (s2, c2)) = (q[0].sin_cos(), q[1].sin_cos());
        let ((b2, b1), (s4, c4), (s5, c5)) =
            ((q[1] + q[2]).sin_cos(), q[3].sin_cos(), q[4].sin_cos());
        let wanted = Vector3::new(
            l5 * (c4 * s5 * b1 + c5 * b2) + l34 * b2 + l2 * s2,
            -l5 * (s5 * (s1 * c4 * b2 - c1 * s4) - s1 * c5 * b1)
                + l34 * s1 * b1
                + l2 * s1 * c2
                + l1 * s1,
            l5 * (s5 * (c1 * c4 * b2 + s1 * s4) - c1 * c5 * b1)
                - l34 * c1 * b1
                - l2 * c1 * c2
                - l1 * c1,
        );
        let found = at(five, &shown).isometry().translation.vector;
        assert!(
            (found - wanted).norm() < 1e-9,
            "{shown:?}: {found} {wanted}"
        );
    }
}

/// The seven-joint arm's file is in the modified convention; here the product is written out.
#[test]
fn a_modified_table_is_the_product_of_modified_links() {
    let rows = [
        (0.0, 0.0, 340.0),
        (0.0, -FRAC_PI_2, 0.0),
        (0.0, FRAC_PI_2, 400.0),
        (0.0, FRAC_PI_2, 0.0),
        (0.0, -FRAC_PI_2, 400.0),
        (0.0, -FRAC_PI_2, 0.0),
        (0.0, FRAC_PI_2, 0.0),
    ];
    for k in 0..50 {
        let shown = sample(arm("seven-joint"), k);
        let mut product = Matrix4::identity();
        for ((a, alpha, d), q) in rows.into_iter().zip(&shown) {
            let ((sa, ca), (s, c)) = (f64::sin_cos(alpha), q.to_radians().sin_cos());
            // Craig, Introduction to Robotics, (3.6).
            #[rustfmt::skip]
            let link = Matrix4::new(
                c,      -s,      0.0, a,
                s * ca, c * ca,  -sa, -sa * d,
                s * sa, c * sa,  ca,  ca * d,
                0.0,    0.0,     0.0, 1.0,
            );
            product *= link;
        }
        product *= Matrix4::new_translation(&Vector3::new(0.0, 0.0, 126.0));
        let found = at(arm("seven-joint"), &shown).isometry().to_homogeneous();
        assert!((found - product).amax() < 1e-9, "{}", found - product);
    }
}

/// Columns of every arm's Jacobian against central differences of the forward kinematics.
#[test]
fn jacobians_are_the_slopes_of_the_forward_kinematics() {
    let h = 1e-5;
    for arm in SerialArm::catalog() {
        for k in 0..20 {
            let values = arm.joints(&sample(arm, k)).unwrap();
            let jacobian = arm.jacobian(&values).unwrap();
            let here = arm.forward(&values).unwrap();
            for i in 0..arm.degrees_of_freedom() {
                let moved = |by: f64| {
                    let mut moved = values.as_slice().to_vec();
                    moved[i] += by;
                    let joints = arm.joints_from_radians(&moved).unwrap();
                    *arm.forward(&joints).unwrap().isometry()
                };
                let (after, before) = (moved(h), moved(-h));
                let v = (after.translation.vector - before.translation.vector) / (2.0 * h);
                let turned = after.rotation * before.rotation.inverse();
                let omega = turned.scaled_axis() / (2.0 * h);
                let column = jacobian.column(i);
                let linear = (column.fixed_rows::<3>(0) - v).norm();
                let angular = (column.fixed_rows::<3>(3) - omega).norm();
                assert!(
                    linear < 1e-5 && angular < 1e-8,
                    "{} {i}: {linear} {angular} at {here:?}",
                    arm.name()
                );
            }
        }
    }
}

#[test]
fn analytic_jacobians_are_the_slopes_of_the_angles() {
    let h = 1e-6;
    for arm in SerialArm::catalog() {
        for k in 0..20 {
            let values = arm.joints(&sample(arm, k)).unwrap();
            for angles in [Angles::Zyz, Angles::Wpr] {
                let Ok(jacobian) = arm.analytic_jacobian(&values, angles) else {
                    // The SCARA's flange points down in every posture.
                    assert_eq!((arm.name(), angles), ("scara", Angles::Zyz));
                    continue;
                };
                for i in 0..arm.degrees_of_freedom() {
                    let moved = |by: f64| {
                        let mut moved = values.as_slice().to_vec();
                        moved[i] += by;
                        let joints = arm.joints_from_radians(&moved).unwrap();
                        three_angles(&arm.forward(&joints).unwrap(), angles)
                    };
                    let difference = (moved(h) - moved(-h)).map(f64::sin) / (2.0 * h);
                    let column = jacobian.column(i).fixed_rows::<3>(3).into_owned();
                    // Near their singular case the angles are fast and their slope bends.
                    let bound = 1e-7 * (1.0 + jacobian.amax()).powi(2);
                    let off = (column - difference).norm();
                    assert!(off < bound, "{} {i} {angles:?}: {off}", arm.name());
                }
            }
        }
    }
}

fn three_angles(pose: &Pose, angles: Angles) -> Vector3<f64> {
    match angles {
        Angles::Zyz => {
            let zyz = pose.zyz(ZyzBranch::Positive).angles();
            Vector3::new(zyz.phi.0, zyz.theta.0, zyz.psi.0)
        }
        Angles::Wpr => {
            let shown = pose.xyzwpr();
            Vector3::new(shown.w.0, shown.p.0, shown.r.0).map(f64::to_radians)
        }
    }
}

#[test]
fn the_angles_have_no_rates_where_they_are_singular() {
    // The textbook's arm points up (theta = 0) with the forearm up: 90, 0, wrist straight.
    let textbook = arm("textbook-6r");
    let up = textbook.joints(&[0.0, 90.0, 0.0, 0.0, 0.0, 0.0]).unwrap();
    assert!(matches!(
        textbook.analytic_jacobian(&up, Angles::Zyz),
        Err(RepresentationSingular::Zyz { theta_deg }) if theta_deg.abs() < 1e-9
    ));
    // An M-20iA with all joints at zero shows P -90.
    let m20ia = arm("fanuc-m20ia");
    let zero = m20ia.joints(&[0.0; 6]).unwrap();
    let error = m20ia.analytic_jacobian(&zero, Angles::Wpr).unwrap_err();
    assert!(error.to_string().starts_with("P is -90"), "{error}");
}

/// (1.11), (1.24) to (1.33): a quarter turn about each axis, by hand, and the singular cases.
#[test]
fn zyz_angles_come_back_in_both_branches_and_in_the_singular_cases() {
    let pose = |phi: f64, theta: f64, psi: f64| {
        let (z, y) = (Vector3::z_axis(), Vector3::y_axis());
        let turn = |axis, angle| nalgebra::UnitQuaternion::from_axis_angle(axis, angle);
        let rotation = turn(&z, phi) * turn(&y, theta) * turn(&z, psi);
        Pose::try_from_isometry(nalgebra::Isometry3::from_parts(
            nalgebra::Translation3::identity(),
            rotation,
        ))
        .unwrap()
    };
    for (phi, theta, psi) in [(0.3, 1.1, -2.0), (-2.5, 0.001, 1.0), (1.0, 3.1, 3.0)] {
        let pose = pose(phi, theta, psi);
        let ZyzAngles::Regular(zyz) = pose.zyz(ZyzBranch::Positive) else {
            panic!("regular");
        };
        let off = [zyz.phi.0 - phi, zyz.theta.0 - theta, zyz.psi.0 - psi];
        assert!(off.iter().all(|off| off.abs() < 1e-9), "{off:?}");
        let other = pose.zyz(ZyzBranch::Negative).angles();
        assert!((other.theta.0 + theta).abs() < 1e-12);
        for zyz in [zyz, other] {
            let r = pose.isometry().rotation.to_rotation_matrix();
            assert!((zyz.rotation().matrix() - r.matrix()).amax() < 1e-12);
        }
    }
    // A quarter turn about Y takes X to -Z: the first column of (1.11) with theta = 90.
    let quarter = pose(0.0, FRAC_PI_2, 0.0)
        .isometry()
        .rotation
        .to_rotation_matrix();
    let wanted = Matrix3::new(0.0, 0.0, 1.0, 0.0, 1.0, 0.0, -1.0, 0.0, 0.0);
    assert!((quarter.matrix() - wanted).amax() < 1e-15);
    // (1.31): only the sum; (1.33): only the difference.
    let ZyzAngles::SumOnly(sum) = pose(0.4, 0.0, 0.5).zyz(ZyzBranch::Positive) else {
        panic!("theta is 0");
    };
    assert!((sum.phi.0 - 0.9).abs() < 1e-12 && sum.psi.0 == 0.0);
    let down = pose(0.4, std::f64::consts::PI, 0.5);
    let ZyzAngles::DifferenceOnly(difference) = down.zyz(ZyzBranch::Positive) else {
        panic!("theta is pi");
    };
    assert!((difference.phi.0 + 0.1).abs() < 1e-12, "{difference:?}");
}

#[test]
fn joint_values_that_are_not_the_arms_are_refused_by_name() {
    let scara = arm("scara");
    assert_eq!(
        scara.joints(&[0.0; 3]).unwrap_err().to_string(),
        "3 joint values were given; scara has 4 joints"
    );
    let error = scara.joints(&[0.0, 0.0, f64::NAN, 0.0]).unwrap_err();
    assert!(matches!(&error, SerialError::NotAValue { joint, .. } if joint == "Z"));
    let five = arm("five-link").home();
    assert!(scara.forward(&five).is_err());
    assert!(scara.jacobian(&five).is_err());
    let low = scara.joints(&[0.0, 0.0, 250.0, -400.0]).unwrap();
    let outside = scara.check_ranges(&low).unwrap();
    let said: Vec<_> = outside.iter().map(ToString::to_string).collect();
    assert_eq!(
        said,
        [
            "Z would be 250.00 mm, its range is 0.00 to 200.00",
            "J4 would be -400.00 deg, its range is -360.00 to 360.00"
        ]
    );
}

#[test]
fn a_file_that_is_wrong_is_refused_with_joint_key_and_value() {
    let good = include_str!("../models/scara.toml");
    let refused = |from: &str, to: &str| {
        let text = good.replacen(from, to, 1);
        assert_ne!(text, good, "{from}");
        SerialArm::from_toml(&text).unwrap_err().to_string()
    };
    assert!(refused("a_mm = 325.0", "a_mm = nan").starts_with("J1: a_mm is NaN"));
    assert_eq!(
        refused("min_deg = -130.0", "min_deg = 131.0"),
        "J1: its range is from 131 to 130 deg; the first must be below the second"
    );
    assert!(refused("home_mm = 0.0", "home_mm = -1.0").starts_with("Z: home is -1 mm"));
    assert!(refused("theta_deg = 0.0", "d_mm = 0.0").starts_with("Z: d_mm is given"));
    assert!(refused("max_mm = 200.0", "max_deg = 200.0").starts_with("Z: max_deg is given"));
    assert!(refused("max_speed_mm_s = 1100.0", "max_speed_mm_s = 0.0").contains("must be above 0"));
    assert!(refused("axis = \"J2\"", "axis = \"J1\"").contains("two joints are called J1"));
    assert!(refused("name = \"scara\"", "name = \" \"").starts_with("name is empty"));
    assert!(refused("axis = \"J1\"", "axis = \"J1\"\nspring = 1").starts_with("reading"));
    // A forearm of no length: J1 and J2 turn about one line.
    assert!(refused("a_mm = 325.0", "a_mm = 0.0").starts_with("J1 and J2 turn about one line"));
    let none = "name = \"x\"\nmanufacturer = \"y\"\njoints = []\n";
    let error = SerialArm::from_toml(none).unwrap_err();
    assert_eq!(
        error.to_string(),
        "the file has 0 joints; it must have 1 to 32"
    );
}
