//! Velocities of the base, and the small ways that come of them.

use std::ops::{Add, Mul};
use std::time::Duration;

use units::{Millimeters, MmPerSec, RadPerSec, Radians};

/// The velocity of the base in its own frame B. Plain data: what is out of range is refused where
/// it would be integrated.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct BodyTwist {
    /// Along x of the base.
    pub forward: MmPerSec,
    /// Along y of the base.
    pub left: MmPerSec,
    /// Counterclockwise, seen from above.
    pub turn: RadPerSec,
}

/// The same velocity along the axes of the world W.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct WorldTwist {
    /// Along X of the world.
    pub x: MmPerSec,
    /// Along Y of the world.
    pub y: MmPerSec,
    /// Counterclockwise, seen from above.
    pub turn: RadPerSec,
}

/// A constant [`BodyTwist`] times a time.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Displacement {
    /// Along x of the base.
    pub forward: Millimeters,
    /// Along y of the base.
    pub left: Millimeters,
    /// Counterclockwise, seen from above.
    pub turn: Radians,
}

impl BodyTwist {
    /// Standing still.
    pub const ZERO: BodyTwist = BodyTwist {
        forward: MmPerSec(0.0),
        left: MmPerSec(0.0),
        turn: RadPerSec(0.0),
    };

    /// How fast the middle of the base moves.
    #[must_use]
    pub fn speed(&self) -> MmPerSec {
        MmPerSec(self.forward.0.hypot(self.left.0))
    }

    /// The same velocity in the world of a base with `heading`: thesis (2).
    #[must_use]
    pub fn in_world(&self, heading: Radians) -> WorldTwist {
        let (sin, cos) = heading.0.sin_cos();
        WorldTwist {
            x: self.forward * cos - self.left * sin,
            y: self.forward * sin + self.left * cos,
            turn: self.turn,
        }
    }

    /// How far a base comes that keeps this velocity for `time`.
    #[must_use]
    pub fn over(&self, time: Duration) -> Displacement {
        let seconds = time.as_secs_f64();
        Displacement {
            forward: Millimeters(self.forward.0 * seconds),
            left: Millimeters(self.left.0 * seconds),
            turn: Radians(self.turn.0 * seconds),
        }
    }
}

impl Displacement {
    /// The twist that drives it in `time`; nothing if there is no time.
    #[must_use]
    pub fn per(&self, time: Duration) -> Option<BodyTwist> {
        if time.is_zero() {
            return None;
        }
        let seconds = time.as_secs_f64();
        Some(BodyTwist {
            forward: MmPerSec(self.forward.0 / seconds),
            left: MmPerSec(self.left.0 / seconds),
            turn: RadPerSec(self.turn.0 / seconds),
        })
    }
}

impl WorldTwist {
    /// How fast the middle of the base moves.
    #[must_use]
    pub fn speed(&self) -> MmPerSec {
        MmPerSec(self.x.0.hypot(self.y.0))
    }

    /// The same velocity in the frame of a base with `heading`: thesis (2), turned round, as
    /// written out before (11).
    #[must_use]
    pub fn in_body(&self, heading: Radians) -> BodyTwist {
        let (sin, cos) = heading.0.sin_cos();
        BodyTwist {
            forward: self.x * cos + self.y * sin,
            left: self.y * cos - self.x * sin,
            turn: self.turn,
        }
    }
}

/// The same direction, another speed.
impl Mul<f64> for BodyTwist {
    type Output = BodyTwist;
    fn mul(self, factor: f64) -> BodyTwist {
        BodyTwist {
            forward: self.forward * factor,
            left: self.left * factor,
            turn: self.turn * factor,
        }
    }
}

impl Add for BodyTwist {
    type Output = BodyTwist;
    fn add(self, other: BodyTwist) -> BodyTwist {
        BodyTwist {
            forward: self.forward + other.forward,
            left: self.left + other.left,
            turn: self.turn + other.turn,
        }
    }
}
