//! Models, forward and inverse kinematics.

use api::arms::{ArmForwardBody, ArmFrames, ArmInverseBody, ArmSolver, FiveLinkPoints};

use crate::common::{assert_near, forward_of, pose};

const MODELS: [&str; 6] = [
    "fanuc-m20ia",
    "fanuc-m20ia-machine",
    "textbook-6r",
    "five-link",
    "scara",
    "seven-joint",
];

#[test]
fn every_model_is_listed_and_described() {
    let listed = robotics::models().arms;
    let names: Vec<&str> = listed.iter().map(|arm| arm.model.as_str()).collect();
    assert_eq!(names, MODELS);
    for arm in &listed {
        let described = robotics::describe(&arm.model).unwrap();
        assert_eq!(described.joints.len(), arm.degrees_of_freedom);
        assert_eq!(described.solvers, arm.solvers);
        assert!(!described.capsules.is_empty(), "{}", arm.model);
        for (joint, home) in described.joints.iter().zip(&described.home_deg_mm) {
            assert!((joint.min_deg_mm..=joint.max_deg_mm).contains(home));
        }
    }
    // Table 1 of the thesis: a2 = 790; J3 counts against the horizontal, so J2 is added to it.
    let m20 = robotics::describe("fanuc-m20ia").unwrap();
    assert_near(&[m20.joints[1].a_mm], [790.0], 0.0);
    assert_eq!(m20.joints[2].couplings[0].joint, "J2");
    assert_eq!(m20.solvers[0], ArmSolver::ClosedForm);
    assert!(m20.solvers.contains(&ArmSolver::Quartic));
    let unknown = robotics::describe("kuka").unwrap_err();
    assert!(
        unknown
            .to_string()
            .contains("\"kuka\"; there are fanuc-m20ia, ")
    );
}

/// By hand, SCARA: J1 0 and J2 90 put the quill at (325, 275); the second row turns Z down, so at 100 of the quill and
/// 20 of the last link the flange is at 400 - 100 - 20 = 280.
#[test]
fn the_scara_is_where_it_is_by_hand() {
    let answer = robotics::forward("scara", &forward_of(&[0.0, 90.0, 100.0, 0.0])).unwrap();
    let tcp = answer.tcp;
    for (is, wanted) in [(tcp.x_mm, 325.0), (tcp.y_mm, 275.0), (tcp.z_mm, 280.0)] {
        assert!((is - wanted).abs() < 1e-9, "{tcp:?}");
    }
    // Frames 0 to 4, flange, tool.
    assert_eq!(answer.link_frames.len(), 7);
    assert_near(&[answer.link_frames[1].x_mm], [325.0], 1e-9);
    assert!(answer.outside.is_empty());
}

/// By hand: at home the M-20iA's flange looks down at (985, 0, 940); a tool 100 long points 100 lower, and a user
/// frame at (900, 0, 0) sees it at x 85.
#[test]
fn tool_and_user_frame_are_counted_in() {
    let question = ArmForwardBody {
        frames: ArmFrames {
            user_frame: Some(pose([900.0, 0.0, 0.0, 0.0, 0.0, 0.0])),
            tool: Some(pose([0.0, 0.0, 100.0, 0.0, 0.0, 0.0])),
        },
        ..forward_of(&[0.0, 0.0, 0.0, 0.0, -90.0, 0.0])
    };
    let answer = robotics::forward("fanuc-m20ia", &question).unwrap();
    let tcp = answer.tcp;
    let numbers = [answer.flange.x_mm, tcp.x_mm, tcp.y_mm, tcp.z_mm];
    assert_near(&numbers, [85.0, 85.0, 0.0, 840.0], 1e-9);
    assert_eq!(answer.configuration.as_deref(), Some("N U T, 0, 0, 0"));
    // Turned by 180 about X: theta is 180, and only phi - psi is determined.
    assert!(!answer.tcp_zyz.regular && (answer.tcp_zyz.theta_deg - 180.0).abs() < 1e-9);
    // And back, by each method.
    for method in [
        ArmSolver::ClosedForm,
        ArmSolver::Quartic,
        ArmSolver::DampedLeastSquares,
    ] {
        let back = ArmInverseBody {
            pose: Some(answer.tcp),
            method: Some(method),
            frames: question.frames.clone(),
            ..ArmInverseBody::default()
        };
        let found = robotics::inverse("fanuc-m20ia", &back).unwrap();
        let nearest = &found.branches[found.nearest.unwrap()];
        for (is, wanted) in nearest.joints_deg_mm.iter().zip(&question.joints_deg_mm) {
            assert!((is - wanted).abs() < 1e-6, "{method:?}: {nearest:?}");
        }
    }
}

#[test]
fn every_method_of_every_model_finds_the_home_pose_again() {
    for arm in robotics::models().arms {
        let described = robotics::describe(&arm.model).unwrap();
        // Not home itself: several arms are singular there.
        let joints: Vec<f64> = described
            .joints
            .iter()
            .zip(&described.home_deg_mm)
            .map(|(joint, home)| home + 0.1 * (joint.max_deg_mm - home))
            .collect();
        let there = robotics::forward(&arm.model, &forward_of(&joints)).unwrap();
        for method in arm.solvers {
            let question = ArmInverseBody {
                pose: Some(there.tcp),
                method: Some(method),
                near_deg_mm: Some(joints.clone()),
                ..ArmInverseBody::default()
            };
            let found = robotics::inverse(&arm.model, &question).unwrap();
            let nearest = &found.branches[found.nearest.unwrap()];
            assert!(nearest.position_error_mm < 1e-5, "{method:?}: {nearest:?}");
            assert!(
                nearest.distance_deg_mm < 1e-5,
                "{}, {method:?}: {nearest:?}",
                arm.model
            );
        }
    }
}

/// By hand, paper (1), (2): BC along X, CDE down, EF along X.
#[test]
fn the_five_link_arm_answers_for_e_and_f() {
    let joints = [0.0, 90.0, -90.0, 0.0, 90.0];
    let answer = robotics::forward("five-link", &forward_of(&joints)).unwrap();
    let named: Vec<(&str, [f64; 3])> = answer
        .points
        .iter()
        .map(|point| (point.name.as_str(), point.at_mm))
        .collect();
    assert_eq!(
        named,
        [
            ("A", [0.0, 0.0, 0.0]),
            ("B", [0.0, 0.0, -300.0]),
            ("C", [250.0, 0.0, -300.0]),
            ("D", [250.0, 0.0, -500.0]),
            ("E", [250.0, 0.0, -650.0]),
            ("F", [350.0, 0.0, -650.0]),
        ]
    );
    let points = |e_mm, f_mm| ArmInverseBody {
        points: Some(FiveLinkPoints { e_mm, f_mm }),
        ..ArmInverseBody::default()
    };
    let question = points([250.0, 0.0, -650.0], [350.0, 0.0, -650.0]);
    let found = robotics::inverse("five-link", &question).unwrap();
    assert_near(&found.branches[0].joints_deg_mm, joints, 1e-9);
    // 250 + 350 from B is as far as E can be: at 700 below A it is 400 from B, at 1000 it is 700 from B.
    let far = points([0.0, 0.0, -1000.0], [100.0, 0.0, -1000.0]);
    let refused = robotics::inverse("five-link", &far).unwrap_err();
    assert!(refused.detail.contains("E is too far from B"), "{refused}");
}

/// J1 at 175 is beyond its 170: the other branches turn J1 to the other side, where the wrist would have to be upside
/// down, so some joint is always beyond. The reason says which.
#[test]
fn a_pose_outside_the_ranges_is_told_with_the_reason() {
    let there = robotics::forward(
        "fanuc-m20ia",
        &forward_of(&[175.0, 80.0, 0.0, 0.0, -90.0, 0.0]),
    );
    let question = ArmInverseBody {
        pose: Some(there.unwrap().tcp),
        ..ArmInverseBody::default()
    };
    let found = robotics::inverse("fanuc-m20ia", &question).unwrap();
    assert!(found.nearest.is_none() && !found.branches.is_empty());
    let reason = found.reason.unwrap();
    assert!(
        reason.contains("J1 would be 175.000, its range is -170 to 170"),
        "{reason}"
    );
}
