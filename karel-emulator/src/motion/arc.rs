//! The circle through three poses.

use karel::Status;
use kinematics::{Pose, PoseError};

use super::linear::{ACCELERATION, MOST_ROTATION_DEG};
use super::planner::Refusal;

/// MOTN-997: no circle goes through the three positions. A number of our own.
const MOTN_NO_CIRCLE: Status = Status::new(15, 997);

/// Positions nearer than this, in mm, are the same one.
///
/// ASSUMPTION: a tenth of a millimeter; a smaller triangle tells nothing about its circle.
const SAME_PLACE: f64 = 0.1;
/// Three positions whose triangle has a smaller sine than this lie on one line.
///
/// ASSUMPTION: about a twentieth of a degree.
const SAME_LINE: f64 = 1e-3;

/// An arc of less than a full turn from one pose over another to a third.
///
/// ASSUMPTION: the orientation changes evenly by the shortest rotation from the start to the position on the way, and
/// from there to the end; so that position is passed in its own orientation.
#[derive(Clone, Copy, Debug)]
pub(super) struct Arc {
    start: Pose,
    via: Pose,
    end: Pose,
    center: [f64; 3],
    /// From the center to the start, mm, and as long as that, at right angles and toward the position on the way.
    axes: [[f64; 3]; 2],
    radius: f64,
    /// Radians from the start to the end, and the share of them where the position on the way is.
    angle: f64,
    via_share: f64,
}

impl Arc {
    /// The arc from `start` over `via` to `end`.
    ///
    /// # Errors
    /// Two of them are at the same place, all are on one line, or two that follow each other differ by half a turn.
    pub(super) fn through(start: &Pose, via: &Pose, end: &Pose) -> Result<Arc, Refusal> {
        let refused = |text: &str| Err(Refusal::new(MOTN_NO_CIRCLE, text));
        let [a, b, c] = [start, via, end].map(place);
        let (u, v) = (minus(b, a), minus(c, a));
        let sides = [length(u), length(v), length(minus(c, b))];
        if sides.iter().any(|side| *side < SAME_PLACE) {
            return refused(
                "No circle: two of start, position on the way and end are at the same place",
            );
        }
        let normal = cross(u, v);
        let area = length(normal);
        let [first, second, _] = sides;
        if area < SAME_LINE * first * second {
            return refused("No circle: start, position on the way and end are on one line");
        }
        // The center of the circle through 0, u and v.
        let twice = 2.0 * area * area;
        let to_center = minus(
            scaled(cross(v, normal), dot(u, u) / twice),
            scaled(cross(u, normal), dot(v, v) / twice),
        );
        let center = plus(a, to_center);
        let x = minus(a, center);
        let radius = length(x);
        let y = cross(scaled(normal, 1.0 / area), x);
        let angle_of = |point: [f64; 3]| {
            let from_center = minus(point, center);
            let angle = dot(from_center, y).atan2(dot(from_center, x));
            angle.rem_euclid(std::f64::consts::TAU)
        };
        let (middle, angle) = (angle_of(b), angle_of(c));
        for (one, other) in [(start, via), (via, end)] {
            if one.distance_to(other).1.0.to_degrees() > MOST_ROTATION_DEG {
                let text = "the orientation changes by half a turn, so no rotation is the shortest";
                return Err(Refusal::new(Status::MOTN_UNREACHABLE, text));
            }
        }
        Ok(Arc {
            start: *start,
            via: *via,
            end: *end,
            center,
            axes: [x, y],
            radius,
            angle,
            via_share: middle / angle,
        })
    }

    /// Millimeters from the start to the end.
    pub(super) fn length(&self) -> f64 {
        self.radius * self.angle
    }

    /// Degrees by which the orientation would change on the whole way if it did so as fast as on its faster part.
    pub(super) fn turning_deg(&self) -> f64 {
        let turned = |one: &Pose, other: &Pose| one.distance_to(other).1.0.to_degrees();
        let before = turned(&self.start, &self.via) / self.via_share;
        let behind = turned(&self.via, &self.end) / (1.0 - self.via_share);
        before.max(behind)
    }

    /// The speed in mm/s, or less if the acceleration toward the center would be more than that of the tool.
    ///
    /// ASSUMPTION: a controller slows down on a small circle and raises no alarm.
    pub(super) fn possible_speed(&self, speed_mm_s: f64, acceleration: f64) -> f64 {
        speed_mm_s.min((ACCELERATION * acceleration * self.radius).sqrt())
    }

    /// Where the tool is at this share of the way.
    pub(super) fn at(&self, share: f64) -> Result<Pose, PoseError> {
        let (from, to, part) = if share < self.via_share {
            (&self.start, &self.via, share / self.via_share)
        } else {
            let part = (share - self.via_share) / (1.0 - self.via_share);
            (&self.via, &self.end, part.min(1.0))
        };
        let mut pose = from.isometry().lerp_slerp(to.isometry(), part);
        let (sin, cos) = (self.angle * share).sin_cos();
        let [x, y] = self.axes;
        let place = plus(self.center, plus(scaled(x, cos), scaled(y, sin)));
        pose.translation.vector = place.into();
        Pose::try_from_isometry(pose)
    }
}

fn place(pose: &Pose) -> [f64; 3] {
    pose.isometry().translation.vector.into()
}

fn plus([a, b, c]: [f64; 3], [x, y, z]: [f64; 3]) -> [f64; 3] {
    [a + x, b + y, c + z]
}

fn minus([a, b, c]: [f64; 3], [x, y, z]: [f64; 3]) -> [f64; 3] {
    [a - x, b - y, c - z]
}

fn scaled(vector: [f64; 3], by: f64) -> [f64; 3] {
    vector.map(|value| value * by)
}

fn dot([a, b, c]: [f64; 3], [x, y, z]: [f64; 3]) -> f64 {
    a * x + b * y + c * z
}

fn cross([a, b, c]: [f64; 3], [x, y, z]: [f64; 3]) -> [f64; 3] {
    [b * z - c * y, c * x - a * z, a * y - b * x]
}

fn length(vector: [f64; 3]) -> f64 {
    dot(vector, vector).sqrt()
}
