//! One number from rest to rest, in place of all joints: how far along its way a move is.
//!
//! What shares one progress stays on its way, whatever is done to the pace. The time of a joint move that is straight
//! in joint space, of a line and of a circle are planned so, with the limits of the way's slowest part.

use super::joint_move::MotionLimits;
use super::phases::Phases;
use super::side::{Side, Task};
use crate::state::State;

/// The shortest move along a way of a given length within velocity, acceleration and jerk, or one of a given duration.
///
/// All in closed form: the state at a time, and the time of a position but for the roots of one cubic. Braking mirrors
/// accelerating.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Progress {
    way: f64,
    /// What the move makes use of.
    limits: MotionLimits,
    phases: Phases,
    duration: f64,
}

impl Progress {
    /// The shortest move. `None` unless way and limits are finite and above zero.
    #[must_use]
    pub fn try_new(way: f64, limits: MotionLimits) -> Option<Progress> {
        let task = task(way, limits)?;
        let shortest = task.shortest_between_rests(way);
        Progress::lasting_exactly(way, limits, shortest)
    }

    /// The move over the same way that takes so many seconds: the farthest one within the same limits, made smaller as
    /// a whole, so that it accelerates as long as one that goes farther.
    ///
    /// # Errors
    /// The shortest time within the limits, if this one is shorter or no number.
    pub fn lasting(&self, seconds: f64) -> Result<Progress, f64> {
        let shortest = Progress::try_new(self.way, self.limits).map_or(0.0, |plan| plan.duration);
        // NaN is no longer than anything.
        if seconds >= shortest && seconds.is_finite() {
            Progress::lasting_exactly(self.way, self.limits, seconds).ok_or(shortest)
        } else {
            Err(shortest)
        }
    }

    /// Over the same way within the same limits, but for a highest velocity of this part of what it reaches now.
    #[must_use]
    pub fn slower(&self, part: f64) -> Option<Progress> {
        let velocity = self.peak() * part;
        Progress::try_new(
            self.way,
            MotionLimits {
                velocity,
                ..self.limits
            },
        )
    }

    /// The same move `factor` times slower at every place.
    #[must_use]
    pub fn stretched(&self, factor: f64) -> Option<Progress> {
        let limits = MotionLimits {
            velocity: self.limits.velocity / factor,
            acceleration: self.limits.acceleration / (factor * factor),
            jerk: self.limits.jerk / (factor * factor * factor),
        };
        Progress::lasting_exactly(self.way, limits, self.duration * factor)
    }

    fn lasting_exactly(way: f64, limits: MotionLimits, duration: f64) -> Option<Progress> {
        let task = task(way, limits)?;
        let phases = task.phases(&Side::new(task).shape_at(duration)?);
        // Exactly the way, apart from rounding, unless there is more time than needed.
        let share = way / phases.end(task.start, task.jerk).position;
        let usable = duration.is_finite() && share.is_finite() && share > 0.0;
        usable.then_some(Progress {
            way,
            limits: MotionLimits {
                velocity: limits.velocity * share,
                acceleration: limits.acceleration * share,
                jerk: limits.jerk * share,
            },
            phases,
            duration,
        })
    }

    /// How long the way is.
    #[must_use]
    pub fn way(&self) -> f64 {
        self.way
    }

    /// In seconds.
    #[must_use]
    pub fn duration(&self) -> f64 {
        self.duration
    }

    /// How long the move accelerates, and how long it brakes, in seconds.
    #[must_use]
    pub fn ramp(&self) -> f64 {
        let Phases([up, hold, down, ..]) = self.phases;
        // Without a cruise the third phase goes on into braking.
        (up + hold + down).min(0.5 * self.duration)
    }

    /// The highest velocity.
    #[must_use]
    pub fn peak(&self) -> f64 {
        self.at(0.5 * self.duration).velocity
    }

    /// The state `t` seconds after the start: before it at rest at 0, after the end at rest at the end.
    #[must_use]
    pub fn at(&self, t: f64) -> State {
        let left = self.duration - t;
        if t <= 0.0 {
            State::default()
        } else if left <= 0.0 {
            State::at_rest(self.way)
        } else if t <= left {
            self.phases.at(State::default(), self.limits.jerk, t)
        } else {
            let mirrored = self.phases.at(State::default(), self.limits.jerk, left);
            State {
                position: self.way - mirrored.position,
                velocity: mirrored.velocity,
                acceleration: -mirrored.acceleration,
            }
        }
    }

    /// How many seconds after the start the position is reached.
    #[must_use]
    pub fn reaches(&self, position: f64) -> f64 {
        if position <= 0.0 {
            return 0.0;
        }
        if position >= self.way {
            return self.duration;
        }
        if position > 0.5 * self.way {
            return self.duration - self.reaches(self.way - position);
        }
        let ramp = self.ramp();
        let on_ramp = self.at(ramp.min(0.5 * self.duration));
        if position <= on_ramp.position {
            self.phases
                .time_to(State::default(), self.limits.jerk, position)
        } else {
            ramp + (position - on_ramp.position) / on_ramp.velocity
        }
    }

    /// How long it would take to brake from the velocity that there is `t` seconds after the start, with the
    /// acceleration and the jerk of this move: in all, and for how much of that the acceleration changes at one end.
    #[must_use]
    pub fn braking(&self, t: f64) -> (f64, f64) {
        let MotionLimits {
            acceleration, jerk, ..
        } = self.limits;
        let (velocity, bend) = (self.at(t).velocity, acceleration / jerk);
        if velocity >= acceleration * bend {
            (velocity / acceleration + bend, bend)
        } else {
            let half = (velocity / jerk).sqrt();
            (2.0 * half, half)
        }
    }
}

fn task(way: f64, limits: MotionLimits) -> Option<Task> {
    let MotionLimits {
        velocity,
        acceleration,
        jerk,
    } = limits;
    let all = [way, velocity, acceleration, jerk];
    let usable = all.iter().all(|value| value.is_finite() && *value > 0.0);
    usable.then_some(Task {
        start: State::default(),
        goal: State::default(),
        velocity,
        acceleration,
        jerk,
    })
}
