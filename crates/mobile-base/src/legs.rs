//! What the legs of a route ask of the base in one step.

use std::time::Duration;

use units::{Millimeters, MmPerSec, RadPerSec, Radians};

use crate::follower::{Docking, FollowerSettings, Place};
use crate::point_law::HeadingReference;
use crate::pose::{PlanarPose, one_turn};
use crate::range::OutOfRange;
use crate::route::{Leg, Route, Waypoint, WaypointHeading};
use crate::speed_plan::PlannedPath;
use crate::tracking::{Deviation, Reference};
use crate::twist::{BodyTwist, WorldTwist};

/// Beyond this turn in a step a held twist is left as it is: an eighth of a turn is no small step.
const MAX_HELD_TURN: f64 = std::f64::consts::FRAC_PI_4;

/// What lies before a base.
pub(crate) enum Sight {
    /// More way, on this leg.
    Ahead(Place),
    /// Nothing.
    Arrived(Place, Docking),
}

/// Where a velocity keeps its direction during a step.
#[derive(Clone, Copy)]
pub(crate) enum HeldIn {
    Body,
    World,
}

/// What a leg asks for in a step.
pub(crate) struct Wanted {
    /// What the law says.
    pub(crate) twist: BodyTwist,
    /// In which frame the law means it to stay the same during the step.
    pub(crate) held_in: HeldIn,
    /// Where on the leg's path the step should end.
    pub(crate) next_along: f64,
    /// How far the base is from its place on the path; zero on the way to a waypoint.
    pub(crate) deviation: Millimeters,
    /// What starting, braking and landing allow.
    pub(crate) speed_limit: MmPerSec,
}

/// Goes past the legs that are over.
pub(crate) fn look(
    route: &Route,
    settings: &FollowerSettings,
    mut place: Place,
    pose: PlanarPose,
    step: Duration,
) -> Sight {
    let last = route.legs().len().saturating_sub(1);
    for (number, leg) in route.legs().iter().enumerate().skip(place.leg) {
        let distance = pose.position().distance_to(leg.end());
        let near = left_on_path(leg, place.along) <= 0.0 && distance <= leg.tolerance();
        if !near {
            break;
        }
        if number < last {
            place.leg = number + 1;
            place.along = 0.0;
            place.heading = pose.heading();
            continue;
        }
        let heading = end_heading(leg, place.heading)
            .map(|wanted| Radians(one_turn(pose.heading().0 - wanted.0)));
        let turned = heading.is_none_or(|error| error.abs() <= settings.heading_tolerance);
        // Slow enough to stand after one more step.
        let slow = place.speed <= settings.acceleration.0 * step.as_secs_f64();
        if turned && slow {
            return Sight::Arrived(place, Docking { distance, heading });
        }
    }
    Sight::Ahead(place)
}

/// The twist for this step. A place behind the last leg asks for rest.
pub(crate) fn wanted(
    route: &Route,
    settings: &FollowerSettings,
    place: Place,
    pose: PlanarPose,
    step: Duration,
) -> Result<Wanted, OutOfRange> {
    let is_last = place.leg + 1 == route.legs().len();
    let started = place.speed + settings.acceleration.0 * step.as_secs_f64();
    match route.legs().get(place.leg) {
        Some(Leg::Waypoint(waypoint)) => {
            let distance = pose.position().distance_to(waypoint.point).0;
            // A sampled law must not step over its target; at the last one the base brakes.
            let mut limit = started.min(distance / step.as_secs_f64());
            if is_last {
                limit = limit.min((2.0 * settings.acceleration.0 * distance).sqrt());
            }
            let (twist, held_in) = to_waypoint(settings, waypoint, place.heading, pose);
            Ok(Wanted {
                twist,
                held_in,
                next_along: 0.0,
                deviation: Millimeters(0.0),
                speed_limit: MmPerSec(limit),
            })
        }
        Some(Leg::Path { path, .. }) => {
            let limit = path.limits().acceleration.0.min(settings.acceleration.0);
            let started = place.speed + limit * step.as_secs_f64();
            along_path(settings, path, (place.along, started), pose, step)
        }
        None => Ok(Wanted {
            twist: BodyTwist::ZERO,
            held_in: HeldIn::Body,
            next_along: place.along,
            deviation: Millimeters(0.0),
            speed_limit: MmPerSec(0.0),
        }),
    }
}

fn to_waypoint(
    settings: &FollowerSettings,
    waypoint: &Waypoint,
    heading_at_start: Radians,
    pose: PlanarPose,
) -> (BodyTwist, HeldIn) {
    let law = &settings.point_law;
    let angle = match waypoint.heading {
        WaypointHeading::FixedCourse { course } => {
            return (law.fixed_course(pose, waypoint.point, course), HeldIn::Body);
        }
        WaypointHeading::Turn { to } => to,
        WaypointHeading::Hold => heading_at_start,
    };
    let reference = HeadingReference {
        angle,
        rate: RadPerSec(0.0),
    };
    let twist = law.free_heading(pose, waypoint.point, &reference);
    (twist, HeldIn::World)
}

fn along_path(
    settings: &FollowerSettings,
    path: &PlannedPath,
    (along, started): (f64, f64),
    pose: PlanarPose,
    step: Duration,
) -> Result<Wanted, OutOfRange> {
    let seconds = step.as_secs_f64();
    let length = path.spline().length().0;
    let planned = path.speed_at(Millimeters(along)).unwrap_or_default().0;
    let next_along = (along + planned.min(started) * seconds).min(length);
    let (here, there) = (path_pose(path, along)?, path_pose(path, next_along)?);
    // The mean velocity of the step, so that the reference is met where the step ends.
    let way = Deviation::between(there, here);
    let reference = Reference {
        pose: here,
        velocity: WorldTwist {
            x: MmPerSec(way.x.0 / seconds),
            y: MmPerSec(way.y.0 / seconds),
            turn: RadPerSec(way.heading.0 / seconds),
        },
    };
    Ok(Wanted {
        twist: settings.tracking_law.command(pose, &reference),
        held_in: HeldIn::World,
        next_along,
        deviation: Deviation::between(pose, here).distance(),
        speed_limit: MmPerSec(started),
    })
}

/// The pose on a path; its end, if rounding leads behind it.
fn path_pose(path: &PlannedPath, along: f64) -> Result<PlanarPose, OutOfRange> {
    let (point, heading) = path
        .pose_at(Millimeters(along))
        .map_or_else(|| path.end(), |(place, heading)| (place.point, heading));
    PlanarPose::try_new(point.x(), point.y(), heading)
}

/// The twist that, held for a step, ends where the wanted velocity in the world would lead.
///
/// A twist that is held in the base's frame swings round while the base turns; a law that thinks in
/// the world would bend off its way by half of the turn.
pub(crate) fn held_in_world(
    pose: PlanarPose,
    twist: &BodyTwist,
    step: Duration,
) -> Result<BodyTwist, OutOfRange> {
    let seconds = step.as_secs_f64();
    if (twist.turn.0 * seconds).abs() > MAX_HELD_TURN {
        return Ok(*twist);
    }
    let WorldTwist { x, y, turn } = pose.world_twist(*twist);
    let end = PlanarPose::try_new(
        Millimeters(pose.position().x().0 + x.0 * seconds),
        Millimeters(pose.position().y().0 + y.0 * seconds),
        Radians(pose.heading().0 + turn.0 * seconds),
    )?;
    Ok(pose.displacement_to(end).per(step).unwrap_or(*twist))
}

/// The way that is left on a leg.
pub(crate) fn left_on(leg: &Leg, along: f64, pose: PlanarPose) -> f64 {
    match leg {
        Leg::Waypoint(waypoint) => pose.position().distance_to(waypoint.point).0,
        Leg::Path { .. } => left_on_path(leg, along),
    }
}

/// The way that is left on the path of a leg; a waypoint has none.
fn left_on_path(leg: &Leg, along: f64) -> f64 {
    match leg {
        Leg::Waypoint(_) => 0.0,
        Leg::Path { path, .. } => path.spline().length().0 - along,
    }
}

/// The heading a leg should end with, if it says so.
fn end_heading(leg: &Leg, heading_at_start: Radians) -> Option<Radians> {
    match leg {
        Leg::Waypoint(waypoint) => match waypoint.heading {
            WaypointHeading::FixedCourse { .. } => None,
            WaypointHeading::Turn { to } => Some(to),
            WaypointHeading::Hold => Some(heading_at_start),
        },
        Leg::Path { path, .. } => Some(path.end().1),
    }
}
