use std::fmt;

use units::{Degrees, Millimeters, MmPerSec};

use super::error::{DecodeError, ValueError};
use super::fields::Fields;
use super::line::LineWriter;

/// The largest number on the wire, either way.
pub const LARGEST: i32 = i32::MAX;

/// The number of a motion or an output: unique on a controller, compared epoch first.
///
/// `(0, 0)` is the number of no motion at all.
#[derive(Clone, Copy, Debug, Default, Eq, Hash, Ord, PartialEq, PartialOrd)]
pub struct MotionNumber {
    /// The writer's epoch: a controller takes none below the highest it has seen.
    pub epoch: u32,
    /// Counts from 1 in each epoch.
    pub seq: u32,
}

impl MotionNumber {
    pub(super) fn write(self, line: &mut LineWriter) {
        let _line = line.integer(self.epoch).integer(self.seq);
    }

    pub(super) fn read(
        fields: &mut Fields<'_>,
        epoch: &'static str,
        seq: &'static str,
    ) -> Result<Self, DecodeError> {
        Ok(Self {
            epoch: fields.count(epoch)?,
            seq: fields.count(seq)?,
        })
    }
}

impl fmt::Display for MotionNumber {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}/{}", self.epoch, self.seq)
    }
}

/// A pose the wire can carry exactly: the tool center point in the active frames, thousandths of a millimeter and of
/// a degree. What is judged and what is sent are this one value.
#[derive(Clone, Copy, Debug, Eq, Hash, PartialEq)]
pub struct WirePose([i32; 6]);

impl WirePose {
    pub(super) const ITEMS: [&'static str; 6] = ["X", "Y", "Z", "W", "P", "R"];

    /// Rounds X, Y, Z and W, P, R to the nearest thousandth, ties away from zero.
    ///
    /// # Errors
    /// A value is not finite, or its thousandths do not fit.
    pub fn try_new(position: [Millimeters; 3], rotation: [Degrees; 3]) -> Result<Self, ValueError> {
        let ([x, y, z], [w, p, r]) = (position, rotation);
        thousandths(Self::ITEMS, [x.0, y.0, z.0, w.0, p.0, r.0]).map(Self)
    }

    /// X, Y, Z.
    #[must_use]
    pub fn position(&self) -> [Millimeters; 3] {
        let [x, y, z, ..] = self.0;
        [x, y, z].map(|value| Millimeters(f64::from(value) / 1000.0))
    }

    /// W, P, R: rotations about the fixed X, Y and Z axes.
    #[must_use]
    pub fn rotation(&self) -> [Degrees; 3] {
        let [.., w, p, r] = self.0;
        [w, p, r].map(|value| Degrees(f64::from(value) / 1000.0))
    }

    /// The six numbers of the wire.
    #[must_use]
    pub fn thousandths(&self) -> [i32; 6] {
        self.0
    }

    pub(super) fn write(self, line: &mut LineWriter) {
        write_six(self.0, line);
    }

    pub(super) fn read(fields: &mut Fields<'_>) -> Result<Self, DecodeError> {
        fields.six(Self::ITEMS).map(Self)
    }
}

/// The target of a move of the seed's wire, which has the same thousandths.
impl From<crate::WireMove> for WirePose {
    fn from(target: crate::WireMove) -> Self {
        Self(target.thousandths())
    }
}

/// Joint values as on the pendant that the wire can carry exactly: thousandths of a degree, J1 first.
#[derive(Clone, Copy, Debug, Eq, Hash, PartialEq)]
pub struct WireJoints([i32; 6]);

impl WireJoints {
    pub(super) const ITEMS: [&'static str; 6] = ["J1", "J2", "J3", "J4", "J5", "J6"];

    /// Rounds joint values to the nearest thousandth, ties away from zero.
    ///
    /// # Errors
    /// A value is not finite, or its thousandths do not fit.
    pub fn try_new(joints: [Degrees; 6]) -> Result<Self, ValueError> {
        thousandths(Self::ITEMS, joints.map(|joint| joint.0)).map(Self)
    }

    /// The joint values, J1 first.
    #[must_use]
    pub fn degrees(&self) -> [Degrees; 6] {
        self.0.map(|value| Degrees(f64::from(value) / 1000.0))
    }

    /// The six numbers of the wire.
    #[must_use]
    pub fn thousandths(&self) -> [i32; 6] {
        self.0
    }

    pub(super) fn write(self, line: &mut LineWriter) {
        write_six(self.0, line);
    }

    pub(super) fn read(fields: &mut Fields<'_>) -> Result<Self, DecodeError> {
        fields.six(Self::ITEMS).map(Self)
    }
}

fn write_six(values: [i32; 6], line: &mut LineWriter) {
    for value in values {
        let _line = line.integer(value);
    }
}

fn thousandths(items: [&'static str; 6], values: [f64; 6]) -> Result<[i32; 6], ValueError> {
    let mut numbers = [0; 6];
    for ((number, item), value) in numbers.iter_mut().zip(items).zip(values) {
        if !value.is_finite() {
            return Err(ValueError::NotFinite { item, value });
        }
        let rounded = (value * 1000.0).round();
        if rounded.abs() > f64::from(LARGEST) {
            return Err(ValueError::TooLarge { item, value });
        }
        #[expect(
            clippy::cast_possible_truncation,
            reason = "a whole number inside the range of i32 was just checked"
        )]
        {
            *number = rounded as i32;
        }
    }
    Ok(numbers)
}

macro_rules! bounded {
    ($(#[$doc:meta])* $name:ident($inner:ty), $item:literal, $min:literal..=$max:literal) => {
        $(#[$doc])*
        #[derive(Clone, Copy, Debug, Eq, Hash, Ord, PartialEq, PartialOrd)]
        pub struct $name($inner);

        impl $name {
            /// The smallest legal value.
            pub const MIN: $inner = $min;
            /// The largest legal value.
            pub const MAX: $inner = $max;

            /// Checks a value.
            ///
            /// # Errors
            /// The value is outside the range.
            pub fn try_new(value: $inner) -> Result<Self, ValueError> {
                if (Self::MIN..=Self::MAX).contains(&value) {
                    return Ok(Self(value));
                }
                Err(ValueError::OutOfRange {
                    item: $item,
                    value: i64::from(value),
                    min: $min,
                    max: $max,
                })
            }

            /// The value.
            #[must_use]
            pub fn get(self) -> $inner {
                self.0
            }

            pub(super) fn write(self, line: &mut LineWriter) {
                let _line = line.integer(self.0);
            }

            pub(super) fn read(fields: &mut Fields<'_>) -> Result<Self, DecodeError> {
                let value = fields.in_range($item, $min, $max)?;
                Ok(Self(<$inner>::try_from(value).unwrap_or(Self::MIN)))
            }
        }
    };
}

bounded!(
    /// A speed of a joint motion, or an override: 1 to 100 percent.
    Percent(u8), "the percentage", 1..=100
);
bounded!(
    /// A speed along a straight line: 1 to 1999 mm/s.
    LinearSpeed(u16), "the speed in mm/s", 1..=1999
);
bounded!(
    /// A digital output the program may set: 1 to 8.
    OutputNumber(u8), "the output", 1..=8
);

impl LinearSpeed {
    /// The speed with its unit.
    #[must_use]
    pub fn speed(self) -> MmPerSec {
        MmPerSec(f64::from(self.0))
    }
}
