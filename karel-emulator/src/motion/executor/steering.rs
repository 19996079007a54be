//! Override, hold, resume and stop: how the arm leaves its pace and comes back to it.

use std::time::Duration;

use kinematics::PendantJoints;

use super::super::path::INTERPOLATION_PERIOD_S;
use super::{Executor, MotionEnd, Outcome, Stance};

/// How hard the arm brakes, compared with the acceleration of its motion.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Brake {
    /// A controlled stop, along the path.
    Controlled,
    /// The drives have no power, the brakes stop the axes.
    PowerOff,
}

/// ASSUMPTION: brakes stop the arm twice as hard as its drives do, and it stays on its path.
fn brake_factor(brake: Brake) -> f64 {
    match brake {
        Brake::Controlled => 1.0,
        Brake::PowerOff => 2.0,
    }
}

impl<T: Clone> Executor<T> {
    /// Brakes on the path and stays there; motions that are added while `frozen` wait as well.
    pub fn hold(&mut self, now: Duration, frozen: bool, brake: Brake) {
        self.frozen |= frozen;
        let harder = self.stance == Stance::Holding && brake == Brake::PowerOff;
        if self.running.is_some() && (self.stance == Stance::Free || harder) {
            self.slow_down(now, brake);
            self.stance = Stance::Holding;
        }
    }

    /// Lets what was held go on along its path. The tag of the motion, if it was held.
    pub fn resume(&mut self, now: Duration) -> Option<&T> {
        self.frozen = false;
        if !self.is_held() {
            return None;
        }
        self.stance = Stance::Free;
        let slope = 1.0 / self.braking_time(now);
        self.tempo.change(now, self.wanted, slope);
        self.current().map(|motion| &motion.tag)
    }

    /// Changes the override to `rate` (0 to 1), in the middle of a motion if there is one.
    ///
    /// ASSUMPTION: the arm gets faster or slower with the acceleration of its motion.
    pub fn set_rate(&mut self, now: Duration, rate: f64) {
        self.wanted = rate;
        if self.running.is_some() && self.stance == Stance::Free {
            let slope = 1.0 / self.braking_time(now);
            self.tempo.change(now, rate, slope);
        }
    }

    /// Brakes on the path, ends what moves, and drops the pending motion, which is returned.
    pub fn stop(&mut self, now: Duration, brake: Brake) -> Option<MotionEnd<T>> {
        let ends = matches!(self.stance, Stance::Cancelling | Stance::Cancelled(..));
        if self.running.is_some() && !ends {
            self.slow_down(now, brake);
            self.stance = Stance::Cancelling;
        }
        let leg = self.pending.take()?;
        let joints = self.joints(now);
        Some(MotionEnd {
            motion: leg.motion,
            outcome: Outcome::Cancelled,
            at: now,
            started: None,
            joints,
        })
    }

    /// Puts the arm somewhere else, as a person with the pendant does. `false` while there is a motion.
    pub fn place(&mut self, joints: PendantJoints) -> bool {
        let free = self.running.is_none() && self.pending.is_none();
        if free {
            self.rest = joints;
        }
        free
    }

    fn slow_down(&mut self, now: Duration, brake: Brake) {
        let slope = brake_factor(brake) / self.braking_time(now);
        self.tempo.change(now, 0.0, slope);
    }

    /// How long the arm brakes from its full speed at this place, s.
    fn braking_time(&self, now: Duration) -> f64 {
        let time = self.tempo.time(now);
        let legs = [&self.running, &self.joining];
        let legs = legs.into_iter().flatten();
        let seconds: f64 = legs.map(|leg| leg.braking_time(time)).sum();
        seconds.max(INTERPOLATION_PERIOD_S)
    }
}
