//! Where the tool goes, without time.

use std::f64::consts::TAU;

use kinematics::{Pose, PoseError};
use nalgebra::{Isometry3, Translation3, Unit, UnitQuaternion, Vector3};
use units::{Millimeters, Radians};

/// Points nearer than this are one point.
const SAME_MM: f64 = 1e-6;
/// A rotation smaller than this is none.
const SAME_RAD: f64 = 1e-9;
/// Points of a circle nearer than this say nothing about it.
///
/// ASSUMPTION: a tenth of a millimeter, what a taught position is worth.
const SAME_ON_A_CIRCLE_MM: f64 = 0.1;
/// Three points whose triangle has a smaller sine at the first are on a line.
///
/// ASSUMPTION: about a twentieth of a degree.
const STRAIGHT: f64 = 1e-3;
/// Rotations this close to half a turn have no shortest way between them: the rounding of a taught position.
const HALF_TURN_RAD: f64 = 1.75e-4;
const MAX_POINTS: usize = 1000;

/// Why a path was refused. Points count from 1.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum PathError {
    /// A spline through too few or too many points.
    #[error("{count} points; a spline goes through 2 to 1000")]
    Points {
        /// How many were given.
        count: usize,
    },
    /// Start and goal are the same pose.
    #[error("start and goal are the same pose")]
    NoWay,
    /// Two neighbors of a circle or a spline are one point.
    #[error("point {second} is only {distance:.9} from the point before it")]
    SamePoint {
        /// The later of the two.
        second: usize,
        /// How far they are apart.
        distance: Millimeters,
    },
    /// Two rotations half a turn apart: the way between them is not defined.
    #[error("the tool at point {second} is turned by half a turn against the point before it")]
    HalfTurn {
        /// The later of the two.
        second: usize,
    },
    /// A circle through points on a line.
    #[error("the three points lie on a line: the via point is {distance:.6} beside it")]
    Straight {
        /// Of the via point from the line from start to goal.
        distance: Millimeters,
    },
    /// A path that leaves what a pose can be.
    #[error("the path leaves the coordinates a pose may have")]
    Pose(#[from] PoseError),
}

/// How much of a circle is meant.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Extent {
    /// From the first point through the second to the third.
    Arc,
    /// All around through the three, back to the first, in its orientation.
    WholeTurn,
}

/// A path of the tool; its parameter runs from 0 to 1.
#[derive(Clone, Debug, PartialEq)]
pub struct ToolPath {
    shape: Shape,
    /// Orientation at increasing parameters, slerped in between.
    rotations: Vec<(f64, UnitQuaternion<f64>)>,
}

#[derive(Clone, Debug, PartialEq)]
enum Shape {
    Line {
        from: Vector3<f64>,
        way: Vector3<f64>,
    },
    Circle {
        center: Vector3<f64>,
        /// From the center to the start.
        arm: Vector3<f64>,
        axis: Unit<Vector3<f64>>,
        angle: f64,
    },
    /// Natural cubic spline: knots with position and second derivative.
    Spline(Vec<Knot>),
}

#[derive(Clone, Copy, Debug, PartialEq)]
struct Knot {
    at: f64,
    point: Vector3<f64>,
    bend: Vector3<f64>,
}

impl ToolPath {
    /// A straight line, the orientation turning evenly about one axis (slerp).
    ///
    /// # Errors
    /// The same pose twice, or half a turn between them.
    pub fn line(start: &Pose, goal: &Pose) -> Result<ToolPath, PathError> {
        let (distance, angle) = start.distance_to(goal);
        if distance.0 < SAME_MM && angle.0 < SAME_RAD {
            return Err(PathError::NoWay);
        }
        let (from, to) = (point(start), point(goal));
        Ok(ToolPath {
            shape: Shape::Line {
                from,
                way: to - from,
            },
            rotations: rotations([(0.0, start), (1.0, goal)])?,
        })
    }

    /// The circle through three poses. On an arc the orientation turns from each to the next.
    ///
    /// # Errors
    /// Points that are one or lie on a line, or half a turn between neighbors.
    pub fn circle(
        start: &Pose,
        via: &Pose,
        goal: &Pose,
        extent: Extent,
    ) -> Result<ToolPath, PathError> {
        let (a, b, c) = (point(start), point(via), point(goal));
        for (one, other, second) in [(a, b, 2), (b, c, 3), (c, a, 3)] {
            let _ = apart((one, other), second, SAME_ON_A_CIRCLE_MM)?;
        }
        // The circumcenter of the triangle, with its corners seen from the start.
        let (u, v) = (b - a, c - a);
        let normal = u.cross(&v);
        let beside = normal.norm() / v.norm();
        if beside < STRAIGHT * u.norm() {
            return Err(PathError::Straight {
                distance: Millimeters(beside),
            });
        }
        let square = normal.norm_squared();
        let to_center = (v.cross(&normal) * -u.norm_squared()
            + u.cross(&normal) * v.norm_squared())
            / (-2.0 * square);
        let arm = -to_center;
        let center = a + to_center;
        // About the normal start, via and goal follow each other counterclockwise.
        let axis = Unit::new_normalize(normal);
        let angle_of = |p: Vector3<f64>| {
            let p = p - center;
            let angle = axis.dot(&arm.cross(&p)).atan2(arm.dot(&p));
            if angle < 0.0 { angle + TAU } else { angle }
        };
        let (angle, rotations) = match extent {
            Extent::Arc => {
                let angle = angle_of(c);
                let part = angle_of(b) / angle;
                (angle, rotations([(0.0, start), (part, via), (1.0, goal)])?)
            }
            Extent::WholeTurn => (TAU, rotations([(0.0, start), (1.0, start)])?),
        };
        Ok(ToolPath {
            shape: Shape::Circle {
                center,
                arm,
                axis,
                angle,
            },
            rotations,
        })
    }

    /// The natural cubic spline through the poses, over the lengths of their chords; position
    /// smooth to the second derivative, orientation slerped from point to point.
    ///
    /// # Errors
    /// Not 2 to 1000 points, neighbors that are one point, or half a turn between them.
    pub fn spline(poses: &[Pose]) -> Result<ToolPath, PathError> {
        let count = poses.len();
        if !(2..=MAX_POINTS).contains(&count) {
            return Err(PathError::Points { count });
        }
        let points: Vec<Vector3<f64>> = poses.iter().map(point).collect();
        let mut at = vec![0.0];
        let mut length = 0.0;
        for (second, (a, b)) in (2..).zip(points.iter().zip(points.iter().skip(1))) {
            length += apart((*a, *b), second, SAME_MM)?;
            at.push(length);
        }
        let at: Vec<f64> = at.into_iter().map(|at| at / length).collect();
        let bends = natural_bends(&at, &points);
        let knots = at.iter().zip(&points).zip(bends);
        Ok(ToolPath {
            rotations: rotations(at.iter().copied().zip(poses))?,
            shape: Shape::Spline(
                knots
                    .map(|((&at, &point), bend)| Knot { at, point, bend })
                    .collect(),
            ),
        })
    }

    /// The pose at a parameter from 0 to 1.
    ///
    /// # Errors
    /// The path leaves the coordinates a pose may have.
    pub fn pose_at(&self, parameter: f64) -> Result<Pose, PathError> {
        let parameter = parameter.clamp(0.0, 1.0);
        let position = match &self.shape {
            Shape::Line { from, way } => from + way * parameter,
            Shape::Circle {
                center,
                arm,
                axis,
                angle,
            } => center + UnitQuaternion::from_axis_angle(axis, angle * parameter) * arm,
            Shape::Spline(knots) => spline_at(knots, parameter),
        };
        let isometry =
            Isometry3::from_parts(Translation3::from(position), self.rotation_at(parameter));
        Ok(Pose::try_from_isometry(isometry)?)
    }

    /// How long a line or a circle is; `None` for a spline, whose parameter is not its length.
    #[must_use]
    pub fn length(&self) -> Option<Millimeters> {
        match &self.shape {
            Shape::Line { way, .. } => Some(Millimeters(way.norm())),
            Shape::Circle { arm, angle, .. } => Some(Millimeters(arm.norm() * angle)),
            Shape::Spline(_) => None,
        }
    }

    /// Of a circle.
    #[must_use]
    pub fn radius(&self) -> Option<Millimeters> {
        match &self.shape {
            Shape::Circle { arm, .. } => Some(Millimeters(arm.norm())),
            Shape::Line { .. } | Shape::Spline(_) => None,
        }
    }

    /// By how much the orientation would change on the whole path if it did so as fast as where it is fastest.
    #[must_use]
    pub fn turning(&self) -> Radians {
        let pairs = self.rotations.iter().zip(self.rotations.iter().skip(1));
        let rates = pairs.map(|((from, a), (to, b))| a.angle_to(b) / (to - from));
        Radians(rates.fold(0.0, f64::max))
    }

    fn rotation_at(&self, parameter: f64) -> UnitQuaternion<f64> {
        let after = self.rotations.iter().skip(1);
        let mut pairs = self.rotations.iter().zip(after);
        let pair = pairs.find(|(_, (end, _))| parameter <= *end);
        let Some(((from, a), (to, b))) = pair else {
            return self
                .rotations
                .last()
                .map_or_else(UnitQuaternion::identity, |(_, last)| *last);
        };
        let share = (parameter - from) / (to - from);
        // Never half a turn apart: `rotations` saw to it.
        a.try_slerp(b, share, SAME_RAD).unwrap_or(*a)
    }
}

fn point(pose: &Pose) -> Vector3<f64> {
    pose.isometry().translation.vector
}

fn apart(
    (a, b): (Vector3<f64>, Vector3<f64>),
    second: usize,
    least: f64,
) -> Result<f64, PathError> {
    let distance = (b - a).norm();
    if distance < least {
        let distance = Millimeters(distance);
        return Err(PathError::SamePoint { second, distance });
    }
    Ok(distance)
}

type Rotations = Vec<(f64, UnitQuaternion<f64>)>;

fn rotations<'a>(poses: impl IntoIterator<Item = (f64, &'a Pose)>) -> Result<Rotations, PathError> {
    let rotations: Rotations = poses
        .into_iter()
        .map(|(at, pose)| (at, pose.isometry().rotation))
        .collect();
    let pairs = rotations.iter().zip(rotations.iter().skip(1));
    for (second, ((_, a), (_, b))) in (2..).zip(pairs) {
        if a.angle_to(b) > std::f64::consts::PI - HALF_TURN_RAD {
            return Err(PathError::HalfTurn { second });
        }
    }
    Ok(rotations)
}

/// The second derivatives at the knots, zero at the ends, [de Boor, A Practical Guide to Splines,
/// ch. IV]: a diagonally dominant tridiagonal system, eliminated downwards and solved upwards.
fn natural_bends(at: &[f64], points: &[Vector3<f64>]) -> Vec<Vector3<f64>> {
    let chords: Vec<(f64, Vector3<f64>)> = at
        .iter()
        .zip(at.iter().skip(1))
        .zip(points.iter().zip(points.iter().skip(1)))
        .map(|((from, to), (a, b))| (to - from, (b - a) / (to - from)))
        .collect();
    let mut rows = Vec::new();
    let (mut factor, mut sum) = (0.0, Vector3::zeros());
    for ((before, slope), (after, next)) in chords.iter().zip(chords.iter().skip(1)) {
        let pivot = 2.0 * (before + after) - before * factor;
        sum = (6.0 * (next - slope) - sum * *before) / pivot;
        factor = after / pivot;
        rows.push((factor, sum));
    }
    let mut bends = vec![Vector3::zeros()];
    let mut below = Vector3::zeros();
    for (factor, sum) in rows.into_iter().rev() {
        below = sum - below * factor;
        bends.push(below);
    }
    bends.push(Vector3::zeros());
    bends.reverse();
    bends
}

fn spline_at(knots: &[Knot], parameter: f64) -> Vector3<f64> {
    let mut pairs = knots.iter().zip(knots.iter().skip(1));
    let Some((a, b)) = pairs.find(|(_, b)| parameter <= b.at) else {
        return knots.last().map_or_else(Vector3::zeros, |knot| knot.point);
    };
    let h = b.at - a.at;
    let (left, right) = ((b.at - parameter) / h, (parameter - a.at) / h);
    let cubic = |x: f64| (x * x * x - x) * h * h / 6.0;
    a.point * left + b.point * right + a.bend * cubic(left) + b.bend * cubic(right)
}
