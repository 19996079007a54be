//! Stopping in front of obstacles, and going on.
#![allow(
    clippy::unwrap_used,
    reason = "helpers of tests, where clippy.toml's exception does not reach"
)]

mod support;

use mobile_base::{
    Blocked, DriveState, Guard, Obstacle, Passage, Robot, StopReason, WaypointHeading,
};
use proptest::prelude::*;
use support::robot::{STEP, drive, drive_and, guard, robot, route, settings, waypoint};
use support::{point, pose, twist};
use units::{Millimeters, Radians};

fn disc(x: f64, y: f64, radius: f64) -> Obstacle {
    Obstacle::disc(point(x, y), Millimeters(radius)).unwrap()
}

#[track_caller]
fn blocked(state: DriveState) -> Blocked {
    let DriveState::Stopped(StopReason::Obstacle(blocked)) = state else {
        panic!("not stopped by an obstacle: {state:?}");
    };
    blocked
}

#[test]
fn a_base_stops_before_an_obstacle_and_goes_on_when_it_is_gone() {
    let mut robot = robot();
    robot.set_obstacles(vec![disc(-5000.0, 0.0, 100.0), disc(2000.0, 0.0, 100.0)]);
    robot
        .start(route(vec![waypoint(4000.0, 0.0, WaypointHeading::Hold)]))
        .unwrap();
    let mut last = 0.0;
    let stop = blocked(drive_and(&mut robot, |robot| {
        // It brakes at 800 mm/s^2 and does not stand still at once.
        let speed = robot.twist().speed().0;
        assert!(last - speed <= 800.0 * 0.01 + 10.0, "{last} to {speed}");
        last = speed;
    }));
    assert_eq!(stop.obstacle, 1);
    // The front edge is 400 mm ahead: the base stands at 2000 - 100 - 200 - 400 = 1300 mm.
    assert!((stop.clearance.0 - 200.0).abs() < 0.2, "{}", stop.clearance);
    assert!((robot.pose().position().x().0 - 1300.0).abs() < 0.2);
    // It stands as long as the obstacle does, and while it is nearer than the resume distance.
    for shift in [0.0, 50.0, 99.0] {
        robot.set_obstacles(vec![
            disc(-5000.0, 0.0, 100.0),
            disc(2000.0 + shift, 0.0, 100.0),
        ]);
        let before = robot.pose();
        for _ in 0..100 {
            let _ = blocked(robot.step(STEP).unwrap().unwrap());
        }
        assert_eq!(robot.pose(), before);
    }
    robot.set_obstacles(Vec::new());
    assert!(matches!(drive(&mut robot), DriveState::Arrived(_)));
}

#[test]
fn a_base_that_is_too_near_may_leave_but_not_come_nearer() {
    let mut guard = Guard::try_new(guard()).unwrap();
    // 50 mm before the front edge.
    let wall = [disc(550.0, 0.0, 100.0)];
    let here = pose(0.0, 0.0, 0.0);
    let mut pass = |forward, left| guard.pass(here, &twist(forward, left, 0.0), STEP, &wall);
    assert!(matches!(pass(100.0, 0.0), Passage::Blocked(_)));
    assert_eq!(pass(-100.0, 0.0), Passage::Free);
    assert_eq!(pass(0.0, 100.0), Passage::Free);
    assert!(matches!(pass(10.0, 100.0), Passage::Blocked(_)));
}

#[test]
fn a_base_that_touches_an_obstacle_does_not_move_by_itself() {
    let mut guard = Guard::try_new(guard()).unwrap();
    let inside = [disc(300.0, 0.0, 50.0)];
    for motion in [
        twist(100.0, 0.0, 0.0),
        twist(-100.0, 0.0, 0.0),
        twist(0.0, 0.0, 1.0),
    ] {
        let passage = guard.pass(pose(0.0, 0.0, 0.0), &motion, STEP, &inside);
        let touch = Blocked {
            obstacle: 0,
            clearance: Millimeters(0.0),
        };
        assert_eq!(passage, Passage::Blocked(touch));
    }
}

#[test]
fn a_base_does_not_turn_a_corner_into_an_obstacle() {
    // The corner is 500 mm from the middle; beside the base there are 300 + 210 mm to the disc.
    let mut robot = Robot::try_new(settings(), pose(0.0, 0.0, 0.0)).unwrap();
    robot.set_obstacles(vec![disc(0.0, 610.0, 100.0)]);
    let turn = WaypointHeading::Turn { to: Radians(1.5) };
    robot.start(route(vec![waypoint(0.0, 0.0, turn)])).unwrap();
    let stop = blocked(drive(&mut robot));
    assert!((stop.clearance.0 - 200.0).abs() < 0.2);
}

#[test]
fn a_distance_that_makes_no_sense_is_refused() {
    let mut bad = guard();
    bad.resume_distance = Millimeters(100.0);
    assert_eq!(
        Guard::try_new(bad).unwrap_err().to_string(),
        "resume distance is 100 mm; it must be from 200 mm to 100000 mm"
    );
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(48))]

    #[test]
    fn no_drive_comes_nearer_than_the_stop_distance(
        goal in (-4e3..4e3, -4e3..4e3),
        start in -3.0..3.0,
        end in -3.0..3.0,
        places in prop::collection::vec((800.0..4e3, -3.2..3.2_f64, 20.0..300.0), 1..6),
        sides in prop::bool::ANY,
    ) {
        let obstacles: Vec<Obstacle> = places
            .iter()
            .map(|(distance, direction, size)| {
                let (x, y) = (distance * direction.cos(), distance * direction.sin());
                if sides {
                    disc(x, y, *size)
                } else {
                    let corners = [(x - size, y), (x, y - 2.0 * size), (x + size, y)];
                    Obstacle::polygon(corners.map(|(x, y)| point(x, y)).to_vec()).unwrap()
                }
            })
            .collect();
        let footprint = guard().footprint;
        let least = |at| {
            let clearances = obstacles.iter().map(|one| footprint.clearance(at, one).0);
            clearances.fold(f64::INFINITY, f64::min)
        };
        let start = pose(0.0, 0.0, start);
        // Where it begins nearer it may stay that near.
        let bound = least(start).min(200.0);
        let mut robot = Robot::try_new(settings(), start).unwrap();
        robot.set_obstacles(obstacles.clone());
        let turn = WaypointHeading::Turn { to: Radians(end) };
        robot.start(route(vec![waypoint(goal.0, goal.1, turn)])).unwrap();
        for _ in 0..1500 {
            let state = robot.step(STEP).unwrap().unwrap();
            prop_assert!(least(robot.pose()) >= bound - 1e-6);
            if state != DriveState::Driving {
                break;
            }
        }
    }
}
