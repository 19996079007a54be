//! Every branch of the inverse kinematics: complete, exact, and named rightly.
#![expect(non_snake_case, reason = "frames are part of a pose's name")]

mod support;

use kinematics::{Axis, Branches, IkError, Seed};
use proptest::prelude::*;
use support::{apart, apart_but_for_turns, arm, assert_same_pose, joints_inside_limits, pose};

/// Near a singularity the joints are less well determined than the pose.
fn exactness(joints: &kinematics::PendantJoints) -> f64 {
    let (_, measure) = arm().singularity(joints).nearest();
    1e-8 / measure.max(1e-3)
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(2000))]

    #[test]
    fn every_branch_reaches_the_pose(joints in joints_inside_limits()) {
        let X_WF = arm().forward(&joints);
        for solution in arm().inverse_all(&X_WF).unwrap().iter() {
            assert_same_pose(&arm().forward(&solution.joints), &X_WF, &joints.to_string());
        }
    }

    #[test]
    fn the_joints_a_pose_was_made_of_are_among_its_branches(joints in joints_inside_limits()) {
        let branches = arm().inverse_all(&arm().forward(&joints)).unwrap();
        let nearest = branches
            .iter()
            .map(|solution| apart_but_for_turns(&solution.joints, &joints))
            .fold(f64::MAX, f64::min);
        prop_assert!(nearest < exactness(&joints), "{nearest} for {joints}");
    }

    #[test]
    fn no_two_branches_have_the_same_configuration(joints in joints_inside_limits()) {
        let branches = arm().inverse_all(&arm().forward(&joints)).unwrap();
        for (index, solution) in branches.iter().enumerate() {
            prop_assert_eq!(solution.configuration, arm().configuration(&solution.joints));
            for other in branches.iter().skip(index + 1) {
                prop_assert!(!solution.configuration.same_branch(other.configuration));
            }
        }
    }

    #[test]
    fn every_pose_is_reached_or_said_to_be_out_of_reach_by_a_positive_excess(
        size in prop::sample::select(vec![1e-9, 1.0, 300.0, 2000.0, 1e6]),
        parts in prop::array::uniform3(-1.0..1.0_f64),
        wpr in prop::array::uniform3(-360.0..360.0_f64),
    ) {
        let ([x, y, z], [w, p, r]) = (parts.map(|part| size * part), wpr);
        let X_WF = pose([x, y, z, w, p, r]);
        match arm().inverse_all(&X_WF) {
            Ok(branches) => {
                for solution in branches.iter() {
                    assert_same_pose(&arm().forward(&solution.joints), &X_WF, "any pose");
                }
            }
            Err(IkError::OutOfReach { excess, .. }) => prop_assert!(excess.0 > 0.0, "{excess}"),
            Err(other) => prop_assert!(false, "{other}"),
        }
        for seed in [Seed::Centered, Seed::Near(arm().home())] {
            if let Ok(solution) = arm().inverse(&X_WF, seed) {
                prop_assert!(solution.within_limits());
                assert_same_pose(&arm().forward(&solution.joints), &X_WF, "any pose");
            }
        }
    }

    #[test]
    fn margins_and_limits_tell_the_same(joints in joints_inside_limits()) {
        for solution in arm().inverse_all(&arm().forward(&joints)).unwrap().iter() {
            for (axis, margin) in Axis::ALL.into_iter().zip(solution.margins) {
                let expected = arm().limits(axis).margin(solution.joints.of(axis));
                prop_assert!((margin - expected).0.abs() < 1e-9, "{axis}: {margin} {expected}");
            }
            let violations = solution.violations(arm());
            prop_assert_eq!(solution.within_limits(), violations.is_empty());
            prop_assert_eq!(solution.within_limits(), arm().check_limits(&solution.joints).is_ok());
        }
    }

    #[test]
    fn from_where_it_stands_the_arm_does_not_move(joints in joints_inside_limits()) {
        let solution = arm().inverse(&arm().forward(&joints), Seed::Near(joints)).unwrap();
        prop_assert!(apart(&solution.joints, &joints) < exactness(&joints), "{joints}");
    }

    #[test]
    fn the_configuration_of_a_posture_leads_back_to_it(joints in joints_inside_limits()) {
        let configuration = arm().configuration(&joints);
        let seed = Seed::InConfiguration(configuration);
        let solution = arm().inverse(&arm().forward(&joints), seed).unwrap();
        prop_assert!(apart(&solution.joints, &joints) < exactness(&joints), "{joints}");
        prop_assert_eq!(solution.configuration, configuration);
        prop_assert_eq!(configuration.to_string().parse(), Ok(configuration));
    }
}

#[test]
fn branches_are_plain_values_without_heap() {
    // What is `Copy` owns no memory.
    fn assert_copy<T: Copy>() {}
    assert_copy::<Branches>();
    assert_copy::<kinematics::Solution>();
}
