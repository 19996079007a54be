//! Routes through places, as legs for the laws.

use api::RoutePointBody;
use mobile_base::{
    Leg, PathHeading, PlanarPose, PlannedPath, Point, Spline, SplineEnds, Waypoint, WaypointHeading,
};
use units::{Degrees, Millimeters};

use crate::config::RouteShape;
use crate::plan::Plan;

/// Places of one route; the legs it makes stay below what a route may have.
const MAX_PLACES: usize = 900;
/// At the end of a drive the base is this near, and stands.
const END_TOLERANCE: Millimeters = Millimeters(5.0);
/// Points of a spline are not nearer than this.
const MIN_CHORD_MM: f64 = 2.0;

/// The legs from `from` through `places` to `to`.
///
/// # Errors
/// A sentence about what cannot be driven.
pub(crate) fn legs(
    plan: &Plan,
    from: PlanarPose,
    places: &[RoutePointBody],
    to: PlanarPose,
) -> Result<Vec<Leg>, String> {
    if places.len() > MAX_PLACES {
        return Err(format!(
            "the route has {} places; it may have {MAX_PLACES}",
            places.len()
        ));
    }
    let mut legs = Vec::with_capacity(places.len() + 1);
    match plan.route {
        RouteShape::Spline if !places.is_empty() => legs.push(path(plan, from, places, to)?),
        RouteShape::Spline | RouteShape::Waypoints => {
            for (number, place) in places.iter().enumerate() {
                legs.push(Leg::Waypoint(Waypoint {
                    point: point(number, place)?,
                    tolerance: plan.waypoint_tolerance,
                    heading: match place.heading_deg {
                        Some(heading) => WaypointHeading::Turn {
                            to: Degrees(heading).into(),
                        },
                        None => WaypointHeading::Hold,
                    },
                }));
            }
        }
    }
    legs.push(end(to, END_TOLERANCE));
    Ok(legs)
}

/// The leg that ends at a pose.
pub(crate) fn end(to: PlanarPose, tolerance: Millimeters) -> Leg {
    Leg::Waypoint(Waypoint {
        point: to.position(),
        tolerance,
        heading: WaypointHeading::Turn { to: to.heading() },
    })
}

fn point(number: usize, place: &RoutePointBody) -> Result<Point, String> {
    let heading = place.heading_deg.unwrap_or_default();
    if !(-36_000.0..=36_000.0).contains(&heading) {
        return Err(format!(
            "place {number} of the route: heading_deg is {heading}; it must be from -36000 to 36000"
        ));
    }
    Point::try_new(Millimeters(place.x_mm), Millimeters(place.y_mm))
        .map_err(|error| format!("place {number} of the route: {error}"))
}

/// One smooth path through all places.
fn path(
    plan: &Plan,
    from: PlanarPose,
    places: &[RoutePointBody],
    to: PlanarPose,
) -> Result<Leg, String> {
    let mut points = vec![from.position()];
    for (number, place) in places.iter().enumerate() {
        points.push(point(number, place)?);
    }
    points.push(to.position());
    points.dedup_by(|next, before| before.distance_to(*next).0 < MIN_CHORD_MM);
    if points.len() < 2 {
        return Ok(end(to, END_TOLERANCE));
    }
    let spline = Spline::try_new(&points, SplineEnds::Natural).map_err(|e| e.to_string())?;
    let heading = PathHeading::Turning {
        from: from.heading(),
        to: to.heading(),
    };
    let path = PlannedPath::try_new(spline, heading, &plan.path_limits, &plan.base)
        .map_err(|error| error.to_string())?;
    Ok(Leg::Path {
        path,
        tolerance: plan.waypoint_tolerance,
    })
}
