//! A robot to send around.

use std::time::Duration;

use mobile_base::{
    Approach, DriveState, FollowerSettings, Footprint, GuardSettings, Leg, Localization,
    PlanarPose, PointGains, PointLaw, Robot, RobotSettings, Route, TrackingLaw, Waypoint,
    WaypointHeading,
};
use units::{Degrees, Millimeters, MmPerSec, MmPerSec2, PerSecond};

use crate::support::{base, point};

pub(crate) const STEP: Duration = Duration::from_millis(10);

pub(crate) fn follower(approach: Approach) -> FollowerSettings {
    FollowerSettings {
        point_law: PointLaw::try_new(&PointGains {
            speed: MmPerSec(800.0),
            turn: PerSecond(2.0),
            approach,
        })
        .unwrap(),
        tracking_law: TrackingLaw::try_new([PerSecond(2.0); 3]).unwrap(),
        acceleration: MmPerSec2(800.0),
        heading_tolerance: Degrees(0.2).into(),
        max_deviation: Millimeters(300.0),
    }
}

pub(crate) const TANH: Approach = Approach::Tanh {
    scale: Millimeters(300.0),
};

/// A base of 800 by 600 mm that stops 200 mm before things, and goes on at 300 mm.
pub(crate) fn guard() -> GuardSettings {
    GuardSettings {
        footprint: Footprint::rectangle(Millimeters(800.0), Millimeters(600.0)).unwrap(),
        stop_distance: Millimeters(200.0),
        resume_distance: Millimeters(300.0),
        deceleration: MmPerSec2(800.0),
    }
}

pub(crate) fn settings() -> RobotSettings {
    RobotSettings {
        base: base(),
        follower: follower(TANH),
        guard: Some(guard()),
        localization: Localization::Exact,
    }
}

pub(crate) fn robot() -> Robot {
    Robot::try_new(settings(), PlanarPose::default()).unwrap()
}

pub(crate) fn waypoint(x: f64, y: f64, heading: WaypointHeading) -> Leg {
    Leg::Waypoint(Waypoint {
        point: point(x, y),
        tolerance: Millimeters(1.0),
        heading,
    })
}

pub(crate) fn route(legs: Vec<Leg>) -> Route {
    Route::try_new(legs).unwrap()
}

/// Lets up to a minute pass, until the robot does something else than driving.
pub(crate) fn drive(robot: &mut Robot) -> DriveState {
    drive_and(robot, |_| ())
}

pub(crate) fn drive_and(robot: &mut Robot, mut look: impl FnMut(&Robot)) -> DriveState {
    for _ in 0..6000 {
        let state = robot.step(STEP).unwrap().unwrap();
        look(robot);
        if state != DriveState::Driving {
            return state;
        }
    }
    panic!("still driving after a minute: {:?}", robot.progress());
}
