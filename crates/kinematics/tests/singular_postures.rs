//! Poses where branches meet, where joints are free, and where the reach ends.
#![expect(non_snake_case, reason = "frames are part of a pose's name")]

mod support;

use kinematics::{
    ArmModel, Configuration, IkError, PendantJoints, Pose, ReachBound, Seed, SingularityKind,
};
use support::{apart, arm, assert_same_pose, joints, pose};

fn configuration(text: &str) -> Configuration {
    text.parse().expect("a configuration")
}

/// The solution near `seed`, which must reach the pose.
fn near(X_WF: &Pose, seed: PendantJoints) -> PendantJoints {
    let solution = arm().inverse(X_WF, Seed::Near(seed)).expect("a solution");
    assert_same_pose(
        &arm().forward(&solution.joints),
        X_WF,
        &solution.joints.to_string(),
    );
    solution.joints
}

#[test]
fn with_a_straight_wrist_j4_and_j6_stay_where_they_are() {
    let there = joints([10.0, 20.0, -30.0, 70.0, 0.0, -45.0]);
    assert!(apart(&near(&arm().forward(&there), there), &there) < 1e-9);
}

#[test]
fn with_a_straight_wrist_a_turn_of_the_tool_is_shared_by_j4_and_j6() {
    let X_WF = arm().forward(&joints([10.0, 20.0, -30.0, 0.0, 0.0, 50.0]));
    let found = near(&X_WF, joints([10.0, 20.0, -30.0, 0.0, 0.0, 0.0]));
    assert!(
        apart(&found, &joints([10.0, 20.0, -30.0, 25.0, 0.0, 25.0])) < 1e-9,
        "{found}"
    );
}

#[test]
fn with_a_straight_wrist_j4_takes_no_more_than_its_limit_allows() {
    let X_WF = arm().forward(&joints([10.0, 20.0, -30.0, 190.0, 0.0, 60.0]));
    let found = near(&X_WF, joints([10.0, 20.0, -30.0, 190.0, 0.0, 0.0]));
    assert!(
        apart(&found, &joints([10.0, 20.0, -30.0, 200.0, 0.0, 50.0])) < 1e-9,
        "{found}"
    );
}

#[test]
fn a_straight_wrist_is_flipped_and_not_flipped() {
    let X_WF = arm().forward(&joints([10.0, 20.0, -30.0, 0.0, 0.0, 50.0]));
    assert!(arm().inverse_all(&X_WF).unwrap().len() < 8);
    for text in ["N U T, 0, 0, 0", "F U T, 0, 0, 0"] {
        let seed = Seed::InConfiguration(configuration(text));
        let solution = arm().inverse(&X_WF, seed).unwrap();
        assert_eq!(solution.configuration.to_string(), text);
    }
}

#[test]
fn a_nearly_straight_wrist_is_still_exact() {
    for exponent in 1..=14 {
        let j5 = 10.0_f64.powi(-exponent);
        let there = joints([10.0, 20.0, -30.0, 70.0, j5, -45.0]);
        let X_WF = arm().forward(&there);
        let found = near(&X_WF, there);
        let _ = near(&X_WF, arm().home());
        // The closer, the less the pose says about J4: this is what five roundings of the rotation (5 * 2.2e-16) make
        // of it, whichever instructions the processor has.
        let allowed = (3.6e-12 / j5).max(1e-9);
        assert!(apart(&found, &there) < allowed, "J5 {j5:e}: {found}");
    }
}

#[test]
fn with_the_wrist_center_on_axis_1_j1_stays_where_it_is() {
    let X_WF = pose([0.0, 0.0, 1500.0, 0.0, 0.0, 20.0]);
    for j1 in [0.0, 37.0, -120.0] {
        let found = near(&X_WF, joints([j1, 0.0, 0.0, 0.0, -90.0, 0.0]));
        assert!((found.degrees()[0] - j1).abs() < 1e-9, "{found}");
        let singularity = arm().singularity(&found);
        assert!(singularity.shoulder < 1e-9 && singularity.near().count() > 0);
    }
    for text in ["N U T, 0, 0, 0", "N U B, 0, 0, 0"] {
        assert!(
            arm()
                .inverse(&X_WF, Seed::InConfiguration(configuration(text)))
                .is_ok(),
            "{text}"
        );
    }
}

#[test]
fn close_to_axis_1_every_pose_still_resolves() {
    for exponent in 0..=13 {
        let x = 10.0_f64.powi(-exponent);
        let found = near(&pose([x, -x, 1500.0, 0.0, 0.0, 20.0]), arm().home());
        assert!(found.degrees()[0].is_finite());
    }
}

/// J3 at which the forearm continues the upper arm at J2 = 0.
fn stretched_j3() -> f64 {
    835.0_f64.atan2(250.0).to_degrees()
}

/// The arm stretched forward, then moved on by `beyond` millimeters along its own line.
fn stretched(beyond: f64) -> Pose {
    let at = joints([0.0, 60.0, stretched_j3() - 60.0, 0.0, -40.0, 0.0]);
    let flange = arm().forward(&at);
    let (sine, cosine) = 60.0_f64.to_radians().sin_cos();
    let mut isometry = *flange.isometry();
    isometry.translation.x += beyond * sine;
    isometry.translation.z += beyond * cosine;
    Pose::try_from_isometry(isometry).expect("a pose")
}

#[test]
fn the_stretched_arm_reaches_and_up_and_down_are_one() {
    let branches = arm().inverse_all(&stretched(0.0)).unwrap();
    let front = |c: Configuration| c.same_branch(configuration("N U T, 0, 0, 0"));
    assert_eq!(
        branches.iter().filter(|s| front(s.configuration)).count(),
        1
    );
    for text in ["N U T, 0, 0, 0", "N D T, 0, 0, 0"] {
        let seed = Seed::InConfiguration(configuration(text));
        let solution = arm().inverse(&stretched(0.0), seed).unwrap();
        assert_eq!(solution.singularity.nearest().0, SingularityKind::Elbow);
    }
}

#[test]
fn within_a_nanometer_of_the_stretched_arm_every_pose_resolves() {
    for beyond in [1e-12, 1e-9, 1e-7, 4e-7, -1e-9, -1e-7, -1e-5, -1e-3] {
        let _ = near(&stretched(beyond), arm().home());
    }
}

#[test]
fn beyond_the_stretched_arm_the_excess_is_told() {
    for beyond in [1e-3, 1.0, 500.0] {
        let Err(IkError::OutOfReach { excess, bound }) = arm().inverse_all(&stretched(beyond))
        else {
            panic!("{beyond} mm beyond reach")
        };
        assert_eq!(bound, ReachBound::TooFar);
        assert!((excess.0 - beyond).abs() < 1e-6, "{excess} of {beyond}");
    }
    let error = arm().inverse(&stretched(12.5), Seed::Centered).unwrap_err();
    assert_eq!(
        error.to_string(),
        "out of reach: the wrist center is 12.500 mm beyond the stretched arm"
    );
}

/// The M-20iA with one line of its file changed.
fn changed(from: &str, to: &str) -> ArmModel {
    let text = include_str!("../models/fanuc_m20ia.toml");
    ArmModel::from_toml(&text.replacen(from, to, 1)).expect("a covered arm")
}

#[test]
fn too_near_to_the_shoulder_the_missing_way_is_told() {
    // Without the offset of axis 2 the shoulder is at the origin; the flange is 100 mm above the
    // wrist center.
    let arm = changed("a_mm = 150.0", "a_mm = 0.0");
    let error = arm
        .inverse_all(&pose([0.0, 0.0, 110.0, 0.0, 0.0, 0.0]))
        .unwrap_err();
    let IkError::OutOfReach { excess, bound } = error else {
        panic!("{error}")
    };
    assert_eq!(bound, ReachBound::TooNear);
    assert!(
        (excess.0 - (835.0_f64.hypot(250.0) - 790.0 - 10.0)).abs() < 1e-9,
        "{excess}"
    );
}

#[test]
fn nearer_to_axis_1_than_the_lateral_offset_the_missing_way_is_told() {
    let arm = changed("d_mm = 0.0\na_mm = 790.0", "d_mm = 50.0\na_mm = 790.0");
    let error = arm
        .inverse_all(&pose([0.0, 20.0, 1100.0, 0.0, 0.0, 0.0]))
        .unwrap_err();
    assert_eq!(
        error.to_string(),
        "out of reach: the wrist center is 30.000 mm nearer to axis 1 than the arm's lateral offset"
    );
    // Exactly beside axis 1, and within a nanometer of it, front and back are one.
    for short in [0.0, 1e-9, 1e-8, 1e-7, 4e-7] {
        let beside = pose([0.0, 50.0 - short, 1100.0, 0.0, 0.0, 20.0]);
        let branches = arm.inverse_all(&beside).unwrap();
        assert!(
            branches
                .iter()
                .all(|solution| solution.singularity.shoulder < 1e-6)
        );
    }
}

#[test]
fn folded_onto_its_shoulder_the_arm_keeps_its_upper_arm() {
    // Upper arm and forearm of the same length, wrist center on the shoulder.
    let arm = changed(
        "a_mm = 790.0",
        &format!("a_mm = {:?}", 835.0_f64.hypot(250.0)),
    );
    let X_WF = pose([150.0, 0.0, 100.0, 0.0, 0.0, 0.0]);
    let branches = arm.inverse_all(&X_WF).unwrap();
    assert!(!branches.is_empty());
    for solution in branches.iter() {
        assert_same_pose(&arm.forward(&solution.joints), &X_WF, "folded");
    }
}

#[test]
fn measures_go_to_zero_at_their_singularities() {
    let at = |degrees| arm().singularity(&joints(degrees));
    let regular = at([0.0, 0.0, 0.0, 0.0, -90.0, 0.0]);
    assert!((regular.wrist - 1.0).abs() < 1e-12 && regular.near().next().is_none());
    assert!(
        at([0.0, 0.0, 0.0, 0.0, 1.0, 0.0])
            .near()
            .eq([SingularityKind::Wrist])
    );
    let straight = at([0.0, 0.0, stretched_j3(), 0.0, -90.0, 0.0]);
    assert_eq!(straight.nearest(), (SingularityKind::Elbow, 0.0));
    assert_eq!(SingularityKind::Shoulder.to_string(), "shoulder");
}
