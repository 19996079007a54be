//! Override, hold, resume and stop: how the arm leaves its pace and comes back to it.

use std::time::Duration;

use kinematics::PendantJoints;

use super::super::path::INTERPOLATION_PERIOD_S;
use super::super::tempo::Agility;
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
        self.tempo.change(now, self.wanted, self.agility(now, 1.0));
        self.current().map(|motion| &motion.tag)
    }

    /// Changes the override to `rate` (0 to 1), in the middle of a motion if there is one.
    ///
    /// ASSUMPTION: the arm gets faster or slower with the acceleration and the jerk of its motion.
    pub fn set_rate(&mut self, now: Duration, rate: f64) {
        self.wanted = rate;
        if self.running.is_some() && self.stance == Stance::Free {
            self.tempo.change(now, rate, self.agility(now, 1.0));
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
        let agility = self.agility(now, brake_factor(brake));
        self.tempo.change(now, 0.0, agility);
    }

    /// How long the arm brakes from its full speed at this place, so many times as hard as it accelerates.
    fn agility(&self, now: Duration, factor: f64) -> Agility {
        let time = self.tempo.time(now);
        let legs = [&self.running, &self.joining];
        let legs = legs.into_iter().flatten().map(|leg| leg.braking(time));
        let (seconds, bend) = legs.fold((0.0, 0.0), |(a, b), (c, d)| (a + c, b + d));
        if seconds < INTERPOLATION_PERIOD_S {
            let seconds = INTERPOLATION_PERIOD_S / factor;
            let bend = 0.5 * seconds;
            return Agility { seconds, bend };
        }
        Agility {
            seconds: seconds / factor,
            bend: bend / factor,
        }
    }
}
