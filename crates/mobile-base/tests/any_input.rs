//! Whatever numbers come in: an error or numbers come out, and nothing panics.

#![allow(
    clippy::unwrap_used,
    reason = "helpers of tests, where clippy.toml's exception does not reach"
)]

mod support;

use std::time::Duration;

use mobile_base::{
    Approach, Dimensions, FollowerSettings, Footprint, GuardSettings, Leg, Localization,
    MecanumBase, Obstacle, PathHeading, PathLimits, PlanarPose, PlannedPath, Point, PointGains,
    PointLaw, Robot, RobotSettings, Route, Spline, SplineEnds, TrackingLaw, Waypoint,
    WaypointHeading,
};
use proptest::prelude::*;
use proptest::strategy::ValueTree;
use support::numbers;
use units::{Millimeters, MmPerSec, MmPerSec2, PerMillimeter, PerSecond, RadPerSec, Radians};

/// Any bit pattern, or a number that may well be accepted.
fn any_number() -> impl Strategy<Value = f64> {
    prop_oneof![
        1 => any::<f64>(),
        1 => -1e4..1e4,
        // Nearly everything has its range around here.
        60 => 1.0..900.0,
    ]
}

/// A supply of numbers, and then zeros.
struct Supply(Vec<f64>);

impl Supply {
    fn next(&mut self) -> f64 {
        self.0.pop().unwrap_or(0.0)
    }

    fn length(&mut self) -> Millimeters {
        Millimeters(self.next())
    }

    fn angle(&mut self) -> Radians {
        Radians(self.next())
    }

    fn point(&mut self) -> Option<Point> {
        Point::try_new(self.length(), self.length()).ok()
    }

    fn outline(&mut self) -> Option<Vec<Point>> {
        (0..4).map(|_| self.point()).collect()
    }
}

/// A robot from any numbers, if they make one.
fn any_robot(supply: &mut Supply, kinds: u8) -> Option<Robot> {
    let base = MecanumBase::try_new(&Dimensions {
        wheel_radius: supply.length(),
        wheelbase: supply.length(),
        track: supply.length(),
        max_wheel_speed: RadPerSec(supply.next()),
    })
    .ok()?;
    let approach = match kinds % 3 {
        0 => Approach::Sign,
        1 => Approach::Exponential {
            k: PerMillimeter(supply.next()),
        },
        _ => Approach::Tanh {
            scale: supply.length(),
        },
    };
    let gains = PointGains {
        speed: MmPerSec(supply.next()),
        turn: PerSecond(supply.next()),
        approach,
    };
    let rates = [supply.next(), supply.next(), supply.next()].map(PerSecond);
    let follower = FollowerSettings {
        point_law: PointLaw::try_new(&gains).ok()?,
        tracking_law: TrackingLaw::try_new(rates).ok()?,
        acceleration: MmPerSec2(supply.next()),
        heading_tolerance: Radians(0.01),
        max_deviation: supply.length(),
    };
    let stop_distance = supply.length();
    let guard = GuardSettings {
        footprint: Footprint::polygon(supply.outline()?).ok()?,
        stop_distance,
        resume_distance: stop_distance + supply.length().abs(),
        deceleration: MmPerSec2(supply.next()),
    };
    let localization = Localization::Odometry {
        noise: Radians(supply.next() * 1e-4),
        seed: 3,
    };
    let settings = RobotSettings {
        base,
        follower,
        guard: (kinds & 4 == 0).then_some(guard),
        localization: if kinds & 8 == 0 {
            Localization::Exact
        } else {
            localization
        },
    };
    let pose = PlanarPose::at(supply.point()?, supply.angle()).ok()?;
    let mut robot = Robot::try_new(settings, pose).ok()?;
    let obstacles = [
        Obstacle::disc(supply.point()?, supply.length()),
        Obstacle::polygon(supply.outline()?),
    ];
    robot.set_obstacles(obstacles.into_iter().flatten().collect());
    let mut legs: Vec<Leg> = any_path(supply, kinds, &base).into_iter().collect();
    legs.push(any_waypoint(supply, kinds)?);
    robot.start(Route::try_new(legs).ok()?).ok()?;
    Some(robot)
}

fn any_waypoint(supply: &mut Supply, kinds: u8) -> Option<Leg> {
    let heading = match kinds / 16 % 3 {
        0 => WaypointHeading::Hold,
        1 => WaypointHeading::Turn { to: supply.angle() },
        _ => WaypointHeading::FixedCourse {
            course: supply.angle(),
        },
    };
    Some(Leg::Waypoint(Waypoint {
        point: supply.point()?,
        tolerance: supply.length(),
        heading,
    }))
}

fn any_path(supply: &mut Supply, kinds: u8, base: &MecanumBase) -> Option<Leg> {
    let ends = if kinds & 64 == 0 {
        SplineEnds::Natural
    } else {
        SplineEnds::Clamped {
            start: supply.angle(),
            end: supply.angle(),
        }
    };
    let spline = Spline::try_new(&supply.outline()?, ends).ok()?;
    for share in [0.0, 0.3, 1.0] {
        let place = spline.at(spline.length() * share).unwrap();
        assert!(place.point.x().is_finite() && place.point.y().is_finite());
        assert!(place.direction.is_finite() && place.curvature.is_finite());
    }
    let heading = if kinds & 128 == 0 {
        PathHeading::FixedCourse {
            course: supply.angle(),
        }
    } else {
        PathHeading::Turning {
            from: supply.angle(),
            to: supply.angle(),
        }
    };
    let limits = PathLimits {
        speed: MmPerSec(supply.next()),
        acceleration: MmPerSec2(supply.next()),
        lateral_acceleration: MmPerSec2(supply.next()),
        min_radius: Millimeters(1.0),
    };
    Some(Leg::Path {
        path: PlannedPath::try_new(spline, heading, &limits, base).ok()?,
        tolerance: supply.length(),
    })
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(1000))]

    #[test]
    fn a_robot_of_any_numbers_drives_by_numbers_or_refuses(
        supply in prop::collection::vec(any_number(), 60..80),
        kinds in any::<u8>(),
        nanos in prop_oneof![Just(10_000_000), 0..2_000_000_000_u64],
    ) {
        let Some(mut robot) = any_robot(&mut Supply(supply), kinds) else {
            return Ok(());
        };
        for _ in 0..50 {
            if robot.step(Duration::from_nanos(nanos)).is_err() {
                break;
            }
            let at = robot.pose().position();
            prop_assert!(at.x().is_finite() && at.y().is_finite());
            prop_assert!(robot.pose().heading().is_finite());
            prop_assert!(numbers(&robot.twist()).iter().all(|number| number.is_finite()));
            prop_assert!((0.0..=1.0).contains(&robot.factor()), "{}", robot.factor());
            let progress = robot.progress().unwrap();
            prop_assert!(progress.left.is_finite() && progress.driven.is_finite());
        }
    }
}

#[test]
fn most_numbers_are_refused_and_enough_are_not() {
    // The test above would be idle if its numbers never made a robot.
    let mut runner = proptest::test_runner::TestRunner::deterministic();
    let numbers = prop::collection::vec(any_number(), 60..80);
    let made = (0..2000).filter(|kinds: &u32| {
        let supply = numbers.new_tree(&mut runner).unwrap().current();
        let kinds = u8::try_from(kinds % 256).unwrap();
        any_robot(&mut Supply(supply), kinds).is_some()
    });
    let made = made.count();
    assert!(made > 200, "{made} of 2000");
}
