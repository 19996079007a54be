//! Tool calibration, reachability, transfers.

use api::arms::{
    ArmCalibrationBody, ArmCalibrationMethod, ArmCalibrationPoint, ArmFrames, ArmObstacle,
    ArmSolver, ArmTransferBody, ArmTransferResult, ReachBody, ReachGrid, ReachPlane,
};

use api::paths::RouteMethod;
use robotics::{RefusalKind, Wanted};

use crate::common::{assert_near, forward_of, pose};
use crate::paths::{floor, line};

fn at(flange: [f64; 6]) -> ArmCalibrationPoint {
    ArmCalibrationPoint {
        flange: Some(pose(flange)),
        ..ArmCalibrationPoint::default()
    }
}

/// By hand: a tip 100 along the flange's Z and 10 along its X, at the world's (500, 0, 300). Turned by R the flange is
/// at (500, 0, 300) - R (10, 0, 100). Upright: (490, 0, 200). W = 180 turns Y and Z over: (490, 0, 400). P = 90 takes X
/// to -Z and Z to X: (10, 0, 100) becomes (100, 0, -10), the flange is at (400, 0, 310). W = 90 takes Z to -Y: (10,
/// -100, 0), the flange is at (490, 100, 300).
fn taught() -> Vec<ArmCalibrationPoint> {
    vec![
        at([490.0, 0.0, 200.0, 0.0, 0.0, 0.0]),
        at([490.0, 0.0, 400.0, 180.0, 0.0, 0.0]),
        at([400.0, 0.0, 310.0, 0.0, 90.0, 0.0]),
        at([490.0, 100.0, 300.0, 90.0, 0.0, 0.0]),
    ]
}

#[test]
fn a_tool_is_calibrated_as_by_hand() {
    let three = ArmCalibrationBody {
        tip: taught(),
        ..ArmCalibrationBody::default()
    };
    let answer = robotics::calibrate("fanuc-m20ia", &three).unwrap();
    assert_eq!(answer.method, ArmCalibrationMethod::ThreePoint);
    let tool = answer.tool;
    assert_near(&[tool.x_mm, tool.y_mm, tool.z_mm], [10.0, 0.0, 100.0], 1e-9);
    assert_near(&answer.place_mm, [500.0, 0.0, 300.0], 1e-9);
    assert_near(&[answer.worst_mm], [0.0], 1e-9);
    // The tool's X along the flange's Y, its Z along the flange's Z: R = 90.
    let six = ArmCalibrationBody {
        orient_origin: Some(at([490.0, 0.0, 200.0, 0.0, 0.0, 0.0])),
        along_x: Some(at([490.0, 100.0, 200.0, 0.0, 0.0, 0.0])),
        along_z: Some(at([490.0, 0.0, 300.0, 0.0, 0.0, 0.0])),
        ..three
    };
    let answer = robotics::calibrate("fanuc-m20ia", &six).unwrap();
    let tool = answer.tool;
    assert_near(
        &[tool.w_deg, tool.p_deg, tool.r_deg],
        [0.0, 0.0, 90.0],
        1e-9,
    );
}

#[test]
fn a_tool_is_calibrated_from_joints_too() {
    // The same tip in three postures of the arm, solved by the inverse kinematics with the tool on.
    let tool = pose([10.0, -20.0, 150.0, 0.0, 0.0, 0.0]);
    let turned = [[180.0, 0.0, 0.0], [150.0, 0.0, 0.0], [180.0, 30.0, 40.0]];
    let tip = turned.map(|[w, p, r]| {
        let question = api::arms::ArmInverseBody {
            pose: Some(pose([900.0, 100.0, 500.0, w, p, r])),
            frames: api::arms::ArmFrames {
                tool: Some(tool),
                user_frame: None,
            },
            ..Default::default()
        };
        let found = robotics::inverse("fanuc-m20ia", &question).unwrap();
        ArmCalibrationPoint {
            joints_deg_mm: Some(found.branches[0].joints_deg_mm.clone()),
            flange: None,
        }
    });
    let question = ArmCalibrationBody {
        tip: tip.to_vec(),
        ..ArmCalibrationBody::default()
    };
    let answer = robotics::calibrate("fanuc-m20ia", &question).unwrap();
    let found = answer.tool;
    assert_near(
        &[found.x_mm, found.y_mm, found.z_mm],
        [10.0, -20.0, 150.0],
        1e-6,
    );
    assert_near(&answer.place_mm, [900.0, 100.0, 500.0], 1e-6);
}

fn grid(step_mm: f64, method: Option<ArmSolver>) -> ReachBody {
    ReachBody {
        grid: Some(ReachGrid {
            plane: ReachPlane::Xz,
            across_mm: 0.0,
            u_mm: [0.0, 2400.0],
            v_mm: [-400.0, 1600.0],
            step_mm,
            w_deg: 180.0,
            p_deg: 0.0,
            r_deg: 0.0,
        }),
        method,
        ..ReachBody::default()
    }
}

#[test]
fn a_reachability_map_agrees_with_the_inverse_kinematics() {
    let answer = robotics::reach("fanuc-m20ia", &grid(400.0, None)).unwrap();
    assert_near(
        &answer.u_mm,
        [0.0, 400.0, 800.0, 1200.0, 1600.0, 2000.0, 2400.0],
        0.0,
    );
    assert_near(
        &answer.v_mm,
        [-400.0, 0.0, 400.0, 800.0, 1200.0, 1600.0],
        0.0,
    );
    assert_eq!(answer.solutions.len(), 42);
    let mut reachable = 0;
    for (index, inside) in answer.inside.iter().enumerate() {
        let (x, z) = (answer.u_mm[index % 7], answer.v_mm[index / 7]);
        let question = api::arms::ArmInverseBody {
            pose: Some(pose([x, 0.0, z, 180.0, 0.0, 0.0])),
            ..Default::default()
        };
        let found = robotics::inverse("fanuc-m20ia", &question);
        let any = found.is_ok_and(|found| found.nearest.is_some());
        assert_eq!(*inside > 0, any, "{x}, {z}");
        reachable += usize::from(any);
    }
    assert_eq!(answer.reachable, reachable);
    // 2400 is beyond the stretched arm: 150 + 790 + hypot(250, 835) = 1812 to the wrist.
    assert!(answer.inside.chunks(7).all(|row| row[6] == 0));
    // The quartic counts alike.
    let quartic = robotics::reach("fanuc-m20ia", &grid(400.0, Some(ArmSolver::Quartic))).unwrap();
    for (a, b) in answer.solutions.iter().zip(&quartic.solutions) {
        assert_eq!(*a > 0, *b > 0);
    }
}

/// By hand, SCARA: the quill's middle reaches from |325 - 275| = 50 to 600 around the base, but J2 only to 145 degrees:
/// hypot(325 - 275 cos 35, 275 sin 35) = 186.7. From 280 to 380 of height.
#[test]
fn the_reach_of_the_scara_is_a_ring() {
    let question = ReachBody {
        poses: Some(
            [
                [150.0, 300.0],
                [200.0, 300.0],
                [599.0, 300.0],
                [601.0, 300.0],
                [400.0, 100.0],
            ]
            .map(|[x, z]| pose([x, 0.0, z, 180.0, 0.0, 0.0]))
            .to_vec(),
        ),
        ..ReachBody::default()
    };
    let answer = robotics::reach("scara", &question).unwrap();
    assert_eq!(answer.method, ArmSolver::DampedLeastSquares);
    assert_eq!(answer.inside, [0, 1, 1, 0, 0]);
}

/// Between start and goal stands a zone that the straight way in joint space goes through.
#[test]
fn a_transfer_goes_around_what_is_in_the_way() {
    let question = ArmTransferBody {
        start_deg_mm: vec![45.0, 20.0, -20.0, 0.0, -70.0, 0.0],
        goal_deg_mm: vec![-45.0, 20.0, -20.0, 0.0, -70.0, 0.0],
        obstacles: vec![ArmObstacle::KeepOut {
            min_mm: [700.0, -100.0, -500.0],
            max_mm: [1500.0, 100.0, 900.0],
        }],
        ..ArmTransferBody::default()
    };
    let answer = robotics::transfer("fanuc-m20ia", &question).unwrap();
    assert!(answer.points_deg_mm.len() > 2 && answer.length_deg > 90.0);
    assert_eq!(answer.points_deg_mm.first(), Some(&question.start_deg_mm));
    assert_eq!(answer.points_deg_mm.last(), Some(&question.goal_deg_mm));
    assert_eq!(
        answer.flange_mm.len(),
        16 * (answer.points_deg_mm.len() - 1) + 1
    );
    for point in &answer.flange_mm {
        let [x, y, z] = *point;
        assert!(
            !((700.0..1500.0).contains(&x) && y.abs() < 100.0 && z < 900.0),
            "{point:?}"
        );
    }
    let again = robotics::transfer("fanuc-m20ia", &question).unwrap();
    assert_eq!(answer, again);
    // Without it, straight.
    let free = ArmTransferBody {
        obstacles: Vec::new(),
        ..question
    };
    let answer = robotics::transfer("fanuc-m20ia", &free).unwrap();
    assert_near(&[answer.length_deg], [90.0], 1e-9);
    // The flange is where the forward kinematics has it.
    let there = robotics::forward("fanuc-m20ia", &forward_of(&free.start_deg_mm)).unwrap();
    assert_near(
        &answer.flange_mm[0],
        [there.tcp.x_mm, there.tcp.y_mm, there.tcp.z_mm],
        1e-6,
    );
}

/// Each arm turns its first joint to and fro; a box is where its flange would be in the middle.
#[test]
fn every_arm_goes_around_a_box() {
    for (model, posture) in [
        ("fanuc-m20ia", vec![0.0, 20.0, -20.0, 0.0, -70.0, 0.0]),
        (
            "fanuc-m20ia-machine",
            vec![0.0, 20.0, -20.0, 0.0, -70.0, 0.0],
        ),
        ("textbook-6r", vec![0.0, 60.0, -60.0, 0.0, -60.0, 0.0]),
        ("five-link", vec![0.0, 45.0, -60.0, 0.0, 30.0]),
        ("scara", vec![0.0, 30.0, 100.0, 0.0]),
        ("seven-joint", vec![0.0, 40.0, 0.0, -70.0, 0.0, 50.0, 0.0]),
    ] {
        let turned = |j1: f64| {
            let mut joints = posture.clone();
            joints[0] = j1;
            joints
        };
        let middle = robotics::forward(model, &forward_of(&turned(0.0))).unwrap();
        let at = [middle.flange.x_mm, middle.flange.y_mm, middle.flange.z_mm];
        let (min, max) = (at.map(|value| value - 30.0), at.map(|value| value + 30.0));
        let question = ArmTransferBody {
            start_deg_mm: turned(-40.0),
            goal_deg_mm: turned(40.0),
            obstacles: vec![ArmObstacle::KeepOut {
                min_mm: min,
                max_mm: max,
            }],
            margin_mm: Some(5.0),
            ..ArmTransferBody::default()
        };
        let answer = robotics::transfer(model, &question).unwrap();
        assert!(answer.points_deg_mm.len() > 2, "{model}");
        assert_eq!(answer.points_deg_mm.last(), Some(&question.goal_deg_mm));
        assert_eq!(answer.length_mm.is_some(), model == "scara");
        for point in &answer.flange_mm {
            let mut coordinates = point.iter().zip(min).zip(max);
            let inside = coordinates.all(|((value, min), max)| (min..max).contains(value));
            assert!(!inside, "{model}: {point:?}");
        }
    }
}

/// The textbook's arm reaches most poses with its elbow up and down. Where the elbow nearest to the start would be,
/// there is a box: the way ends with the other one.
#[test]
fn a_transfer_to_a_pose_ends_at_the_nearest_joints_that_are_free() {
    let model = "textbook-6r";
    let goal = [510.119, 171.512, 1159.066, 25.231, 17.644, -87.535];
    let question = ArmTransferBody {
        start_deg_mm: vec![40.0, 35.0, 35.0, 10.0, 50.0, 60.0],
        goal_pose: Some(goal.into()),
        margin_mm: Some(5.0),
        ..ArmTransferBody::default()
    };
    let reached = |answer: &ArmTransferResult| {
        let end = answer.points_deg_mm.last().unwrap();
        let tcp = robotics::forward(model, &forward_of(end)).unwrap().tcp;
        assert_near(
            &[
                tcp.x_mm, tcp.y_mm, tcp.z_mm, tcp.w_deg, tcp.p_deg, tcp.r_deg,
            ],
            goal,
            1e-6,
        );
        end.clone()
    };
    let nearest = robotics::transfer(model, &question).unwrap();
    let end = reached(&nearest);
    assert_near(&end[..3], [20.0, 30.0, 40.0], 1e-3);
    // The shoulder is on the base's axis; the upper arm ends at the elbow.
    let shape = nearest.capsules.last().unwrap();
    let elbow = shape[1].to_mm;
    let blocked = ArmTransferBody {
        obstacles: vec![ArmObstacle::KeepOut {
            min_mm: elbow.map(|value| value - 10.0),
            max_mm: elbow.map(|value| value + 10.0),
        }],
        ..question
    };
    let answer = robotics::transfer(model, &blocked).unwrap();
    let other = reached(&answer);
    assert!((other[2] - end[2]).abs() > 30.0, "{end:?} {other:?}");
}

/// The tool hangs 150 mm below the flange: with it, the same pose is reached by a higher flange.
#[test]
fn the_goal_of_a_transfer_is_the_tools_pose() {
    let goal = [985.0, 100.0, 640.0, 180.0, 0.0, 0.0];
    let question = ArmTransferBody {
        start_deg_mm: vec![45.0, 20.0, -20.0, 0.0, -70.0, 0.0],
        goal_pose: Some(goal.into()),
        frames: ArmFrames {
            tool: Some([0.0, 0.0, 150.0, 0.0, 0.0, 0.0].into()),
            ..ArmFrames::default()
        },
        ..ArmTransferBody::default()
    };
    let answer = robotics::transfer("fanuc-m20ia", &question).unwrap();
    assert_near(
        answer.flange_mm.last().unwrap(),
        [985.0, 100.0, 790.0],
        1e-6,
    );
}

#[test]
fn what_nobody_waits_for_is_broken_off() {
    let over = Wanted::while_true(&|| false);
    let transfer = ArmTransferBody {
        start_deg_mm: vec![45.0, 20.0, -20.0, 0.0, -70.0, 0.0],
        goal_deg_mm: vec![-45.0, 20.0, -20.0, 0.0, -70.0, 0.0],
        obstacles: vec![ArmObstacle::KeepOut {
            min_mm: [700.0, -100.0, -500.0],
            max_mm: [1500.0, 100.0, 900.0],
        }],
        ..ArmTransferBody::default()
    };
    let path = line([985.0, 400.0, 940.0, 180.0, 0.0, 0.0]);
    let mut ends = vec![
        robotics::transfer_while("fanuc-m20ia", &transfer, over).map(|_| ()),
        robotics::tool_path_while("fanuc-m20ia", &path, over).map(|_| ()),
        robotics::reach_while("fanuc-m20ia", &grid(400.0, None), over).map(|_| ()),
    ];
    for method in [
        RouteMethod::Trapezoidal,
        RouteMethod::Quadtree,
        RouteMethod::PotentialField,
        RouteMethod::Roadmap,
    ] {
        ends.push(robotics::plan_route_while(&floor(method), over).map(|_| ()));
    }
    for end in ends {
        let refusal = end.unwrap_err();
        assert_eq!(refusal.kind, RefusalKind::BrokenOff, "{refusal}");
        assert_eq!(
            refusal.to_string(),
            "broken off: nobody waits for the answer any more"
        );
    }
}
