//! The largest displacement of one joint in a given time: the pattern up, down, up.

use super::phases::Phases;
use crate::state::State;

/// Accelerations this far beyond where they should be, as a part of the limit, are rounding.
const ROUNDING: f64 = 1e-11;

/// What one joint has to do: from `start` (at position 0) to the velocity and acceleration of
/// `goal`.
#[derive(Clone, Copy, Debug)]
pub(super) struct Task {
    pub(super) start: State,
    pub(super) goal: State,
    pub(super) velocity: f64,
    pub(super) acceleration: f64,
    pub(super) jerk: f64,
}

/// Accelerations of a profile up to `peak`, held, down to `trough`, held, up; with a cruise on the
/// way down where the acceleration is zero.
#[derive(Clone, Copy, Debug)]
pub(super) struct Shape {
    pub(super) peak: f64,
    pub(super) peak_hold: f64,
    pub(super) trough: f64,
    pub(super) trough_hold: f64,
    pub(super) cruise: Option<f64>,
}

/// A [`Task`] with what its profiles have in common.
#[derive(Clone, Copy, Debug)]
pub(super) struct Side {
    pub(super) task: Task,
    /// `peak² + jerk (acceleration * peak_hold) - trough² - ..`: what the velocities ask for.
    pub(super) k: f64,
    capped: Shape,
    /// The time from which on the profile cruises at the highest velocity.
    pub(super) t_cruise: f64,
}

impl Task {
    pub(super) fn mirrored(&self) -> Task {
        Task {
            start: self.start.mirrored(),
            goal: self.goal.mirrored(),
            ..*self
        }
    }

    /// The phases of a shape that fits this task.
    pub(super) fn phases(&self, shape: &Shape) -> Phases {
        let (a0, af) = (self.start.acceleration, self.goal.acceleration);
        let per_jerk = 1.0 / self.jerk;
        let up = (shape.peak - a0) * per_jerk;
        let up_again = (af - shape.trough) * per_jerk;
        // A phase shorter than nothing is rounding, see `Side::fits`.
        let [down, down_again] = match shape.cruise {
            Some(_) => [shape.peak * per_jerk, -shape.trough * per_jerk],
            None => [(shape.peak - shape.trough) * per_jerk, 0.0],
        };
        Phases(
            [
                up,
                shape.peak_hold,
                down,
                shape.cruise.unwrap_or(0.0),
                down_again,
                shape.trough_hold,
                up_again,
            ]
            .map(|duration| duration.max(0.0)),
        )
    }

    pub(super) fn displacement(&self, shape: &Shape) -> f64 {
        self.phases(shape).end(self.start, self.jerk).position
    }

    pub(super) fn duration(&self, shape: &Shape) -> f64 {
        let ways = 2.0 * (shape.peak - shape.trough);
        let ends = self.goal.acceleration - self.start.acceleration;
        (ways + ends) / self.jerk
            + shape.peak_hold
            + shape.trough_hold
            + shape.cruise.unwrap_or(0.0)
    }
}

impl Task {
    /// Does the joint rest before and after?
    pub(super) fn is_from_rest_to_rest(&self) -> bool {
        let State {
            velocity,
            acceleration,
            ..
        } = self.start;
        let parts = [
            velocity,
            acceleration,
            self.goal.velocity,
            self.goal.acceleration,
        ];
        parts.iter().all(|part| *part == 0.0)
    }

    /// The shortest time from rest to rest over `way`, which is not negative: with `v`, `a`, `j`
    /// reached or not.
    pub(super) fn shortest_between_rests(&self, way: f64) -> f64 {
        let (v, a, j) = (self.velocity, self.acceleration, self.jerk);
        // The least velocity that needs the whole acceleration.
        let bend = a * a / j;
        if way <= 2.0 * bend.min(v) * (bend.min(v) / j).sqrt() {
            return (32.0 * way / j).cbrt();
        }
        if v <= bend {
            return way / v + 2.0 * (v / j).sqrt();
        }
        if way >= v * (v / a + a / j) {
            return way / v + v / a + a / j;
        }
        // The highest velocity V of way = V (V / a + a / j).
        let highest = 0.5 * ((bend * bend + 4.0 * way * a).sqrt() - bend);
        2.0 * (highest / a + a / j)
    }
}

impl Side {
    pub(super) fn new(task: Task) -> Side {
        let (a0, v0) = (task.start.acceleration, task.start.velocity);
        let (af, vf) = (task.goal.acceleration, task.goal.velocity);
        let (limit, j) = (task.acceleration, task.jerk);
        let held = |square: f64| {
            // The way to or from the highest velocity, held at the limit if that is reached.
            let square = square.max(0.0);
            if square > limit * limit {
                (limit, (square - limit * limit) / (j * limit))
            } else {
                (square.sqrt(), 0.0)
            }
        };
        let (peak, peak_hold) = held(j * (task.velocity - v0) + 0.5 * a0 * a0);
        let (depth, trough_hold) = held(j * (task.velocity - vf) + 0.5 * af * af);
        let capped = Shape {
            peak,
            peak_hold,
            trough: -depth,
            trough_hold,
            cruise: Some(0.0),
        };
        Side {
            task,
            k: j * (vf - v0) + 0.5 * (a0 * a0 - af * af),
            capped,
            t_cruise: task.duration(&capped),
        }
    }

    /// How far the joint gets before it begins to cruise.
    pub(super) fn d_cruise(&self) -> f64 {
        self.task.displacement(&self.capped)
    }

    /// Half of what the accelerations go through in the time `t`: `peak - trough` and the holds.
    pub(super) fn way(&self, t: f64) -> f64 {
        let Task {
            start, goal, jerk, ..
        } = &self.task;
        0.5 * (jerk * t + start.acceleration - goal.acceleration)
    }

    /// The inverse of [`Self::way`].
    pub(super) fn time_of_way(&self, way: f64) -> f64 {
        let Task {
            start, goal, jerk, ..
        } = &self.task;
        (2.0 * way - start.acceleration + goal.acceleration) / jerk
    }

    /// The profile that gets farthest in the time `t`; `None` if no profile lasts so long.
    pub(super) fn shape_at(&self, t: f64) -> Option<Shape> {
        if t >= self.t_cruise {
            return Some(Shape {
                cruise: Some(t - self.t_cruise),
                ..self.capped
            });
        }
        let way = self.way(t);
        if way <= 0.0 {
            return None;
        }
        let sum = self.k / way;
        let (peak, trough) = (0.5 * (sum + way), 0.5 * (sum - way));
        let limit = self.task.acceleration;
        let shape = if peak <= limit && trough >= -limit {
            Shape {
                peak,
                peak_hold: 0.0,
                trough,
                trough_hold: 0.0,
                cruise: None,
            }
        } else {
            self.held(way, peak > limit)?
        };
        self.fits(&shape).then_some(shape)
    }

    /// With the acceleration at its limit for a while.
    fn held(&self, way: f64, at_the_peak: bool) -> Option<Shape> {
        let (limit, j) = (self.task.acceleration, self.task.jerk);
        let root = |k: f64| (2.0 * way * limit - k).max(0.0).sqrt();
        if at_the_peak {
            let trough = limit - root(self.k);
            let peak_hold = 2.0 * (way - limit + trough) / j;
            if trough >= -limit && peak_hold >= 0.0 {
                return Some(Shape {
                    peak: limit,
                    peak_hold,
                    trough,
                    trough_hold: 0.0,
                    cruise: None,
                });
            }
        }
        let peak = root(-self.k) - limit;
        let trough_hold = 2.0 * (way - limit - peak) / j;
        if peak <= limit && trough_hold >= 0.0 {
            return Some(Shape {
                peak,
                peak_hold: 0.0,
                trough: -limit,
                trough_hold,
                cruise: None,
            });
        }
        // Both: the holds' sum is given by the time, their difference by the velocities.
        let (sum, difference) = (2.0 * way - 4.0 * limit, self.k / limit);
        let (peak_hold, trough_hold) = (0.5 * (sum + difference) / j, 0.5 * (sum - difference) / j);
        (peak_hold >= 0.0 && trough_hold >= 0.0).then_some(Shape {
            peak: limit,
            peak_hold,
            trough: -limit,
            trough_hold,
            cruise: None,
        })
    }

    /// Do all phases go the right way?
    fn fits(&self, shape: &Shape) -> bool {
        let slack = ROUNDING * self.task.acceleration;
        shape.peak >= self.task.start.acceleration - slack
            && shape.trough <= self.task.goal.acceleration + slack
    }

    /// `(displacement, its derivative in the time)` of the profile that gets farthest.
    pub(super) fn reach(&self, t: f64) -> Option<(f64, f64)> {
        let shape = self.shape_at(t)?;
        Some((self.task.displacement(&shape), self.slope(&shape)))
    }

    /// How much farther the joint gets for each second more: the highest velocity (of the parabola
    /// on the way down), and what the steeper acceleration gains.
    pub(super) fn slope(&self, shape: &Shape) -> f64 {
        if shape.cruise.is_some() {
            return self.task.velocity;
        }
        let (
            State {
                velocity,
                acceleration,
                ..
            },
            j,
        ) = (self.task.start, self.task.jerk);
        let peak = shape.peak;
        velocity - 0.5 * acceleration * acceleration / j
            + peak * (peak / j + shape.peak_hold - 0.5 * shape.trough / j)
    }
}
