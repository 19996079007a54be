//! From one speed to another.

use crate::state::State;

/// The shortest change of the velocity within acceleration and jerk; the position is where that leads.
///
/// The acceleration goes to its peak, is held there and goes back to zero: with `a0` at the start, in the direction of
/// the change, the peak is `sqrt(j dv + a0² / 2)`, or the limit.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SpeedChange {
    start: State,
    /// Duration and jerk.
    phases: [(f64, f64); 3],
    /// Exactly at the new velocity.
    end: State,
    duration: f64,
}

impl SpeedChange {
    /// From `start` to `velocity`, with at most this acceleration and this jerk, both above zero. A start that
    /// accelerates more than that is brought inside.
    #[must_use]
    pub fn new(start: State, velocity: f64, acceleration: f64, jerk: f64) -> SpeedChange {
        // What the velocity becomes if the acceleration only goes to zero.
        let entailed = start.velocity + 0.5 * start.acceleration * start.acceleration.abs() / jerk;
        let sign = if velocity >= entailed { 1.0 } else { -1.0 };
        let (change, a0) = (
            sign * (velocity - start.velocity),
            sign * start.acceleration,
        );
        let free = (jerk * change + 0.5 * a0 * a0).max(0.0).sqrt();
        let peak = free.min(acceleration).max(0.0);
        let (first, last) = ((peak - a0) / jerk, peak / jerk);
        let on_ramps = 0.5 * (first.abs() * (peak + a0) + last * peak);
        let hold = if peak > 0.0 {
            ((change - on_ramps) / peak).max(0.0)
        } else {
            0.0
        };
        let upward = if first >= 0.0 { jerk } else { -jerk };
        let phases = [
            (first.abs(), sign * upward),
            (hold, 0.0),
            (last, -sign * jerk),
        ];
        let mut end = start;
        for (duration, jerk) in phases {
            end = end.after(duration, jerk);
        }
        SpeedChange {
            start,
            phases,
            end: State {
                position: end.position,
                velocity,
                acceleration: 0.0,
            },
            duration: phases.iter().map(|(duration, _)| duration).sum(),
        }
    }

    /// No change.
    #[must_use]
    pub fn steady(position: f64, velocity: f64) -> SpeedChange {
        let state = State {
            position,
            velocity,
            acceleration: 0.0,
        };
        SpeedChange {
            start: state,
            phases: [(0.0, 0.0); 3],
            end: state,
            duration: 0.0,
        }
    }

    /// In seconds; the new velocity lasts from then on.
    #[must_use]
    pub fn duration(&self) -> f64 {
        self.duration
    }

    /// The velocity that it changes to.
    #[must_use]
    pub fn target(&self) -> f64 {
        self.end.velocity
    }

    /// The state `t` seconds after the start, which is where it begins.
    #[must_use]
    pub fn at(&self, t: f64) -> State {
        if t >= self.duration {
            return self.end.after(t - self.duration, 0.0);
        }
        let (mut state, mut left) = (self.start, t.max(0.0));
        for (duration, jerk) in self.phases {
            if left < duration {
                return state.after(left, jerk);
            }
            state = state.after(duration, jerk);
            left -= duration;
        }
        self.end
    }

    /// How many seconds after the start the position is reached, if no velocity on the way is below zero. `None` if it
    /// stops before.
    #[must_use]
    pub fn reaches(&self, position: f64) -> Option<f64> {
        let (mut state, mut before) = (self.start, 0.0);
        for (duration, jerk) in self.phases {
            let next = state.after(duration, jerk);
            if position <= next.position {
                return Some(before + state.time_to(position, jerk, duration));
            }
            state = next;
            before += duration;
        }
        let left = position - self.end.position;
        if left <= 0.0 {
            Some(self.duration)
        } else if self.end.velocity > 0.0 {
            Some(self.duration + left / self.end.velocity)
        } else {
            None
        }
    }
}
