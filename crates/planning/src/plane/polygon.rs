//! Simple polygons.

use super::Point;

const MIN_CORNERS: usize = 3;
const MAX_CORNERS: usize = 256;
const MAX_COORDINATE: f64 = 1e6;
/// The least area of an obstacle, mm².
const MIN_AREA: f64 = 1e-3;

/// Why a polygon was refused. Corners and edges count from 1; edge k begins at corner k.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum PolygonError {
    /// Too few or too many corners.
    #[error("{count} corners; a polygon has {MIN_CORNERS} to {MAX_CORNERS}")]
    Corners {
        /// How many were given.
        count: usize,
    },
    /// A coordinate that is NaN, infinite or too large.
    #[error(
        "corner {corner} has the coordinate {value}; it must be a number from -{MAX_COORDINATE} to {MAX_COORDINATE}"
    )]
    Coordinate {
        /// Which corner.
        corner: usize,
        /// What was given.
        value: f64,
    },
    /// Two edges that meet elsewhere than at a common corner.
    #[error("edges {first} and {second} cross or touch")]
    Crossing {
        /// The one.
        first: usize,
        /// The other.
        second: usize,
    },
    /// Corners on a line, or all in one place.
    #[error("the area is {area} mm²; it must be at least {MIN_AREA} mm²")]
    Empty {
        /// How large it is.
        area: f64,
    },
}

/// An outline whose edges do not cross; it need not be convex, and its corners may go either way
/// around.
#[derive(Clone, Debug, PartialEq)]
pub struct Polygon {
    corners: Vec<Point>,
}

impl Polygon {
    /// An outline from its corners.
    ///
    /// # Errors
    /// Names the corner or the edges that are wrong.
    pub fn try_new(corners: Vec<Point>) -> Result<Polygon, PolygonError> {
        let count = corners.len();
        if !(MIN_CORNERS..=MAX_CORNERS).contains(&count) {
            return Err(PolygonError::Corners { count });
        }
        for (corner, point) in (1..).zip(&corners) {
            for value in *point {
                if !value.is_finite() || value.abs() > MAX_COORDINATE {
                    return Err(PolygonError::Coordinate { corner, value });
                }
            }
        }
        let polygon = Polygon { corners };
        let area = polygon.area();
        if area < MIN_AREA {
            return Err(PolygonError::Empty { area });
        }
        let edges: Vec<(Point, Point)> = polygon.edges().collect();
        for (i, a) in edges.iter().enumerate() {
            for (j, b) in edges.iter().enumerate().skip(i + 1) {
                let neighbors = j == i + 1 || (i == 0 && j + 1 == count);
                let meet = if neighbors {
                    // Neighbors share a corner; they must not lie on each other.
                    let (before, after) = if j == i + 1 { (a, b) } else { (b, a) };
                    folds_back(before.0, before.1, after.1)
                } else {
                    segments_meet(*a, *b)
                };
                if meet {
                    return Err(PolygonError::Crossing {
                        first: i + 1,
                        second: j + 1,
                    });
                }
            }
        }
        Ok(polygon)
    }

    /// The corners as they were given.
    #[must_use]
    pub fn corners(&self) -> &[Point] {
        &self.corners
    }

    /// In mm².
    #[must_use]
    pub fn area(&self) -> f64 {
        let origin = self.corners.first().copied().unwrap_or_default();
        let twice: f64 = self.edges().map(|(a, b)| cross(origin, a, b)).sum();
        0.5 * twice.abs()
    }

    /// Each edge from its corner to the next one.
    pub(crate) fn edges(&self) -> impl Iterator<Item = (Point, Point)> + '_ {
        let next = self.corners.iter().cycle().skip(1);
        self.corners.iter().copied().zip(next.copied())
    }

    /// Is the point inside? A point on an edge may be either.
    pub(crate) fn contains(&self, [x, y]: Point) -> bool {
        self.edges().fold(false, |inside, ([ax, ay], [bx, by])| {
            let crossed = (ay > y) != (by > y) && x < ax + (y - ay) / (by - ay) * (bx - ax);
            inside != crossed
        })
    }

    /// The distance to the outline and the nearest point of it; negative inside.
    pub(crate) fn distance(&self, point: Point) -> (f64, Point) {
        let (distance, nearest) = self
            .edges()
            .map(|(a, b)| {
                let nearest = nearest_on(a, b, point);
                (between(point, nearest), nearest)
            })
            .min_by(|a, b| a.0.total_cmp(&b.0))
            .unwrap_or((f64::INFINITY, point));
        if self.contains(point) {
            (-distance, nearest)
        } else {
            (distance, nearest)
        }
    }

    /// The distance of a segment; zero if it meets the outline or lies inside.
    pub(crate) fn distance_to_segment(&self, a: Point, b: Point) -> f64 {
        if self.contains(a) {
            return 0.0;
        }
        let distances = self.edges().map(|(c, d)| segment_distance((a, b), (c, d)));
        distances.fold(f64::INFINITY, f64::min)
    }
}

pub(crate) fn between([ax, ay]: Point, [bx, by]: Point) -> f64 {
    (bx - ax).hypot(by - ay)
}

/// Twice the area of the triangle, positive counterclockwise.
fn cross([ox, oy]: Point, [ax, ay]: Point, [bx, by]: Point) -> f64 {
    (ax - ox) * (by - oy) - (ay - oy) * (bx - ox)
}

/// Do the edges from `a` over `b` to `c` lie on each other?
fn folds_back(a: Point, b: Point, c: Point) -> bool {
    let ahead = (b[0] - a[0]) * (c[0] - b[0]) + (b[1] - a[1]) * (c[1] - b[1]);
    let (ab, bc) = (between(a, b), between(b, c));
    let beside = cross(a, b, c).abs();
    ab == 0.0 || bc == 0.0 || (beside <= 1e-12 * ab * bc && ahead < 0.0)
}

pub(crate) fn nearest_on([ax, ay]: Point, [bx, by]: Point, [x, y]: Point) -> Point {
    let (dx, dy) = (bx - ax, by - ay);
    let square = dx * dx + dy * dy;
    if square == 0.0 {
        return [ax, ay];
    }
    let share = (((x - ax) * dx + (y - ay) * dy) / square).clamp(0.0, 1.0);
    [ax + share * dx, ay + share * dy]
}

type Segment = (Point, Point);

fn segments_meet((a, b): Segment, (c, d): Segment) -> bool {
    let (abc, abd) = (cross(a, b, c), cross(a, b, d));
    let (cda, cdb) = (cross(c, d, a), cross(c, d, b));
    if abc * abd < 0.0 && cda * cdb < 0.0 {
        return true;
    }
    // An end of one on the other.
    let touches = |a, b, p| between(nearest_on(a, b, p), p) <= 1e-9;
    touches(a, b, c) || touches(a, b, d) || touches(c, d, a) || touches(c, d, b)
}

fn segment_distance((a, b): Segment, (c, d): Segment) -> f64 {
    if segments_meet((a, b), (c, d)) {
        return 0.0;
    }
    let to = |a, b, p| between(nearest_on(a, b, p), p);
    to(a, b, c)
        .min(to(a, b, d))
        .min(to(c, d, a))
        .min(to(c, d, b))
}
