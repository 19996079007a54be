//! Where the base is: points and poses on the floor.

use std::f64::consts::{PI, TAU};

use units::{Millimeters, Radians};

use crate::range::{OutOfRange, within};
use crate::twist::{BodyTwist, Displacement, WorldTwist};

/// The largest coordinate: ten kilometers from the origin, beyond any plant.
const MAX_COORDINATE: Millimeters = Millimeters(1e7);
/// The largest heading that may be given; it is then reduced to one turn.
const MAX_HEADING: Radians = Radians(1e6);

/// `p_WP`: a point of the floor in the world, within ten kilometers of the origin.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Point {
    x: f64,
    y: f64,
}

impl Point {
    /// A point from its coordinates in the world.
    ///
    /// # Errors
    /// A coordinate that is not a number within ten kilometers.
    pub fn try_new(x: Millimeters, y: Millimeters) -> Result<Point, OutOfRange> {
        let x = within("x", x, -MAX_COORDINATE, MAX_COORDINATE)?;
        let y = within("y", y, -MAX_COORDINATE, MAX_COORDINATE)?;
        Ok(Point { x: x.0, y: y.0 })
    }

    /// For coordinates that are in range by construction, or that are only looked at.
    pub(crate) fn raw(x: f64, y: f64) -> Point {
        Point { x, y }
    }

    pub(crate) fn xy(self) -> (f64, f64) {
        (self.x, self.y)
    }

    /// Along X of the world.
    #[must_use]
    pub fn x(self) -> Millimeters {
        Millimeters(self.x)
    }

    /// Along Y of the world.
    #[must_use]
    pub fn y(self) -> Millimeters {
        Millimeters(self.y)
    }

    /// How far the points are apart.
    #[must_use]
    pub fn distance_to(self, other: Point) -> Millimeters {
        let (x, y) = self.to(other);
        Millimeters((x * x + y * y).sqrt())
    }

    /// The way to `other` along X and Y. Coordinates are bounded, so its square cannot overflow.
    pub(crate) fn to(self, other: Point) -> (f64, f64) {
        (other.x - self.x, other.y - self.y)
    }
}

/// `X_WB`: the base's frame B in the world W, checked.
///
/// B is in the middle of the four wheels, its x axis forward and its y axis to the left. The heading
/// is the angle from X of the world to x of the base, counterclockwise, from -pi to pi.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct PlanarPose {
    position: Point,
    heading: f64,
}

impl PlanarPose {
    /// A pose from coordinates in the world and a heading, which is reduced to one turn.
    ///
    /// # Errors
    /// A coordinate that is not a number within ten kilometers, a heading that is not a number
    /// within a million radians.
    pub fn try_new(
        x: Millimeters,
        y: Millimeters,
        heading: Radians,
    ) -> Result<PlanarPose, OutOfRange> {
        Self::at(Point::try_new(x, y)?, heading)
    }

    /// A pose from a point and a heading, which is reduced to one turn.
    ///
    /// # Errors
    /// A heading that is not a number within a million radians.
    pub fn at(position: Point, heading: Radians) -> Result<PlanarPose, OutOfRange> {
        let heading = within("heading", heading, -MAX_HEADING, MAX_HEADING)?;
        Ok(PlanarPose {
            position,
            heading: one_turn(heading.0),
        })
    }

    /// Where the middle of the base is.
    #[must_use]
    pub fn position(self) -> Point {
        self.position
    }

    /// Where the base looks, from -pi to pi.
    #[must_use]
    pub fn heading(self) -> Radians {
        Radians(self.heading)
    }

    /// The way from this heading to `other`, the short way round, from -pi to pi.
    #[must_use]
    pub fn heading_error_to(self, other: PlanarPose) -> Radians {
        Radians(one_turn(other.heading - self.heading))
    }

    /// The velocity in the world of a base that moves with `twist`: thesis (2).
    #[must_use]
    pub fn world_twist(self, twist: BodyTwist) -> WorldTwist {
        twist.in_world(self.heading())
    }

    /// The velocity in the base's frame of what moves with `twist` in the world: thesis (2), turned
    /// round.
    #[must_use]
    pub fn body_twist(self, twist: WorldTwist) -> BodyTwist {
        twist.in_body(self.heading())
    }

    /// `X_WB * X_BC`: where the base is after `displacement`, along one exact arc.
    ///
    /// The displacement is a constant twist times a time: the base turns evenly while it drives.
    ///
    /// # Errors
    /// The new pose is out of range.
    pub fn moved_by(self, displacement: &Displacement) -> Result<PlanarPose, OutOfRange> {
        let turn = displacement.turn.0;
        let (forward, left) = (displacement.forward.0, displacement.left.0);
        // The chord of an arc: as long as the arc times sin(h) / h, turned by h, half the turn.
        let half = 0.5 * turn;
        let (sin, cos) = (self.heading + half).sin_cos();
        let chord = sinc(half);
        PlanarPose::try_new(
            Millimeters(self.position.x + chord * (cos * forward - sin * left)),
            Millimeters(self.position.y + chord * (sin * forward + cos * left)),
            Radians(self.heading + turn),
        )
    }

    /// `X_BW * X_WC`: the constant twist times time that leads to `other`, the short way round. The
    /// inverse of [`PlanarPose::moved_by`].
    #[must_use]
    pub fn displacement_to(self, other: PlanarPose) -> Displacement {
        let turn = one_turn(other.heading - self.heading);
        let half = 0.5 * turn;
        let (sin, cos) = (self.heading + half).sin_cos();
        let (x, y) = (
            other.position.x - self.position.x,
            other.position.y - self.position.y,
        );
        // At most half a turn, so the chord is at least 2 / pi of the arc.
        let stretch = 1.0 / sinc(half);
        Displacement {
            forward: Millimeters(stretch * (cos * x + sin * y)),
            left: Millimeters(stretch * (cos * y - sin * x)),
            turn: Radians(turn),
        }
    }

    /// A point that is given in the base's frame, in the world.
    pub(crate) fn point_in_world(self, p_B: (f64, f64)) -> Point {
        let (sin, cos) = self.heading.sin_cos();
        Point::raw(
            self.position.x + cos * p_B.0 - sin * p_B.1,
            self.position.y + sin * p_B.0 + cos * p_B.1,
        )
    }
}

/// `angle` less the whole turns: from -pi to pi. Angles of that range stay as they are.
pub(crate) fn one_turn(angle: f64) -> f64 {
    if angle.abs() <= PI {
        return angle;
    }
    angle - TAU * (angle / TAU).round()
}

/// sin(h) / h, 1 at zero.
pub(crate) fn sinc(h: f64) -> f64 {
    // Steps turn little, and there the series is quicker than the sine; below the bound its next
    // term, h^10 / 39,916,800, is lost in the last bit.
    if h.abs() < 0.1 {
        let s = h * h;
        1.0 - s / 6.0 * (1.0 - s / 20.0 * (1.0 - s / 42.0 * (1.0 - s / 72.0)))
    } else {
        h.sin() / h
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::f64::consts::FRAC_PI_2;

    fn pose(x: f64, y: f64, heading: f64) -> PlanarPose {
        PlanarPose::try_new(Millimeters(x), Millimeters(y), Radians(heading)).unwrap()
    }

    fn displacement(forward: f64, left: f64, turn: f64) -> Displacement {
        Displacement {
            forward: Millimeters(forward),
            left: Millimeters(left),
            turn: Radians(turn),
        }
    }

    #[test]
    fn a_quarter_circle_ends_a_radius_ahead_and_a_radius_aside() {
        // Radius 1000 mm: a quarter is pi/2 * 1000 = 1570.796 mm of way. From (100, 200), looking
        // along Y, the center is 1000 mm to the left, at (-900, 200); the quarter ends above it.
        let end = pose(100.0, 200.0, FRAC_PI_2)
            .moved_by(&displacement(1000.0 * FRAC_PI_2, 0.0, FRAC_PI_2))
            .unwrap();
        assert!(end.position().distance_to(Point::raw(-900.0, 1200.0)).0 < 1e-9);
        assert!((end.heading().0.abs() - PI).abs() < 1e-12);
    }

    #[test]
    fn a_whole_turn_ends_where_it_began() {
        let start = pose(-3.0, 7.0, 0.4);
        let end = start.moved_by(&displacement(500.0, 80.0, TAU)).unwrap();
        assert!(end.position().distance_to(start.position()).0 < 1e-9);
        assert!(start.heading_error_to(end).0.abs() < 1e-12);
    }

    #[test]
    fn the_way_to_a_pose_leads_there() {
        let (start, end) = (pose(1.0, 2.0, 0.3), pose(-500.0, 90.0, -2.8));
        let found = start.moved_by(&start.displacement_to(end)).unwrap();
        assert!(found.position().distance_to(end.position()).0 < 1e-9);
        assert!(found.heading_error_to(end).0.abs() < 1e-12);
    }

    #[test]
    fn the_chord_is_smooth_where_its_series_takes_over() {
        for h in [1e-3_f64, 0.03, 0.0999, -0.0999, 0.1, 0.1001] {
            assert!((sinc(h) - h.sin() / h).abs() < 3e-16, "at {h}");
        }
        assert!((sinc(0.0) - 1.0).abs() < f64::EPSILON);
    }

    #[test]
    fn headings_are_reduced_to_one_turn() {
        assert!((pose(0.0, 0.0, 7.0 * PI + 0.25).heading().0 - (0.25 - PI)).abs() < 1e-12);
        let error = pose(0.0, 0.0, 3.0).heading_error_to(pose(0.0, 0.0, -3.0));
        assert!((error.0 - (TAU - 6.0)).abs() < 1e-12);
    }

    #[test]
    fn a_pose_out_of_range_is_refused_by_name() {
        let refused = PlanarPose::try_new(Millimeters(f64::NAN), Millimeters(0.0), Radians(0.0));
        assert!(refused.unwrap_err().to_string().starts_with("x is NaN mm;"));
        let refused = pose(0.0, 0.0, 0.0).moved_by(&displacement(1.1e7, 0.0, 0.0));
        assert_eq!(
            refused.unwrap_err().to_string(),
            "x is 11000000 mm; it must be from -10000000 mm to 10000000 mm"
        );
    }
}
