//! Jacobians, joint rates, motion by a velocity vector.

use api::arms::{
    ArmFrames, ArmJacobianBody, ArmMotionEnd, ArmRatesBody, ArmTask, ArmTwist,
    ArmVelocityMotionBody,
};
use robotics::RefusalKind;

use crate::common::{assert_near, pose};

fn jacobian_of(joints: &[f64]) -> ArmJacobianBody {
    ArmJacobianBody {
        joints_deg_mm: joints.to_vec(),
        task: None,
        frames: ArmFrames::default(),
    }
}

fn rates_of(joints: &[f64], linear_mm_s: [f64; 3]) -> ArmRatesBody {
    ArmRatesBody {
        joints_deg_mm: joints.to_vec(),
        velocity: ArmTwist {
            linear_mm_s,
            angular_deg_s: [0.0; 3],
        },
        null_motion_deg_mm_s: None,
        task: None,
        frames: ArmFrames::default(),
    }
}

/// By hand, SCARA at J2 = 90, the quill at (325, 275): a degree of J1 is 325 pi/180 = 5.672320 along Y and -275 pi/180 =
/// -4.799655 along X; one of J2 moves only the second link, 275 long along Y: -4.799655 along X. The quill goes down.
/// Both turn the tool with the world's Z, the last joint against it.
#[test]
fn the_jacobian_of_the_scara_is_as_by_hand() {
    let answer = robotics::jacobian("scara", &jacobian_of(&[0.0, 90.0, 0.0, 0.0])).unwrap();
    let [x, y, z, .., turn] = answer.geometric.as_slice() else {
        panic!("six rows: {answer:?}");
    };
    assert_near(x, [-4.799_655_443, -4.799_655_443, 0.0, 0.0], 1e-8);
    assert_near(y, [5.672_320_069, 0.0, 0.0, 0.0], 1e-8);
    assert_near(z, [0.0, 0.0, -1.0, 0.0], 1e-12);
    assert_near(turn, [1.0, 1.0, 0.0, -1.0], 1e-12);
    // The flange looks down: theta is 180, so phi and psi have no rates of their own; W, P, R have.
    assert!(answer.analytic_zyz.is_none() && answer.zyz_singular.is_some());
    assert!(answer.analytic_wpr.is_some());
    assert_eq!((answer.rank, answer.full_rank), (4, 4));
    assert_eq!(answer.task, ArmTask::PositionAndHeading);
    // Stretched out, the two links move the quill alike: one direction is lost.
    let straight = robotics::jacobian("scara", &jacobian_of(&[0.0, 0.0, 0.0, 0.0])).unwrap();
    assert_eq!((straight.rank, straight.lost.len()), (3, 1));
    assert!(straight.condition.is_none() && straight.manipulability < 1e-9);
    let lost = straight.lost[0].linear_mm_s;
    assert!(
        lost[0].abs() > 1.0 && lost[1].abs() < 1e-6 * lost[0].abs(),
        "{lost:?}"
    );
}

/// With J5 at 0 the wrist of the M-20iA is singular, and its first three joints are not; the SCARA has no such wrist.
#[test]
fn what_is_singular_is_told() {
    let decomposition = |model: &str, joints: &[f64]| {
        let answer = robotics::jacobian(model, &jacobian_of(joints)).unwrap();
        (answer.rank, answer.decomposition)
    };
    let (rank, apart) = decomposition("fanuc-m20ia", &[0.0; 6]);
    let apart = apart.unwrap();
    assert_eq!((rank, apart.arm_rank, apart.wrist_rank), (5, 3, 2));
    let (rank, apart) = decomposition("fanuc-m20ia", &[0.0, 0.0, 0.0, 0.0, -90.0, 0.0]);
    let apart = apart.unwrap();
    assert_eq!((rank, apart.arm_rank, apart.wrist_rank), (6, 3, 3));
    // Axes 4, 5 and 6 at right angles.
    assert_near(&[apart.wrist_determinant.abs()], [1.0], 1e-9);
    assert!(decomposition("scara", &[0.0; 4]).1.is_none());
}

/// A tool 100 mm to the side of the quill moves when the last joint turns: by 100 pi/180 = 1.745329 mm a degree.
#[test]
fn the_jacobian_is_the_tools() {
    let question = ArmJacobianBody {
        frames: ArmFrames {
            tool: Some(pose([100.0, 0.0, 0.0, 0.0, 0.0, 0.0])),
            user_frame: None,
        },
        ..jacobian_of(&[0.0, 90.0, 0.0, 0.0])
    };
    let answer = robotics::jacobian("scara", &question).unwrap();
    let last: Vec<f64> = answer.geometric.iter().map(|row| row[3]).collect();
    // J1 + J2 = 90: the tool points along Y, and the joint turns against Z: along +X.
    assert_near(&last, [1.745_329_252, 0.0, 0.0, 0.0, 0.0, -1.0], 1e-8);
}

/// By hand, SCARA as above: 56.72320 mm/s along Y alone need 10 deg/s of J1; J2 has to undo the X of it with -10, and
/// the heading then stays. The last joint need not move.
#[test]
fn the_rates_of_the_scara_are_as_by_hand() {
    let question = rates_of(&[0.0, 90.0, 0.0, 0.0], [0.0, 56.723_200_69, 0.0]);
    let answer = robotics::rates("scara", &question).unwrap();
    assert_near(&answer.rates_deg_mm_s, [10.0, -10.0, 0.0, 0.0], 1e-6);
    // 10 of 440 deg/s.
    assert_near(&[answer.load], [10.0 / 440.0], 1e-8);
    // At the stretched arm X is lost.
    let stretched = rates_of(&[0.0; 4], [10.0, 0.0, 0.0]);
    let refused = robotics::rates("scara", &stretched).unwrap_err();
    assert_eq!(refused.kind, RefusalKind::Singular);
    assert!(refused.detail.contains("10.000 mm/s"), "{refused}");
}

#[test]
fn seven_joints_move_without_moving_the_tool() {
    let joints = [0.0, 30.0, 0.0, -60.0, 0.0, 45.0, 0.0];
    let still = ArmRatesBody {
        null_motion_deg_mm_s: Some(vec![0.0, 0.0, 10.0, 0.0, 0.0, 0.0, 0.0]),
        ..rates_of(&joints, [0.0; 3])
    };
    let answer = robotics::rates("seven-joint", &still).unwrap();
    assert!(
        answer.rates_deg_mm_s.iter().any(|rate| rate.abs() > 1.0),
        "{answer:?}"
    );
    let jacobian = robotics::jacobian("seven-joint", &jacobian_of(&joints)).unwrap();
    for row in &jacobian.geometric {
        let products = row
            .iter()
            .zip(&answer.rates_deg_mm_s)
            .map(|(j, rate)| j * rate);
        assert!(products.sum::<f64>().abs() < 1e-6);
    }
    assert_eq!(jacobian.free_deg_mm_s.len(), 1);
}

/// The quill, down at 40 mm/s for 2 s from 0: 80. From 150 its range ends at 200, after 1.25 s.
#[test]
fn the_quill_moves_with_a_velocity_and_stops_at_its_end() {
    let down = |from: f64| ArmVelocityMotionBody {
        start_deg_mm: vec![0.0, 90.0, from, 0.0],
        velocity_mm_s: Some([0.0, 0.0, -40.0]),
        time_s: 2.0,
        steps: Some(20),
        ..ArmVelocityMotionBody::default()
    };
    let answer = robotics::velocity_motion("scara", &down(0.0)).unwrap();
    assert_eq!(
        (answer.end, answer.samples.len()),
        (ArmMotionEnd::Completed, 21)
    );
    let last = answer.samples.last().unwrap();
    assert_near(&last.joints_deg_mm, [0.0, 90.0, 80.0, 0.0], 1e-6);
    assert_near(&last.tcp_mm, [325.0, 275.0, 300.0], 1e-6);
    let answer = robotics::velocity_motion("scara", &down(150.0)).unwrap();
    assert_eq!(answer.end, ArmMotionEnd::Limit);
    assert_near(&[answer.moved_s], [1.25], 1e-5);
    assert_eq!(answer.outside.unwrap().joint, "Z");
    // The same along the tool, which looks down.
    let along = ArmVelocityMotionBody {
        velocity_mm_s: None,
        along_tool_mm_s: Some(40.0),
        ..down(0.0)
    };
    let answer = robotics::velocity_motion("scara", &along).unwrap();
    assert_near(
        &answer.samples.last().unwrap().tcp_mm,
        [325.0, 275.0, 300.0],
        1e-6,
    );
    // Along X the arm is stretched before 400 mm.
    let out = ArmVelocityMotionBody {
        velocity_mm_s: Some([200.0, 0.0, 0.0]),
        ..down(0.0)
    };
    let answer = robotics::velocity_motion("scara", &out).unwrap();
    assert_eq!(answer.end, ArmMotionEnd::Singular, "{:?}", answer.detail);
    // From rest it would have to be faster than the quill's 1100 mm/s at once.
    let fast = ArmVelocityMotionBody {
        velocity_mm_s: Some([0.0, 0.0, -1200.0]),
        ..down(0.0)
    };
    let answer = robotics::velocity_motion("scara", &fast).unwrap();
    assert_eq!(answer.end, ArmMotionEnd::TooFast);
    let detail = answer.detail.unwrap();
    assert!(
        detail.contains("1200.000 mm/s") && detail.contains("1100.000 mm/s"),
        "{detail}"
    );
}
