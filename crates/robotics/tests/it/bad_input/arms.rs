//! Poses, velocities, taught points, obstacles of an arm.

use api::PoseBody;
use api::arms::{
    ArmCalibrationBody, ArmCalibrationPoint, ArmInverseBody, ArmObstacle, ArmSearch, ArmSolver,
    ArmTask, ArmTransferBody, ArmTransferResult, ArmVelocityMotionBody, FiveLinkPoints, ReachBody,
    ReachGrid, ReachPlane,
};

use robotics::Refusal;

use super::{HOME, M20, NAN, assert_refused};
use crate::common::{forward_of, pose};

fn reached(pose: PoseBody) -> ArmInverseBody {
    ArmInverseBody {
        pose: Some(pose),
        ..ArmInverseBody::default()
    }
}

#[test]
fn joints_and_poses_that_are_none_are_refused() {
    let forward = |joints: &[f64]| robotics::forward(M20, &forward_of(joints));
    assert_refused(
        forward(&[0.0; 5]),
        "joints_deg_mm",
        "5 joint values were given; fanuc-m20ia has 6",
    );
    assert_refused(
        forward(&[0.0, NAN, 0.0, 0.0, 0.0, 0.0]),
        "joints_deg_mm[1]",
        "J2 is NaN",
    );
    assert_refused(
        forward(&[0.0, 0.0, 2e6, 0.0, 0.0, 0.0]),
        "joints_deg_mm[2]",
        "J3 is 2000000",
    );
    let mut framed = forward_of(&HOME);
    framed.frames.tool = Some(pose([0.0, f64::INFINITY, 0.0, 0.0, 0.0, 0.0]));
    assert_refused(
        robotics::forward(M20, &framed),
        "frames.tool.y_mm",
        "y is inf mm",
    );

    let inverse = |body: &ArmInverseBody| robotics::inverse(M20, body);
    let there = pose([985.0, 0.0, 940.0, 180.0, 0.0, 0.0]);
    assert_refused(inverse(&ArmInverseBody::default()), "pose", "missing");
    let turned = PoseBody {
        r_deg: 36_001.0,
        ..there
    };
    assert_refused(inverse(&reached(turned)), "pose.r_deg", "r is 36001");
    let far = PoseBody {
        x_mm: 5000.0,
        ..there
    };
    assert_refused(inverse(&reached(far)), "pose", "beyond the stretched arm");
    let other = ArmInverseBody {
        method: Some(ArmSolver::FiveLink),
        ..reached(there)
    };
    assert_refused(
        inverse(&other),
        "method",
        "FiveLink does not cover fanuc-m20ia",
    );
    let task = ArmInverseBody {
        task: Some(ArmTask::Position),
        ..reached(there)
    };
    assert_refused(inverse(&task), "task", "ClosedForm solves Pose only");
    let both = ArmInverseBody {
        points: Some(FiveLinkPoints {
            e_mm: [0.0; 3],
            f_mm: [0.0; 3],
        }),
        ..reached(there)
    };
    assert_refused(inverse(&both), "points", "give one of them");
    let starts = ArmInverseBody {
        method: Some(ArmSolver::DampedLeastSquares),
        search: Some(ArmSearch {
            starts: Some(0),
            ..ArmSearch::default()
        }),
        ..reached(there)
    };
    assert_refused(
        inverse(&starts),
        "search.starts",
        "it is 0; it must be from 1 to 1000",
    );
    let outside = ArmInverseBody {
        method: Some(ArmSolver::DampedLeastSquares),
        near_deg_mm: Some(vec![0.0, 0.0, 0.0, 0.0, -90.0, 9000.0]),
        ..reached(there)
    };
    assert_refused(
        inverse(&outside),
        "near_deg_mm[5]",
        "J6 is 9000 deg; its range is",
    );
    // E and F must be one link apart: 100 mm.
    let apart = ArmInverseBody {
        points: Some(FiveLinkPoints {
            e_mm: [0.0, 0.0, -700.0],
            f_mm: [50.0, 0.0, -700.0],
        }),
        ..ArmInverseBody::default()
    };
    assert_refused(
        robotics::inverse("five-link", &apart),
        "points",
        "the link EF is 100.000000 mm long",
    );
}

#[test]
fn velocities_times_and_points_that_are_none_are_refused() {
    let motion = |change: fn(&mut ArmVelocityMotionBody)| {
        let mut body = ArmVelocityMotionBody {
            start_deg_mm: vec![0.0, 45.0, -60.0, 0.0, 30.0],
            velocity_mm_s: Some([-30.0, 5.0, -2.0]),
            time_s: 2.0,
            ..ArmVelocityMotionBody::default()
        };
        change(&mut body);
        robotics::velocity_motion("five-link", &body)
    };
    assert!(motion(|_| ()).is_ok());
    assert_refused(motion(|body| body.time_s = 0.0), "time_s", "it is 0 s");
    assert_refused(motion(|body| body.time_s = NAN), "time_s", "it is NaN s");
    assert_refused(
        motion(|body| body.steps = Some(1_000_000)),
        "steps",
        "from 1 to 5000",
    );
    assert_refused(
        motion(|body| body.velocity_mm_s = None),
        "velocity_mm_s",
        "missing",
    );
    assert_refused(
        motion(|body| body.velocity_mm_s = Some([0.0; 3])),
        "velocity_mm_s",
        "the speed is 0",
    );
    assert_refused(
        motion(|body| body.along_tool_mm_s = Some(5.0)),
        "along_tool_mm_s",
        "give one of them",
    );
    assert_refused(
        motion(|body| body.start_deg_mm[0] = 61.0),
        "start_deg_mm[0]",
        "A is 61 deg; its range is -60 to 60 deg",
    );

    let calibrate = |tip: usize, change: fn(&mut ArmCalibrationBody)| {
        let point = ArmCalibrationPoint {
            flange: Some(pose([500.0, 0.0, 500.0, 180.0, 0.0, 0.0])),
            ..ArmCalibrationPoint::default()
        };
        let mut body = ArmCalibrationBody {
            tip: vec![point; tip],
            ..ArmCalibrationBody::default()
        };
        change(&mut body);
        robotics::calibrate(M20, &body)
    };
    assert_refused(
        calibrate(2, |_| ()),
        "tip",
        "2 points were given; it must be 3 to 1000",
    );
    assert_refused(calibrate(3, |_| ()), "tip", "too alike");
    assert_refused(
        calibrate(3, |body| body.tip[1].flange = None),
        "tip[1]",
        "exactly one of",
    );
    assert_refused(
        calibrate(3, |body| body.along_x = body.tip.first().cloned()),
        "orient_origin",
        "missing",
    );
}

#[test]
fn too_many_poses_are_refused() {
    let grid = |step_mm: f64, method: ArmSolver, u_mm: [f64; 2]| {
        let body = ReachBody {
            grid: Some(ReachGrid {
                plane: ReachPlane::Xy,
                across_mm: 0.0,
                u_mm,
                v_mm: [0.0, 1000.0],
                step_mm,
                w_deg: 0.0,
                p_deg: 0.0,
                r_deg: 0.0,
            }),
            method: Some(method),
            ..ReachBody::default()
        };
        robotics::reach(M20, &body)
    };
    let closed = ArmSolver::ClosedForm;
    let says = "1001 x 1001 points, steps of 1 mm, are 1002001; at most 250000";
    assert_refused(grid(1.0, closed, [0.0, 1000.0]), "grid.step_mm", says);
    assert_refused(
        grid(10.0, ArmSolver::DampedLeastSquares, [0.0, 1000.0]),
        "grid.step_mm",
        "at most 2000",
    );
    assert_refused(
        grid(0.0, closed, [0.0, 1000.0]),
        "grid.step_mm",
        "it is 0 mm",
    );
    assert_refused(
        grid(1.0, closed, [10.0, 0.0]),
        "grid.u_mm[1]",
        "it is 0 mm; it must be from 10",
    );
    assert_refused(grid(0.001, closed, [-1e6, 1e6]), "grid.u_mm", "steps");
    assert_refused(
        robotics::reach(M20, &ReachBody::default()),
        "poses",
        "missing",
    );
    let none = ReachBody {
        poses: Some(Vec::new()),
        ..ReachBody::default()
    };
    assert_refused(robotics::reach(M20, &none), "poses", "0 poses were given");
}

fn transfer(change: fn(&mut ArmTransferBody)) -> Result<ArmTransferResult, Refusal> {
    let mut body = ArmTransferBody {
        start_deg_mm: HOME.to_vec(),
        goal_deg_mm: vec![40.0, 0.0, 0.0, 0.0, -90.0, 0.0],
        ..ArmTransferBody::default()
    };
    change(&mut body);
    robotics::transfer(M20, &body)
}

fn ends_at(goal: [f64; 6], body: &mut ArmTransferBody) {
    body.goal_deg_mm = Vec::new();
    body.goal_pose = Some(pose(goal));
}

#[test]
fn goals_of_a_transfer_that_it_cannot_end_at_are_refused() {
    assert_refused(
        transfer(|body| body.goal_pose = Some(pose([985.0, 0.0, 940.0, 180.0, 0.0, 0.0]))),
        "goal_pose",
        "there is goal_deg_mm too",
    );
    assert_refused(
        transfer(|body| body.goal_deg_mm = Vec::new()),
        "goal_deg_mm",
        "it is missing, and so is goal_pose",
    );
    assert_refused(
        transfer(|body| ends_at([5000.0, 0.0, 940.0, 180.0, 0.0, 0.0], body)),
        "goal_pose",
        "3298.630 mm beyond the stretched arm",
    );
    assert_refused(
        transfer(|body| ends_at([NAN, 0.0, 940.0, 180.0, 0.0, 0.0], body)),
        "goal_pose.x_mm",
        "NaN",
    );
    assert_refused(
        transfer(|body| {
            ends_at([985.0, 300.0, 640.0, 180.0, 0.0, 0.0], body);
            body.obstacles = vec![ArmObstacle::Box {
                pose: pose([985.0, 300.0, 640.0, 0.0, 0.0, 0.0]),
                size_mm: [50.0; 3],
            }];
        }),
        "goal_pose",
        "obstacle 1",
    );
}

#[test]
fn transfers_that_make_no_sense_are_refused() {
    assert!(transfer(|_| ()).is_ok());
    assert_refused(
        transfer(|body| {
            body.obstacles = vec![ArmObstacle::Box {
                pose: pose([985.0, 0.0, 940.0, 0.0, 0.0, 0.0]),
                size_mm: [50.0; 3],
            }];
        }),
        "start_deg_mm",
        "capsule",
    );
    assert_refused(
        transfer(|body| {
            body.obstacles = vec![ArmObstacle::KeepOut {
                min_mm: [0.0, 0.0, 10.0],
                max_mm: [1.0, 1.0, 10.0],
            }];
        }),
        "obstacles[0].max_mm[2]",
        "it is 10 mm",
    );
    assert_refused(
        transfer(|body| {
            body.obstacles = vec![ArmObstacle::Cylinder {
                pose: pose([0.0; 6]),
                radius_mm: NAN,
                height_mm: 1.0,
            }];
        }),
        "obstacles[0].radius_mm",
        "it is NaN mm",
    );
    assert_refused(
        transfer(|body| body.goal_deg_mm[0] = 171.0),
        "goal_deg_mm[0]",
        "J1 is 171 deg; its range is -170 to 170",
    );
    assert_refused(
        transfer(|body| body.margin_mm = Some(1.0)),
        "margin_mm",
        "it is 1 mm; it must be from 5",
    );
    assert_refused(
        transfer(|body| body.samples = Some(1_000_000)),
        "samples",
        "10000",
    );
    assert_refused(
        transfer(|body| body.capsules = Some(Vec::new())),
        "capsules",
        "0 capsules were given",
    );
    assert_refused(
        transfer(|body| {
            body.obstacles = vec![
                ArmObstacle::KeepOut {
                    min_mm: [0.0; 3],
                    max_mm: [1.0; 3]
                };
                101
            ];
        }),
        "obstacles",
        "101 obstacles were given",
    );
    let other = robotics::transfer("scara", &ArmTransferBody::default());
    assert_refused(
        other,
        "start_deg_mm",
        "0 joint values were given; scara has 4 joints",
    );
}
