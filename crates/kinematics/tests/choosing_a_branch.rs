//! Seeds, turns, limits, and the reasons for a refusal.
#![expect(non_snake_case, reason = "frames are part of a pose's name")]

mod support;

use kinematics::{Axis, Configuration, Elbow, Flip, Front, IkError, Obstacle, Seed};
use proptest::prelude::*;
use support::{apart, arm, assert_same_pose, joints, joints_inside_limits, pose};

fn configuration(text: &str) -> Configuration {
    text.parse().expect("a configuration")
}

#[test]
fn home_is_no_flip_up_toward() {
    assert_eq!(
        arm().configuration(&arm().home()).to_string(),
        "N U T, 0, 0, 0"
    );
}

#[test]
fn the_nearest_solution_keeps_the_turn_of_the_wrist() {
    let there = joints([10.0, 20.0, -30.0, 190.0, -60.0, 250.0]);
    let X_WF = arm().forward(&there);
    let close = joints([11.0, 19.0, -31.0, 185.0, -65.0, 240.0]);
    let near = arm().inverse(&X_WF, Seed::Near(close)).unwrap();
    assert!(apart(&near.joints, &there) < 1e-9, "{}", near.joints);
    assert_eq!(near.configuration.turns, [1, 0, 1]);

    let unwound = joints([11.0, 19.0, -31.0, -160.0, -65.0, -100.0]);
    let near = arm().inverse(&X_WF, Seed::Near(unwound)).unwrap();
    assert!(
        apart(
            &near.joints,
            &joints([10.0, 20.0, -30.0, -170.0, -60.0, -110.0])
        ) < 1e-9
    );
    assert_eq!(near.configuration.turns, [0, 0, 0]);
}

#[test]
fn a_configuration_names_the_turns_exactly() {
    let there = joints([10.0, 20.0, -30.0, 190.0, -60.0, 250.0]);
    let X_WF = arm().forward(&there);
    let wound = configuration("N U T, 1, 0, 1");
    let solution = arm().inverse(&X_WF, Seed::InConfiguration(wound)).unwrap();
    assert!(
        apart(&solution.joints, &there) < 1e-9,
        "{}",
        solution.joints
    );
    let plain = configuration("N U T, 0, 0, 0");
    let solution = arm().inverse(&X_WF, Seed::InConfiguration(plain)).unwrap();
    assert!(
        apart(
            &solution.joints,
            &joints([10.0, 20.0, -30.0, -170.0, -60.0, -110.0])
        ) < 1e-9
    );
}

#[test]
fn a_joint_at_half_a_turn_is_on_both_turns() {
    let X_WF = arm().forward(&joints([10.0, 20.0, -30.0, 180.0, -60.0, 0.0]));
    for (turns, j4) in [("1, 0, 0", 180.0), ("-1, 0, 0", -180.0)] {
        let wanted = configuration(&format!("N U T, {turns}"));
        let solution = arm().inverse(&X_WF, Seed::InConfiguration(wanted)).unwrap();
        assert!(
            (solution.joints.of(Axis::J4).0 - j4).abs() < 1e-9,
            "{}",
            solution.joints
        );
    }
    let plain = Seed::InConfiguration(configuration("N U T, 0, 0, 0"));
    let solution = arm().inverse(&X_WF, plain).unwrap();
    assert!((solution.joints.of(Axis::J4).0.abs() - 180.0).abs() < 1e-9);
}

#[test]
fn a_joint_exactly_at_its_limit_is_inside() {
    for axis in Axis::ALL {
        let limits = arm().limits(axis);
        for value in [limits.min.0, limits.max.0] {
            let mut degrees = arm().home().degrees();
            degrees[Axis::ALL.iter().position(|a| *a == axis).unwrap()] = value;
            assert_eq!(arm().check_limits(&joints(degrees)), Ok(()));
        }
    }
}

#[test]
fn every_joint_beyond_a_limit_is_reported() {
    let violations = arm()
        .check_limits(&joints([171.0, 0.0, 212.4, 0.0, -150.5, 0.0]))
        .unwrap_err();
    assert_eq!(
        violations.to_string(),
        "J1 would be 171.00\u{b0}, its limit is 170.00\u{b0} (over by 1.00\u{b0}); \
         J3 would be 212.40\u{b0}, its limit is 200.00\u{b0} (over by 12.40\u{b0}); \
         J5 would be -150.50\u{b0}, its limit is -140.00\u{b0} (under by 10.50\u{b0})"
    );
    assert_eq!(violations.worst().unwrap().joint, Axis::J3);
    assert!(
        arm()
            .check_limits(&joints([f64::NAN, 0.0, 0.0, 0.0, 0.0, 0.0]))
            .is_err()
    );
}

#[test]
fn a_pose_beyond_the_limits_names_the_joint_that_misses_by_the_least() {
    // Low and far behind: the arm would have to turn J1 beyond 170 degrees.
    let X_WF = arm().forward(&joints([178.0, 20.0, -10.0, 0.0, -60.0, 0.0]));
    let error = arm().inverse(&X_WF, Seed::Near(arm().home())).unwrap_err();
    let IkError::JointLimit {
        violations,
        branches,
        ..
    } = &error
    else {
        panic!("{error}")
    };
    assert_eq!(violations.worst().unwrap().joint, Axis::J1);
    assert!(
        (violations.worst().unwrap().excess.0 - 8.0).abs() < 1e-9,
        "{violations}"
    );
    assert_eq!(
        error.to_string(),
        format!(
            "J1 would be 178.00\u{b0}, its limit is 170.00\u{b0} (over by 8.00\u{b0}) \
             in branch N U T, 0, 0, 0; {branches} branches tried"
        )
    );
}

#[test]
fn a_configuration_beyond_the_limits_names_those_that_would_do() {
    let X_WF = arm().forward(&arm().home());
    let wanted = configuration("N U B, 0, 0, 0");
    let error = arm()
        .inverse(&X_WF, Seed::InConfiguration(wanted))
        .unwrap_err();
    let IkError::NoSolutionInConfiguration {
        obstacle,
        available,
        ..
    } = &error
    else {
        panic!("{error}")
    };
    assert!(matches!(obstacle, Obstacle::Limits(_)), "{error}");
    assert!(
        available.contains(&configuration("N U T, 0, 0, 0")),
        "{error}"
    );
    assert!(
        error
            .to_string()
            .starts_with("no solution in configuration N U B, 0, 0, 0: J")
    );
    assert!(error.to_string().contains("N U T, 0, 0, 0 or "), "{error}");
}

#[test]
fn a_configuration_the_arm_cannot_have_says_so() {
    // Far in front: reaching over its back the arm is too short.
    let X_WF = pose([1700.0, 0.0, 100.0, 180.0, 0.0, 0.0]);
    let wanted = configuration("N U B, 0, 0, 0");
    let error = arm()
        .inverse(&X_WF, Seed::InConfiguration(wanted))
        .unwrap_err();
    assert!(
        error.to_string().starts_with(
            "no solution in configuration N U B, 0, 0, 0: the arm does not reach it in this posture; "
        ),
        "{error}"
    );
}

#[test]
fn a_seed_that_is_not_a_number_is_refused() {
    let seed = joints([0.0, 0.0, f64::NAN, 0.0, 0.0, 0.0]);
    let error = arm()
        .inverse(&arm().forward(&arm().home()), Seed::Near(seed))
        .unwrap_err();
    assert!(matches!(error, IkError::NotFinite(_)), "{error}");
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(1000))]

    #[test]
    fn nothing_inside_the_limits_is_nearer(
        there in joints_inside_limits(),
        seed in joints_inside_limits(),
    ) {
        let X_WF = arm().forward(&there);
        let chosen = arm().inverse(&X_WF, Seed::Near(seed)).unwrap();
        assert_same_pose(&arm().forward(&chosen.joints), &X_WF, &seed.to_string());
        prop_assert!(chosen.within_limits());
        let distance = |joints: [f64; 6]| -> f64 {
            joints.into_iter().zip(seed.degrees()).map(|(a, b)| (a - b).powi(2)).sum()
        };
        for solution in arm().inverse_all(&X_WF).unwrap().iter() {
            let [j1, j2, j3, j4, j5, j6] = solution.joints.degrees();
            for turns in 0..9 {
                let [t4, t6] = [turns % 3 - 1, turns / 3 - 1].map(|turn| 360.0 * f64::from(turn));
                let other = [j1, j2, j3, j4 + t4, j5, j6 + t6];
                if arm().check_limits(&joints(other)).is_ok() {
                    prop_assert!(distance(chosen.joints.degrees()) <= distance(other) + 1e-6);
                }
            }
        }
    }

    #[test]
    fn the_centered_solution_has_the_largest_margin(there in joints_inside_limits()) {
        let X_WF = arm().forward(&there);
        let chosen = arm().inverse(&X_WF, Seed::Centered).unwrap();
        for solution in arm().inverse_all(&X_WF).unwrap().iter() {
            prop_assert!(solution.smallest_margin().0 <= chosen.smallest_margin().0 + 1e-9);
        }
    }

    #[test]
    fn a_configuration_is_read_as_it_is_written(
        flip in prop::sample::select(vec![Flip::NoFlip, Flip::Flip]),
        elbow in prop::sample::select(vec![Elbow::Up, Elbow::Down]),
        front in prop::sample::select(vec![Front::Toward, Front::Back]),
        turns in prop::array::uniform3(-8..=7_i8),
    ) {
        let configuration = Configuration { flip, elbow, front, turns };
        prop_assert_eq!(configuration.to_string().parse(), Ok(configuration));
    }

    #[test]
    fn no_text_makes_the_configuration_parser_panic(text in ".{0,60}") {
        let _ = text.parse::<Configuration>();
    }
}
