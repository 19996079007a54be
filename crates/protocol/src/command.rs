use std::fmt;

use thiserror::Error;
use units::{Degrees, Millimeters, MmPerSec};

use crate::CommandBytes;

/// The slowest speed the controller's program takes, in mm/s.
pub const MIN_SPEED: u16 = 1;
/// The fastest speed the controller's program takes, in mm/s.
pub const MAX_SPEED: u16 = 1999;

/// A move to a point, programmed speed along the path. Plain data; checked by [`MoveCommand::to_wire`].
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct MoveCommand {
    /// X of the tool center point in the active user frame.
    pub x: Millimeters,
    /// Y of the tool center point.
    pub y: Millimeters,
    /// Z of the tool center point.
    pub z: Millimeters,
    /// Rotation about the fixed X axis.
    pub w: Degrees,
    /// Rotation about the fixed Y axis.
    pub p: Degrees,
    /// Rotation about the fixed Z axis.
    pub r: Degrees,
    /// Programmed speed: a whole number of mm/s, 1 to 1999.
    pub speed: MmPerSec,
}

impl MoveCommand {
    /// The command as the wire can carry it: thousandths, rounded to the nearest, ties away from zero.
    ///
    /// # Errors
    /// A value is not finite or its thousandths do not fit 32 bits; the speed is not a whole number of 1 to 1999.
    pub fn to_wire(&self) -> Result<WireMove, CommandError> {
        let speed = self.speed.0;
        if speed.fract() != 0.0 || !(f64::from(MIN_SPEED)..=f64::from(MAX_SPEED)).contains(&speed) {
            return Err(CommandError::Speed { value: speed });
        }
        Ok(WireMove {
            point: [
                thousandths(Item::X, self.x.0)?,
                thousandths(Item::Y, self.y.0)?,
                thousandths(Item::Z, self.z.0)?,
                thousandths(Item::W, self.w.0)?,
                thousandths(Item::P, self.p.0)?,
                thousandths(Item::R, self.r.0)?,
            ],
            #[expect(
                clippy::cast_possible_truncation,
                clippy::cast_sign_loss,
                reason = "a whole number of 1 to 1999 was just checked"
            )]
            speed: speed as u16,
        })
    }

    /// The bytes of the command.
    ///
    /// # Errors
    /// As [`MoveCommand::to_wire`].
    pub fn encode(&self) -> Result<CommandBytes, CommandError> {
        self.to_wire().map(|wire| wire.encode())
    }
}

/// A command the wire can carry exactly: what the controller will see, after the rounding.
#[derive(Clone, Copy, Debug, Eq, Hash, PartialEq)]
pub struct WireMove {
    point: [i32; 6],
    speed: u16,
}

impl WireMove {
    pub(crate) fn from_parts(point: [i32; 6], speed: u16) -> Self {
        Self { point, speed }
    }

    /// X, Y, Z in thousandths of a millimeter and W, P, R in thousandths of a degree.
    #[must_use]
    pub fn thousandths(&self) -> [i32; 6] {
        self.point
    }

    /// The programmed speed in mm/s.
    #[must_use]
    pub fn speed(&self) -> u16 {
        self.speed
    }

    /// The values the controller will compute from the thousandths.
    #[must_use]
    pub fn command(&self) -> MoveCommand {
        let [x, y, z, w, p, r] = self.point.map(|value| f64::from(value) / 1000.0);
        MoveCommand {
            x: Millimeters(x),
            y: Millimeters(y),
            z: Millimeters(z),
            w: Degrees(w),
            p: Degrees(p),
            r: Degrees(r),
            speed: MmPerSec(f64::from(self.speed)),
        }
    }

    /// The bytes of the command, without a line end.
    #[must_use]
    pub fn encode(&self) -> CommandBytes {
        let mut bytes = CommandBytes::new();
        for value in self.point {
            bytes.push_integer(value);
            bytes.push(b' ');
        }
        bytes.push_integer(i32::from(self.speed));
        bytes.push(b' ');
        bytes.push(b'1');
        bytes
    }
}

/// A message that asks the seed program for a motion at speed 0, which it refuses as `ERROR: POINT UNREACHABLE`.
///
/// The program serves one connection after the other, so its answer proves that every message before this one has
/// been read and answered, or was lost. It proves nothing about a motion that was accepted: that runs on. No
/// [`MoveCommand`] has this form.
#[must_use]
pub fn seed_fence() -> CommandBytes {
    let mut bytes = CommandBytes::new();
    for byte in b"0 0 0 0 0 0 0 1" {
        bytes.push(*byte);
    }
    bytes
}

fn thousandths(item: Item, value: f64) -> Result<i32, CommandError> {
    if !value.is_finite() {
        return Err(CommandError::NotFinite { item, value });
    }
    let rounded = (value * 1000.0).round();
    if !(f64::from(i32::MIN)..=f64::from(i32::MAX)).contains(&rounded) {
        return Err(CommandError::OutOfRange { item, value });
    }
    #[expect(
        clippy::cast_possible_truncation,
        reason = "a whole number inside the range of i32 was just checked"
    )]
    Ok(rounded as i32)
}

/// A field of the command.
#[derive(Clone, Copy, Debug, Eq, Hash, PartialEq)]
pub enum Item {
    /// X in millimeters.
    X,
    /// Y in millimeters.
    Y,
    /// Z in millimeters.
    Z,
    /// W in degrees.
    W,
    /// P in degrees.
    P,
    /// R in degrees.
    R,
    /// The speed in mm/s.
    Speed,
    /// The digit after the speed.
    Last,
}

impl Item {
    /// The fields in the order of the wire.
    pub const ALL: [Self; 8] = [
        Self::X,
        Self::Y,
        Self::Z,
        Self::W,
        Self::P,
        Self::R,
        Self::Speed,
        Self::Last,
    ];
}

impl fmt::Display for Item {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::X => "X",
            Self::Y => "Y",
            Self::Z => "Z",
            Self::W => "W",
            Self::P => "P",
            Self::R => "R",
            Self::Speed => "SPEED",
            Self::Last => "the last digit",
        })
    }
}

/// Why a command cannot be written.
#[derive(Clone, Copy, Debug, Error, PartialEq)]
pub enum CommandError {
    /// A value is NaN or infinite.
    #[error("{item} is {value}, which is not a finite number")]
    NotFinite {
        /// Which value.
        item: Item,
        /// The value, in mm or degrees.
        value: f64,
    },
    /// A value in thousandths does not fit the controller's 32-bit INTEGER.
    #[error(
        "{item} is {}, outside the wire's -2147483.648 to 2147483.647 (32-bit thousandths)", Short(*value)
    )]
    OutOfRange {
        /// Which value.
        item: Item,
        /// The value, in mm or degrees.
        value: f64,
    },
    /// The speed is not a whole number of 1 to 1999 mm/s.
    #[error("SPEED is {} mm/s, not a whole number of {MIN_SPEED} to {MAX_SPEED}", Short(*value))]
    Speed {
        /// The speed in mm/s.
        value: f64,
    },
}

/// A number in a message: no row of three hundred digits.
struct Short(f64);

impl fmt::Display for Short {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        if self.0.abs() < 1e15 {
            write!(f, "{}", self.0)
        } else {
            write!(f, "{:e}", self.0)
        }
    }
}

impl CommandError {
    /// The field concerned.
    #[must_use]
    pub fn item(&self) -> Item {
        match self {
            Self::NotFinite { item, .. } | Self::OutOfRange { item, .. } => *item,
            Self::Speed { .. } => Item::Speed,
        }
    }

    /// The value refused, in the field's unit.
    #[must_use]
    pub fn value(&self) -> f64 {
        match self {
            Self::NotFinite { value, .. }
            | Self::OutOfRange { value, .. }
            | Self::Speed { value } => *value,
        }
    }
}
