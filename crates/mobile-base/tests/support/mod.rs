//! A base to test with, and short ways to write values down.
#![allow(dead_code, reason = "each test file uses a part of this")]

pub(crate) mod robot;

use mobile_base::{BodyTwist, Dimensions, MecanumBase, PlanarPose, Point, WheelSpeeds, WorldTwist};
use units::{Millimeters, MmPerSec, RadPerSec, Radians};

/// r = 100 mm, d = 600 mm, e = 400 mm: the lever (d + e) / 2 is 500 mm.
pub(crate) fn base() -> MecanumBase {
    MecanumBase::try_new(&Dimensions {
        wheel_radius: Millimeters(100.0),
        wheelbase: Millimeters(600.0),
        track: Millimeters(400.0),
        max_wheel_speed: RadPerSec(20.0),
    })
    .unwrap()
}

pub(crate) fn pose(x: f64, y: f64, heading: f64) -> PlanarPose {
    PlanarPose::try_new(Millimeters(x), Millimeters(y), Radians(heading)).unwrap()
}

pub(crate) fn point(x: f64, y: f64) -> Point {
    Point::try_new(Millimeters(x), Millimeters(y)).unwrap()
}

pub(crate) fn twist(forward: f64, left: f64, turn: f64) -> BodyTwist {
    BodyTwist {
        forward: MmPerSec(forward),
        left: MmPerSec(left),
        turn: RadPerSec(turn),
    }
}

pub(crate) fn world(x: f64, y: f64, turn: f64) -> WorldTwist {
    WorldTwist {
        x: MmPerSec(x),
        y: MmPerSec(y),
        turn: RadPerSec(turn),
    }
}

pub(crate) fn wheels(speeds: [f64; 4]) -> WheelSpeeds {
    WheelSpeeds(speeds.map(RadPerSec))
}

pub(crate) fn numbers(twist: &BodyTwist) -> [f64; 3] {
    [twist.forward.0, twist.left.0, twist.turn.0]
}

#[track_caller]
pub(crate) fn assert_near<const N: usize>(found: [f64; N], wanted: [f64; N], tolerance: f64) {
    for (found_one, wanted_one) in found.iter().zip(wanted) {
        assert!(
            (found_one - wanted_one).abs() <= tolerance,
            "found {found:?}, wanted {wanted:?}"
        );
    }
}
