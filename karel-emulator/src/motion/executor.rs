//! The motion that runs, the one that waits behind it, and where the arm is at any time.

use std::time::Duration;

use kinematics::PendantJoints;

use super::duration_from_secs_rounded_up;
use super::path::Path;

/// A planned motion with whatever its owner wants back when it ends.
#[derive(Clone, Debug)]
pub struct Motion<T> {
    /// Where to and how fast.
    pub path: Path,
    /// The owner's notes: id, program, peer.
    pub tag: T,
}

/// How a motion ended.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Outcome {
    /// At the target and standing still.
    Finished,
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
    /// When the arm stood still.
    pub at: Duration,
    /// When it began to move; `None` if it never did.
    pub started: Option<Duration>,
    /// Where the arm stood still.
    pub joints: PendantJoints,
}

/// One running motion and at most one pending, as on a controller.
///
/// The general override scales the rate of path time: half the override, half the speed on the same path. A change
/// takes effect at once, in the middle of a motion. ASSUMPTION: a real controller blends over a few periods.
#[derive(Debug)]
pub struct Executor<T> {
    rest: PendantJoints,
    rate: f64,
    /// Whether motions that are added wait for [`Executor::resume`].
    frozen: bool,
    running: Option<Running<T>>,
    pending: Option<Motion<T>>,
}

#[derive(Debug)]
struct Running<T> {
    motion: Motion<T>,
    started: Duration,
    phase: Phase,
}

#[derive(Clone, Copy, Debug)]
enum Phase {
    /// Path time `path_s` was reached at `since`.
    Traveling { since: Duration, path_s: f64 },
    /// Braking on the path from `progress`, with `rate` (1/s) falling by `slope` (1/s²).
    Stopping {
        since: Duration,
        progress: f64,
        rate: f64,
        slope: f64,
        then: Then,
    },
    /// Standing still on the path, until it goes on.
    Held { progress: f64 },
}

/// What follows when the arm has come to rest.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Then {
    /// The motion is over.
    Cancel,
    /// It waits where it is.
    Hold,
    /// It goes on at once: somebody held it and changed their mind while it braked.
    GoOn,
}

impl<T> Running<T> {
    /// Whether its time is that of its end, and not of a hold.
    fn ends(&self) -> bool {
        match self.phase {
            Phase::Traveling { .. } => true,
            Phase::Stopping { then, .. } => then == Then::Cancel,
            Phase::Held { .. } => false,
        }
    }

    fn is_cancelled(&self) -> bool {
        matches!(
            self.phase,
            Phase::Stopping {
                then: Then::Cancel,
                ..
            }
        )
    }
}

impl<T> Executor<T> {
    /// An arm that stands still at `rest`, at an override of `rate` (0 to 1).
    #[must_use]
    pub fn new(rest: PendantJoints, rate: f64) -> Self {
        Self {
            rest,
            rate,
            frozen: false,
            running: None,
            pending: None,
        }
    }

    /// Whether another motion may be added.
    #[must_use]
    pub fn has_room(&self) -> bool {
        self.pending.is_none() && !self.is_stopping()
    }

    /// Whether the arm moves.
    #[must_use]
    pub fn is_moving(&self) -> bool {
        self.running
            .as_ref()
            .is_some_and(|running| !matches!(running.phase, Phase::Held { .. }))
    }

    /// Whether a motion is held, or brakes to be held.
    #[must_use]
    pub fn is_held(&self) -> bool {
        self.running.as_ref().is_some_and(|running| {
            let braking = matches!(
                running.phase,
                Phase::Stopping {
                    then: Then::Hold,
                    ..
                }
            );
            braking || matches!(running.phase, Phase::Held { .. })
        })
    }

    /// Motions running and pending: 0 to 2.
    #[must_use]
    pub fn queued(&self) -> usize {
        usize::from(self.running.is_some()) + usize::from(self.pending.is_some())
    }

    /// Where a motion added now would start.
    #[must_use]
    pub fn tail(&self) -> PendantJoints {
        self.pending
            .as_ref()
            .or(self.running.as_ref().map(|r| &r.motion))
            .map_or(self.rest, |motion| *motion.path.to())
    }

    /// Where the arm is at `now`.
    #[must_use]
    pub fn joints(&self, now: Duration) -> PendantJoints {
        self.running.as_ref().map_or(self.rest, |running| {
            running.motion.path.at(self.progress(running, now))
        })
    }

    /// The motion the arm is on.
    #[must_use]
    pub fn current(&self) -> Option<&Motion<T>> {
        self.running.as_ref().map(|running| &running.motion)
    }

    /// Adds a motion: it starts at once, waits for its turn, or finds no room and is dropped.
    pub fn add(&mut self, now: Duration, motion: Motion<T>) -> Added {
        if !self.has_room() {
            return Added::NoRoom;
        }
        if self.running.is_some() {
            self.pending = Some(motion);
            return Added::Waits;
        }
        let _tag = self.start(now, motion);
        Added::Started
    }

    /// When the running motion ends, at the present override. Never, at an override of 0.
    #[must_use]
    pub fn next_end(&self) -> Option<Duration> {
        let running = self.running.as_ref()?;
        let (since, seconds) = match running.phase {
            Phase::Traveling { .. } if self.rate <= 0.0 => return None,
            Phase::Traveling { since, path_s } => {
                (since, (running.motion.path.duration() - path_s) / self.rate)
            }
            Phase::Stopping {
                since, rate, slope, ..
            } => (since, rate / slope),
            Phase::Held { .. } => return None,
        };
        Some(since.saturating_add(duration_from_secs_rounded_up(seconds)))
    }

    /// Ends the running motion if its time has come, and starts the pending one in its place.
    ///
    /// The second value is the tag of the motion that started. Call again until it answers `None`.
    pub fn end_due(&mut self, now: Duration) -> Option<(MotionEnd<T>, Option<&T>)> {
        let at = self.next_end().filter(|&at| at <= now)?;
        if !self.running.as_ref()?.ends() {
            return None;
        }
        let running = self.running.take()?;
        let (outcome, joints) = match running.phase {
            Phase::Traveling { .. } => (Outcome::Finished, *running.motion.path.to()),
            Phase::Stopping { .. } | Phase::Held { .. } => (
                Outcome::Cancelled,
                running.motion.path.at(self.progress(&running, at)),
            ),
        };
        self.rest = joints;
        let end = MotionEnd {
            motion: running.motion,
            outcome,
            at,
            started: Some(running.started),
            joints,
        };
        let next = self.pending.take();
        let started = next.map(|motion| self.start(at, motion));
        Some((end, started))
    }

    /// Puts the arm somewhere else, as a person with the pendant does. `false` while there is a motion.
    pub fn place(&mut self, joints: PendantJoints) -> bool {
        let free = self.running.is_none() && self.pending.is_none();
        if free {
            self.rest = joints;
        }
        free
    }

    /// Brakes on the path and stays there; motions that are added while `frozen` wait as well.
    pub fn hold(&mut self, now: Duration, frozen: bool) {
        self.frozen |= frozen;
        let phase = self.braking(now, Then::Hold);
        if let Some(running) = &mut self.running
            && let Some(phase) = phase
        {
            running.phase = phase;
        }
    }

    /// Lets what was held go on along its path. The tag of the motion, if it starts to move now.
    pub fn resume(&mut self, now: Duration) -> Option<&T> {
        self.frozen = false;
        let running = self.running.as_mut()?;
        match &mut running.phase {
            Phase::Stopping { then, .. } => {
                if *then == Then::Hold {
                    *then = Then::GoOn;
                }
                None
            }
            Phase::Held { progress } => {
                running.motion.path = running.motion.path.remaining(*progress);
                running.phase = Phase::Traveling {
                    since: now,
                    path_s: 0.0,
                };
                Some(&running.motion.tag)
            }
            Phase::Traveling { .. } => None,
        }
    }

    /// Brings a motion that brakes to be held to its rest, if its time has come. Its tag, and whether it stays there.
    pub fn hold_due(&mut self, now: Duration) -> Option<(&T, bool)> {
        let at = self.next_end().filter(|&at| at <= now)?;
        let progress = self.progress(self.running.as_ref()?, at);
        let running = self.running.as_mut()?;
        let Phase::Stopping { then, .. } = running.phase else {
            return None;
        };
        match then {
            Then::Cancel => None,
            Then::Hold => {
                running.phase = Phase::Held { progress };
                Some((&running.motion.tag, true))
            }
            Then::GoOn => {
                running.motion.path = running.motion.path.remaining(progress);
                running.phase = Phase::Traveling {
                    since: at,
                    path_s: 0.0,
                };
                Some((&running.motion.tag, false))
            }
        }
    }

    /// How the running motion brakes from now on; `None` if nothing runs.
    fn braking(&self, now: Duration, then: Then) -> Option<Phase> {
        let running = self.running.as_ref()?;
        Some(match running.phase {
            Phase::Traveling { since, path_s } => {
                let path_s = path_s + seconds_between(since, now) * self.rate;
                let path = &running.motion.path;
                let (rate, slope) = path.braking(path_s).unwrap_or((0.0, 1.0));
                Phase::Stopping {
                    since: now,
                    progress: path.progress(path_s),
                    rate: rate * self.rate,
                    slope,
                    then,
                }
            }
            Phase::Stopping {
                since,
                progress,
                rate,
                slope,
                then: before,
            } => Phase::Stopping {
                since,
                progress,
                rate,
                slope,
                then: if before == Then::Cancel { before } else { then },
            },
            Phase::Held { progress } if then == Then::Cancel => Phase::Stopping {
                since: now,
                progress,
                rate: 0.0,
                slope: 1.0,
                then,
            },
            held @ Phase::Held { .. } => held,
        })
    }

    /// Changes the override to `rate` (0 to 1) at `now`, in the middle of a motion if there is one.
    pub fn set_rate(&mut self, now: Duration, rate: f64) {
        if let Some(running) = &mut self.running
            && let Phase::Traveling { since, path_s } = running.phase
        {
            let path_s = path_s + seconds_between(since, now) * self.rate;
            running.phase = Phase::Traveling { since: now, path_s };
        }
        self.rate = rate;
    }

    /// Brakes on the path, with the acceleration of the motion, and drops the pending motion, which is returned.
    pub fn stop(&mut self, now: Duration) -> Option<MotionEnd<T>> {
        let phase = self.braking(now, Then::Cancel);
        if let Some(running) = &mut self.running
            && let Some(phase) = phase
        {
            running.phase = phase;
        }
        let motion = self.pending.take()?;
        let joints = self.joints(now);
        Some(MotionEnd {
            motion,
            outcome: Outcome::Cancelled,
            at: now,
            started: None,
            joints,
        })
    }

    fn is_stopping(&self) -> bool {
        self.running.as_ref().is_some_and(|r| r.is_cancelled())
    }

    fn start(&mut self, now: Duration, motion: Motion<T>) -> &T {
        let phase = if self.frozen {
            Phase::Held { progress: 0.0 }
        } else {
            Phase::Traveling {
                since: now,
                path_s: 0.0,
            }
        };
        let running = self.running.insert(Running {
            motion,
            started: now,
            phase,
        });
        &running.motion.tag
    }

    fn progress(&self, running: &Running<T>, now: Duration) -> f64 {
        match running.phase {
            Phase::Traveling { since, path_s } => running
                .motion
                .path
                .progress(path_s + seconds_between(since, now) * self.rate),
            Phase::Held { progress } => progress,
            Phase::Stopping {
                since,
                progress,
                rate,
                slope,
                ..
            } => {
                let t = seconds_between(since, now).min(rate / slope);
                (progress + rate * t - 0.5 * slope * t * t).min(1.0)
            }
        }
    }
}

fn seconds_between(earlier: Duration, later: Duration) -> f64 {
    later.saturating_sub(earlier).as_secs_f64()
}

#[cfg(test)]
#[path = "executor_tests.rs"]
mod tests;
