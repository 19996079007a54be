//! What of a cell's set-up is in a mobile robot's way.

use api::paths::{CellRouteBody, FloorBody, PlanRouteBody, PolygonBody};
use api::setup::{BoxBody, SetupFile, ZoneBody, ZoneKind};

use crate::refusal::Refusal;

/// Room around everything where nothing says how large the floor is: this, and twice the robot.
const ROOM_MM: f64 = 500.0;

/// The question for [`crate::plan_route`] about a mobile robot of a cell; everything in the cell frame.
///
/// In the way are the keep-out zones that are for this robot, the hand-over zones that neither its start nor its goal
/// is in, and what the question brings. `at` is where the robot last told that it is.
///
/// # Errors
/// No such mobile robot or goal in the set-up, no start, or a goal said twice.
pub fn route_in_cell(
    setup: &SetupFile,
    mobile_robot: &str,
    at: Option<[f64; 2]>,
    body: &CellRouteBody,
) -> Result<PlanRouteBody, Refusal> {
    let robot = setup
        .mobile_robots
        .iter()
        .find(|known| known.id == mobile_robot);
    let robot = robot.ok_or_else(|| {
        let detail = format!("there is no mobile robot {mobile_robot:?} in the set-up");
        Refusal::invalid("", detail)
    })?;
    let goal_mm = goal(setup, body)?;
    let start_mm = body.start_mm.or(at).ok_or_else(|| {
        Refusal::invalid(
            "start_mm",
            "it is missing, and the robot has not told where it is",
        )
    })?;
    let footprint = &robot.footprint;
    let round = 0.5 * footprint.length_mm.hypot(footprint.width_mm);
    let radius_mm = body.radius_mm.unwrap_or(round);
    let own: Vec<&ZoneBody> = setup
        .zones
        .iter()
        .filter(|zone| {
            let robots = zone.robots.as_ref();
            robots.is_none_or(|robots| robots.iter().any(|id| id == mobile_robot))
        })
        .collect();
    let in_the_way = own.iter().filter(|zone| match zone.kind {
        ZoneKind::KeepOut => true,
        ZoneKind::Handover => !holds(&zone.bounds, start_mm) && !holds(&zone.bounds, goal_mm),
        ZoneKind::Work => false,
    });
    let mut obstacles: Vec<PolygonBody> = in_the_way.map(|zone| polygon(zone)).collect();
    obstacles.extend(body.obstacles.iter().cloned());
    let floor = match body.floor {
        Some(floor) => floor,
        None => floor_of(setup, &own, [start_mm, goal_mm], radius_mm),
    };
    Ok(PlanRouteBody {
        floor,
        obstacles,
        radius_mm,
        start_mm,
        goal_mm,
        search: body.search.clone(),
    })
}

fn goal(setup: &SetupFile, body: &CellRouteBody) -> Result<[f64; 2], Refusal> {
    let name = match (&body.goal, body.goal_mm) {
        (None, Some(goal)) => return Ok(goal),
        (Some(name), None) => name,
        (Some(_), Some(_)) => {
            return Err(Refusal::invalid(
                "goal_mm",
                "there is goal too; give one of them",
            ));
        }
        (None, None) => return Err(Refusal::invalid("goal", "it is missing")),
    };
    let points = setup.stations.iter().flat_map(|station| {
        let named = move |id: &str| format!("{}/{id}", station.id);
        station
            .points
            .iter()
            .map(move |point| (named(&point.id), point))
    });
    let mut named = points.filter(|(known, _)| known == name);
    let found = named
        .next()
        .map(|(_, point)| [point.dock.x_mm, point.dock.y_mm]);
    found.ok_or_else(|| {
        // It is somebody's text.
        let shown: String = name.chars().take(100).collect();
        Refusal::invalid("goal", format!("there is no point {shown:?} in the set-up"))
    })
}

fn holds(bounds: &BoxBody, [x, y]: [f64; 2]) -> bool {
    (bounds.min.x_mm..=bounds.max.x_mm).contains(&x)
        && (bounds.min.y_mm..=bounds.max.y_mm).contains(&y)
}

fn polygon(zone: &ZoneBody) -> PolygonBody {
    let (min, max) = (&zone.bounds.min, &zone.bounds.max);
    PolygonBody {
        name: Some(zone.id.clone()),
        corners_mm: vec![
            [min.x_mm, min.y_mm],
            [max.x_mm, min.y_mm],
            [max.x_mm, max.y_mm],
            [min.x_mm, max.y_mm],
        ],
    }
}

/// Around the robot's own work zones; without any, around all that is known.
fn floor_of(
    setup: &SetupFile,
    own: &[&ZoneBody],
    ends: [[f64; 2]; 2],
    radius_mm: f64,
) -> FloorBody {
    let corners = |zone: &ZoneBody| {
        let (min, max) = (zone.bounds.min, zone.bounds.max);
        [[min.x_mm, min.y_mm], [max.x_mm, max.y_mm]]
    };
    // A work zone for all robots is an arm's as well: it says nothing about the floor.
    let work = own
        .iter()
        .filter(|zone| zone.kind == ZoneKind::Work && zone.robots.is_some());
    let inside: Vec<[f64; 2]> = work.flat_map(|zone| corners(zone)).collect();
    if !inside.is_empty() {
        return around(&inside, 0.0);
    }
    let docks = setup.stations.iter().flat_map(|station| &station.points);
    let docks = docks.map(|point| [point.dock.x_mm, point.dock.y_mm]);
    let zones = setup.zones.iter().flat_map(corners);
    let all: Vec<[f64; 2]> = docks.chain(zones).chain(ends).collect();
    around(&all, ROOM_MM + 2.0 * radius_mm)
}

fn around(points: &[[f64; 2]], room: f64) -> FloorBody {
    let mut floor = FloorBody {
        min_mm: [f64::INFINITY; 2],
        max_mm: [f64::NEG_INFINITY; 2],
    };
    for point in points {
        let bounds = floor.min_mm.iter_mut().zip(&mut floor.max_mm);
        for ((min, max), value) in bounds.zip(point) {
            *min = min.min(value - room);
            *max = max.max(value + room);
        }
    }
    floor
}
