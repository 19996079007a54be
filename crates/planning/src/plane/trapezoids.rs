//! Exact cell decomposition.

use std::f64::consts::{PI, TAU};

use super::Point;
use super::floor::{Floor, PlaneError};
use super::graph::shortest;
use super::polygon::between;
use super::route::Route;
use super::sketch::{Sketch, SketchedCell};
use crate::wanted::{BrokenOff, Wanted};

/// Corners of the polygon around the robot's disc.
const CORNERS: u32 = 16;
/// Openings narrower than this are none.
const LEAST: f64 = 1e-6;

/// More cells, or lines between them, than this are not looked at.
const MOST_CELLS: u32 = 400_000;

/// A piece of a grown obstacle: within it, edges come in pairs from below.
type Edges = Vec<(Point, Point)>;

/// Between two neighboring events nothing begins, ends or crosses.
#[derive(Clone, Copy, Debug)]
struct Cell {
    x: [f64; 2],
    /// At both x.
    bottom: [f64; 2],
    top: [f64; 2],
    slab: usize,
}

/// A path by exact (trapezoidal) cell decomposition, its detours left out.
///
/// Each obstacle is grown by the 16-gon around the robot's disc (2 % larger than the disc); vertical
/// lines through every corner and crossing cut what is left into trapezoids, and the path goes
/// through their middles and the middles of their common sides. If there is a path for the 16-gon,
/// it is found.
///
/// # Errors
/// Start or goal where the robot cannot stand, no path, or obstacles that overlap in more than
/// 400,000 trapezoids.
pub fn trapezoids(floor: &Floor, start: Point, goal: Point) -> Result<Route, PlaneError> {
    Ok(trapezoids_sketched(floor, start, goal, Wanted::ALWAYS)?.0)
}

/// As [`trapezoids`], with the trapezoids, as long as the path is `wanted`.
///
/// # Errors
/// As [`trapezoids`]; [`PlaneError::BrokenOff`].
pub fn trapezoids_sketched(
    floor: &Floor,
    start: Point,
    goal: Point,
    wanted: Wanted<'_>,
) -> Result<(Route, Sketch), PlaneError> {
    floor.check("start", start)?;
    floor.check("goal", goal)?;
    if floor.is_free(start, goal) {
        return Ok((Route::new(vec![start, goal]), Sketch::default()));
    }
    let no_path = || PlaneError::NoPath {
        method: "exact cell decomposition",
        resolution: floor.radius() * (outer() - 1.0),
    };
    let cells = decompose(floor, wanted)?.ok_or(PlaneError::GaveUp {
        method: "exact cell decomposition",
        effort: MOST_CELLS,
        unit: "cells or events",
    })?;
    let (Some(first), Some(last)) = (cell_of(floor, &cells, start), cell_of(floor, &cells, goal))
    else {
        return Err(no_path());
    };
    let slabs = cells.last().map_or(0, |cell| cell.slab + 1);
    let mut by_slab = vec![Vec::new(); slabs];
    for (index, cell) in cells.iter().enumerate() {
        if let Some(slab) = by_slab.get_mut(cell.slab) {
            slab.push(index);
        }
    }
    let way = shortest(
        cells.len(),
        first,
        last,
        |node, around| {
            let Some(cell) = cells.get(node) else {
                return;
            };
            let beside = [cell.slab.wrapping_sub(1), cell.slab + 1];
            for &next in beside
                .iter()
                .filter_map(|slab| by_slab.get(*slab))
                .flatten()
            {
                if let Some(other) = cells.get(next)
                    && let Some(door) = door(cell, other)
                {
                    let cost = between(cell.middle(), door) + between(door, other.middle());
                    around.push((next, cost));
                }
            }
        },
        |node| {
            cells
                .get(node)
                .map_or(0.0, |cell| between(cell.middle(), goal))
        },
    )
    .ok_or_else(no_path)?;
    let mut points = vec![start];
    for (from, to) in way.iter().zip(way.iter().skip(1)) {
        if let (Some(from), Some(to)) = (cells.get(*from), cells.get(*to)) {
            points.push(from.middle());
            points.extend(door(from, to));
        }
    }
    points.extend(cells.get(last).map(Cell::middle));
    points.push(goal);
    let sketch = Sketch {
        cells: cells.iter().map(Cell::sketched).collect(),
        edges: Vec::new(),
    };
    Ok((Route::new(points).shortened(floor, wanted)?, sketch))
}

impl Cell {
    fn sketched(&self) -> SketchedCell {
        let ([x0, x1], [b0, b1], [t0, t1]) = (self.x, self.bottom, self.top);
        SketchedCell {
            corners: [[x0, b0], [x1, b1], [x1, t1], [x0, t0]],
            free: true,
        }
    }

    fn middle(&self) -> Point {
        let [x0, x1] = self.x;
        let sum: f64 = self.bottom.iter().chain(&self.top).sum();
        [0.5 * (x0 + x1), 0.25 * sum]
    }

    fn contains(&self, [x, y]: Point) -> bool {
        let [x0, x1] = self.x;
        if x < x0 || x > x1 {
            return false;
        }
        let share = (x - x0) / (x1 - x0);
        let at = |[a, b]: [f64; 2]| a + share * (b - a);
        at(self.bottom) <= y && y <= at(self.top)
    }
}

/// The middle of what two cells of neighboring slabs have in common.
fn door(a: &Cell, b: &Cell) -> Option<Point> {
    let (left, right) = if a.slab < b.slab { (a, b) } else { (b, a) };
    let low = left.bottom[1].max(right.bottom[0]);
    let high = left.top[1].min(right.top[0]);
    (high - low > LEAST).then_some([left.x[1], 0.5 * (low + high)])
}

/// The cell of a point; for a point between the disc and the 16-gon, one that it sees.
fn cell_of(floor: &Floor, cells: &[Cell], point: Point) -> Option<usize> {
    let inside = cells.iter().position(|cell| cell.contains(point));
    let seen = |cell: &&(f64, usize, Point)| floor.is_free(point, cell.2);
    inside
        .filter(|index| {
            cells
                .get(*index)
                .is_some_and(|cell| floor.is_free(point, cell.middle()))
        })
        .or_else(|| {
            let mut near: Vec<(f64, usize, Point)> = cells
                .iter()
                .enumerate()
                .map(|(index, cell)| (between(cell.middle(), point), index, cell.middle()))
                .collect();
            near.sort_by(|a, b| a.0.total_cmp(&b.0));
            near.iter().find(seen).map(|(_, index, _)| *index)
        })
}

/// How much larger the polygon around a circle is.
fn outer() -> f64 {
    1.0 / (PI / f64::from(CORNERS)).cos()
}

fn pieces(floor: &Floor) -> Vec<Edges> {
    let radius = floor.radius() * outer();
    let disc: Vec<Point> = (0..CORNERS)
        .map(|corner| {
            let angle = TAU * (f64::from(corner) + 0.5) / f64::from(CORNERS);
            [radius * angle.cos(), radius * angle.sin()]
        })
        .collect();
    let mut pieces = Vec::new();
    for obstacle in floor.obstacles() {
        pieces.push(obstacle.edges().collect());
        if radius > 0.0 {
            for (a, b) in obstacle.edges() {
                let moved = |to: Point| disc.iter().map(move |[x, y]| [x + to[0], y + to[1]]);
                pieces.push(closed(&hull(moved(a).chain(moved(b)).collect())));
            }
        }
    }
    pieces
}

fn closed(corners: &[Point]) -> Edges {
    let next = corners.iter().cycle().skip(1);
    corners.iter().copied().zip(next.copied()).collect()
}

/// The convex hull (Andrew's monotone chain), counterclockwise.
fn hull(mut points: Vec<Point>) -> Vec<Point> {
    points.sort_by(|a, b| a[0].total_cmp(&b[0]).then(a[1].total_cmp(&b[1])));
    let half = |points: &mut dyn Iterator<Item = &Point>| {
        let mut chain: Vec<Point> = Vec::new();
        for &[x, y] in points {
            while let [.., [ax, ay], [bx, by]] = chain.as_slice()
                && (bx - ax) * (y - ay) - (by - ay) * (x - ax) <= 0.0
            {
                let _ = chain.pop();
            }
            chain.push([x, y]);
        }
        let _ = chain.pop();
        chain
    };
    let mut lower = half(&mut points.iter());
    lower.extend(half(&mut points.iter().rev()));
    lower
}

/// Nothing if there are too many cells.
fn decompose(floor: &Floor, wanted: Wanted<'_>) -> Result<Option<Vec<Cell>>, BrokenOff> {
    let pieces = pieces(floor);
    let radius = floor.radius();
    let (left, right) = (floor.min()[0] + radius, floor.max()[0] - radius);
    let (bottom, top) = (floor.min()[1] + radius, floor.max()[1] - radius);
    let most = usize::try_from(MOST_CELLS).unwrap_or(usize::MAX);
    let Some(events) = events(&pieces, [left, right], [bottom, top], most) else {
        return Ok(None);
    };
    let mut cells = Vec::new();
    // Edges by where they begin; those that ended are dropped on the way.
    let mut waiting: Vec<(usize, Point, Point)> = pieces
        .iter()
        .enumerate()
        .flat_map(|(piece, edges)| {
            edges.iter().map(move |&(a, b)| {
                if a[0] <= b[0] {
                    (piece, a, b)
                } else {
                    (piece, b, a)
                }
            })
        })
        .filter(|(_, a, b)| b[0] > a[0])
        .collect();
    waiting.sort_by(|(_, a, _), (_, b, _)| a[0].total_cmp(&b[0]));
    let mut waiting = waiting.into_iter().peekable();
    let mut active: Vec<(usize, Point, Point)> = Vec::new();
    let spans = events.iter().zip(events.iter().skip(1));
    for (slab, (&x0, &x1)) in spans.enumerate() {
        wanted.check()?;
        if cells.len() > most {
            return Ok(None);
        }
        let x = 0.5 * (x0 + x1);
        while let Some(edge) = waiting.next_if(|(_, a, _)| a[0] < x) {
            active.push(edge);
        }
        active.retain(|(_, _, b)| b[0] > x);
        let mut crossed: Vec<(usize, f64, [f64; 2])> = active
            .iter()
            .map(|&(piece, a, b)| (piece, height(a, b, x), [height(a, b, x0), height(a, b, x1)]))
            .collect();
        crossed.sort_by(|a, b| a.0.cmp(&b.0).then(a.1.total_cmp(&b.1)));
        let (below, above) = crossed
            .as_chunks::<2>()
            .0
            .iter()
            .map(|[a, b]| (*a, *b))
            .fold(
                (Vec::new(), Vec::new()),
                |(mut below, mut above), (a, b)| {
                    below.push(a);
                    above.push(b);
                    (below, above)
                },
            );
        let mut blocked: Vec<_> = below.into_iter().zip(above).collect();
        blocked.sort_by(|(a, _), (b, _)| a.1.total_cmp(&b.1));
        let mut floor_at = (bottom, [bottom; 2]);
        let ceiling = ((0, top, [top; 2]), (0, f64::INFINITY, [f64::INFINITY; 2]));
        for ((_, low, low_ends), (_, high, high_ends)) in blocked.into_iter().chain([ceiling]) {
            let (low, low_ends) = if low < top {
                (low, low_ends)
            } else {
                (top, [top; 2])
            };
            if low > floor_at.0 {
                cells.push(Cell {
                    x: [x0, x1],
                    bottom: floor_at.1,
                    top: low_ends,
                    slab,
                });
            }
            if high > floor_at.0 {
                floor_at = (high, high_ends);
            }
        }
    }
    Ok(Some(cells))
}

fn height(a: Point, b: Point, x: f64) -> f64 {
    let share = (x - a[0]) / (b[0] - a[0]);
    a[1] + share * (b[1] - a[1])
}

/// Every x at which an edge begins, ends or crosses another one, or an edge of the floor.
///
/// Nothing if there are more than `most`.
fn events(
    pieces: &[Edges],
    [left, right]: [f64; 2],
    [bottom, top]: [f64; 2],
    most: usize,
) -> Option<Vec<f64>> {
    let mut edges: Vec<(Point, Point)> = pieces
        .iter()
        .flatten()
        .map(|&(a, b)| if a[0] <= b[0] { (a, b) } else { (b, a) })
        .collect();
    edges.push(([left, bottom], [right, bottom]));
    edges.push(([left, top], [right, top]));
    edges.sort_by(|(a, _), (b, _)| a[0].total_cmp(&b[0]));
    let mut events = vec![left, right];
    for (index, (a, b)) in edges.iter().enumerate() {
        events.extend([a[0], b[0]]);
        let later = edges.iter().skip(index + 1);
        let overlapping = later.take_while(|(c, _)| c[0] <= b[0]);
        events.extend(overlapping.filter_map(|(c, d)| crossing(*a, *b, *c, *d)));
        if events.len() > most {
            return None;
        }
    }
    events.retain(|x| (left..=right).contains(x));
    events.sort_by(f64::total_cmp);
    events.dedup_by(|a, b| *a - *b < 1e-9);
    Some(events)
}

/// The x at which two segments cross.
fn crossing(a: Point, b: Point, c: Point, d: Point) -> Option<f64> {
    let (u, v) = ([b[0] - a[0], b[1] - a[1]], [d[0] - c[0], d[1] - c[1]]);
    let turn = u[0] * v[1] - u[1] * v[0];
    if turn == 0.0 {
        return None;
    }
    let w = [c[0] - a[0], c[1] - a[1]];
    let (s, t) = (
        (w[0] * v[1] - w[1] * v[0]) / turn,
        (w[0] * u[1] - w[1] * u[0]) / turn,
    );
    ((0.0..=1.0).contains(&s) && (0.0..=1.0).contains(&t)).then_some(a[0] + s * u[0])
}
