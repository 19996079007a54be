//! Newtypes for the quantities of a robot cell.
//!
//! Millimeters and degrees live at the edges (JSON, command line, TOML, wire, pendant); radians live inside.
//! A bare `f64` below an edge is neither a length nor an angle.
//!
//! ```
//! use units::{Degrees, Radians};
//! let half_turn: Radians = Degrees(180.0).into();
//! assert!((half_turn.0 - std::f64::consts::PI).abs() < 1e-15);
//! ```

use std::fmt;
use std::ops::{Add, Mul, Neg, Sub};

/// A number as people read it: to a billionth, so that 985 does not come back as 985.0000000000001 from its way through
/// radians.
///
/// A millionth of what a controller tells apart (a thousandth of a millimeter, a thousandth of a degree), so nothing that
/// is compared at an edge is another number for it. What is not finite stays as it is, and there is no negative zero.
///
/// ```
/// assert_eq!(units::shown(985.000_000_000_000_1), 985.0);
/// assert_eq!(units::shown(-1.2e-15).to_string(), "0");
/// assert_eq!(units::shown(0.001_25), 0.001_25);
/// ```
#[must_use]
pub fn shown(value: f64) -> f64 {
    let scaled = (value * 1e9).round();
    if scaled.is_finite() {
        // Adding zero makes a negative zero positive.
        scaled / 1e9 + 0.0
    } else {
        value
    }
}

macro_rules! quantity {
    ($(#[$doc:meta])* $name:ident, $unit:literal) => {
        $(#[$doc])*
        #[derive(Clone, Copy, Debug, Default, PartialEq, PartialOrd)]
        #[repr(transparent)]
        pub struct $name(pub f64);

        impl $name {
            /// The magnitude without the sign.
            #[must_use]
            pub fn abs(self) -> Self {
                Self(self.0.abs())
            }

            /// Neither NaN nor infinite.
            #[must_use]
            pub fn is_finite(self) -> bool {
                self.0.is_finite()
            }
        }

        impl Add for $name {
            type Output = Self;
            fn add(self, other: Self) -> Self {
                Self(self.0 + other.0)
            }
        }

        impl Sub for $name {
            type Output = Self;
            fn sub(self, other: Self) -> Self {
                Self(self.0 - other.0)
            }
        }

        impl Neg for $name {
            type Output = Self;
            fn neg(self) -> Self {
                Self(-self.0)
            }
        }

        impl Mul<f64> for $name {
            type Output = Self;
            fn mul(self, factor: f64) -> Self {
                Self(self.0 * factor)
            }
        }

        /// The value with its unit, at the precision the formatter asks for.
        impl fmt::Display for $name {
            fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
                fmt::Display::fmt(&self.0, f)?;
                f.write_str($unit)
            }
        }
    };
}

quantity!(
    /// A length in millimeters.
    Millimeters, " mm"
);
quantity!(
    /// An angle in degrees: the unit of every edge.
    Degrees, "\u{b0}"
);
quantity!(
    /// An angle in radians: the unit inside.
    Radians, " rad"
);
quantity!(
    /// A speed along a path in millimeters a second.
    MmPerSec, " mm/s"
);
quantity!(
    /// An acceleration in millimeters a second squared.
    MmPerSec2, " mm/s\u{b2}"
);
quantity!(
    /// An angular speed in radians a second: the unit inside.
    RadPerSec, " rad/s"
);
quantity!(
    /// A rate of decay or a feedback gain: a share a second.
    PerSecond, " /s"
);
quantity!(
    /// A curvature: radians a millimeter of path.
    PerMillimeter, " /mm"
);
quantity!(
    /// An angular speed in degrees a second, as data sheets give it.
    DegPerSec, "\u{b0}/s"
);
quantity!(
    /// An angular acceleration in degrees a second squared.
    DegPerSec2, "\u{b0}/s\u{b2}"
);
quantity!(
    /// An angular jerk in degrees a second cubed.
    DegPerSec3, "\u{b0}/s\u{b3}"
);

impl From<Degrees> for Radians {
    fn from(angle: Degrees) -> Self {
        Self(angle.0.to_radians())
    }
}

impl From<Radians> for Degrees {
    fn from(angle: Radians) -> Self {
        Self(angle.0.to_degrees())
    }
}

impl From<DegPerSec> for RadPerSec {
    fn from(speed: DegPerSec) -> Self {
        Self(speed.0.to_radians())
    }
}

impl From<RadPerSec> for DegPerSec {
    fn from(speed: RadPerSec) -> Self {
        Self(speed.0.to_degrees())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_right_angle_is_half_pi() {
        assert_eq!(
            Radians::from(Degrees(90.0)),
            Radians(std::f64::consts::FRAC_PI_2)
        );
        assert_eq!(
            Degrees::from(Radians(std::f64::consts::FRAC_PI_2)),
            Degrees(90.0)
        );
    }

    #[test]
    fn a_turn_a_second_is_two_pi_radians_a_second() {
        let speed = RadPerSec::from(DegPerSec(360.0));
        assert_eq!(speed, RadPerSec(std::f64::consts::TAU));
        assert_eq!(DegPerSec::from(speed), DegPerSec(360.0));
    }

    #[test]
    fn values_print_with_their_unit() {
        assert_eq!(format!("{:.1}", Millimeters(12.345)), "12.3 mm");
        assert_eq!(format!("{:.1}", Degrees(-45.0)), "-45.0\u{b0}");
        assert_eq!(format!("{:.2}", RadPerSec(0.125)), "0.12 rad/s");
        assert_eq!(format!("{}", PerSecond(2.0)), "2 /s");
    }
}
