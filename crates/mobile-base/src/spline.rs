//! Smooth paths through points: cubic splines, twice continuously differentiable.

use units::{Millimeters, PerMillimeter, Radians};

use crate::cubic::{Cubic, interpolate};
use crate::pose::Point;

/// The most points of a path.
const MAX_POINTS: usize = 10_000;
/// The least way between two points that follow each other.
const MIN_CHORD: Millimeters = Millimeters(1.0);
/// In how many pieces the length of a segment is measured.
const PIECES: u32 = 16;
/// The parameter is chord length, so the speed along it is near 1; where it falls below this the
/// curve all but stands, and turns on the spot.
const MIN_RATE: f64 = 1e-3;

/// How a spline begins and ends.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum SplineEnds {
    /// Without curvature.
    Natural,
    /// In these directions, from X of the world.
    Clamped {
        /// At the first point.
        start: Radians,
        /// At the last point.
        end: Radians,
    },
}

/// Why points make no spline.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
pub enum SplineError {
    /// Too few or too many points.
    #[error("the spline has {count} points; it must have from 2 to {max}", max = MAX_POINTS)]
    Count {
        /// How many were given.
        count: usize,
    },
    /// Two points that follow each other are too near.
    #[error(
        "point {index} of the spline is {distance} from the one before; it must be at least {min}",
        min = MIN_CHORD
    )]
    TooNear {
        /// The second one, from 0.
        index: usize,
        /// How far it is from the first.
        distance: Millimeters,
    },
    /// A direction that is not a number.
    #[error("the direction at the {end} of the spline is {value}; it must be a number")]
    Direction {
        /// `start` or `end`.
        end: &'static str,
        /// What was given.
        value: Radians,
    },
    /// The curve stands still in its parameter: it has a corner or turns back.
    #[error("the spline turns on the spot after {after}; its points turn back too sharply")]
    Cusp {
        /// The way from the start.
        after: Millimeters,
    },
}

/// A place on a path.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PathPoint {
    /// In the world.
    pub point: Point,
    /// Of the tangent, from X of the world.
    pub direction: Radians,
    /// Positive where the path bends to the left.
    pub curvature: PerMillimeter,
}

impl PathPoint {
    /// The radius of the bend, whichever way it goes; infinite on a straight.
    #[must_use]
    pub fn radius(&self) -> Millimeters {
        Millimeters(1.0 / self.curvature.0.abs())
    }
}

/// A curve through points, known by the way along it.
#[derive(Clone, Debug, PartialEq)]
pub struct Spline {
    pieces: Vec<Piece>,
    length: f64,
}

/// A part of a segment, short enough for the quadrature.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Piece {
    /// Way from the start of the spline to the start of the piece.
    start: f64,
    length: f64,
    /// Parameter of the segment at the start of the piece, and how far the piece goes.
    from: f64,
    span: f64,
    x: Cubic,
    y: Cubic,
}

impl Spline {
    /// The spline through `points`, in their order, parametrized by the length of the chords.
    ///
    /// # Errors
    /// Fewer than 2 or more than 10,000 points, neighbors nearer than a millimeter, a direction that
    /// is not a number, or points that make the curve turn on the spot.
    pub fn try_new(points: &[Point], ends: SplineEnds) -> Result<Spline, SplineError> {
        let count = points.len();
        if !(2..=MAX_POINTS).contains(&count) {
            return Err(SplineError::Count { count });
        }
        let chords = chords(points)?;
        let (x_ends, y_ends) = slopes(ends)?;
        let xs: Vec<f64> = points.iter().map(|point| point.xy().0).collect();
        let ys: Vec<f64> = points.iter().map(|point| point.xy().1).collect();
        let x = interpolate(&xs, &chords, x_ends);
        let y = interpolate(&ys, &chords, y_ends);

        let mut pieces = Vec::with_capacity(chords.len() * PIECES as usize);
        let mut length = 0.0;
        for ((x, y), chord) in x.into_iter().zip(y).zip(chords) {
            let span = chord / f64::from(PIECES);
            for number in 0..PIECES {
                let from = span * f64::from(number);
                let mut piece = Piece {
                    start: length,
                    length: 0.0,
                    from,
                    span,
                    x,
                    y,
                };
                if piece.rate(0.0).min(piece.rate(0.5 * span)) < MIN_RATE {
                    let after = Millimeters(length);
                    return Err(SplineError::Cusp { after });
                }
                piece.length = piece.way(span);
                length += piece.length;
                pieces.push(piece);
            }
        }
        Ok(Spline { pieces, length })
    }

    /// The way from the first point to the last.
    #[must_use]
    pub fn length(&self) -> Millimeters {
        Millimeters(self.length)
    }

    /// The place `along` the path; nothing before its start or behind its end.
    #[must_use]
    pub fn at(&self, along: Millimeters) -> Option<PathPoint> {
        if !(0.0..=self.length).contains(&along.0) {
            return None;
        }
        let after = self.pieces.partition_point(|piece| piece.start <= along.0);
        let piece = self.pieces.get(after.checked_sub(1)?)?;
        Some(piece.at(piece.parameter(along.0 - piece.start)))
    }

    /// Ways from the start at which [`Spline::at`] sees all there is to see: a sixteenth of the way
    /// between two points apart.
    pub(crate) fn stations(&self) -> impl Iterator<Item = Millimeters> + '_ {
        let starts = self.pieces.iter().map(|piece| Millimeters(piece.start));
        starts.chain([self.length()])
    }
}

impl Piece {
    /// Length of the derivative, `t` into the piece.
    fn rate(&self, t: f64) -> f64 {
        let u = self.from + t;
        self.x.slope(u).hypot(self.y.slope(u))
    }

    /// The way over the first `t` of the piece, by Gauss's rule with five points.
    fn way(&self, t: f64) -> f64 {
        const NODES: [(f64, f64); 5] = [
            (0.0, 0.568_888_888_888_888_9),
            (-0.538_469_310_105_683_1, 0.478_628_670_499_366_47),
            (0.538_469_310_105_683_1, 0.478_628_670_499_366_47),
            (-0.906_179_845_938_664, 0.236_926_885_056_189_08),
            (0.906_179_845_938_664, 0.236_926_885_056_189_08),
        ];
        let half = 0.5 * t;
        let weighed = NODES.map(|(node, weight)| weight * self.rate(half * (1.0 + node)));
        half * weighed.iter().sum::<f64>()
    }

    /// The parameter at a way into the piece: Newton's method from the proportional guess, which is
    /// good to a part in a thousand already.
    fn parameter(&self, way: f64) -> f64 {
        let mut t = self.span * way / self.length;
        for _ in 0..2 {
            t -= (self.way(t) - way) / self.rate(t);
        }
        t
    }

    fn at(&self, t: f64) -> PathPoint {
        let u = self.from + t;
        let (dx, dy) = (self.x.slope(u), self.y.slope(u));
        let bend = dx * self.y.bend(u) - dy * self.x.bend(u);
        PathPoint {
            point: Point::raw(self.x.value(u), self.y.value(u)),
            direction: Radians(dy.atan2(dx)),
            curvature: PerMillimeter(bend / dx.hypot(dy).powi(3)),
        }
    }
}

fn chords(points: &[Point]) -> Result<Vec<f64>, SplineError> {
    let pairs = points.iter().zip(points.iter().skip(1)).enumerate();
    pairs
        .map(|(before, (from, to))| {
            let distance = from.distance_to(*to);
            if distance < MIN_CHORD {
                let index = before + 1;
                return Err(SplineError::TooNear { index, distance });
            }
            Ok(distance.0)
        })
        .collect()
}

/// Slopes of x and of y at start and end.
type Slopes = Option<(f64, f64)>;

fn slopes(ends: SplineEnds) -> Result<(Slopes, Slopes), SplineError> {
    match ends {
        SplineEnds::Natural => Ok((None, None)),
        SplineEnds::Clamped { start, end } => {
            for (end, value) in [("start", start), ("end", end)] {
                if !value.is_finite() {
                    return Err(SplineError::Direction { end, value });
                }
            }
            let ((start_y, start_x), (end_y, end_x)) = (start.0.sin_cos(), end.0.sin_cos());
            Ok((Some((start_x, end_x)), Some((start_y, end_y))))
        }
    }
}
