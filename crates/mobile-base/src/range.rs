//! Values that are refused when they are out of their range.

use std::fmt;
use std::time::Duration;

use units::{Degrees, Millimeters};
use units::{MmPerSec, MmPerSec2, PerMillimeter, PerSecond, RadPerSec, Radians};

/// A value with its unit, whatever the unit is: what an error shows.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Quantity {
    /// A length.
    Length(Millimeters),
    /// An angle.
    Angle(Radians),
    /// A speed.
    Speed(MmPerSec),
    /// An acceleration.
    Acceleration(MmPerSec2),
    /// An angular speed.
    Turn(RadPerSec),
    /// A gain.
    Rate(PerSecond),
    /// A share of a length: a curvature, or the steepness of a function of distance.
    PerLength(PerMillimeter),
    /// A time.
    Time(Duration),
    /// A number of things.
    Count(usize),
    /// A share.
    Ratio(f64),
}

impl fmt::Display for Quantity {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Quantity::Length(value) => value.fmt(f),
            Quantity::Angle(value) => Degrees::from(*value).fmt(f),
            Quantity::Speed(value) => value.fmt(f),
            Quantity::Acceleration(value) => value.fmt(f),
            Quantity::Turn(value) => value.fmt(f),
            Quantity::Rate(value) => value.fmt(f),
            Quantity::PerLength(value) => value.fmt(f),
            Quantity::Time(value) => write!(f, "{value:?}"),
            Quantity::Count(value) => value.fmt(f),
            Quantity::Ratio(value) => value.fmt(f),
        }
    }
}

macro_rules! quantity_from {
    ($($from:ty => $variant:ident),+ $(,)?) => {$(
        impl From<$from> for Quantity {
            fn from(value: $from) -> Self {
                Quantity::$variant(value)
            }
        }
    )+};
}

quantity_from!(
    Millimeters => Length,
    Radians => Angle,
    MmPerSec => Speed,
    MmPerSec2 => Acceleration,
    RadPerSec => Turn,
    PerSecond => Rate,
    PerMillimeter => PerLength,
    Duration => Time,
    usize => Count,
    f64 => Ratio,
);

/// A value that is not a number, or outside its range.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
#[error("{item} is {value}; it must be from {min} to {max}")]
pub struct OutOfRange {
    /// What the value is.
    pub item: &'static str,
    /// What was given.
    pub value: Quantity,
    /// The smallest value that is accepted.
    pub min: Quantity,
    /// The largest value that is accepted.
    pub max: Quantity,
}

/// `value` if it is a number from `min` to `max`.
pub(crate) fn within<T>(item: &'static str, value: T, min: T, max: T) -> Result<T, OutOfRange>
where
    T: Copy + PartialOrd + Into<Quantity>,
{
    // NaN is in no range.
    if (min..=max).contains(&value) {
        Ok(value)
    } else {
        Err(OutOfRange {
            item,
            value: value.into(),
            min: min.into(),
            max: max.into(),
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_refusal_names_item_value_and_limits() {
        let refused = within(
            "wheel radius",
            Millimeters(-5.0),
            Millimeters(1.0),
            Millimeters(1e4),
        );
        assert_eq!(
            refused.unwrap_err().to_string(),
            "wheel radius is -5 mm; it must be from 1 mm to 10000 mm"
        );
    }

    #[test]
    fn not_a_number_is_in_no_range() {
        for value in [f64::NAN, f64::INFINITY, f64::NEG_INFINITY] {
            assert!(within("gain", value, -1e300, 1e300).is_err());
        }
    }
}
