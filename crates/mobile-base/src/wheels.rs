//! The four wheels: their names, speeds and angles.

use std::fmt;
use std::time::Duration;

use units::{RadPerSec, Radians};

/// A wheel; the thesis numbers them from 1 to 4 in this order.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub enum Wheel {
    /// Wheel 1.
    FrontLeft,
    /// Wheel 2.
    FrontRight,
    /// Wheel 3.
    RearLeft,
    /// Wheel 4.
    RearRight,
}

impl Wheel {
    /// All wheels, in the order of their numbers.
    pub const ALL: [Wheel; 4] = [
        Wheel::FrontLeft,
        Wheel::FrontRight,
        Wheel::RearLeft,
        Wheel::RearRight,
    ];

    /// The number the thesis gives it, from 1.
    #[must_use]
    pub fn number(self) -> usize {
        match self {
            Wheel::FrontLeft => 1,
            Wheel::FrontRight => 2,
            Wheel::RearLeft => 3,
            Wheel::RearRight => 4,
        }
    }
}

impl fmt::Display for Wheel {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Wheel::FrontLeft => "front left",
            Wheel::FrontRight => "front right",
            Wheel::RearLeft => "rear left",
            Wheel::RearRight => "rear right",
        })
    }
}

/// How fast the wheels turn, in the order of [`Wheel::ALL`]; positive drives forward.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct WheelSpeeds(pub [RadPerSec; 4]);

impl WheelSpeeds {
    /// Standing still.
    pub const ZERO: WheelSpeeds = WheelSpeeds([RadPerSec(0.0); 4]);

    /// The speed of one wheel.
    #[must_use]
    pub fn of(&self, wheel: Wheel) -> RadPerSec {
        let [front_left, front_right, rear_left, rear_right] = self.0;
        match wheel {
            Wheel::FrontLeft => front_left,
            Wheel::FrontRight => front_right,
            Wheel::RearLeft => rear_left,
            Wheel::RearRight => rear_right,
        }
    }

    /// The fastest wheel, whichever way it turns; a speed that is not a number is the fastest.
    #[must_use]
    pub fn fastest(&self) -> (Wheel, RadPerSec) {
        let mut fastest = (Wheel::FrontLeft, self.of(Wheel::FrontLeft));
        for wheel in Wheel::ALL {
            let speed = self.of(wheel);
            if speed.0.is_nan() {
                return (wheel, speed);
            }
            if speed.abs() > fastest.1.abs() {
                fastest = (wheel, speed);
            }
        }
        fastest
    }

    /// How far the wheels turn in `time`.
    #[must_use]
    pub fn over(&self, time: Duration) -> WheelAngles {
        let seconds = time.as_secs_f64();
        WheelAngles(self.0.map(|speed| Radians(speed.0 * seconds)))
    }
}

/// How far the wheels have turned, in the order of [`Wheel::ALL`].
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct WheelAngles(pub [Radians; 4]);
