//! A disc among polygons.

use api::paths::{PlanRouteBody, PlanRouteResult, RouteCell, RouteMethod};
use planning::plane::{self, Field, Floor, PlaneError, Point, Polygon, Route, Sketch};
use planning::{Sampling, Wanted};

use crate::convert::shown;
use crate::refusal::{Refusal, RefusalKind, count_or, length, number, within, within_or};

const MOST_OBSTACLES: usize = 200;
const MOST_CORNERS: usize = 1000;
/// Steps in the potential field times corners of obstacles.
const FIELD_EFFORT: f64 = 1e8;
/// Cells or edges of one answer.
const MOST_SKETCHED: usize = 10_000;
const LENGTH_MM: [f64; 2] = [-1e6, 1e6];

/// A path of a disc-shaped robot from start to goal among polygons.
///
/// Textbook 2.2: exact and approximate cell decomposition, potential field (2.7) to (2.11), probabilistic roadmap.
/// The same question, seed included, gives the same path.
///
/// # Errors
/// Names the obstacle and the corner or edges that are wrong, a start or goal in an obstacle or off the floor with the
/// distance, or that no path was found and how far it was looked for.
pub fn plan_route(body: &PlanRouteBody) -> Result<PlanRouteResult, Refusal> {
    plan_route_while(body, Wanted::ALWAYS)
}

/// As [`plan_route`], as long as the answer is `wanted`.
///
/// # Errors
/// As [`plan_route`]; [`RefusalKind::BrokenOff`].
pub fn plan_route_while(
    body: &PlanRouteBody,
    wanted: Wanted<'_>,
) -> Result<PlanRouteResult, Refusal> {
    let floor = floor_of(body)?;
    let (start, goal) = (body.start_mm, body.goal_mm);
    let search = &body.search;
    let method = search.method.unwrap_or_default();
    let seed = search.seed.unwrap_or(0);
    let [width, height] = [0, 1].map(|axis| side(&floor, axis));
    let size = width.max(height);
    let route = match method {
        RouteMethod::Trapezoidal => plane::trapezoids_sketched(&floor, start, goal, wanted),
        RouteMethod::Quadtree => {
            let resolution = within_or(
                "search.resolution_mm",
                search.resolution_mm,
                (size / 200.0).max(0.1),
                [0.1, 1e5],
                "mm",
            )?;
            plane::quadtree_sketched(&floor, start, goal, resolution, wanted)
        }
        RouteMethod::PotentialField => {
            let usual = Field::default();
            // Each step looks at every edge.
            let corners = floor.obstacles().iter().map(|o| o.corners().len()).sum();
            let affordable = FIELD_EFFORT / number(corners).unwrap_or(1.0).max(1.0);
            let usual_steps = if affordable < 400_000.0 {
                100_000
            } else {
                400_000
            };
            let most = count_or("search.steps", search.steps, usual_steps, [1, 1_000_000])?;
            let _ = within("search.steps", f64::from(most), [1.0, affordable], "")?;
            let influence = within_or(
                "search.influence_mm",
                search.influence_mm,
                usual.influence,
                [1e-3, 1e6],
                "mm",
            )?;
            let field = Field {
                influence,
                most_steps: most,
                seed,
                ..usual
            };
            plane::potential_sketched(&floor, start, goal, &field, wanted)
        }
        RouteMethod::Roadmap => {
            let most = count_or("search.samples", search.samples, 5000, [1, 10_000])?;
            let sampling = Sampling {
                seed,
                most,
                ..Sampling::default()
            };
            plane::roadmap_sketched(&floor, start, goal, &sampling, wanted)
        }
    };
    let (route, sketch) = route.map_err(|error| plane_refusal(&error, body))?;
    let (cells, graph_mm) = sketched(sketch);
    Ok(PlanRouteResult {
        method,
        floor: body.floor,
        obstacles: body.obstacles.clone(),
        radius_mm: body.radius_mm,
        points_mm: route.points().iter().map(|p| p.map(shown)).collect(),
        length_mm: shown(route.length()),
        clearance_mm: shown(clearance(&floor, &route)),
        cells,
        graph_mm,
    })
}

/// For drawings: nothing where it would be more than a drawing shows.
fn sketched(sketch: Sketch) -> (Vec<RouteCell>, Vec<[Point; 2]>) {
    let Sketch { cells, mut edges } = sketch;
    let cells = if cells.len() > MOST_SKETCHED {
        Vec::new()
    } else {
        let told = cells.into_iter().map(|cell| RouteCell {
            corners_mm: cell.corners.map(|corner| corner.map(shown)).to_vec(),
            free: cell.free,
        });
        told.collect()
    };
    if edges.len() > MOST_SKETCHED {
        edges.clear();
    }
    let graph = edges.into_iter().map(|edge| edge.map(|end| end.map(shown)));
    (cells, graph.collect())
}

fn side(floor: &Floor, axis: usize) -> f64 {
    let of = |point: Point| point.get(axis).copied().unwrap_or(0.0);
    of(floor.max()) - of(floor.min())
}

fn floor_of(body: &PlanRouteBody) -> Result<Floor, Refusal> {
    length(
        "obstacles",
        body.obstacles.len(),
        [0, MOST_OBSTACLES],
        "obstacles",
    )?;
    let corners: usize = body.obstacles.iter().map(|o| o.corners_mm.len()).sum();
    length(
        "obstacles",
        corners,
        [0, MOST_CORNERS],
        "corners of all obstacles together",
    )?;
    let points = [
        ("floor.min_mm", body.floor.min_mm),
        ("floor.max_mm", body.floor.max_mm),
        ("start_mm", body.start_mm),
        ("goal_mm", body.goal_mm),
    ];
    for (path, point) in points {
        for (index, value) in point.into_iter().enumerate() {
            let _ = within(&format!("{path}[{index}]"), value, LENGTH_MM, "mm")?;
        }
    }
    let _ = within("radius_mm", body.radius_mm, [0.0, 1e6], "mm")?;
    let mut polygons = Vec::new();
    for (index, obstacle) in body.obstacles.iter().enumerate() {
        let polygon = Polygon::try_new(obstacle.corners_mm.clone()).map_err(|error| {
            let path = format!("obstacles[{index}].corners_mm");
            match &obstacle.name {
                Some(name) => Refusal::invalid(path, format!("{name}: {error}")),
                None => Refusal::invalid(path, error),
            }
        })?;
        polygons.push(polygon);
    }
    Floor::try_new(
        body.floor.min_mm,
        body.floor.max_mm,
        polygons,
        body.radius_mm,
    )
    .map_err(|error| Refusal::invalid("floor", error))
}

/// The least distance of the disc from anything, along the path.
fn clearance(floor: &Floor, route: &Route) -> f64 {
    let points = route.points();
    let pairs = points.iter().zip(points.iter().skip(1));
    let between = pairs.flat_map(|([ax, ay], [bx, by])| {
        (0..=64_u32).map(move |part| {
            let share = f64::from(part) / 64.0;
            [ax + share * (bx - ax), ay + share * (by - ay)]
        })
    });
    between
        .chain(points.first().copied())
        .map(|point| floor.clearance(point))
        .fold(f64::INFINITY, f64::min)
}

fn plane_refusal(error: &PlaneError, body: &PlanRouteBody) -> Refusal {
    match error {
        PlaneError::OffTheFloor {
            point,
            distance,
            radius,
        } => Refusal {
            min: Some(*radius),
            ..Refusal::invalid(format!("{point}_mm"), error).with_value(*distance)
        },
        PlaneError::InObstacle {
            point,
            obstacle,
            distance,
            radius,
        } => {
            let index = obstacle.saturating_sub(1);
            let name = body.obstacles.get(index).and_then(|o| o.name.as_deref());
            let called = name.map_or_else(|| format!("obstacle {obstacle}"), str::to_owned);
            let detail = format!(
                "the {point} is {distance:.3} mm from {called} (negative: inside); the robot needs {radius} mm"
            );
            Refusal {
                min: Some(*radius),
                ..Refusal::invalid(format!("{point}_mm"), detail).with_value(*distance)
            }
        }
        PlaneError::NoPath { .. } | PlaneError::GaveUp { .. } => {
            Refusal::new(RefusalKind::NoWay, "", error)
        }
        PlaneError::BrokenOff(error) => Refusal::broken_off(*error),
        PlaneError::Polygon(_) | PlaneError::Obstacles { .. } => {
            Refusal::invalid("obstacles", error)
        }
        PlaneError::Range { value, .. } => Refusal::invalid("search", error).with_value(*value),
    }
}
