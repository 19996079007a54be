//! The general solver for spherical wrists against the closed form, rs-opw-kinematics (through the
//! closed form's own comparison), random tables and singular postures.
#![expect(
    clippy::unwrap_used,
    reason = "helpers of tests, where clippy.toml's exception does not reach"
)]

mod support;

use kinematics::serial::{SerialArm, WristError};
use kinematics::{ArmModel, PendantJoints, SingularityKind};
use proptest::prelude::*;
use rs_opw_kinematics::kinematic_traits::Kinematics;
use rs_opw_kinematics::kinematics_impl::OPWKinematics;
use rs_opw_kinematics::parameters::opw_kinematics::Parameters;
use support::joints_inside_limits;

fn m20ia() -> &'static SerialArm {
    SerialArm::builtin("fanuc-m20ia").unwrap()
}

/// A table of six revolute joints with a spherical wrist.
fn table(rows: [[f64; 3]; 6]) -> SerialArm {
    use std::fmt::Write as _;
    let mut text = "name = \"any\"\nmanufacturer = \"test\"\n".to_owned();
    for (i, [d, a, alpha]) in rows.into_iter().enumerate() {
        write!(
            text,
            "[[joints]]\naxis = \"J{}\"\nd_mm = {d:?}\na_mm = {a:?}\nalpha_deg = {alpha:?}\nmin_deg = \
             -180.0\nmax_deg = 180.0\nmax_speed_deg_s = 90.0\nmax_acceleration_deg_s2 = 90.0\n\
             home_deg = 0.0\n",
            i + 1
        )
        .unwrap();
    }
    SerialArm::from_toml(&text).unwrap()
}

/// The number of solutions; each of them is checked, and `from` is among them.
fn solve(arm: &SerialArm, shown: &[f64]) -> Result<usize, TestCaseError> {
    let joints = arm.joints(shown).unwrap();
    let pose = arm.forward(&joints).unwrap();
    let found = arm
        .inverse_spherical(&pose, &arm.home())
        .map_err(|error| TestCaseError::fail(format!("{error} at {shown:?}")))?;
    for solution in &found {
        let (apart, turned) = arm.forward(&solution.joints).unwrap().distance_to(&pose);
        prop_assert!(apart.0 < 1e-6 && turned.0 < 1e-8, "{apart} {turned}");
    }
    let is_back = |solution: &[f64]| {
        let pairs = solution.iter().zip(joints.as_slice());
        pairs
            .map(|(a, b)| ((a - b) / 2.0).sin().abs())
            .all(|d| d < 1e-5)
    };
    let back = found.iter().any(|s| is_back(s.joints.as_slice()));
    let singular = found.iter().any(|s| !s.singular.is_empty());
    prop_assert!(back || singular, "{shown:?} is not among {found:?}");
    Ok(found.len())
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(400))]

    /// As many solutions as the closed form, and the same.
    #[test]
    fn the_quartic_finds_what_the_closed_form_finds(joints in joints_inside_limits()) {
        let pose = support::arm().forward(&joints);
        let closed = support::arm().inverse_all(&pose).unwrap();
        let general = m20ia().inverse_spherical(&pose, &m20ia().home()).unwrap();
        prop_assert_eq!(closed.len(), general.len());
        for solution in &closed {
            let near = general.iter().any(|other| {
                let values: [f64; 6] = other.joints.as_slice().try_into().unwrap();
                let other = PendantJoints::from_radians(values);
                support::apart_but_for_turns(&other, &solution.joints) < 1e-4
            });
            prop_assert!(near, "{} is missing", solution.joints);
        }
    }

    /// rs-opw-kinematics of the textbook's arm: another table, another author.
    #[test]
    fn rs_opw_agrees_on_the_textbook_arm(
        parts in prop::array::uniform6(0.0..1.0_f64)
    ) {
        let arm = SerialArm::builtin("textbook-6r").unwrap();
        let shown: Vec<f64> = arm.joint_list().iter().zip(parts)
            .map(|(joint, part)| (joint.min + part * (joint.max - joint.min)).to_degrees())
            .collect();
        let peer = OPWKinematics::new(Parameters {
            a1: 0.0, a2: 0.0, b: 0.0, c1: 0.4, c2: 0.5, c3: 0.45, c4: 0.1,
            offsets: [0.0; 6], sign_corrections: [1; 6], dof: 6,
        });
        let pose = arm.forward(&arm.joints(&shown).unwrap()).unwrap();
        let q = pose.isometry().rotation.coords;
        let p = pose.isometry().translation.vector / 1000.0;
        let mut peer_pose = rs_opw_kinematics::pose::Pose::IDENTITY;
        peer_pose.translation = [p.x, p.y, p.z].into();
        (peer_pose.rotation.x, peer_pose.rotation.y) = (q.x, q.y);
        (peer_pose.rotation.z, peer_pose.rotation.w) = (q.z, q.w);
        let theirs = peer.inverse(&peer_pose);
        let ours = arm.inverse_spherical(&pose, &arm.home()).unwrap();
        prop_assume!(ours.iter().all(|solution| solution.singular.is_empty()));
        prop_assert_eq!(ours.len(), theirs.len());
        // Their upper arm stands at zero and their forearm is counted the other way round.
        for theirs in &theirs {
            let [t1, t2, t3, ..] = *theirs;
            let near = ours.iter().any(|ours| {
                let ours = ours.joints.as_slice();
                let q2 = std::f64::consts::FRAC_PI_2 - t2;
                let same = |a: f64, b: f64| ((a - b) / 2.0).sin().abs() < 1e-6;
                same(ours[0], t1) && same(ours[1], q2) && same(ours[2], -t3)
            });
            prop_assert!(near, "{theirs:?} {:?}", ours);
        }
    }

    /// Any twists and offsets: the posture the pose was made of is among the solutions.
    #[test]
    fn any_spherical_wrist_is_solved(
        lengths in prop::array::uniform9(-500.0..500.0_f64),
        twists in prop::array::uniform6(-170.0..170.0_f64),
        joints in prop::array::uniform6(-179.0..179.0_f64),
    ) {
        let [d1, d2, d3, d4, d6, a1, a2, a3, a6] = lengths;
        let [t1, t2, t3, t4, t5, t6] = twists;
        prop_assume!(t4.abs() > 15.0 && t5.abs() > 15.0 && t1.abs() > 5.0 && a1.abs() > 5.0);
        prop_assume!(a2.abs() + a3.abs() + d4.abs() > 50.0);
        let arm = table([
            [d1, a1, t1], [d2, a2, t2], [d3, a3, t3], [d4, 0.0, t4], [0.0, 0.0, t5], [d6, a6, t6],
        ]);
        prop_assert!(solve(&arm, &joints)? >= 1);
    }

    /// Without the offset a1 (a PUMA with shoulder offset), and with axes 1 and 2 parallel: the
    /// quartic is no quartic.
    #[test]
    fn tables_without_a_quartic_are_solved_too(
        joints in prop::array::uniform6(-179.0..179.0_f64),
        d3 in -200.0..200.0_f64,
    ) {
        let puma = table([
            [0.0, 0.0, -90.0], [0.0, 432.0, 0.0], [d3, 20.0, -90.0], [433.0, 0.0, 90.0],
            [0.0, 0.0, -90.0], [56.0, 0.0, 0.0],
        ]);
        prop_assert!(solve(&puma, &joints)? >= 1);
        let parallel = table([
            [300.0, 250.0, 0.0], [50.0, 200.0, 90.0], [d3, 30.0, 90.0], [400.0, 0.0, -90.0],
            [0.0, 0.0, 90.0], [80.0, 0.0, 0.0],
        ]);
        prop_assert!(solve(&parallel, &joints)? >= 1);
    }

    /// J5 = 0: J4 + J6 is what counts, and both stay near the reference.
    #[test]
    fn a_singular_wrist_shares_the_way_between_j4_and_j6(
        j4 in -90.0..90.0_f64, j6 in -90.0..90.0_f64, turn in -60.0..60.0_f64,
    ) {
        let arm = SerialArm::builtin("textbook-6r").unwrap();
        let reference = arm.joints(&[10.0, 60.0, -40.0, j4, 0.0, j6]).unwrap();
        let moved = arm.joints(&[10.0, 60.0, -40.0, j4 + turn, 0.0, j6]).unwrap();
        let pose = arm.forward(&moved).unwrap();
        let found = arm.inverse_spherical(&pose, &reference).unwrap();
        let near = found.iter().find(|solution| {
            (solution.joints.as_slice()[1] - 60.0_f64.to_radians()).abs() < 1e-6
                && (solution.joints.as_slice()[0] - 10.0_f64.to_radians()).abs() < 1e-6
        }).unwrap();
        prop_assert_eq!(&near.singular, &vec![SingularityKind::Wrist]);
        let values = near.joints.as_slice();
        prop_assert!((values[3].to_degrees() - j4 - turn / 2.0).abs() < 1e-5, "{values:?}");
        prop_assert!((values[5].to_degrees() - j6 - turn / 2.0).abs() < 1e-5, "{values:?}");
    }
}

#[test]
fn the_singular_elbow_is_one_double_root() {
    // The forearm in line with the upper arm: 450 + 500 from the shoulder, up and down are one.
    let arm = SerialArm::builtin("textbook-6r").unwrap();
    let joints = arm.joints(&[20.0, 50.0, 0.0, 30.0, 40.0, 10.0]).unwrap();
    let pose = arm.forward(&joints).unwrap();
    let found = arm.inverse_spherical(&pose, &arm.home()).unwrap();
    assert_eq!(found.len(), 4, "front and back, two wrists: {found:?}");
    for solution in &found {
        assert_eq!(solution.singular, [SingularityKind::Elbow]);
    }
    // The same with the quartic: an M-20iA stretched, J3 where forearm and upper arm are in line.
    let angle = (835.0_f64 / 250.0).atan().to_degrees();
    let joints = m20ia()
        .joints(&[0.0, 30.0, angle - 30.0, 0.0, -50.0, 0.0])
        .unwrap();
    let pose = m20ia().forward(&joints).unwrap();
    let found = m20ia().inverse_spherical(&pose, &m20ia().home()).unwrap();
    assert!(
        found.iter().any(|s| s.singular == [SingularityKind::Elbow]),
        "{found:?}"
    );
}

#[test]
fn a_wrist_center_on_axis_1_leaves_j1_where_it_was() {
    let arm = SerialArm::builtin("textbook-6r").unwrap();
    // 500 sin 60 = 450 sin(..) brings the center over the base; here straight up.
    let up = arm.joints(&[0.0, 90.0, 0.0, 0.0, 60.0, 0.0]).unwrap();
    let pose = arm.forward(&up).unwrap();
    let reference = arm.joints(&[35.0, 90.0, 0.0, 0.0, 60.0, 0.0]).unwrap();
    let found = arm.inverse_spherical(&pose, &reference).unwrap();
    assert!(!found.is_empty());
    for solution in &found {
        assert!(solution.singular.contains(&SingularityKind::Shoulder));
        let j1 = solution.joints.as_slice()[0].to_degrees();
        assert!((j1 - 35.0).abs() < 1e-6, "{j1}");
    }
}

#[test]
fn what_is_out_of_reach_or_not_covered_is_said() {
    let far = support::pose([3000.0, 0.0, 900.0, 180.0, 0.0, 0.0]);
    let error = m20ia()
        .inverse_spherical(&far, &m20ia().home())
        .unwrap_err();
    assert_eq!(
        error.to_string(),
        "out of reach: the wrist center at (3000.000, 0.000, 1000.000) mm from the base has no posture"
    );
    for (name, why) in [
        ("scara", "scara has no spherical wrist: 4 joints, not 6"),
        (
            "five-link",
            "five-link has no spherical wrist: 5 joints, not 6",
        ),
    ] {
        let arm = SerialArm::builtin(name).unwrap();
        let error = arm.inverse_spherical(&far, &arm.home()).unwrap_err();
        assert!(matches!(error, WristError::NotCovered { .. }));
        assert_eq!(error.to_string(), why);
    }
    let bent = table([
        [0.0, 100.0, 90.0],
        [0.0, 300.0, 0.0],
        [0.0, 0.0, 90.0],
        [300.0, 0.0, -90.0],
        [40.0, 0.0, 90.0],
        [50.0, 0.0, 0.0],
    ]);
    let error = bent.inverse_spherical(&far, &bent.home()).unwrap_err();
    assert_eq!(
        error.to_string(),
        "any has no spherical wrist: J5: d_mm is 40, not 0"
    );
    assert!(ArmModel::builtin("no-such-arm").is_none());
}
