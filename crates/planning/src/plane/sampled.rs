//! The probabilistic roadmap of the floor.

use rand_distr::{Distribution, Uniform};
use rand_pcg::Pcg64Mcg;

use super::Point;
use super::floor::{Floor, PlaneError};
use super::polygon::between;
use super::route::Route;
use super::sketch::Sketch;
use crate::sampling::{Space, search};
use crate::wanted::Wanted;

pub use crate::sampling::Sampling;

/// A path by a probabilistic roadmap, its detours left out.
///
/// The four steps of the textbook's 2.2.3: random free points, neighbors joined by free segments,
/// repeated until start and goal are joined, and the shortest sequence. Some samples are made where
/// passages are narrow.
///
/// # Errors
/// Start or goal where the robot cannot stand, or no path after all samples, which does not prove
/// that there is none.
pub fn roadmap(
    floor: &Floor,
    start: Point,
    goal: Point,
    sampling: &Sampling,
) -> Result<Route, PlaneError> {
    Ok(roadmap_sketched(floor, start, goal, sampling, Wanted::ALWAYS)?.0)
}

/// As [`roadmap`], with the edges of the map, as long as the path is `wanted`.
///
/// # Errors
/// As [`roadmap`]; [`PlaneError::BrokenOff`].
pub fn roadmap_sketched(
    floor: &Floor,
    start: Point,
    goal: Point,
    sampling: &Sampling,
    wanted: Wanted<'_>,
) -> Result<(Route, Sketch), PlaneError> {
    floor.check("start", start)?;
    floor.check("goal", goal)?;
    let found = search(&OnFloor(floor), start, goal, sampling, wanted)?;
    let found = found.ok_or(PlaneError::GaveUp {
        method: "probabilistic roadmap",
        effort: sampling.most,
        unit: "samples",
    })?;
    let sketch = Sketch {
        cells: Vec::new(),
        edges: found.edges,
    };
    Ok((Route::new(found.way).shortened(floor, wanted)?, sketch))
}

struct OnFloor<'a>(&'a Floor);

impl Space for OnFloor<'_> {
    type At = Point;

    const LAZY: bool = false;

    /// Every other sample is a bridge: the middle between two blocked points not far from each
    /// other, which is where a passage is narrow (Hsu, Jiang, Reif and Sun, ICRA 2003).
    fn sample(&self, random: &mut Pcg64Mcg) -> Point {
        let (min, max) = (self.0.min(), self.0.max());
        let mut between =
            |low: f64, high: f64| Uniform::new(low, high).map_or(low, |range| range.sample(random));
        let anywhere = [between(min[0], max[0]), between(min[1], max[1])];
        if between(0.0, 1.0) < 0.5 || self.is_valid(&anywhere) {
            return anywhere;
        }
        let span = 0.15 * (max[0] - min[0]).min(max[1] - min[1]);
        let [x, y] = anywhere;
        let other = [x + between(-span, span), y + between(-span, span)];
        if self.is_valid(&other) {
            return other;
        }
        [0.5 * (x + other[0]), 0.5 * (y + other[1])]
    }

    fn distance(&self, a: &Point, b: &Point) -> f64 {
        between(*a, *b)
    }

    fn is_valid(&self, point: &Point) -> bool {
        self.0.clearance(*point) >= 0.0
    }

    fn is_free(&self, a: &Point, b: &Point) -> bool {
        self.0.is_free(*a, *b)
    }
}
