//! The five-link arm's equations, the textbook's geometric solution, motion by a velocity vector.
#![expect(
    clippy::unwrap_used,
    reason = "helpers of tests, where clippy.toml's exception does not reach"
)]

use kinematics::serial::{
    FiveLinkArm, FiveLinkError, FiveLinkSolutions, MotionEnd, SerialArm, Task, TextbookArm,
    TextbookBranch, TextbookError, VelocityCommand,
};
use kinematics::{Elbow, Flip, Front, SingularityKind};
use nalgebra::Vector3;
use proptest::prelude::*;
use units::{Degrees, Millimeters};

fn five() -> FiveLinkArm {
    FiveLinkArm::try_new([300.0, 250.0, 200.0, 150.0, 100.0]).unwrap()
}

fn textbook() -> TextbookArm {
    let [d1, a2, d4, d6] = [400.0, 500.0, 450.0, 100.0].map(Millimeters);
    TextbookArm::try_new(d1, a2, d4, d6).unwrap()
}

fn arm(name: &str) -> &'static SerialArm {
    SerialArm::builtin(name).unwrap()
}

/// By hand: BC along X, CDE down, EF along X.
#[test]
fn the_points_of_the_five_link_arm_are_as_by_hand() {
    let joints = [0.0, 90.0, -90.0, 0.0, 90.0].map(Degrees);
    let points = five().points(&joints).unwrap();
    let wanted = [
        [0.0, 0.0, 0.0],
        [0.0, 0.0, -300.0],
        [250.0, 0.0, -300.0],
        [250.0, 0.0, -500.0],
        [250.0, 0.0, -650.0],
        [350.0, 0.0, -650.0],
    ];
    for (point, wanted) in points.into_iter().zip(wanted) {
        assert!((point - Vector3::from(wanted)).norm() < 1e-9, "{point}");
    }
}

proptest! {
    /// (3) and (4) undo (1) and (2), which another table (the arm's Denavit-Hartenberg file)
    /// confirms in serial_arms.rs.
    #[test]
    fn the_joints_come_back_from_e_and_f(
        a in -59.0..59.0_f64, b in -44.0..134.0_f64, c in -134.0..-1.0_f64,
        d in -94.0..94.0_f64, e in -94.0..94.0_f64,
    ) {
        prop_assume!(e.abs() > 0.01);
        let joints = [a, b, c, d, e];
        let points = five().points(&joints.map(Degrees)).unwrap();
        prop_assume!(points[4].y.hypot(points[4].z) > 1.0);
        let found = five().inverse(&points[4], &points[5]).unwrap();
        let sets = match found {
            FiveLinkSolutions::One(set) | FiveLinkSolutions::AnyD(set) => vec![set],
            FiveLinkSolutions::Two(sets) => sets.to_vec(),
        };
        let near = |set: &[Degrees; 5]| {
            set.iter().zip(joints).map(|(x, y)| (x.0 - y).abs()).fold(0.0, f64::max) < 1e-3
        };
        prop_assert!(sets.iter().any(near), "{sets:?} {joints:?}");
        prop_assert!(d.abs() < 85.0 || sets.len() == 2);
        for set in &sets {
            let again = five().points(set).unwrap();
            prop_assert!((again[4] - points[4]).norm() < 1e-6);
            prop_assert!((again[5] - points[5]).norm() < 1e-6);
        }
    }

    /// All eight branches of the textbook's solution, in the arm's own forward kinematics.
    #[test]
    fn the_geometric_solution_reaches_the_pose_in_all_branches(
        joints in prop::array::uniform6(-170.0..170.0_f64)
    ) {
        let arm = arm("textbook-6r");
        let pose = arm.forward(&arm.joints(&joints).unwrap()).unwrap();
        let mut back = false;
        for front in [Front::Toward, Front::Back] {
            for elbow in [Elbow::Up, Elbow::Down] {
                for flip in [Flip::NoFlip, Flip::Flip] {
                    let branch = TextbookBranch { front, elbow, flip };
                    let found = textbook().inverse(&pose, branch).unwrap();
                    let shown = found.joints.map(|joint| joint.0);
                    let there = arm.forward(&arm.joints(&shown).unwrap()).unwrap();
                    let (apart, turned) = there.distance_to(&pose);
                    prop_assert!(apart.0 < 1e-6 && turned.0 < 1e-9, "{branch:?}: {apart}");
                    let same = |(a, b): (f64, f64)| ((a - b).to_radians() / 2.0).sin().abs() < 1e-5;
                    back |= shown.into_iter().zip(joints).all(same);
                }
            }
        }
        prop_assert!(back);
    }
}

#[test]
fn each_case_without_a_solution_has_its_name() {
    let inverse = |e: [f64; 3], along: [f64; 3]| {
        let e = Vector3::from(e);
        let f = e + Vector3::from(along).normalize() * 100.0;
        five().inverse(&e, &f).unwrap_err()
    };
    let down = [0.0, 0.0, -1.0];
    // 70 degrees to the side.
    let side = 70_f64.to_radians();
    let beyond_a = inverse([0.0, 700.0 * side.sin(), -700.0 * side.cos()], down);
    assert!(matches!(beyond_a, FiveLinkError::BeyondA(a) if (a.0 - 70.0).abs() < 1e-9));
    assert_eq!(inverse([100.0, 0.0, 0.0], down), FiveLinkError::OnAxisA);
    assert!(matches!(inverse([0.0, 0.0, -1000.0], down), FiveLinkError::TooFar(c) if c > 1.0));
    // B is at (0, 0, -300); 100 is what the folded arm leaves.
    assert!(matches!(inverse([50.0, 0.0, -300.0], down), FiveLinkError::TooNear(c) if c < -1.0));
    assert!(
        matches!(inverse([110.0, 0.0, -300.0], down), FiveLinkError::BeyondC(c) if c.0 < -135.0)
    );
    assert!(
        matches!(inverse([-500.0, 0.0, -300.0], down), FiveLinkError::BeyondB(b) if b.0 < -45.0)
    );
    // EF folded back onto DE.
    let up = inverse([250.0, 0.0, -650.0], [0.1, 0.0, 1.0]);
    assert!(
        matches!(up, FiveLinkError::BeyondE(e) if e.0 > 95.0),
        "{up}"
    );
    let apart = five().inverse(&Vector3::new(250.0, 0.0, -650.0), &Vector3::zeros());
    assert!(matches!(apart, Err(FiveLinkError::LinkLength { .. })));
    let nan = five().inverse(&Vector3::new(f64::NAN, 0.0, 0.0), &Vector3::zeros());
    assert!(matches!(
        nan,
        Err(FiveLinkError::NotANumber { name: "E", .. })
    ));
    let length = FiveLinkArm::try_new([300.0, 0.0, 1.0, 1.0, 1.0]).unwrap_err();
    assert_eq!(
        length.to_string(),
        "l2 is 0 mm; it must be above 0 and not above 100000"
    );
    // In line with DE: any D.
    let straight = five().inverse(
        &Vector3::new(250.0, 0.0, -650.0),
        &Vector3::new(250.0, 0.0, -750.0),
    );
    assert!(matches!(straight, Ok(FiveLinkSolutions::AnyD(set)) if set[4].0.abs() < 1e-9));
}

#[test]
fn the_geometric_solution_names_its_singular_cases_and_its_reach() {
    let branch = TextbookBranch {
        front: Front::Toward,
        elbow: Elbow::Up,
        flip: Flip::NoFlip,
    };
    let at = |shown: [f64; 6]| {
        let arm = arm("textbook-6r");
        arm.forward(&arm.joints(&shown).unwrap()).unwrap()
    };
    let zero = textbook().inverse(&at([0.0; 6]), branch).unwrap();
    assert_eq!(
        zero.singular,
        [SingularityKind::Elbow, SingularityKind::Wrist]
    );
    let up = textbook().inverse(&at([0.0, 90.0, 0.0, 0.0, 40.0, 0.0]), branch);
    assert_eq!(
        up.unwrap().singular,
        [SingularityKind::Shoulder, SingularityKind::Elbow]
    );
    let mut far = *at([0.0; 6]).isometry();
    far.translation.vector.x += 10.0;
    let far = kinematics::Pose::try_from_isometry(far).unwrap();
    let error = textbook().inverse(&far, branch).unwrap_err();
    assert!(matches!(error, TextbookError::TooFar(excess) if (excess.0 - 10.0).abs() < 1e-9));
    let none = TextbookArm::try_new(
        Millimeters(400.0),
        Millimeters(f64::NAN),
        Millimeters(1.0),
        Millimeters(0.0),
    );
    assert!(none.unwrap_err().to_string().starts_with("a2 is NaN mm"));
}

/// The paper's example, along X: E and F both move by V T, and (3), (4) give the same joints.
#[test]
fn the_five_link_arm_moves_with_a_velocity_vector() {
    let five_links = arm("five-link");
    let start = five_links.home();
    let shown = five_links.shown(&start).unwrap();
    let joints: [f64; 5] = shown.try_into().unwrap();
    let before = five().points(&joints.map(Degrees)).unwrap();
    let velocity = Vector3::new(-30.0, 5.0, -2.0);
    let motion = five_links
        .move_by_velocity(
            &start,
            VelocityCommand::Vector(velocity),
            2.0,
            100,
            Task::PositionAndAxis,
        )
        .unwrap();
    assert_eq!(motion.end, MotionEnd::Completed);
    assert_eq!(motion.samples.len(), 101);
    for sample in &motion.samples {
        let way = velocity * sample.time_s;
        let closed = five()
            .inverse(&(before[4] + way), &(before[5] + way))
            .unwrap();
        let FiveLinkSolutions::One(closed) = closed else {
            panic!("one solution");
        };
        for (a, b) in closed.iter().zip(sample.joints.as_slice()) {
            assert!((a.0.to_radians() - b).abs() < 1e-8, "{closed:?} {sample:?}");
        }
    }
}

#[test]
fn a_motion_along_the_tool_stops_at_a_limit_with_its_name() {
    let scara = arm("scara");
    let start = scara.joints(&[10.0, 60.0, 50.0, 0.0]).unwrap();
    // Down with 100 mm/s: the quill's 200 mm end after 1.5 s.
    let command = VelocityCommand::AlongTool(100.0);
    let motion = scara
        .move_by_velocity(&start, command, 5.0, 50, Task::PositionAndHeading)
        .unwrap();
    let MotionEnd::Limit(limit) = &motion.end else {
        panic!("{:?}", motion.end);
    };
    assert_eq!(limit.joint, "Z");
    let last = motion.samples.last().unwrap();
    assert!((last.time_s - 1.5).abs() < 1e-6, "{}", last.time_s);
    assert!((last.joints.as_slice()[2] - 200.0).abs() < 1e-4);
}

#[test]
fn a_motion_stops_at_the_end_of_the_reach_and_where_a_joint_is_too_slow() {
    let scara = arm("scara");
    let start = scara.joints(&[0.0, 90.0, 50.0, 0.0]).unwrap();
    // Along Y from (325, 275): the circle of 600 mm is met at y = sqrt(600^2 - 325^2) = 504.36.
    let command = VelocityCommand::Vector(Vector3::new(0.0, 100.0, 0.0));
    let motion = scara
        .move_by_velocity(&start, command, 10.0, 500, Task::PositionAndHeading)
        .unwrap();
    let last = motion.samples.last().unwrap();
    let is_end = matches!(
        motion.end,
        MotionEnd::Singular { .. } | MotionEnd::TooFast { .. }
    );
    assert!(is_end, "{:?}", motion.end);
    assert!((last.position.y - 504.36).abs() < 0.5, "{}", last.position);
    // 10 m/s near axis 1 are too much for its 440 deg/s.
    let command = VelocityCommand::Vector(Vector3::new(0.0, 10_000.0, 0.0));
    let motion = scara
        .move_by_velocity(&start, command, 0.01, 10, Task::PositionAndHeading)
        .unwrap();
    assert!(matches!(&motion.end, MotionEnd::TooFast { load, .. } if *load > 1.0));
    let command = VelocityCommand::AlongTool(f64::NAN);
    let error = scara.move_by_velocity(&start, command, 1.0, 10, Task::Position);
    assert!(
        error
            .unwrap_err()
            .to_string()
            .starts_with("the speed is NaN")
    );
    let command = VelocityCommand::AlongTool(1.0);
    let error = scara.move_by_velocity(&start, command, 1.0, 0, Task::Position);
    assert_eq!(
        error.unwrap_err().to_string(),
        "the number of steps is 0; it must be from 1 to 100000"
    );
}
