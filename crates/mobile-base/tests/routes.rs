//! Routes, driven to their end.
#![allow(
    clippy::unwrap_used,
    reason = "helpers of tests, where clippy.toml's exception does not reach"
)]

mod support;

use std::f64::consts::{FRAC_PI_2, PI};
use std::time::Duration;

use mobile_base::{
    Approach, Deviation, DriveError, DriveState, Leg, Localization, MecanumBase, PathHeading,
    PathLimits, PlanarPose, PlannedPath, Robot, Route, Spline, SplineEnds, StopReason,
    WaypointHeading,
};
use proptest::prelude::*;
use support::robot::{STEP, drive, drive_and, follower, robot, route, settings, waypoint};
use support::{base, point, pose};
use units::{Millimeters, MmPerSec, MmPerSec2, PerMillimeter, Radians};

const AHEAD: WaypointHeading = WaypointHeading::FixedCourse {
    course: Radians(0.0),
};

fn path(points: &[(f64, f64)], heading: PathHeading) -> Leg {
    let points: Vec<_> = points.iter().map(|(x, y)| point(*x, *y)).collect();
    let spline = Spline::try_new(&points, SplineEnds::Natural).unwrap();
    let limits = PathLimits {
        speed: MmPerSec(900.0),
        acceleration: MmPerSec2(600.0),
        lateral_acceleration: MmPerSec2(500.0),
        min_radius: Millimeters(200.0),
    };
    Leg::Path {
        path: PlannedPath::try_new(spline, heading, &limits, &base()).unwrap(),
        tolerance: Millimeters(1.0),
    }
}

#[track_caller]
fn arrived(state: DriveState) -> (f64, Option<f64>) {
    let DriveState::Arrived(docking) = state else {
        panic!("not arrived: {state:?}");
    };
    (docking.distance.0, docking.heading.map(|error| error.0))
}

#[test]
fn a_base_docks_at_its_last_waypoint_with_its_heading() {
    let mut robot = robot();
    let turn = WaypointHeading::Turn {
        to: Radians(FRAC_PI_2),
    };
    let legs = vec![
        waypoint(1500.0, 0.0, WaypointHeading::Hold),
        waypoint(1500.0, 1500.0, turn),
    ];
    robot.start(route(legs)).unwrap();
    let (distance, heading) = arrived(drive(&mut robot));
    assert!(distance < 1.0, "{distance}");
    assert!(heading.unwrap().abs() < 0.2_f64.to_radians());
    assert!(robot.pose().position().distance_to(point(1500.0, 1500.0)).0 < 1.0);
    assert!((robot.pose().heading().0 - FRAC_PI_2).abs() < 0.2_f64.to_radians());
    // And stays there.
    let _ = robot.step(STEP).unwrap();
    assert!(robot.twist().speed().0.abs() < f64::EPSILON);
    assert!(robot.progress().unwrap().left.0 < 1.0);
}

#[test]
fn in_mode_2_the_base_keeps_to_the_straight_line_while_it_turns() {
    let mut robot = robot();
    let turn = WaypointHeading::Turn { to: Radians(3.0) };
    robot
        .start(route(vec![waypoint(2000.0, 1000.0, turn)]))
        .unwrap();
    let state = drive_and(&mut robot, |robot| {
        let at = robot.pose().position();
        let aside = (at.y().0 * 2.0 - at.x().0) / 5.0_f64.sqrt();
        assert!(aside.abs() < 0.5, "{aside} at {at:?}");
    });
    let _ = arrived(state);
}

#[test]
fn a_sampled_sign_lands_on_the_target_instead_of_chattering() {
    let mut settings = settings();
    settings.follower = follower(Approach::Sign);
    let mut robot = Robot::try_new(settings, PlanarPose::default()).unwrap();
    let hold = WaypointHeading::Hold;
    robot
        .start(route(vec![waypoint(1234.5, -321.0, hold)]))
        .unwrap();
    let (distance, _) = arrived(drive(&mut robot));
    assert!(distance < 1.0, "{distance}");
}

#[test]
fn a_path_is_followed_within_a_millimeter() {
    let shape = [(0.0, 0.0), (1000.0, 300.0), (2000.0, -300.0), (3000.0, 0.0)];
    let headings = [
        // From the pose of the start, which is not along the path.
        PathHeading::Turning {
            from: Radians(0.0),
            to: Radians(2.0),
        },
        PathHeading::FixedCourse {
            course: Radians(0.0),
        },
    ];
    for heading in headings {
        let leg = path(&shape, heading);
        let Leg::Path { path, .. } = &leg else {
            panic!("a path");
        };
        let (start, first) = path.pose_at(Millimeters(0.0)).unwrap();
        let start = PlanarPose::at(start.point, first).unwrap();
        let spline = path.spline().clone();
        let mut robot = Robot::try_new(settings(), start).unwrap();
        robot.start(route(vec![leg])).unwrap();
        let length = spline.length().0;
        let state = drive_and(&mut robot, |robot| {
            let along = length - robot.progress().unwrap().left.0;
            let place = spline.at(Millimeters(along)).unwrap();
            let aside = robot.pose().position().distance_to(place.point).0;
            assert!(aside < 1.0, "{aside} mm off at {along} mm");
        });
        let (distance, heading) = arrived(state);
        assert!(distance < 1.0 && heading.unwrap().abs() < 0.004);
    }
}

#[test]
fn a_base_beside_the_path_comes_to_it_and_one_far_off_stops() {
    let line = [(0.0, 0.0), (4000.0, 0.0)];
    let forward = PathHeading::FixedCourse {
        course: Radians(0.0),
    };
    let mut beside = Robot::try_new(settings(), pose(0.0, 250.0, 0.5)).unwrap();
    beside.start(route(vec![path(&line, forward)])).unwrap();
    let _ = arrived(drive(&mut beside));

    let mut far = Robot::try_new(settings(), pose(0.0, 301.0, 0.0)).unwrap();
    far.start(route(vec![path(&line, forward)])).unwrap();
    let state = drive(&mut far);
    let off = StopReason::OffPath {
        deviation: Millimeters(301.0),
        limit: Millimeters(300.0),
    };
    assert_eq!(state, DriveState::Stopped(off));
    assert_eq!(far.pose(), pose(0.0, 301.0, 0.0));
}

#[test]
fn slower_wheels_make_the_base_later_not_elsewhere() {
    let mut slow = *base().dimensions();
    slow.max_wheel_speed = slow.max_wheel_speed * 0.1;
    let slow = MecanumBase::try_new(&slow).unwrap();
    // The path is planned for the faster base.
    let leg = path(
        &[(0.0, 0.0), (1000.0, 300.0), (2000.0, 0.0)],
        PathHeading::Turning {
            from: Radians(0.0),
            to: Radians(0.0),
        },
    );
    let mut settings = settings();
    settings.base = slow;
    let mut robot = Robot::try_new(settings, PlanarPose::default()).unwrap();
    let Leg::Path { path, .. } = &leg else {
        panic!("a path");
    };
    let spline = path.spline().clone();
    robot.start(route(vec![leg])).unwrap();
    let (mut least, mut fastest) = (1.0_f64, 0.0_f64);
    let state = drive_and(&mut robot, |robot| {
        slow.check(&robot.wheel_speeds()).unwrap();
        least = least.min(robot.factor());
        fastest = fastest.max(robot.twist().speed().0);
        let along = spline.length().0 - robot.progress().unwrap().left.0;
        let place = spline.at(Millimeters(along)).unwrap();
        assert!(robot.pose().position().distance_to(place.point).0 < 1.0);
    });
    let _ = arrived(state);
    // 2 rad/s on 100 mm wheels; planned were up to 900 mm/s.
    assert!(
        least < 0.99 && (150.0..=200.0).contains(&fastest),
        "{least}, {fastest}"
    );
}

#[test]
fn stop_and_resume_are_obeyed() {
    let mut robot = robot();
    robot
        .start(route(vec![waypoint(2000.0, 0.0, AHEAD)]))
        .unwrap();
    for _ in 0..50 {
        let _ = robot.step(STEP).unwrap();
    }
    robot.stop();
    let there = robot.pose();
    let stopped = DriveState::Stopped(StopReason::Requested);
    assert_eq!(robot.step(STEP).unwrap(), Some(stopped));
    assert_eq!(robot.pose(), there);
    robot.resume();
    let _ = arrived(drive(&mut robot));
}

#[test]
fn a_noisy_robot_arrives_where_it_believes_to_be() {
    let drive_with = |seed| {
        let mut settings = settings();
        settings.localization = Localization::Odometry {
            noise: Radians(0.02),
            seed,
        };
        let mut robot = Robot::try_new(settings, PlanarPose::default()).unwrap();
        let hold = WaypointHeading::Hold;
        robot
            .start(route(vec![waypoint(3000.0, 0.0, hold)]))
            .unwrap();
        let (distance, _) = arrived(drive(&mut robot));
        assert!(distance < 1.0);
        robot
    };
    let robot = drive_with(5);
    let off = Deviation::between(robot.pose(), robot.believed_pose())
        .distance()
        .0;
    assert!((0.1..200.0).contains(&off), "{off}");
    assert_eq!(robot.pose(), drive_with(5).pose());
    assert_ne!(robot.pose(), drive_with(6).pose());
    // A marker at the dock puts it right.
    let mut robot = robot;
    robot.correct_odometry(robot.pose());
    assert_eq!(robot.believed_pose(), robot.pose());
}

#[test]
fn refused_steps_change_nothing() {
    let mut robot = robot();
    robot
        .start(route(vec![waypoint(2000.0, 0.0, AHEAD)]))
        .unwrap();
    for bad in [Duration::ZERO, Duration::from_secs(2)] {
        let error = robot.step(bad).unwrap_err();
        assert!(matches!(error, DriveError::Range(_)));
        assert_eq!(robot.pose(), PlanarPose::default());
    }
    let mut idle = support::robot::robot();
    assert_eq!(idle.step(STEP).unwrap(), None);
}

#[test]
fn routes_that_make_no_sense_are_refused() {
    let message = Route::try_new(Vec::new()).unwrap_err().to_string();
    assert_eq!(message, "legs of the route is 0; it must be from 1 to 1000");
    let nowhere = WaypointHeading::Turn {
        to: Radians(f64::NAN),
    };
    let refused = Route::try_new(vec![waypoint(1.0, 1.0, nowhere)]);
    assert!(
        refused
            .unwrap_err()
            .to_string()
            .starts_with("heading of the waypoint is NaN")
    );
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(48))]

    #[test]
    fn every_waypoint_is_reached_in_every_mode(
        x in -4e3..4e3, y in -4e3..4e3, start in -PI..PI, angle in -PI..PI, law in 0..3, mode in 0..3
    ) {
        let approach = match law {
            0 => Approach::Sign,
            1 => Approach::Exponential { k: PerMillimeter(0.008) },
            _ => support::robot::TANH,
        };
        let heading = match mode {
            0 => WaypointHeading::FixedCourse { course: Radians(angle) },
            1 => WaypointHeading::Turn { to: Radians(angle) },
            _ => WaypointHeading::Hold,
        };
        let mut settings = settings();
        settings.follower = follower(approach);
        let mut robot = Robot::try_new(settings, pose(0.0, 0.0, start)).unwrap();
        robot.start(route(vec![waypoint(x, y, heading)])).unwrap();
        let limits = base();
        let mut last = 0.0;
        let state = drive_and(&mut robot, |robot| {
            limits.check(&robot.wheel_speeds()).unwrap();
            let speed = robot.twist().speed().0;
            // An arc is a little longer than its chord.
            assert!(speed <= (last + 800.0 * 0.01) * 1.001, "gained {} in a step", speed - last);
            last = speed;
        });
        let (distance, heading) = arrived(state);
        prop_assert!(distance <= 1.0);
        prop_assert!(heading.unwrap_or(0.0).abs() <= 0.2_f64.to_radians());
    }
}
