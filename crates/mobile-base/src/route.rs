//! Where the base is to go: waypoints and paths, one after the other.

use units::{Millimeters, Radians};

use crate::pose::Point;
use crate::range::{OutOfRange, within};
use crate::speed_plan::PlannedPath;

const MAX_LEGS: usize = 1000;
const MIN_TOLERANCE: Millimeters = Millimeters(0.01);
const MAX_TOLERANCE: Millimeters = Millimeters(1e4);
const MAX_ANGLE: Radians = Radians(1e6);

/// How the heading goes on the way to a waypoint.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum WaypointHeading {
    /// Mode 1: the velocity has this direction in the base's frame (beta*), and the base turns so
    /// that it points at the waypoint. The heading at the waypoint is what comes of it.
    FixedCourse {
        /// From x of the base to the velocity, counterclockwise.
        course: Radians,
    },
    /// Mode 2: the base turns to this heading while it drives straight to the waypoint.
    Turn {
        /// From X of the world.
        to: Radians,
    },
    /// Mode 2, with the heading that the base has when it sets out for the waypoint.
    Hold,
}

/// A point to drive to.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Waypoint {
    /// In the world.
    pub point: Point,
    /// The next leg begins when the base is this near. At the last waypoint the base also stands, and
    /// is then much nearer.
    pub tolerance: Millimeters,
    /// How the heading goes on the way.
    pub heading: WaypointHeading,
}

/// A part of a route.
#[derive(Clone, Debug, PartialEq)]
pub enum Leg {
    /// Straight to a point, with a [`PointLaw`](crate::PointLaw).
    Waypoint(Waypoint),
    /// Along a path, with a [`TrackingLaw`](crate::TrackingLaw).
    Path {
        /// The path; it should begin where the leg before ends.
        path: PlannedPath,
        /// The leg is over when the base is this near to the path's end.
        tolerance: Millimeters,
    },
}

/// Legs to drive in their order, checked.
#[derive(Clone, Debug, PartialEq)]
pub struct Route {
    legs: Vec<Leg>,
}

impl Route {
    /// A route of these legs.
    ///
    /// # Errors
    /// Not 1 to 1000 legs, a tolerance that is not from 0.01 mm to 10 m, an angle that is not a
    /// number within a million radians.
    pub fn try_new(legs: Vec<Leg>) -> Result<Route, OutOfRange> {
        let _ = within("legs of the route", legs.len(), 1, MAX_LEGS)?;
        for leg in &legs {
            let tolerance = leg.tolerance();
            let _ = within(
                "tolerance of the leg",
                tolerance,
                MIN_TOLERANCE,
                MAX_TOLERANCE,
            )?;
            if let Leg::Waypoint(Waypoint { heading, .. }) = leg {
                heading.check()?;
            }
        }
        Ok(Route { legs })
    }

    /// The legs, in their order.
    #[must_use]
    pub fn legs(&self) -> &[Leg] {
        &self.legs
    }

    /// The way from the end of a leg to the end of the route, as the crow flies between legs.
    pub(crate) fn left_after(&self, leg: usize) -> Millimeters {
        let pairs = self.legs.iter().zip(self.legs.iter().skip(1)).skip(leg);
        let ways = pairs.map(|(before, next)| match next {
            Leg::Waypoint(waypoint) => before.end().distance_to(waypoint.point).0,
            Leg::Path { path, .. } => path.spline().length().0,
        });
        Millimeters(ways.sum())
    }
}

impl Leg {
    pub(crate) fn tolerance(&self) -> Millimeters {
        match self {
            Leg::Waypoint(waypoint) => waypoint.tolerance,
            Leg::Path { tolerance, .. } => *tolerance,
        }
    }

    /// Where the leg ends.
    #[must_use]
    pub fn end(&self) -> Point {
        match self {
            Leg::Waypoint(waypoint) => waypoint.point,
            Leg::Path { path, .. } => path.end().0,
        }
    }
}

impl WaypointHeading {
    fn check(&self) -> Result<(), OutOfRange> {
        let number = |item, angle| within(item, angle, -MAX_ANGLE, MAX_ANGLE).map(drop);
        match self {
            WaypointHeading::FixedCourse { course } => number("course of the waypoint", *course),
            WaypointHeading::Turn { to } => number("heading of the waypoint", *to),
            WaypointHeading::Hold => Ok(()),
        }
    }
}
