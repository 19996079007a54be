//! The mecanum base: wheel speeds and body velocity, thesis (1) and (3).

use units::{Millimeters, MmPerSec, RadPerSec, Radians};

use crate::range::{OutOfRange, within};
use crate::twist::{BodyTwist, Displacement};
use crate::wheels::{Wheel, WheelAngles, WheelSpeeds};

const MIN_LENGTH: Millimeters = Millimeters(1.0);
const MAX_LENGTH: Millimeters = Millimeters(1e5);
const MIN_WHEEL_SPEED: RadPerSec = RadPerSec(1e-3);
const MAX_WHEEL_SPEED: RadPerSec = RadPerSec(1e4);

/// The measures of a base, as its drawing gives them.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Dimensions {
    /// r: radius of the wheels, over the rollers.
    pub wheel_radius: Millimeters,
    /// d: from the front axle to the rear axle.
    pub wheelbase: Millimeters,
    /// e: from the middle of the left wheels to the middle of the right wheels.
    pub track: Millimeters,
    /// The highest speed of a wheel, either way.
    pub max_wheel_speed: RadPerSec,
}

/// A base with four mecanum wheels, checked.
///
/// ```text
///   seen from above; the slash is the axis of the roller that is up
///
///        x (forward)               r  wheel radius
///        ^                         d  wheelbase
///    1 \ | / 2   ---               e  track
///        |        |
///  y <---B        d                All rollers at 45 degrees to their wheel's axle. On the floor
///                 |                they lie the other way: wheels 1 and 4 as /, 2 and 3 as \.
///    3 /   \ 4   ---               A positive wheel speed drives forward.
///      |-e-|
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct MecanumBase {
    dimensions: Dimensions,
}

/// A wheel would have to turn faster than it can.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
#[error("the {wheel} wheel would turn at {value}; its limit is {limit} either way")]
pub struct WheelTooFast {
    /// The fastest wheel.
    pub wheel: Wheel,
    /// What it would have to do.
    pub value: RadPerSec,
    /// What it can do.
    pub limit: RadPerSec,
}

/// A twist that the wheels can drive, and how much of the wanted one it is.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ScaledTwist {
    /// The wanted twist times the factor: the same path, driven more slowly.
    pub twist: BodyTwist,
    /// From 0 to 1; 1 if the wheels can drive what was wanted.
    pub factor: f64,
}

impl MecanumBase {
    /// A base from its measures.
    ///
    /// # Errors
    /// A length that is not from 1 mm to 100 m, a wheel speed that is not from 0.001 to 10,000
    /// rad/s.
    pub fn try_new(dimensions: &Dimensions) -> Result<MecanumBase, OutOfRange> {
        let lengths = [
            ("wheel radius", dimensions.wheel_radius),
            ("wheelbase", dimensions.wheelbase),
            ("track", dimensions.track),
        ];
        for (item, length) in lengths {
            let _ = within(item, length, MIN_LENGTH, MAX_LENGTH)?;
        }
        let _ = within(
            "highest wheel speed",
            dimensions.max_wheel_speed,
            MIN_WHEEL_SPEED,
            MAX_WHEEL_SPEED,
        )?;
        Ok(MecanumBase {
            dimensions: *dimensions,
        })
    }

    /// The measures it was made from.
    #[must_use]
    pub fn dimensions(&self) -> &Dimensions {
        &self.dimensions
    }

    /// The body velocity that fits the wheel speeds best: thesis (1).
    ///
    /// Least squares: wheels that fight each other ([`MecanumBase::slip`]) are averaged.
    #[must_use]
    pub fn forward(&self, speeds: &WheelSpeeds) -> BodyTwist {
        let [forward, left, turn] = self.least_squares(speeds.0.map(|speed| speed.0));
        BodyTwist {
            forward: MmPerSec(forward),
            left: MmPerSec(left),
            turn: RadPerSec(turn),
        }
    }

    /// The same for ways: how the base moves while the wheels turn by `angles`, evenly.
    #[must_use]
    pub fn displacement(&self, angles: &WheelAngles) -> Displacement {
        let [forward, left, turn] = self.least_squares(angles.0.map(|angle| angle.0));
        Displacement {
            forward: Millimeters(forward),
            left: Millimeters(left),
            turn: Radians(turn),
        }
    }

    /// The wheel speeds that drive a body velocity without slip: thesis (3).
    ///
    /// Limits are not applied; see [`MecanumBase::check`] and [`MecanumBase::scale_to_limits`].
    #[must_use]
    pub fn inverse(&self, twist: &BodyTwist) -> WheelSpeeds {
        let BodyTwist {
            forward,
            left,
            turn,
        } = twist;
        let arm = turn.0 * self.lever();
        let per_radius = 1.0 / self.dimensions.wheel_radius.0;
        WheelSpeeds(
            [
                forward.0 - left.0 - arm,
                forward.0 + left.0 + arm,
                forward.0 + left.0 - arm,
                forward.0 - left.0 + arm,
            ]
            .map(|rim| RadPerSec(rim * per_radius)),
        )
    }

    /// How much the wheels fight each other: zero if some motion of the body turns all four without
    /// slip.
    ///
    /// The one direction of the wheel speeds that (1) does not see is (1, 1, -1, -1); this is the
    /// part along it. Each wheel slips by this much, the front ones forward.
    #[must_use]
    pub fn slip(&self, speeds: &WheelSpeeds) -> RadPerSec {
        let [w1, w2, w3, w4] = speeds.0;
        (w1 + w2 - w3 - w4) * 0.25
    }

    /// Refuses wheel speeds beyond the limit.
    ///
    /// # Errors
    /// Names the fastest wheel; a speed that is not a number is refused too.
    pub fn check(&self, speeds: &WheelSpeeds) -> Result<(), WheelTooFast> {
        let (wheel, value) = speeds.fastest();
        let limit = self.dimensions.max_wheel_speed;
        if value.abs() <= limit {
            return Ok(());
        }
        Err(WheelTooFast {
            wheel,
            value,
            limit,
        })
    }

    /// Slows a twist down, evenly, until the wheels can drive it, and says by how much.
    ///
    /// Translation and turn shrink by one factor, so the base stays on the path of the wanted twist
    /// and only takes longer. A law whose proof needs the wanted speed does not hold while the
    /// factor is below 1.
    ///
    /// # Errors
    /// A twist that is not a number has no direction to keep.
    pub fn scale_to_limits(&self, twist: &BodyTwist) -> Result<ScaledTwist, WheelTooFast> {
        let (wheel, value) = self.inverse(twist).fastest();
        let limit = self.dimensions.max_wheel_speed;
        if value.abs() <= limit {
            return Ok(ScaledTwist {
                twist: *twist,
                factor: 1.0,
            });
        }
        if !value.is_finite() {
            return Err(WheelTooFast {
                wheel,
                value,
                limit,
            });
        }
        // A hair less, so that rounding does not carry the fastest wheel over its limit.
        let factor = limit.0 / value.0.abs() * (1.0 - 4.0 * f64::EPSILON);
        Ok(ScaledTwist {
            twist: *twist * factor,
            factor,
        })
    }

    /// (d + e) / 2: what a turn of the body adds to the way of a wheel's rim.
    fn lever(&self) -> f64 {
        0.5 * (self.dimensions.wheelbase.0 + self.dimensions.track.0)
    }

    /// The matrix of (1), the pseudo-inverse of that of (3).
    fn least_squares(&self, [w1, w2, w3, w4]: [f64; 4]) -> [f64; 3] {
        let quarter = 0.25 * self.dimensions.wheel_radius.0;
        [
            quarter * (w1 + w2 + w3 + w4),
            quarter * (-w1 + w2 + w3 - w4),
            quarter / self.lever() * (-w1 + w2 - w3 + w4),
        ]
    }
}
