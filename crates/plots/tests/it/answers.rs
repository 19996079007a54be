//! The answers of the API as they are drawn: the numbers come from the real functions.

#![expect(
    clippy::unwrap_used,
    reason = "an answer that does not come is a test that fails"
)]

use api::arms::{
    ArmCalibrationBody, ArmCalibrationPoint, ArmDescription, ArmForwardBody, ArmForwardResult,
    ArmFrames, ArmJacobianBody, ArmObstacle, ArmRatesBody, ArmTransferBody, ArmTwist,
    ArmVelocityMotionBody, ReachBody, ReachGrid, ReachPlane,
};
use api::paths::{FloorBody, PlanRouteBody, PolygonBody, RouteMethod, RouteSearch};
use api::trajectory::{JointStates, TrajectoryBody, TrajectoryKind, TrajectoryResult};
use plots::PlotError;
use plots::answers::{self, Drive, DriveSample, Labeled, Taught, TaughtBy, TrajectoryLook};

use crate::seen::seen;

const MODEL: &str = "fanuc-m20ia";
const BLUE: &str = "#0072B2";

fn at(model: &str, joints: &[f64]) -> ArmForwardResult {
    let body = ArmForwardBody {
        joints_deg_mm: joints.to_vec(),
        frames: ArmFrames::default(),
    };
    robotics::forward(model, &body).unwrap()
}

fn trajectory(model: &str, from: &[f64], to: &[f64]) -> TrajectoryResult {
    let states = |position: &[f64]| JointStates {
        position_deg_mm: position.to_vec(),
        ..JointStates::default()
    };
    let body = TrajectoryBody {
        kind: TrajectoryKind::JerkLimited,
        start: states(from),
        goal: states(to),
        via_deg_mm: Vec::new(),
        durations_s: Vec::new(),
        max_velocity_deg_mm_s: None,
        max_acceleration_deg_mm_s2: None,
        max_jerk_deg_mm_s3: None,
        period_s: None,
        frames: ArmFrames::default(),
    };
    robotics::trajectory(model, &body).unwrap()
}

#[test]
fn the_five_link_arm_has_its_letters_in_all_four_pictures() {
    let joints = [20.0, 45.0, -60.0, 30.0, 40.0];
    let drawing = answers::posture("five-link", &joints, &at("five-link", &joints)).unwrap();
    let seen = seen(&drawing);
    for letter in ["A", "B", "C", "D", "E", "F"] {
        assert_eq!(seen.count(letter), 4, "{letter}");
    }
    assert!(seen.says("five-link at 20, 45, -60, 30, 40"));
    assert!(
        seen.texts
            .iter()
            .any(|text| text.starts_with("Tool at X, Y, Z = 120.134, "))
    );
    // A dot with its rim for each of the six points in each of the four.
    assert_eq!(seen.circles.len(), 6 * 4 * 2);
}

#[test]
fn a_joint_outside_its_range_is_said() {
    let joints = [0.0, 120.0, 0.0, 0.0, -90.0, 0.0];
    let drawing = answers::posture(MODEL, &joints, &at(MODEL, &joints)).unwrap();
    assert!(
        seen(&drawing)
            .texts
            .iter()
            .any(|text| text == "Outside its ranges: J2 is 120, its range -70 to 90")
    );
}

#[test]
fn joint_sets_that_lie_on_each_other_are_both_seen() {
    let labeled = |name: &str, within_ranges: bool, joints: [f64; 6]| Labeled {
        name: name.to_owned(),
        within_ranges,
        at: at(MODEL, &joints),
    };
    let found = [
        labeled("1: N", true, [0.0, 0.0, 0.0, 0.0, -90.0, 0.0]),
        labeled("2: F", true, [0.0, 0.0, 0.0, 180.0, 90.0, 180.0]),
        labeled("3", false, [180.0, -70.0, 100.0, 180.0, -170.0, 0.0]),
    ];
    let drawing = answers::branches(MODEL, "", &found).unwrap();
    let seen = seen(&drawing);
    assert!(seen.says("fanuc-m20ia: 3 joint sets reach the pose, 2 inside the ranges"));
    assert!(seen.says("outside the ranges") && seen.says("1: N") && seen.says("2: F"));
    // Thick below, thin on top; in four pictures and the legend.
    assert_eq!(seen.drawn(BLUE, 6.0).len(), 5);
    assert_eq!(seen.drawn("#D55E00", 1.6).len(), 5);
}

fn look<'a>(arm: &'a ArmDescription, answer: &'a TrajectoryResult) -> TrajectoryLook<'a> {
    TrajectoryLook {
        title: "A move",
        note: "",
        arm,
        samples: &answer.samples,
        peaks: &answer.peaks,
        via_s: &[],
        path_mm: &[],
        failure: None,
    }
}

#[test]
fn a_trajectory_has_a_panel_for_each_quantity_and_its_limits() {
    let from = [0.0, 0.0, 0.0, 0.0, -90.0, 0.0];
    let answer = trajectory(MODEL, &from, &[60.0, 20.0, -20.0, 0.0, -70.0, 0.0]);
    let arm = robotics::describe(MODEL).unwrap();
    let look = look(&arm, &answer);
    let drawing = answers::joints_in_time(&look).unwrap();
    let drawn = seen(&drawing);
    for label in [
        "position in °",
        "velocity in %",
        "acceleration in %",
        "jerk in %",
    ] {
        assert_eq!(drawn.count(label), 1, "{label}");
    }
    assert_eq!(drawn.count("time in s"), 4);
    // Velocity, acceleration and jerk come near their limits, both ways.
    assert_eq!(drawn.count("limit"), 6);
    // J1 in four panels, which decides: its acceleration touches the limit.
    let curves = drawn.drawn(BLUE, 1.8);
    assert_eq!(curves.len(), 4);
    let limits = drawn.drawn("#D55E00", 1.2);
    let top = |curve: &[(f64, f64)]| curve.iter().map(|point| point.1).fold(1e9, f64::min);
    let touches = limits
        .iter()
        .any(|limit| (top(curves[2]) - limit[0].1).abs() < 0.5);
    assert!(touches, "{:?} {limits:?}", top(curves[2]));
    let tool = seen(&answers::tool_in_time(&look).unwrap());
    assert!(tool.says("place in mm") && tool.says("speed in mm/s"));
    let space = answers::tool_in_space(&look, Some(&at(MODEL, &from)), None).unwrap();
    assert!(seen(&space).says("way of the tool") && seen(&space).says("at the start"));
}

#[test]
fn a_joint_that_slides_has_a_panel_in_millimeters() {
    let answer = trajectory("scara", &[0.0, 0.0, 20.0, 0.0], &[60.0, 60.0, 120.0, 90.0]);
    let arm = robotics::describe("scara").unwrap();
    let look = TrajectoryLook {
        via_s: &[0.1],
        ..look(&arm, &answer)
    };
    let drawing = answers::joints_in_time(&look).unwrap();
    let seen = seen(&drawing);
    assert!(seen.says("position in °") && seen.says("position in mm"));
    // 20 mm are near the end of the range, which is 0.
    assert!(seen.says("Z min 0"), "{:?}", seen.texts);
    assert_eq!(seen.count("via 1"), 5);
}

#[test]
fn the_velocities_of_a_stretched_wrist_are_drawn_with_what_is_lost() {
    let joints = [0.0; 6];
    let arm = robotics::describe(MODEL).unwrap();
    let body = ArmJacobianBody {
        joints_deg_mm: joints.to_vec(),
        task: None,
        frames: ArmFrames::default(),
    };
    let mut jacobian = robotics::jacobian(MODEL, &body).unwrap();
    let place = at(MODEL, &joints);
    let drawing = answers::velocities(&arm, &joints, &place, &jacobian).unwrap();
    let texts = seen(&drawing).texts;
    assert!(
        texts
            .iter()
            .any(|text| text == "Rank 5 of 6, manipulability 0")
    );
    let _shorter = jacobian.geometric[1].pop();
    let error = answers::velocities(&arm, &joints, &place, &jacobian).unwrap_err();
    assert_eq!(
        error.to_string(),
        "a row of the Jacobian has 5 values where 6 are needed"
    );
}

#[test]
fn a_motion_that_ended_early_says_why() {
    let start = [0.0, 45.0, -60.0, 0.0, 30.0];
    let body = ArmVelocityMotionBody {
        start_deg_mm: start.to_vec(),
        velocity_mm_s: Some([60.0, 30.0, 20.0]),
        time_s: 8.0,
        ..ArmVelocityMotionBody::default()
    };
    let answer = robotics::velocity_motion("five-link", &body).unwrap();
    let last = &answer.samples[answer.samples.len() - 1];
    let end = at("five-link", &last.joints_deg_mm);
    let arms = answers::velocity_motion("five-link", &answer, &at("five-link", &start), &end);
    let seen_arms = seen(&arms.unwrap());
    assert!(seen_arms.says("at the start") && seen_arms.says("way of the tool"));
    let arm = robotics::describe("five-link").unwrap();
    let joints = seen(&answers::velocity_motion_joints(&arm, &answer).unwrap());
    assert!(
        joints.says("stopped") && joints.says("D min -95"),
        "{:?}",
        joints.texts
    );
}

#[test]
fn a_reach_has_a_cell_for_each_pose_and_says_how_many_are_reached() {
    let grid = ReachGrid {
        plane: ReachPlane::Xz,
        across_mm: 0.0,
        u_mm: [-200.0, 1400.0],
        v_mm: [0.0, 1200.0],
        step_mm: 200.0,
        w_deg: 180.0,
        p_deg: 0.0,
        r_deg: 0.0,
    };
    let body = ReachBody {
        grid: Some(grid.clone()),
        ..ReachBody::default()
    };
    let mut answer = robotics::reach(MODEL, &body).unwrap();
    let drawing = seen(&answers::reach(MODEL, &grid, &answer).unwrap());
    let text = format!("{} of 63 poses are reached", answer.reachable);
    assert!(
        drawing.texts.iter().any(|line| line.ends_with(&text)),
        "{:?}",
        drawing.texts
    );
    assert!(drawing.says("Z in mm") && drawing.says("2") && drawing.says("base"));
    let _missing = answer.inside.pop();
    let error = answers::reach(MODEL, &grid, &answer).unwrap_err();
    assert!(
        matches!(
            error,
            PlotError::Shape {
                given: 62,
                wanted: 63,
                ..
            }
        ),
        "{error}"
    );
}

#[test]
fn a_route_shows_floor_obstacles_cells_and_both_ends() {
    let ask = |method: RouteMethod| {
        let body = PlanRouteBody {
            floor: FloorBody {
                min_mm: [0.0, 0.0],
                max_mm: [3000.0, 2000.0],
            },
            obstacles: vec![PolygonBody {
                name: None,
                corners_mm: vec![
                    [1200.0, 0.0],
                    [1600.0, 0.0],
                    [1600.0, 1200.0],
                    [1200.0, 1200.0],
                ],
            }],
            radius_mm: 200.0,
            start_mm: [500.0, 500.0],
            goal_mm: [2500.0, 500.0],
            search: RouteSearch {
                method: Some(method),
                ..RouteSearch::default()
            },
        };
        robotics::plan_route(&body).unwrap()
    };
    for (method, behind) in [
        (RouteMethod::Trapezoidal, "free cell"),
        (RouteMethod::Quadtree, "cell not wholly free"),
        (RouteMethod::PotentialField, "walked on the way"),
        (RouteMethod::Roadmap, "roadmap"),
    ] {
        let answer = ask(method);
        let drawing = answers::route(&answer).unwrap();
        let seen = seen(&drawing);
        for name in [
            "obstacle",
            "edge of the floor",
            "route",
            "start",
            "goal",
            "X in mm",
            behind,
        ] {
            assert!(seen.says(name), "{method:?}: {name} in {:?}", seen.texts);
        }
        // The route is one line, the other of its color is the legend's; from start to goal at one height.
        let routes = seen.drawn(BLUE, 3.0);
        assert_eq!(routes.len(), 2, "{method:?}");
        let route = routes.iter().max_by_key(|line| line.len()).unwrap();
        assert!((route[0].1 - route[route.len() - 1].1).abs() < 0.3);
        // Two rings of the disc.
        let rings = seen.circles.iter().filter(|circle| circle.2 > 20.0).count();
        assert_eq!(rings, 2, "{method:?}");
    }
}

#[test]
fn a_transfer_shows_each_edge_of_the_zone() {
    let obstacles = vec![
        ArmObstacle::KeepOut {
            min_mm: [700.0, -100.0, -500.0],
            max_mm: [1000.0, 100.0, 500.0],
        },
        ArmObstacle::Cylinder {
            pose: at(MODEL, &[0.0; 6]).flange,
            radius_mm: 10.0,
            height_mm: 20.0,
        },
    ];
    let body = ArmTransferBody {
        start_deg_mm: vec![60.0, 20.0, -20.0, 0.0, -70.0, 0.0],
        goal_deg_mm: vec![-60.0, 20.0, -20.0, 0.0, -70.0, 0.0],
        obstacles: obstacles[..1].to_vec(),
        ..ArmTransferBody::default()
    };
    let answer = robotics::transfer(MODEL, &body).unwrap();
    let seen = seen(&answers::transfer(MODEL, &obstacles, &answer).unwrap());
    for name in [
        "keep-out zone",
        "obstacle",
        "arm at the start",
        "arm at the goal",
        "way of the flange",
    ] {
        assert_eq!(seen.count(name), 1, "{name}");
    }
    // Two rounds and four uprights, in four pictures, and the legend.
    assert_eq!(seen.drawn("#D55E00", 1.4).len(), 6 * 4 + 1);
}

#[test]
fn all_four_wheels_are_seen_even_where_they_turn_alike() {
    let sample = |time_s: f64, speed: f64| DriveSample {
        time_s,
        x_mm: 0.0,
        y_mm: 0.0,
        heading_deg: 0.0,
        speed_mm_s: speed * 100.0,
        turn_deg_s: 0.0,
        wheels_rad_s: [speed; 4],
    };
    let drive = Drive {
        samples: vec![sample(0.0, 0.0), sample(1.0, 8.0), sample(2.0, 0.0)],
        max_wheel_speed_rad_s: 12.0,
    };
    let seen = seen(&answers::wheels("A drive", &drive).unwrap());
    for (color, pixels) in [
        (BLUE, 4.6),
        ("#D55E00", 4.6),
        ("#009E73", 1.6),
        ("#E69F00", 1.6),
    ] {
        assert_eq!(seen.drawn(color, pixels).len(), 1, "{color}");
    }
    assert!(seen.says("limit 12") && seen.says("limit -12") && seen.says("speed in rad/s"));
}

#[test]
fn rates_move_the_arm_and_a_velocity_is_a_line() {
    let joints = [0.0, 0.0, 0.0, 0.0, -90.0, 0.0];
    let velocity = ArmTwist {
        linear_mm_s: [0.0, 100.0, 0.0],
        angular_deg_s: [0.0; 3],
    };
    let body = ArmRatesBody {
        joints_deg_mm: joints.to_vec(),
        velocity,
        null_motion_deg_mm_s: None,
        task: None,
        frames: ArmFrames::default(),
    };
    let answer = robotics::rates(MODEL, &body).unwrap();
    let moved = joints.iter().zip(&answer.rates_deg_mm_s);
    let later: Vec<f64> = moved.map(|(at, rate)| at + rate * 0.5).collect();
    let (now, later) = (at(MODEL, &joints), at(MODEL, &later));
    let drawing = answers::rates(MODEL, &answer, &velocity, 0.5, (&now, &later)).unwrap();
    let seen = seen(&drawing);
    assert!(seen.says("fanuc-m20ia: the arm now, and 0.5 s later at its joints' rates"));
    let load = format!("{} % of what", (answer.load * 1e5).round() / 1e3);
    assert!(
        seen.texts.iter().any(|text| text.starts_with(&load)),
        "{load}"
    );
    // In four pictures and the legend; seen along Y, the velocity is a point.
    assert_eq!(seen.drawn("#D55E00", 2.4).len(), 5);
    assert_eq!(seen.drawn(BLUE, 3.0).len(), 5);
}

#[test]
fn taught_postures_meet_at_the_place() {
    let joints = [
        [5.947, -3.744, -10.63, 0.0, -79.37, -5.947],
        [5.28, 5.018, -11.157, -2.294, -103.739, -5.333],
        [9.238, -7.147, -11.451, 18.346, -69.022, 25.58],
    ];
    let point = |joints: &[f64; 6]| ArmCalibrationPoint {
        joints_deg_mm: Some(joints.to_vec()),
        flange: None,
    };
    let body = ArmCalibrationBody {
        tip: joints.iter().map(point).collect(),
        ..ArmCalibrationBody::default()
    };
    let answer = robotics::calibrate(MODEL, &body).unwrap();
    let mut taught: Vec<Taught> = (1..)
        .zip(&joints)
        .map(|(number, joints)| {
            let body = ArmForwardBody {
                joints_deg_mm: joints.to_vec(),
                frames: ArmFrames {
                    tool: Some(answer.tool),
                    user_frame: None,
                },
            };
            Taught {
                name: format!("tip {number}"),
                by: TaughtBy::Joints(robotics::forward(MODEL, &body).unwrap()),
            }
        })
        .collect();
    taught.push(Taught {
        name: "by its pose".to_owned(),
        by: TaughtBy::Flange([900.0, 0.0, 800.0, 180.0, 0.0, 0.0].into()),
    });
    let drawing = answers::calibration(MODEL, &answer, &taught).unwrap();
    let seen = seen(&drawing);
    assert!(seen.says("fanuc-m20ia: a tool by the three-point method"));
    assert!(seen.says("tip 3") && seen.says("by its pose") && seen.says("place"));
    // The four ways to the place end in one point of each picture, a tenth of a millimeter being no pixel.
    let ways = ["#0072B2", "#D55E00", "#009E73", "#E69F00"].map(|color| seen.drawn(color, 3.0));
    // The first of each is the legend's.
    for picture in 1..=4 {
        let ends = ways.each_ref().map(|ways| *ways[picture].last().unwrap());
        for end in ends {
            let apart = (end.0 - ends[0].0).hypot(end.1 - ends[0].1);
            assert!(apart < 0.5, "{ends:?}");
        }
    }
    assert!(matches!(
        answers::calibration(MODEL, &answer, &[]),
        Err(PlotError::Empty { .. })
    ));
}
