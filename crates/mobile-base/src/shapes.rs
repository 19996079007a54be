//! Outlines on the floor, and how far they are apart.

use units::Millimeters;

use crate::pose::{PlanarPose, Point};
use crate::range::{OutOfRange, Quantity, within};

const MIN_CORNERS: usize = 3;
const MAX_CORNERS: usize = 256;
const MIN_SIZE: Millimeters = Millimeters(1.0);
const MAX_SIZE: Millimeters = Millimeters(1e5);

/// An outline without holes, whose edges do not cross; it need not be convex.
#[derive(Clone, Debug, PartialEq)]
struct Polygon {
    corners: Vec<Point>,
    /// Of a circle that holds it: its middle and its radius.
    middle: Point,
    radius: f64,
}

/// Something in the way, in the world.
#[derive(Clone, Debug, PartialEq)]
pub struct Obstacle(Shape);

#[derive(Clone, Debug, PartialEq)]
enum Shape {
    Disc { center: Point, radius: f64 },
    Polygon(Polygon),
}

/// The outline of the base, in its own frame.
#[derive(Clone, Debug, PartialEq)]
pub struct Footprint {
    outline: Polygon,
    /// Of the farthest corner from the base's frame.
    reach: f64,
}

impl Obstacle {
    /// A round obstacle.
    ///
    /// # Errors
    /// A radius that is not from 1 mm to 100 m.
    pub fn disc(center: Point, radius: Millimeters) -> Result<Obstacle, OutOfRange> {
        let radius = within("radius of the obstacle", radius, MIN_SIZE, MAX_SIZE)?.0;
        Ok(Obstacle(Shape::Disc { center, radius }))
    }

    /// An obstacle with corners, in their order around it; it need not be convex.
    ///
    /// # Errors
    /// Not 3 to 256 corners. Edges that cross are not noticed; the edges then still count.
    pub fn polygon(corners: Vec<Point>) -> Result<Obstacle, OutOfRange> {
        let polygon = Polygon::try_new("corners of the obstacle", corners)?;
        Ok(Obstacle(Shape::Polygon(polygon)))
    }
}

impl Footprint {
    /// A rectangle with the base's frame in its middle; `length` along x, `width` along y.
    ///
    /// # Errors
    /// A side that is not from 1 mm to 100 m.
    pub fn rectangle(length: Millimeters, width: Millimeters) -> Result<Footprint, OutOfRange> {
        let x = 0.5 * within("length of the footprint", length, MIN_SIZE, MAX_SIZE)?.0;
        let y = 0.5 * within("width of the footprint", width, MIN_SIZE, MAX_SIZE)?.0;
        let corners = [(x, y), (-x, y), (-x, -y), (x, -y)];
        Footprint::polygon(corners.map(|(x, y)| Point::raw(x, y)).to_vec())
    }

    /// Any outline, its corners in the base's frame.
    ///
    /// # Errors
    /// Not 3 to 256 corners.
    pub fn polygon(corners_B: Vec<Point>) -> Result<Footprint, OutOfRange> {
        let outline = Polygon::try_new("corners of the footprint", corners_B)?;
        let distances = outline.corners.iter().map(|corner| {
            let (x, y) = corner.xy();
            x.hypot(y)
        });
        let reach = distances.fold(0.0, f64::max);
        Ok(Footprint { outline, reach })
    }

    /// The least distance between a base at `pose` and an obstacle; zero if they overlap.
    #[must_use]
    pub fn clearance(&self, pose: PlanarPose, obstacle: &Obstacle) -> Millimeters {
        let outline = self.outline.placed(pose);
        Millimeters(match &obstacle.0 {
            Shape::Disc { center, radius } => {
                (outline.distance_to_point(*center) - radius).max(0.0)
            }
            Shape::Polygon(polygon) => outline.distance_to(polygon),
        })
    }

    /// At most the clearance, and quick to find: the distance between circles around both.
    pub(crate) fn clearance_at_least(&self, pose: PlanarPose, obstacle: &Obstacle) -> f64 {
        let (middle, radius) = match &obstacle.0 {
            Shape::Disc { center, radius } => (*center, *radius),
            Shape::Polygon(polygon) => (polygon.middle, polygon.radius),
        };
        pose.position().distance_to(middle).0 - radius - self.reach().0
    }

    /// How far the farthest corner is from the base's frame.
    #[must_use]
    pub fn reach(&self) -> Millimeters {
        Millimeters(self.reach)
    }
}

impl Polygon {
    fn try_new(item: &'static str, corners: Vec<Point>) -> Result<Polygon, OutOfRange> {
        let count = within(item, corners.len(), MIN_CORNERS, MAX_CORNERS)?;
        let share = 1.0 / count_as_f64(count);
        let middle = corners.iter().fold(Point::default(), |sum, corner| {
            let ((sx, sy), (x, y)) = (sum.xy(), corner.xy());
            Point::raw(sx + share * x, sy + share * y)
        });
        let distances = corners.iter().map(|corner| corner.distance_to(middle).0);
        let radius = distances.fold(0.0, f64::max);
        if radius < 0.5 * MIN_SIZE.0 {
            return Err(OutOfRange {
                item: "radius of the outline",
                value: Quantity::Length(Millimeters(radius)),
                min: Quantity::Length(MIN_SIZE * 0.5),
                max: Quantity::Length(MAX_SIZE),
            });
        }
        Ok(Polygon {
            corners,
            middle,
            radius,
        })
    }

    fn placed(&self, pose: PlanarPose) -> Polygon {
        let place = |corner: &Point| pose.point_in_world(corner.xy());
        Polygon {
            corners: self.corners.iter().map(place).collect(),
            middle: place(&self.middle),
            radius: self.radius,
        }
    }

    fn edges(&self) -> impl Iterator<Item = (Point, Point)> + '_ {
        let ends = self.corners.iter().skip(1).chain(self.corners.first());
        self.corners.iter().copied().zip(ends.copied())
    }

    /// Whether a ray from the point along X crosses the outline an odd number of times.
    fn holds(&self, point: Point) -> bool {
        let (px, py) = point.xy();
        let crossings = self.edges().filter(|(from, to)| {
            let ((ax, ay), (bx, by)) = (from.xy(), to.xy());
            (ay > py) != (by > py) && px < ax + (py - ay) / (by - ay) * (bx - ax)
        });
        crossings.count() % 2 == 1
    }

    fn distance_to_point(&self, point: Point) -> f64 {
        if self.holds(point) {
            return 0.0;
        }
        let distances = self.edges().map(|edge| from_edge(edge, point));
        distances.fold(f64::INFINITY, f64::min)
    }

    fn distance_to(&self, other: &Polygon) -> f64 {
        let corner_inside = |outer: &Polygon, inner: &Polygon| {
            inner
                .corners
                .first()
                .is_some_and(|corner| outer.holds(*corner))
        };
        // One lies in the other, or their edges cross, or the distance is between two edges.
        if corner_inside(self, other) || corner_inside(other, self) {
            return 0.0;
        }
        let mut nearest = f64::INFINITY;
        for mine in self.edges() {
            for theirs in other.edges() {
                if cross(mine, theirs) {
                    return 0.0;
                }
                let ends = [from_edge(mine, theirs.0), from_edge(theirs, mine.0)];
                nearest = ends.into_iter().fold(nearest, f64::min);
            }
        }
        nearest
    }
}

/// Distance from a point to an edge. An edge of no length is a point.
fn from_edge((from, to): (Point, Point), point: Point) -> f64 {
    let ((ax, ay), (bx, by), (px, py)) = (from.xy(), to.xy(), point.xy());
    let (dx, dy) = (bx - ax, by - ay);
    let squared = dx * dx + dy * dy;
    let share = if squared > 0.0 {
        // The foot of the perpendicular, or the nearer end.
        (((px - ax) * dx + (py - ay) * dy) / squared).clamp(0.0, 1.0)
    } else {
        0.0
    };
    (px - ax - share * dx).hypot(py - ay - share * dy)
}

/// Whether two edges cross inside both.
fn cross((a, b): (Point, Point), (c, d): (Point, Point)) -> bool {
    let side = |from: Point, to: Point, of: Point| {
        let ((ax, ay), (bx, by), (px, py)) = (from.xy(), to.xy(), of.xy());
        (bx - ax) * (py - ay) - (by - ay) * (px - ax)
    };
    side(a, b, c) * side(a, b, d) < 0.0 && side(c, d, a) * side(c, d, b) < 0.0
}

fn count_as_f64(count: usize) -> f64 {
    u32::try_from(count).map_or(f64::MAX, f64::from)
}

#[cfg(test)]
mod tests {
    use super::*;
    use units::Radians;

    fn footprint() -> Footprint {
        Footprint::rectangle(Millimeters(800.0), Millimeters(600.0)).unwrap()
    }

    fn pose(x: f64, y: f64, heading: f64) -> PlanarPose {
        PlanarPose::try_new(Millimeters(x), Millimeters(y), Radians(heading)).unwrap()
    }

    fn polygon(corners: &[(f64, f64)]) -> Obstacle {
        let corners = corners.iter().map(|(x, y)| Point::raw(*x, *y)).collect();
        Obstacle::polygon(corners).unwrap()
    }

    fn clearance(at: PlanarPose, obstacle: &Obstacle) -> f64 {
        footprint().clearance(at, obstacle).0
    }

    #[test]
    fn clearances_are_as_by_hand() {
        let disc = Obstacle::disc(Point::raw(1000.0, 0.0), Millimeters(100.0)).unwrap();
        // Front edge at 400, disc from 900.
        assert!((clearance(pose(0.0, 0.0, 0.0), &disc) - 500.0).abs() < 1e-9);
        // Turned by a quarter the half width, 300, is ahead.
        let quarter = std::f64::consts::FRAC_PI_2;
        assert!((clearance(pose(0.0, 0.0, quarter), &disc) - 600.0).abs() < 1e-9);
        // Corner (400, 300) to corner (700, 700): 3-4-5.
        let block = polygon(&[(700.0, 700.0), (900.0, 700.0), (900.0, 900.0)]);
        assert!((clearance(pose(0.0, 0.0, 0.0), &block) - 500.0).abs() < 1e-9);
    }

    #[test]
    fn overlaps_have_no_clearance() {
        let here = pose(0.0, 0.0, 0.3);
        // A disc inside the base, a post through it, a ring of walls around it is none.
        let disc = Obstacle::disc(Point::raw(10.0, 10.0), Millimeters(5.0)).unwrap();
        let wall = polygon(&[(-2e3, -5.0), (2e3, -5.0), (2e3, 5.0), (-2e3, 5.0)]);
        let inside = polygon(&[(-5.0, -5.0), (5.0, -5.0), (5.0, 5.0)]);
        let around = polygon(&[(-2e3, -2e3), (2e3, -2e3), (2e3, 2e3), (-2e3, 2e3)]);
        for obstacle in [disc, wall, inside, around] {
            assert!(
                clearance(here, &obstacle).abs() < f64::EPSILON,
                "{obstacle:?}"
            );
        }
    }

    #[test]
    fn a_base_in_the_bay_of_an_l_is_free() {
        let bay = polygon(&[
            (-1000.0, -1000.0),
            (1000.0, -1000.0),
            (1000.0, -500.0),
            (-600.0, -500.0),
            (-600.0, 1000.0),
            (-1000.0, 1000.0),
        ]);
        // Left edge at -400, the bay's wall at -600; lower edge at -300, the floor at -500.
        assert!((clearance(pose(0.0, 0.0, 0.0), &bay) - 200.0).abs() < 1e-9);
    }

    #[test]
    fn outlines_without_size_are_refused() {
        let two = vec![Point::raw(0.0, 0.0), Point::raw(1.0, 0.0)];
        let message = Obstacle::polygon(two).unwrap_err().to_string();
        assert_eq!(
            message,
            "corners of the obstacle is 2; it must be from 3 to 256"
        );
        assert!(Obstacle::polygon(vec![Point::raw(5.0, 5.0); 4]).is_err());
        assert!(Obstacle::disc(Point::default(), Millimeters(f64::NAN)).is_err());
        assert!(Footprint::rectangle(Millimeters(0.0), Millimeters(1.0)).is_err());
    }
}
