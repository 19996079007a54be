//! The floor, what stands on it, and the robot's size.

use super::Point;
use super::polygon::{Polygon, PolygonError, between};
use crate::wanted::BrokenOff;

const MAX_COORDINATE: f64 = 1e6;
const MAX_OBSTACLES: usize = 1000;
/// Clearances this far below zero are rounding.
const ROUNDING: f64 = 1e-6;

/// Why a path was not found, or not looked for.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum PlaneError {
    /// An obstacle that is none.
    #[error(transparent)]
    Polygon(#[from] PolygonError),
    /// A number that is NaN, infinite or too large.
    #[error("{item} is {value}; it must be a number from {least} to {most}")]
    Range {
        /// Which number.
        item: &'static str,
        /// What was given.
        value: f64,
        /// What it may be.
        least: f64,
        /// What it may be.
        most: f64,
    },
    /// More obstacles than are looked at.
    #[error("{count} obstacles; at most {most}")]
    Obstacles {
        /// How many were given.
        count: usize,
        /// How many there may be.
        most: usize,
    },
    /// Start or goal too near the edge of the floor, or beyond it.
    #[error(
        "the {point} is {distance:.3} mm from the edge of the floor; the robot needs {radius} mm"
    )]
    OffTheFloor {
        /// `start` or `goal`.
        point: &'static str,
        /// Negative beyond the edge.
        distance: f64,
        /// The robot's.
        radius: f64,
    },
    /// Start or goal in an obstacle, or too near to it.
    #[error(
        "the {point} is {distance:.3} mm from obstacle {obstacle} (negative: inside); the robot needs {radius} mm"
    )]
    InObstacle {
        /// `start` or `goal`.
        point: &'static str,
        /// Which, counted from 1.
        obstacle: usize,
        /// Negative inside.
        distance: f64,
        /// The robot's radius.
        radius: f64,
    },
    /// There is no path, as far as this method can tell: the exact one always, the others at their
    /// resolution.
    #[error("there is no path ({method}, down to {resolution} mm)")]
    NoPath {
        /// Which method.
        method: &'static str,
        /// How fine it looked.
        resolution: f64,
    },
    /// Nobody waited for the path any more.
    #[error(transparent)]
    BrokenOff(#[from] BrokenOff),
    /// The method gave up.
    #[error("no path found by {method} after {effort} {unit}")]
    GaveUp {
        /// Which method.
        method: &'static str,
        /// How long it tried.
        effort: u32,
        /// Of what.
        unit: &'static str,
    },
}

/// A rectangle with polygons on it, for a robot of a given radius.
#[derive(Clone, Debug, PartialEq)]
pub struct Floor {
    min: Point,
    max: Point,
    obstacles: Vec<Polygon>,
    radius: f64,
}

impl Floor {
    /// A floor from `min` to `max`, for a disc of this `radius`.
    ///
    /// # Errors
    /// Names the number that is out of range.
    pub fn try_new(
        min: Point,
        max: Point,
        obstacles: Vec<Polygon>,
        radius: f64,
    ) -> Result<Floor, PlaneError> {
        let ([min_x, min_y], [max_x, max_y]) = (min, max);
        let _ = within(
            "least x of the floor",
            min_x,
            -MAX_COORDINATE,
            MAX_COORDINATE,
        )?;
        let _ = within(
            "least y of the floor",
            min_y,
            -MAX_COORDINATE,
            MAX_COORDINATE,
        )?;
        let _ = within(
            "greatest x of the floor",
            max_x,
            min_x + 1.0,
            MAX_COORDINATE,
        )?;
        let _ = within(
            "greatest y of the floor",
            max_y,
            min_y + 1.0,
            MAX_COORDINATE,
        )?;
        let _ = within("radius of the robot", radius, 0.0, MAX_COORDINATE)?;
        let count = obstacles.len();
        if count > MAX_OBSTACLES {
            let most = MAX_OBSTACLES;
            return Err(PlaneError::Obstacles { count, most });
        }
        Ok(Floor {
            min,
            max,
            obstacles,
            radius,
        })
    }

    /// The corner with the least coordinates.
    #[must_use]
    pub fn min(&self) -> Point {
        self.min
    }

    /// The corner with the greatest coordinates.
    #[must_use]
    pub fn max(&self) -> Point {
        self.max
    }

    /// What stands on it.
    #[must_use]
    pub fn obstacles(&self) -> &[Polygon] {
        &self.obstacles
    }

    /// The robot's.
    #[must_use]
    pub fn radius(&self) -> f64 {
        self.radius
    }

    /// The distance from the robot, with its middle at `point`, to the nearest obstacle or edge;
    /// negative if it overlaps.
    #[must_use]
    pub fn clearance(&self, point: Point) -> f64 {
        let to_obstacles = self.obstacles.iter().map(|o| o.distance(point).0);
        to_obstacles.fold(self.to_edge(point), f64::min) - self.radius
    }

    /// Can the robot drive straight from one point to the other?
    #[must_use]
    pub fn is_free(&self, a: Point, b: Point) -> bool {
        let needed = self.radius - ROUNDING;
        self.to_edge(a) >= needed
            && self.to_edge(b) >= needed
            && self
                .obstacles
                .iter()
                .all(|obstacle| obstacle.distance_to_segment(a, b) >= needed.max(ROUNDING))
    }

    /// Nearest obstacle's (or edge's) point, as seen from `point`, and the distance of the disc.
    pub(crate) fn nearest(&self, [x, y]: Point) -> (f64, Point) {
        let edges = [
            [self.min[0], y],
            [self.max[0], y],
            [x, self.min[1]],
            [x, self.max[1]],
        ];
        let edges = edges.map(|edge| (between([x, y], edge), edge));
        let obstacles = self
            .obstacles
            .iter()
            .map(|obstacle| obstacle.distance([x, y]));
        let (distance, point) = obstacles
            .chain(edges)
            .min_by(|a, b| a.0.total_cmp(&b.0))
            .unwrap_or((f64::INFINITY, [x, y]));
        (distance - self.radius, point)
    }

    /// Is the point one where the robot can stand?
    ///
    /// # Errors
    /// What is in its way.
    pub(crate) fn check(&self, name: &'static str, point: Point) -> Result<(), PlaneError> {
        for value in point {
            let _ = within(name, value, -MAX_COORDINATE, MAX_COORDINATE)?;
        }
        let radius = self.radius;
        let distance = self.to_edge(point);
        if distance < radius - ROUNDING {
            return Err(PlaneError::OffTheFloor {
                point: name,
                distance,
                radius,
            });
        }
        for (obstacle, polygon) in (1..).zip(&self.obstacles) {
            let (distance, _) = polygon.distance(point);
            if distance < (radius - ROUNDING).max(ROUNDING) {
                return Err(PlaneError::InObstacle {
                    point: name,
                    obstacle,
                    distance,
                    radius,
                });
            }
        }
        Ok(())
    }

    fn to_edge(&self, [x, y]: Point) -> f64 {
        let (along_x, along_y) = (
            (x - self.min[0]).min(self.max[0] - x),
            (y - self.min[1]).min(self.max[1] - y),
        );
        along_x.min(along_y)
    }
}

pub(crate) fn within(
    item: &'static str,
    value: f64,
    least: f64,
    most: f64,
) -> Result<f64, PlaneError> {
    if (least..=most).contains(&value) {
        Ok(value)
    } else {
        Err(PlaneError::Range {
            item,
            value,
            least,
            most,
        })
    }
}
