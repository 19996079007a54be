//! Boxes, the capsules that stand for an arm's body, and poses on the floor.

#![expect(
    non_snake_case,
    reason = "frames are part of a pose's name: X_CD is the dock D in the cell C"
)]

use kinematics::{Pose, Xyzwpr};
use nalgebra::Point3;
use units::{Degrees, Millimeters};

/// A box with its edges along the axes of the cell frame; each edge has a length.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct ZoneBox {
    /// Smallest and largest coordinates, in millimeters.
    pub(super) min: Point3<f64>,
    pub(super) max: Point3<f64>,
}

/// Everything closer to the line between two points than a radius, in millimeters and the cell frame.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Capsule {
    pub(crate) from: Point3<f64>,
    pub(crate) to: Point3<f64>,
    pub(crate) radius: f64,
}

impl ZoneBox {
    /// Its outline on the floor: the smallest x and y, and the largest, in millimeters.
    pub(crate) fn outline(&self) -> ([f64; 2], [f64; 2]) {
        ([self.min.x, self.min.y], [self.max.x, self.max.y])
    }

    /// The box and all that is above it.
    pub(crate) fn and_above(&self) -> Self {
        let max = Point3::new(self.max.x, self.max.y, f64::INFINITY);
        Self { max, ..*self }
    }

    /// The distance of a point from the box, in millimeters; negative inside: the depth.
    ///
    /// A convex function of the point, because the box is convex.
    pub(crate) fn distance(&self, point: &Point3<f64>) -> f64 {
        // By how much it is outside along each axis; negative inside.
        let x = (self.min.x - point.x).max(point.x - self.max.x);
        let y = (self.min.y - point.y).max(point.y - self.max.y);
        let z = (self.min.z - point.z).max(point.z - self.max.z);
        let (beyond_x, beyond_y, beyond_z) = (x.max(0.0), y.max(0.0), z.max(0.0));
        let beyond = beyond_x * beyond_x + beyond_y * beyond_y + beyond_z * beyond_z;
        beyond.sqrt() + x.max(y).max(z).min(0.0)
    }

    /// Whether a point is inside or on the surface.
    pub(crate) fn contains(&self, point: &Point3<f64>) -> bool {
        self.distance(point) <= 0.0
    }

    /// The gap between the capsule and the box, negative by the depth, and the point of the capsule's line where it is.
    ///
    /// The distance is a convex function along the line, so narrowing down the interval finds its least value.
    pub(crate) fn gap(&self, capsule: &Capsule) -> (f64, Point3<f64>) {
        let (from, along) = (capsule.from, capsule.to - capsule.from);
        let at = |t: f64| {
            Point3::new(
                from.x + along.x * t,
                from.y + along.y * t,
                from.z + along.z * t,
            )
        };
        let value = |t: f64| self.distance(&at(t));
        let (mut low, mut high) = (0.0_f64, 1.0_f64);
        // Thousandths of a millimeter are enough; each step keeps two thirds.
        let enough = 1e-3 / along.norm().max(1e-3);
        while high - low > enough {
            let (a, b) = (low + (high - low) / 3.0, high - (high - low) / 3.0);
            if value(a) <= value(b) {
                high = b;
            } else {
                low = a;
            }
        }
        let [best, ..] = {
            let mut ends = [0.0, 1.0, f64::midpoint(low, high)];
            ends.sort_by(|a, b| value(*a).total_cmp(&value(*b)));
            ends
        };
        (value(best) - capsule.radius, at(best))
    }

    /// A lower bound of [`Self::gap`], in one evaluation.
    pub(crate) fn gap_at_least(&self, capsule: &Capsule) -> f64 {
        let (from, to) = (capsule.from, capsule.to);
        let middle = Point3::new(
            f64::midpoint(from.x, to.x),
            f64::midpoint(from.y, to.y),
            f64::midpoint(from.z, to.z),
        );
        let half = (to - from).norm() / 2.0;
        self.distance(&middle) - half - capsule.radius
    }

    /// Whether a circle on the floor is inside, seen from above.
    pub(crate) fn holds_circle(&self, [x, y]: [f64; 2], radius: f64) -> bool {
        x - radius >= self.min.x
            && x + radius <= self.max.x
            && y - radius >= self.min.y
            && y + radius <= self.max.y
    }

    /// The gap between a circle on the floor, swept up to a height and along a line, and the box; `None` where the box
    /// is above that height or below the floor.
    pub(crate) fn gap_on_floor(
        &self,
        from: [f64; 2],
        to: [f64; 2],
        radius: f64,
        height: f64,
    ) -> Option<f64> {
        if self.min.z >= height || self.max.z <= 0.0 {
            return None;
        }
        let z = f64::midpoint(self.min.z, self.max.z);
        // Nothing but the floor plan counts: the box is taken to be as high as it takes.
        let tall = ZoneBox {
            min: Point3::new(self.min.x, self.min.y, z - 1e7),
            max: Point3::new(self.max.x, self.max.y, z + 1e7),
        };
        let [x, y] = from;
        let [to_x, to_y] = to;
        let capsule = Capsule {
            from: Point3::new(x, y, z),
            to: Point3::new(to_x, to_y, z),
            radius,
        };
        Some(tall.gap(&capsule).0)
    }
}

/// A pose on the floor, in the cell frame.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct DockPose {
    pub(crate) x: Millimeters,
    pub(crate) y: Millimeters,
    pub(crate) heading: Degrees,
}

/// How far a docked mobile robot may be from the nominal pose.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct DockTolerance {
    /// Along each axis of the dock's frame.
    pub(crate) position: Millimeters,
    pub(crate) angle: Degrees,
}

/// How far a measured dock pose is from the nominal one, in the nominal one's frame.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct DockDeviation {
    pub(crate) along: Millimeters,
    pub(crate) across: Millimeters,
    pub(crate) angle: Degrees,
}

impl DockPose {
    /// `X_CD`: the dock's frame in the cell frame. `None` for numbers no pose can have.
    pub(crate) fn pose(&self) -> Option<Pose> {
        Pose::try_from_xyzwpr(&Xyzwpr::new(
            [self.x, self.y, Millimeters(0.0)],
            [Degrees(0.0), Degrees(0.0), self.heading],
        ))
        .ok()
    }

    /// How far `measured` is from this pose; the angle is the smaller way round.
    pub(crate) fn deviation(&self, measured: &DockPose) -> DockDeviation {
        let (sin, cos) = self.heading.0.to_radians().sin_cos();
        let (dx, dy) = (measured.x.0 - self.x.0, measured.y.0 - self.y.0);
        let turn = measured.heading.0 - self.heading.0;
        DockDeviation {
            along: Millimeters(cos * dx + sin * dy),
            across: Millimeters(cos * dy - sin * dx),
            angle: Degrees(turn - 360.0 * (turn / 360.0).round()),
        }
    }

    /// This pose and, where the tolerance leaves any room, the eight corners of it.
    pub(crate) fn corners(&self, tolerance: &DockTolerance) -> Vec<DockPose> {
        let (sin, cos) = self.heading.0.to_radians().sin_cos();
        let mut poses = vec![*self];
        for along in [-1.0, 1.0] {
            for across in [-1.0, 1.0] {
                for turn in [-1.0, 1.0] {
                    let (along, across) =
                        (along * tolerance.position.0, across * tolerance.position.0);
                    let corner = DockPose {
                        x: Millimeters(self.x.0 + cos * along - sin * across),
                        y: Millimeters(self.y.0 + sin * along + cos * across),
                        heading: Degrees(self.heading.0 + turn * tolerance.angle.0),
                    };
                    if !poses.contains(&corner) {
                        poses.push(corner);
                    }
                }
            }
        }
        poses
    }
}

impl DockTolerance {
    /// Whether a deviation is inside. A NaN is not.
    pub(crate) fn allows(&self, deviation: &DockDeviation) -> bool {
        // A corner of the tolerance itself is inside: rounding must not put it outside.
        const ROUNDING: f64 = 1e-6;
        deviation.along.0.abs() <= self.position.0 + ROUNDING
            && deviation.across.0.abs() <= self.position.0 + ROUNDING
            && deviation.angle.0.abs() <= self.angle.0 + ROUNDING
    }
}

/// The tool center point as a point.
pub(crate) fn origin_of(X: &Pose) -> Point3<f64> {
    Point3::from(X.isometry().translation.vector)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn unit_box() -> ZoneBox {
        ZoneBox {
            min: Point3::new(0.0, 0.0, 0.0),
            max: Point3::new(100.0, 100.0, 100.0),
        }
    }

    fn capsule(from: [f64; 3], to: [f64; 3], radius: f64) -> Capsule {
        Capsule {
            from: Point3::from(from),
            to: Point3::from(to),
            radius,
        }
    }

    #[test]
    fn a_point_has_a_distance_outside_and_a_depth_inside() {
        let zone = unit_box();
        assert!((zone.distance(&Point3::new(103.0, 104.0, 50.0)) - 5.0).abs() < 1e-12);
        assert!((zone.distance(&Point3::new(90.0, 50.0, 50.0)) + 10.0).abs() < 1e-12);
        assert!(zone.contains(&Point3::new(100.0, 0.0, 50.0)));
    }

    #[test]
    fn a_line_that_crosses_between_two_points_outside_is_as_deep_as_it_goes() {
        let (gap, at) = unit_box().gap(&capsule([-200.0, 50.0, 80.0], [300.0, 50.0, 80.0], 5.0));
        assert!((gap + 25.0).abs() < 1e-2, "{gap}");
        assert!(at.x > 19.0 && at.x < 81.0);
        let (gap, _) = unit_box().gap(&capsule([-30.0, -40.0, 50.0], [-60.0, -80.0, 50.0], 20.0));
        assert!((gap - 30.0).abs() < 1e-3, "{gap}");
    }

    #[test]
    fn the_cheap_bound_is_never_above_the_gap() {
        for i in 0..50_i32 {
            let shift = f64::from(i * 7 % 50) * 10.0 - 250.0;
            let capsule = capsule([shift, -50.0, 20.0], [-shift, 160.0, shift], 10.0);
            assert!(unit_box().gap_at_least(&capsule) <= unit_box().gap(&capsule).0 + 1e-9);
        }
    }

    #[test]
    fn the_floor_plan_counts_and_what_is_above_does_not() {
        let zone = unit_box();
        let gap = zone.gap_on_floor([200.0, -50.0], [200.0, 500.0], 30.0, 10.0);
        assert!((gap.unwrap() - 70.0).abs() < 1e-2);
        let shelf = ZoneBox {
            min: Point3::new(0.0, 0.0, 60.0),
            ..zone
        };
        assert_eq!(shelf.gap_on_floor([0.0, 0.0], [1.0, 1.0], 30.0, 50.0), None);
    }

    #[test]
    fn corners_are_inside_their_own_tolerance_and_a_little_more_is_not() {
        let dock = DockPose {
            x: Millimeters(900.0),
            y: Millimeters(-100.0),
            heading: Degrees(170.0),
        };
        let tolerance = DockTolerance {
            position: Millimeters(10.0),
            angle: Degrees(2.0),
        };
        let corners = dock.corners(&tolerance);
        assert_eq!(corners.len(), 9);
        for corner in &corners {
            assert!(tolerance.allows(&dock.deviation(corner)), "{corner:?}");
            let other_way_round = DockPose {
                heading: Degrees(corner.heading.0 - 360.0),
                ..*corner
            };
            assert!(tolerance.allows(&dock.deviation(&other_way_round)));
        }
        let beyond = DockPose {
            heading: Degrees(172.1),
            ..dock
        };
        assert!(!tolerance.allows(&dock.deviation(&beyond)));
        let nowhere = DockPose {
            x: Millimeters(f64::NAN),
            ..dock
        };
        assert!(!tolerance.allows(&dock.deviation(&nowhere)));
    }
}
