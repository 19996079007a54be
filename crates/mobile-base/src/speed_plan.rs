//! How fast a path may be driven: curvature, braking, what the wheels can do.

use units::{Millimeters, MmPerSec, MmPerSec2, RadPerSec, Radians};

use crate::base::MecanumBase;
use crate::pose::{Point, one_turn};
use crate::range::{OutOfRange, within};
use crate::spline::{PathPoint, Spline};
use crate::twist::{BodyTwist, WorldTwist};

const MIN_SPEED: MmPerSec = MmPerSec(1.0);
const MAX_SPEED: MmPerSec = MmPerSec(1e5);
const MIN_ACCELERATION: MmPerSec2 = MmPerSec2(1.0);
const MAX_ACCELERATION: MmPerSec2 = MmPerSec2(1e6);
const MIN_RADIUS: Millimeters = Millimeters(1.0);
const MAX_RADIUS: Millimeters = Millimeters(1e6);

/// What a path is driven with.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PathLimits {
    /// The highest speed.
    pub speed: MmPerSec,
    /// Along the path, for starting and for braking.
    pub acceleration: MmPerSec2,
    /// Across the path: it sets the speed in bends.
    pub lateral_acceleration: MmPerSec2,
    /// Bends that are tighter than this are refused.
    pub min_radius: Millimeters,
}

/// Why a path cannot be driven.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
pub enum PathError {
    /// A limit is out of its range.
    #[error("the limits of the path")]
    Limits(#[source] OutOfRange),
    /// A bend is too tight.
    #[error("{after} along the path the radius is {radius:.1}; it must be at least {min}")]
    TooTight {
        /// The way from the start.
        after: Millimeters,
        /// The radius there.
        radius: Millimeters,
        /// The smallest allowed one.
        min: Millimeters,
    },
}

/// How the heading goes along a path.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum PathHeading {
    /// Mode 1: the velocity has this direction in the base's frame (beta*).
    FixedCourse {
        /// From x of the base to the velocity, counterclockwise.
        course: Radians,
    },
    /// Mode 2: the base turns from one heading to the other, the short way round and smoothly, over
    /// the length of the path.
    Turning {
        /// At the start.
        from: Radians,
        /// At the end.
        to: Radians,
    },
}

/// A spline with a heading and a speed for each place on it, checked for one base.
#[derive(Clone, Debug, PartialEq)]
pub struct PlannedPath {
    spline: Spline,
    heading: PathHeading,
    limits: PathLimits,
    stations: Vec<Station>,
    end: (Point, Radians),
}

#[derive(Clone, Copy, Debug, PartialEq)]
struct Station {
    along: f64,
    speed_squared: f64,
}

impl PathLimits {
    fn check(&self) -> Result<(), OutOfRange> {
        let accelerations = [
            ("acceleration", self.acceleration),
            ("lateral acceleration", self.lateral_acceleration),
        ];
        for (item, value) in accelerations {
            let _ = within(item, value, MIN_ACCELERATION, MAX_ACCELERATION)?;
        }
        let _ = within("speed", self.speed, MIN_SPEED, MAX_SPEED)?;
        let _ = within("smallest radius", self.min_radius, MIN_RADIUS, MAX_RADIUS)?;
        Ok(())
    }
}

impl PlannedPath {
    /// Plans the speed along `spline`: as fast as limits, bends and wheels allow, and so that the
    /// base can brake before each slower place and stands at the end.
    ///
    /// Bends are looked at every sixteenth of the way between two points.
    ///
    /// # Errors
    /// A limit that makes no sense, or a bend that is too tight.
    pub fn try_new(
        spline: Spline,
        heading: PathHeading,
        limits: &PathLimits,
        base: &MecanumBase,
    ) -> Result<PlannedPath, PathError> {
        limits.check().map_err(PathError::Limits)?;
        heading.check().map_err(PathError::Limits)?;
        let length = spline.length().0;
        let mut stations = Vec::new();
        let mut end = (Point::default(), Radians(0.0));
        for along in spline.stations() {
            let Some(place) = spline.at(along) else {
                continue;
            };
            let curvature = place.curvature.0.abs();
            if curvature * limits.min_radius.0 > 1.0 {
                return Err(PathError::TooTight {
                    after: along,
                    radius: Millimeters(1.0 / curvature),
                    min: limits.min_radius,
                });
            }
            let in_bends = (limits.lateral_acceleration.0 / curvature).sqrt();
            let (pose_heading, per_length) = heading.at(&place, along.0 / length, length);
            let wheels = fastest_along(base, &place, pose_heading, per_length);
            end = (place.point, Radians(pose_heading));
            let speed = limits.speed.0.min(in_bends).min(wheels);
            stations.push(Station {
                along: along.0,
                speed_squared: speed * speed,
            });
        }
        // From the end, where the base stands, back: v^2 grows by 2 a s at most.
        let (mut behind, mut allowed) = (length, 0.0_f64);
        for station in stations.iter_mut().rev() {
            allowed += 2.0 * limits.acceleration.0 * (behind - station.along);
            allowed = allowed.min(station.speed_squared);
            station.speed_squared = allowed;
            behind = station.along;
        }
        Ok(PlannedPath {
            spline,
            heading,
            limits: *limits,
            stations,
            end,
        })
    }

    /// The curve.
    #[must_use]
    pub fn spline(&self) -> &Spline {
        &self.spline
    }

    /// What it was planned with.
    #[must_use]
    pub fn limits(&self) -> &PathLimits {
        &self.limits
    }

    /// The highest speed at a place, from which the base can still brake; nothing off the path.
    #[must_use]
    pub fn speed_at(&self, along: Millimeters) -> Option<MmPerSec> {
        let after = self
            .stations
            .partition_point(|station| station.along <= along.0);
        let before = self.stations.get(after.checked_sub(1)?)?;
        let Some(next) = self.stations.get(after) else {
            return (along == self.spline.length()).then_some(MmPerSec(0.0));
        };
        // Even acceleration between two stations: v^2 is linear in the way.
        let share = (along.0 - before.along) / (next.along - before.along);
        let squared = before.speed_squared + share * (next.speed_squared - before.speed_squared);
        Some(MmPerSec(squared.max(0.0).sqrt()))
    }

    /// Place and heading of the base at a place; nothing off the path.
    #[must_use]
    pub fn pose_at(&self, along: Millimeters) -> Option<(PathPoint, Radians)> {
        let place = self.spline.at(along)?;
        let length = self.spline.length().0;
        let (heading, _) = self.heading.at(&place, along.0 / length, length);
        Some((place, Radians(heading)))
    }
}

impl PlannedPath {
    /// Point and heading at the end.
    pub(crate) fn end(&self) -> (Point, Radians) {
        self.end
    }
}

impl PathHeading {
    fn check(&self) -> Result<(), OutOfRange> {
        let turn = |item, value| within(item, value, Radians(-1e6), Radians(1e6)).map(drop);
        match self {
            PathHeading::FixedCourse { course } => turn("course", *course),
            PathHeading::Turning { from, to } => {
                turn("heading at the start", *from)?;
                turn("heading at the end", *to)
            }
        }
    }

    /// Heading, and how fast it changes with the way.
    fn at(&self, place: &PathPoint, share: f64, length: f64) -> (f64, f64) {
        match self {
            PathHeading::FixedCourse { course } => {
                (place.direction.0 - course.0, place.curvature.0)
            }
            PathHeading::Turning { from, to } => {
                let turn = one_turn(to.0 - from.0);
                // 10 u^3 - 15 u^4 + 6 u^5: rate and acceleration are zero at both ends.
                let u = share;
                let blend = u * u * u * (10.0 + u * (6.0 * u - 15.0));
                let rate = 30.0 * u * u * (1.0 - u) * (1.0 - u) / length;
                (from.0 + turn * blend, turn * rate)
            }
        }
    }
}

/// The speed along the path at which the first wheel reaches its limit.
fn fastest_along(base: &MecanumBase, place: &PathPoint, heading: f64, per_length: f64) -> f64 {
    let (sin, cos) = place.direction.0.sin_cos();
    let at_unit_speed: BodyTwist = WorldTwist {
        x: MmPerSec(cos),
        y: MmPerSec(sin),
        turn: RadPerSec(per_length),
    }
    .in_body(Radians(heading));
    let (_, wheel) = base.inverse(&at_unit_speed).fastest();
    base.dimensions().max_wheel_speed.0 / wheel.0.abs()
}
