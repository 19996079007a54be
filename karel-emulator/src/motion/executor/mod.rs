//! The motions that run, the one that waits behind them, and where the arm is at any time.

mod leg;
mod steering;

use std::time::Duration;

use kinematics::PendantJoints;

use super::corner::Blend;
use super::path::Path;
use super::tempo::Tempo;
use leg::Leg;
pub use leg::Motion;
pub use steering::Brake;

/// How a motion ended.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Outcome {
    /// At the target and standing still.
    Finished,
    /// Around the corner: the next motion has taken over.
    Passed,
    /// Stopped before the target, or never started.
    Cancelled,
}

/// What became of a motion that was added.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[must_use]
pub enum Added {
    /// The arm moves.
    Started,
    /// It waits behind the running motion.
    Waits,
    /// One waits already, or the arm is being stopped; see [`Executor::has_room`].
    NoRoom,
}

/// A motion that is over.
#[derive(Clone, Debug)]
pub struct MotionEnd<T> {
    /// The motion.
    pub motion: Motion<T>,
    /// How it ended.
    pub outcome: Outcome,
    /// When the arm stood still, or had gone around the corner.
    pub at: Duration,
    /// When it began to move; `None` if it never did.
    pub started: Option<Duration>,
    /// Where the arm was then.
    pub joints: PendantJoints,
}

/// Something that happened to a motion.
#[derive(Clone, Debug)]
pub enum Happening<T> {
    /// It waited, and moves the arm now.
    Started(T),
    /// The program that waits for it goes on; the arm is about to go around the corner.
    Passes(T),
    /// The arm has come to rest where it was held.
    Held(T),
    /// It is over.
    Ended(Box<MotionEnd<T>>),
}

/// One running motion, one that joins it around a corner, and at most one pending.
///
/// The general override scales the rate of path time: half the override, half the speed on the same path. The rate
/// changes as fast as the motion accelerates, and so it does for a hold, a stop and what goes on after them.
#[derive(Debug)]
pub struct Executor<T> {
    rest: PendantJoints,
    /// The override, 0 to 1.
    wanted: f64,
    /// Whether motions that are added wait for [`Executor::resume`].
    frozen: bool,
    tempo: Tempo,
    stance: Stance,
    running: Option<Leg<T>>,
    /// Started on top of the end of the running one.
    joining: Option<Leg<T>>,
    pending: Option<Leg<T>>,
}

/// What was decided from outside about the arm.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Stance {
    /// It goes on.
    Free,
    /// It brakes and waits then.
    Holding,
    /// It stands still on its path.
    Held,
    /// It brakes, and its motions are over then.
    Cancelling,
    /// It stands still here, and its motions are over.
    Cancelled(PendantJoints, Duration),
}

/// What comes next on the way.
#[derive(Clone, Copy, Debug)]
enum Next {
    Pass,
    End,
    Start,
}

impl<T: Clone> Executor<T> {
    /// An arm that stands still at `rest`, at an override of `rate` (0 to 1).
    #[must_use]
    pub fn new(rest: PendantJoints, rate: f64) -> Self {
        Self {
            rest,
            wanted: rate,
            frozen: false,
            tempo: Tempo::new(Duration::ZERO, rate),
            stance: Stance::Free,
            running: None,
            joining: None,
            pending: None,
        }
    }

    /// Whether another motion may be added.
    #[must_use]
    pub fn has_room(&self) -> bool {
        let stopping = matches!(self.stance, Stance::Cancelling | Stance::Cancelled(..));
        self.pending.is_none() && !stopping
    }

    /// Whether the arm moves.
    #[must_use]
    pub fn is_moving(&self) -> bool {
        self.running.is_some() && self.stance != Stance::Held
    }

    /// Whether a motion is held, or brakes to be held.
    #[must_use]
    pub fn is_held(&self) -> bool {
        matches!(self.stance, Stance::Holding | Stance::Held)
    }

    /// Motions running and pending: 0 to 3.
    #[must_use]
    pub fn queued(&self) -> usize {
        let legs = [&self.running, &self.joining, &self.pending];
        legs.into_iter().flatten().count()
    }

    /// Where a motion added now would start.
    #[must_use]
    pub fn tail(&self) -> PendantJoints {
        let last = self.pending.as_ref().or(self.last_moving());
        last.map_or(self.rest, |leg| *leg.motion.path.to())
    }

    /// Where the arm is at `now`.
    #[must_use]
    pub fn joints(&self, now: Duration) -> PendantJoints {
        if let Stance::Cancelled(joints, _) = self.stance {
            return joints;
        }
        let time = self.tempo.time(now);
        match (&self.running, &self.joining) {
            (None, _) => self.rest,
            (Some(running), Some(joining)) => joining.around(running, time),
            (Some(running), None) => running.at(time),
        }
    }

    /// The motion the arm is on.
    #[must_use]
    pub fn current(&self) -> Option<&Motion<T>> {
        self.last_moving().map(|leg| &leg.motion)
    }

    /// The present rate of path time: what the override makes of it, less while it brakes.
    #[must_use]
    pub fn rate(&self, now: Duration) -> f64 {
        self.tempo.rate(now)
    }

    /// Adds a motion: it starts at once, waits for its turn, or finds no room and is dropped. `round` plans the way
    /// around the corner before it, if there is one to be rounded.
    pub fn add(
        &mut self,
        now: Duration,
        motion: Motion<T>,
        round: impl FnOnce(&Path, &Path, f64) -> Option<Blend>,
    ) -> Added {
        if !self.has_room() {
            return Added::NoRoom;
        }
        let time = self.tempo.time(now);
        let Some(before) = self.last_moving() else {
            let rate = if self.frozen { 0.0 } else { self.wanted };
            self.tempo = Tempo::new(now, rate);
            if self.frozen {
                self.stance = Stance::Held;
            }
            self.running = Some(Leg::first(motion, now));
            return Added::Started;
        };
        let mut leg = Leg::behind(before, motion, time, round);
        if leg.begin <= time && self.joining.is_none() && leg.begin < before.end() {
            leg.started = now;
            self.joining = Some(leg);
            return Added::Started;
        }
        self.pending = Some(leg);
        Added::Waits
    }

    /// When something happens next, at the present override. Never, at an override of 0.
    #[must_use]
    pub fn next_due(&self) -> Option<Duration> {
        if let Stance::Cancelled(_, at) = self.stance {
            return Some(at);
        }
        let rests = match self.stance {
            Stance::Holding | Stance::Cancelling => self.tempo.rests(),
            Stance::Free | Stance::Held | Stance::Cancelled(..) => None,
        };
        let next = self.next_on_the_way();
        let next = next.and_then(|(time, _)| self.tempo.reaches(time));
        [rests, next].into_iter().flatten().min()
    }

    /// What happened up to `now`, one thing at a time, oldest first. Call again until it answers `None`.
    pub fn due(&mut self, now: Duration) -> Option<Happening<T>> {
        let at = self.next_due().filter(|&at| at <= now)?;
        match self.stance {
            Stance::Cancelled(joints, at) => return self.cancel_next(joints, at),
            Stance::Holding if self.tempo.rests() == Some(at) => {
                self.stance = Stance::Held;
                return self
                    .current()
                    .map(|motion| Happening::Held(motion.tag.clone()));
            }
            Stance::Cancelling if self.tempo.rests() == Some(at) => {
                let joints = self.joints(at);
                return self.cancel_next(joints, at);
            }
            Stance::Free | Stance::Holding | Stance::Held | Stance::Cancelling => {}
        }
        match self.next_on_the_way()?.1 {
            Next::Pass => {
                let leg = self.running.as_mut()?;
                leg.passed = true;
                Some(Happening::Passes(leg.motion.tag.clone()))
            }
            Next::Start => {
                let mut leg = self.pending.take()?;
                leg.started = at;
                let tag = leg.motion.tag.clone();
                let place = if self.running.is_some() {
                    &mut self.joining
                } else {
                    &mut self.running
                };
                *place = Some(leg);
                Some(Happening::Started(tag))
            }
            Next::End => self.end_running(at),
        }
    }

    fn end_running(&mut self, at: Duration) -> Option<Happening<T>> {
        let rounded = self.joining.is_some();
        let joints = self.joints(at);
        let leg = self.running.take()?;
        self.running = self.joining.take();
        let (outcome, joints) = if rounded {
            (Outcome::Passed, joints)
        } else {
            (Outcome::Finished, *leg.motion.path.to())
        };
        self.rest = joints;
        if self.running.is_none() && self.pending.is_none() {
            self.stance = Stance::Free;
        }
        Some(ended(leg, outcome, at, joints))
    }

    /// The arm stands still for good: one motion after the other is over.
    fn cancel_next(&mut self, joints: PendantJoints, at: Duration) -> Option<Happening<T>> {
        let leg = self.running.take()?;
        self.rest = joints;
        self.running = self.joining.take();
        self.stance = match self.running {
            Some(_) => Stance::Cancelled(joints, at),
            None => Stance::Free,
        };
        Some(ended(leg, Outcome::Cancelled, at, joints))
    }

    fn last_moving(&self) -> Option<&Leg<T>> {
        self.joining.as_ref().or(self.running.as_ref())
    }

    /// With its path time.
    fn next_on_the_way(&self) -> Option<(f64, Next)> {
        let start = self.pending.as_ref().map(|leg| (leg.begin, Next::Start));
        let Some(running) = &self.running else {
            return start;
        };
        let pass = running.pass().filter(|_| !running.passed);
        let pass = pass.map(|time| (time, Next::Pass));
        let end = Some((running.end(), Next::End));
        let all = [pass, end, start].into_iter().flatten();
        // The first of those at the same time.
        all.reduce(|first, other| if other.0 < first.0 { other } else { first })
    }
}

fn ended<T>(leg: Leg<T>, outcome: Outcome, at: Duration, joints: PendantJoints) -> Happening<T> {
    Happening::Ended(Box::new(MotionEnd {
        motion: leg.motion,
        outcome,
        at,
        started: Some(leg.started),
        joints,
    }))
}

#[cfg(test)]
mod tests;
