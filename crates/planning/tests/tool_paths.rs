//! Lines, circles and splines: geometry by hand, limits at every sample, where a path fails.
#![allow(
    clippy::indexing_slicing,
    clippy::unwrap_used,
    clippy::wildcard_enum_match_arm,
    reason = "the helpers of tests, too, may fail loudly"
)]

use kinematics::serial::{SerialArm, Task};
use kinematics::{ArmModel, Axis, Frames, IkError, PendantJoints, Pose, Seed, Xyzwpr};
use planning::Wanted;
use planning::cartesian::{
    Demands, Extent, PathError, Sample, SolvedArm, Solver, ToolError, ToolFollower, ToolLimits,
    ToolMove, ToolMoveError, ToolPath,
};
use planning::jerk::{MotionLimits, Progress};
use units::{Degrees, Millimeters, MmPerSec, MmPerSec2, RadPerSec};

const LIMITS: ToolLimits = ToolLimits {
    speed: MmPerSec(200.0),
    acceleration: MmPerSec2(1000.0),
    jerk: 10_000.0,
    turning: RadPerSec(1.0),
};

fn arm() -> &'static ArmModel {
    ArmModel::builtin("fanuc-m20ia").unwrap()
}

fn pose(x: f64, y: f64, z: f64, wpr: [f64; 3]) -> Pose {
    let position = [x, y, z].map(Millimeters);
    Pose::try_from_xyzwpr(&Xyzwpr::new(position, wpr.map(Degrees))).unwrap()
}

fn down(x: f64, y: f64, z: f64) -> Pose {
    pose(x, y, z, [180.0, 0.0, 0.0])
}

fn position(pose: &Pose) -> [f64; 3] {
    pose.isometry().translation.vector.into()
}

fn near(a: [f64; 3], b: [f64; 3], tolerance: f64) {
    for (a, b) in a.iter().zip(b) {
        assert!((a - b).abs() < tolerance, "{a} {b}");
    }
}

fn joints(at: &Pose) -> PendantJoints {
    arm().inverse(at, Seed::Near(arm().home())).unwrap().joints
}

fn go(path: &ToolPath, limits: &ToolLimits) -> Result<ToolMove, ToolError> {
    let start = joints(&path.pose_at(0.0).unwrap());
    go_from(path, limits, &start, 0.008)
}

fn go_from(
    path: &ToolPath,
    limits: &ToolLimits,
    start: &PendantJoints,
    period: f64,
) -> Result<ToolMove, ToolError> {
    let serial = SerialArm::builtin("fanuc-m20ia").unwrap();
    let solved = SolvedArm {
        arm: serial,
        frames: &Frames::default(),
        solver: Solver::ClosedForm(arm()),
    };
    let start = serial.joints(&start.degrees()).unwrap();
    let planned = ToolMove::try_new(&solved, path, limits, &start, period, Wanted::ALWAYS);
    planned.map_err(|error| match error {
        ToolMoveError::Tool(error) => error,
        other => panic!("{other}"),
    })
}

fn pendant(sample: &Sample) -> PendantJoints {
    PendantJoints::from_radians(sample.joints.as_slice().try_into().unwrap())
}

/// Every sample on the path, every joint within its limits, speed and acceleration.
fn keeps_its_promises(plan: &ToolMove, path: &ToolPath) {
    let samples = plan.samples();
    for sample in samples {
        let joints = pendant(sample);
        assert!(arm().check_limits(&joints).is_ok());
        let (distance, angle) = arm()
            .forward(&joints)
            .distance_to(&path.pose_at(sample.parameter).unwrap());
        assert!(distance.0 < 1e-6 && angle.0 < 1e-8, "{distance} {angle}");
    }
    for joint in Axis::ALL {
        let speeds: Vec<f64> = samples
            .windows(2)
            .map(|pair| (pendant(&pair[1]).of(joint).0 - pendant(&pair[0]).of(joint).0) / 0.008)
            .collect();
        for speed in &speeds {
            assert!(speed.abs() <= arm().max_speed(joint).0);
        }
        for pair in speeds.windows(2) {
            let acceleration = (pair[1] - pair[0]) / 0.008;
            assert!(
                acceleration.abs() <= arm().max_acceleration(joint).0,
                "{joint}"
            );
        }
    }
}

#[test]
fn a_line_takes_the_time_of_its_profile_and_stays_straight() {
    let path = ToolPath::line(&down(985.0, -200.0, 800.0), &down(985.0, 200.0, 800.0)).unwrap();
    let plan = go(&path, &LIMITS).unwrap();
    // way / v + v / a + a / j = 400 / 200 + 200 / 1000 + 1000 / 10000 = 2.3 s, in whole periods.
    assert!(
        (plan.duration() - 2.304).abs() < 1e-9,
        "{}",
        plan.duration()
    );
    assert!((plan.slowed() - 1.0).abs() < 1e-12 && plan.limited_by().is_none());
    keeps_its_promises(&plan, &path);
    for sample in plan.samples() {
        let [x, _, z] = position(&arm().forward(&pendant(sample)));
        assert!((x - 985.0).abs() < 1e-6 && (z - 800.0).abs() < 1e-6);
    }
}

#[test]
fn the_orientation_turns_evenly_along_a_line() {
    let (start, goal) = (
        down(985.0, 0.0, 800.0),
        pose(985.0, 0.0, 800.0, [180.0, 0.0, 60.0]),
    );
    let path = ToolPath::line(&start, &goal).unwrap();
    for (part, angle) in [(0.25, 15.0), (0.5, 30.0), (1.0, 60.0)] {
        let (distance, turned) = path.pose_at(part).unwrap().distance_to(&start);
        assert!(distance.0 < 1e-9 && (turned.0.to_degrees() - angle).abs() < 1e-9);
    }
    // Turning only: 60 degrees at 1 rad/s, and v / a + a / j as above.
    let plan = go(&path, &LIMITS).unwrap();
    assert!((plan.duration() - (60.0_f64.to_radians() + 0.3)).abs() < 0.008);
    keeps_its_promises(&plan, &path);
}

#[test]
fn a_circle_goes_through_its_points() {
    // Center (900, 0, 700), radius 100, in the plane z = 700.
    let (a, b, c) = (
        down(1000.0, 0.0, 700.0),
        down(900.0, 100.0, 700.0),
        down(800.0, 0.0, 700.0),
    );
    let arc = ToolPath::circle(&a, &b, &c, Extent::Arc).unwrap();
    near(
        position(&arc.pose_at(0.5).unwrap()),
        [900.0, 100.0, 700.0],
        1e-9,
    );
    near(
        position(&arc.pose_at(1.0).unwrap()),
        [800.0, 0.0, 700.0],
        1e-9,
    );
    let eighth = 100.0 * 0.5_f64.sqrt();
    near(
        position(&arc.pose_at(0.25).unwrap()),
        [900.0 + eighth, eighth, 700.0],
        1e-9,
    );
    let around = ToolPath::circle(&a, &b, &c, Extent::WholeTurn).unwrap();
    near(
        position(&around.pose_at(0.75).unwrap()),
        [900.0, -100.0, 700.0],
        1e-9,
    );
    near(
        position(&around.pose_at(1.0).unwrap()),
        [1000.0, 0.0, 700.0],
        1e-9,
    );
    let plan = go(&around, &LIMITS).unwrap();
    // 2 pi 100 / 200 + 0.3
    assert!((plan.duration() - (std::f64::consts::PI + 0.3)).abs() < 0.01);
    keeps_its_promises(&plan, &around);
}

#[test]
fn a_spline_through_points_of_a_line_is_the_line() {
    let points = [0.0, 60.0, 200.0, 300.0].map(|y| down(985.0, y, 800.0));
    let path = ToolPath::spline(&points).unwrap();
    for part in [0.1, 0.2, 0.55, 0.9] {
        near(
            position(&path.pose_at(part).unwrap()),
            [985.0, 300.0 * part, 800.0],
            1e-9,
        );
    }
    keeps_its_promises(&go(&path, &LIMITS).unwrap(), &path);
}

#[test]
fn a_natural_spline_by_hand() {
    // Knots 0, 1/2, 1 with z 0, 30, 0 over equal chords: with M0 = M2 = 0 the middle second
    // derivative is M1 = 6 (s2 - s1) / (2 (h + h)) = 6 (-60 - 60) / 2 = -360, and at 1/4 the value
    // is 15 - M1 (x - x^3) h^2 / 6 = 15 + 360 * 0.375 * 0.25 / 6 = 20.625.
    let points = [
        down(985.0, 0.0, 800.0),
        down(985.0, 40.0, 830.0),
        down(985.0, 80.0, 800.0),
    ];
    let path = ToolPath::spline(&points).unwrap();
    near(
        position(&path.pose_at(0.25).unwrap()),
        [985.0, 20.0, 820.625],
        1e-9,
    );
    near(
        position(&path.pose_at(0.5).unwrap()),
        [985.0, 40.0, 830.0],
        1e-9,
    );
}

#[test]
fn joints_that_are_too_fast_slow_the_whole_move_and_say_so() {
    let path = ToolPath::line(&down(985.0, -300.0, 800.0), &down(985.0, 300.0, 800.0)).unwrap();
    let fast = ToolLimits {
        speed: MmPerSec(5000.0),
        acceleration: MmPerSec2(50_000.0),
        jerk: 1e6,
        turning: RadPerSec(10.0),
    };
    let plan = go(&path, &fast).unwrap();
    assert!(
        plan.slowed() > 1.5 && plan.limited_by().is_some(),
        "{}",
        plan.slowed()
    );
    keeps_its_promises(&plan, &path);
}

#[test]
fn a_path_that_leaves_the_reach_says_where() {
    let path = ToolPath::line(&down(1000.0, 0.0, 800.0), &down(2400.0, 0.0, 800.0)).unwrap();
    match go(&path, &LIMITS).unwrap_err() {
        ToolError::Unreachable {
            parameter,
            pose,
            source: IkError::OutOfReach { excess, .. },
        } => {
            // One step of 1/200 of 1400 mm too far at most.
            assert!(excess.0 > 0.0 && excess.0 < 7.0, "{excess}");
            assert!((pose.x.0 - (1000.0 + 1400.0 * parameter)).abs() < 1e-6);
        }
        other => panic!("{other}"),
    }
}

#[test]
fn a_path_into_a_joint_limit_names_the_joint() {
    // Around axis 1 beyond J1 = 170 degrees.
    let at = |degrees: f64| {
        let (sin, cos) = degrees.to_radians().sin_cos();
        pose(900.0 * cos, 900.0 * sin, 700.0, [180.0, 0.0, degrees])
    };
    let path = ToolPath::circle(&at(100.0), &at(140.0), &at(179.0), Extent::Arc).unwrap();
    match go(&path, &LIMITS).unwrap_err() {
        ToolError::Unreachable {
            parameter,
            source: IkError::JointLimit { violations, .. },
            ..
        } => {
            let worst = violations.worst().unwrap();
            assert_eq!(worst.joint, Axis::J1);
            assert!((parameter - 70.0 / 79.0).abs() < 0.01, "{parameter}");
        }
        ToolError::Jump { parameter, .. } => {
            assert!((parameter - 70.0 / 79.0).abs() < 0.01, "{parameter}");
        }
        other => panic!("{other}"),
    }
}

#[test]
fn bad_input_is_refused_by_name() {
    let (a, b, c) = (
        down(900.0, 0.0, 700.0),
        down(900.0, 50.0, 700.0),
        down(900.0, 100.0, 700.0),
    );
    assert_eq!(ToolPath::line(&a, &a).unwrap_err(), PathError::NoWay);
    assert!(matches!(
        ToolPath::circle(&a, &b, &c, Extent::Arc),
        Err(PathError::Straight { .. })
    ));
    assert!(matches!(
        ToolPath::circle(&a, &a, &c, Extent::Arc),
        Err(PathError::SamePoint { second: 2, .. })
    ));
    assert_eq!(
        ToolPath::spline(&[a]).unwrap_err(),
        PathError::Points { count: 1 }
    );
    assert_eq!(
        ToolPath::line(&a, &pose(900.0, 50.0, 700.0, [0.0, 0.0, 0.0])).unwrap_err(),
        PathError::HalfTurn { second: 2 }
    );
    let path = ToolPath::line(&a, &c).unwrap();
    for speed in [0.0, -1.0, f64::NAN, f64::INFINITY] {
        let limits = ToolLimits {
            speed: MmPerSec(speed),
            ..LIMITS
        };
        let refused = go(&path, &limits).unwrap_err();
        assert!(
            matches!(refused, ToolError::Limit { item: "speed", .. }),
            "{refused}"
        );
    }
    let elsewhere = arm().home();
    let refused = go_from(&path, &LIMITS, &elsewhere, 0.008).unwrap_err();
    assert!(
        matches!(refused, ToolError::StartElsewhere { .. }),
        "{refused}"
    );
    let refused = go_from(&path, &LIMITS, &joints(&a), 0.0).unwrap_err();
    assert!(matches!(refused, ToolError::Period { .. }), "{refused}");
}

#[test]
fn the_demands_of_a_path_are_those_of_its_derivatives_in_time() {
    // Around axis 1 with the tool turning along: J1 alone turns by 60 degrees, all else stands still.
    let at = |degrees: f64| {
        let (sin, cos) = degrees.to_radians().sin_cos();
        pose(900.0 * cos, 900.0 * sin, 700.0, [180.0, 0.0, degrees])
    };
    let path = ToolPath::circle(&at(0.0), &at(30.0), &at(60.0), Extent::Arc).unwrap();
    assert!((path.radius().unwrap().0 - 900.0).abs() < 1e-6);
    assert!((path.turning().0.to_degrees() - 60.0).abs() < 1e-6);
    let frames = Frames::default();
    let follower = ToolFollower::new(arm(), &frames, &path);
    let mut all = vec![joints(&at(0.0))];
    for step in 1..=200 {
        let step = f64::from(step);
        let next = follower.follow((step - 1.0) / 200.0, all.last().unwrap(), step / 200.0);
        all.push(next.unwrap());
    }
    let limits = MotionLimits {
        velocity: 39.0,
        acceleration: 195.0,
        jerk: 1950.0,
    };
    let progress = Progress::try_new(60.0, limits).unwrap();
    let demands = Demands::of(arm(), &all, &progress);
    // 39 of 195 deg/s. 195 of 390 deg/s^2 where the acceleration is held, the mean of 0.1 s about it.
    assert!((demands.speed.share - 0.2).abs() < 1e-3, "{demands:?}");
    assert_eq!(demands.acceleration.joint, Axis::J1);
    assert!(
        (demands.acceleration.share - 0.5).abs() < 0.05,
        "{demands:?}"
    );
}

#[test]
fn a_wrist_on_its_own_way_passes_its_singularity_with_the_tool_in_its_place() {
    let start = PendantJoints::from_degrees([0.0, 10.0, -10.0, 30.0, -40.0, 0.0]);
    let goal = PendantJoints::from_degrees([20.0, 10.0, -10.0, -20.0, 40.0, 10.0]);
    let path = ToolPath::line(&arm().forward(&start), &arm().forward(&goal)).unwrap();
    let frames = Frames::default();
    let follower = ToolFollower::new(arm(), &frames, &path).with_wrist(&start, &goal);
    let mut before = start;
    for step in 1..=50 {
        let (from, to) = (f64::from(step - 1) / 50.0, f64::from(step) / 50.0);
        before = follower.follow(from, &before, to).unwrap();
        let (there, wanted) = (arm().forward(&before), path.pose_at(to).unwrap());
        near(position(&there), position(&wanted), 1e-6);
        assert!((before.of(Axis::J5).0 - (-40.0 + 80.0 * to)).abs() < 1e-9);
    }
    assert_eq!(before, goal);
}

/// The search knows nothing of the closed form, and finds the same joints.
#[test]
fn a_search_follows_as_the_closed_form_does() {
    let serial = SerialArm::builtin("fanuc-m20ia").unwrap();
    let (a, b) = (
        pose(900.0, -200.0, 700.0, [170.0, 10.0, 20.0]),
        pose(1000.0, 300.0, 500.0, [175.0, -20.0, 60.0]),
    );
    let path = ToolPath::line(&a, &b).unwrap();
    let start = serial.joints(&joints(&a).degrees()).unwrap();
    let frames = Frames::default();
    let plan = |solver| {
        let solved = SolvedArm {
            arm: serial,
            frames: &frames,
            solver,
        };
        ToolMove::try_new(&solved, &path, &LIMITS, &start, 0.02, Wanted::ALWAYS).unwrap()
    };
    let exact = plan(Solver::ClosedForm(arm()));
    let searched = plan(Solver::Search(Task::Pose));
    assert_eq!(exact.samples().len(), searched.samples().len());
    for (a, b) in exact.samples().iter().zip(searched.samples()) {
        let pairs = a.joints.as_slice().iter().zip(b.joints.as_slice());
        for (a, b) in pairs {
            assert!((a - b).abs() < 1e-8, "{a} {b}");
        }
    }
}
