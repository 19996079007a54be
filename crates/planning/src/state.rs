//! Where a joint is, and how it moves.

use std::fmt;

/// Position, velocity and acceleration of one joint: rad, rad/s, rad/s² (or mm, mm/s, mm/s²).
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct State {
    /// Where.
    pub position: f64,
    /// Its first derivative in time.
    pub velocity: f64,
    /// Its second derivative in time.
    pub acceleration: f64,
}

/// One of the three numbers of a [`State`].
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[expect(missing_docs, reason = "the names say it all")]
pub enum Part {
    Position,
    Velocity,
    Acceleration,
}

impl fmt::Display for Part {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Part::Position => "position",
            Part::Velocity => "velocity",
            Part::Acceleration => "acceleration",
        })
    }
}

/// A number of a state that is no number.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
#[error("the {part} is {value}; it must be a finite number")]
pub struct NotFinite {
    /// Which of the three.
    pub part: Part,
    /// What it was given.
    pub value: f64,
}

impl State {
    /// Standing still.
    #[must_use]
    pub fn at_rest(position: f64) -> State {
        State {
            position,
            ..State::default()
        }
    }

    /// Are all three finite numbers?
    ///
    /// # Errors
    /// Names the first that is not.
    pub fn check_finite(&self) -> Result<(), NotFinite> {
        let parts = [
            (Part::Position, self.position),
            (Part::Velocity, self.velocity),
            (Part::Acceleration, self.acceleration),
        ];
        parts.into_iter().try_for_each(|(part, value)| {
            if value.is_finite() {
                Ok(())
            } else {
                Err(NotFinite { part, value })
            }
        })
    }

    /// After `dt` seconds of constant `jerk`.
    pub(crate) fn after(self, dt: f64, jerk: f64) -> State {
        let (v, a) = (self.velocity, self.acceleration);
        State {
            position: self.position + dt * (v + dt * (0.5 * a + dt * jerk * (1.0 / 6.0))),
            velocity: v + dt * (a + 0.5 * dt * jerk),
            acceleration: a + dt * jerk,
        }
    }

    /// After how many seconds of constant `jerk` the position is reached. Within `most` seconds it is, and until then the
    /// velocity is not below zero.
    ///
    /// Newton's method between two times; halving where it would leave them.
    pub(crate) fn time_to(self, position: f64, jerk: f64, most: f64) -> f64 {
        let way = position - self.position;
        if way <= 0.0 {
            return 0.0;
        }
        let (mut low, mut high) = (0.0, most);
        let from_rest = (6.0 * way / jerk).cbrt();
        let mut time = if self.velocity > 0.0 || self.acceleration > 0.0 || from_rest.is_nan() {
            0.5 * most
        } else {
            from_rest.min(most)
        };
        for _ in 0..100 {
            let there = self.after(time, jerk);
            let miss = there.position - position;
            if miss < 0.0 {
                low = time;
            } else {
                high = time;
            }
            let newton = time - miss / there.velocity;
            let next = if newton > low && newton < high {
                newton
            } else {
                0.5 * (low + high)
            };
            if (next - time).abs() <= 2.0 * f64::EPSILON * most {
                return next;
            }
            time = next;
        }
        time
    }

    pub(crate) fn mirrored(self) -> State {
        State {
            position: -self.position,
            velocity: -self.velocity,
            acceleration: -self.acceleration,
        }
    }
}
