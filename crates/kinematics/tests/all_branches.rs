//! Every branch of the inverse kinematics: complete, exact, and named rightly.
#![expect(non_snake_case, reason = "frames are part of a pose's name")]

use kinematics::{ArmModel, Axis, PendantJoints, Seed, Solution};
use proptest::prelude::*;

fn arm() -> &'static ArmModel {
    ArmModel::builtin("fanuc-m20ia").unwrap()
}

prop_compose! {
    fn joints_inside_limits()(parts in prop::array::uniform6(0.0..1.0_f64)) -> PendantJoints {
        let mut degrees = [0.0; 6];
        for ((axis, part), value) in Axis::ALL.into_iter().zip(parts).zip(&mut degrees) {
            let limits = arm().limits(axis);
            *value = limits.min.0 + part * (limits.max.0 - limits.min.0);
        }
        PendantJoints::from_degrees(degrees)
    }
}

/// The largest difference of two joint sets in degrees, whole turns left out.
fn apart(a: &PendantJoints, b: &PendantJoints) -> f64 {
    let differences = a.degrees().into_iter().zip(b.degrees());
    differences
        .map(|(a, b)| (a - b - 360.0 * ((a - b) / 360.0).round()).abs())
        .fold(0.0, f64::max)
}

fn assert_reaches(solution: &Solution, joints: &PendantJoints) {
    let (apart, turned) = arm()
        .forward(&solution.joints)
        .distance_to(&arm().forward(joints));
    assert!(
        apart.0 <= 1e-6 && turned.0 <= 1e-9,
        "{joints}: {solution:?} is {apart}, {turned} off"
    );
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(2000))]

    #[test]
    fn every_branch_reaches_the_pose(joints in joints_inside_limits()) {
        let X_WF = arm().forward(&joints);
        for solution in arm().inverse_all(&X_WF).unwrap().iter() {
            assert_reaches(solution, &joints);
        }
    }

    #[test]
    fn the_joints_a_pose_was_made_of_are_among_its_branches(joints in joints_inside_limits()) {
        let branches = arm().inverse_all(&arm().forward(&joints)).unwrap();
        let nearest = branches.iter().map(|s| apart(&s.joints, &joints)).fold(f64::MAX, f64::min);
        // Near a singularity the joints are less well determined than the pose.
        let (_, measure) = arm().singularity(&joints).nearest();
        prop_assert!(nearest < 1e-9 / measure.max(1e-3), "{nearest} for {joints}, {measure}");
    }

    #[test]
    fn no_two_branches_have_the_same_configuration(joints in joints_inside_limits()) {
        let branches = arm().inverse_all(&arm().forward(&joints)).unwrap();
        for (index, solution) in branches.iter().enumerate() {
            prop_assert_eq!(solution.configuration, arm().configuration(&solution.joints));
            for other in branches.iter().skip(index + 1) {
                prop_assert!(!solution.configuration.same_branch(&other.configuration));
            }
        }
    }

    #[test]
    fn from_where_it_stands_the_arm_does_not_move(joints in joints_inside_limits()) {
        let solution = arm().inverse(&arm().forward(&joints), Seed::Near(joints)).unwrap();
        let (_, measure) = arm().singularity(&joints).nearest();
        for (now, then) in solution.joints.degrees().into_iter().zip(joints.degrees()) {
            prop_assert!((now - then).abs() < 1e-8 / measure.max(1e-3), "{} for {joints}", solution.joints);
        }
    }

    #[test]
    fn the_configuration_of_a_posture_leads_back_to_it(joints in joints_inside_limits()) {
        let seed = Seed::InConfiguration(arm().configuration(&joints));
        let solution = arm().inverse(&arm().forward(&joints), seed).unwrap();
        let (_, measure) = arm().singularity(&joints).nearest();
        for (now, then) in solution.joints.degrees().into_iter().zip(joints.degrees()) {
            prop_assert!((now - then).abs() < 1e-8 / measure.max(1e-3), "{} for {joints}", solution.joints);
        }
    }
}
