//! Stopping in front of obstacles. Not a safety function: scanners and emergency stop stay in the
//! hardware of the robot.

use std::time::Duration;

use units::{Millimeters, MmPerSec2};

use crate::pose::PlanarPose;
use crate::range::{OutOfRange, within};
use crate::shapes::{Footprint, Obstacle};
use crate::twist::BodyTwist;

const MIN_DISTANCE: Millimeters = Millimeters(0.0);
const MAX_DISTANCE: Millimeters = Millimeters(1e5);
const MIN_DECELERATION: MmPerSec2 = MmPerSec2(1.0);
const MAX_DECELERATION: MmPerSec2 = MmPerSec2(1e6);
/// A base that is this near to the stop distance stands.
const STANDSTILL: f64 = 0.1;
/// How often a step is shortened before it is given up.
const SHORTENINGS: u32 = 12;
/// How often all obstacles are asked.
const ROUNDS: u32 = 8;

/// The parameters of [`Guard`].
#[derive(Clone, Debug, PartialEq)]
pub struct GuardSettings {
    /// The outline of the base.
    pub footprint: Footprint,
    /// Nearer than this the base does not go.
    pub stop_distance: Millimeters,
    /// Once stopped by an obstacle, it goes on towards it when it is at least this far away.
    pub resume_distance: Millimeters,
    /// How it brakes in front of an obstacle.
    pub deceleration: MmPerSec2,
}

/// Watches the distance between the base and the obstacles.
#[derive(Clone, Debug, PartialEq)]
pub struct Guard {
    settings: GuardSettings,
    /// The obstacle that blocked the last step.
    stopped_by: Option<usize>,
}

/// How much of a motion the obstacles leave.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Passage {
    /// All of it.
    Free,
    /// This share of it, more than nothing.
    Slowed {
        /// Between 0 and 1.
        share: f64,
    },
    /// Nothing.
    Blocked(Blocked),
}

/// What stops the base.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Blocked {
    /// Which obstacle, from 0, in the order they were given.
    pub obstacle: usize,
    /// How far the base is from it.
    pub clearance: Millimeters,
}

impl Guard {
    /// A guard with these settings.
    ///
    /// # Errors
    /// A distance that is not from 0 to 100 m, a resume distance below the stop distance, or a
    /// deceleration that is not from 1 to 1,000,000 mm/s².
    pub fn try_new(settings: GuardSettings) -> Result<Guard, OutOfRange> {
        let stop = settings.stop_distance;
        let _ = within("stop distance", stop, MIN_DISTANCE, MAX_DISTANCE)?;
        let _ = within(
            "resume distance",
            settings.resume_distance,
            stop,
            MAX_DISTANCE,
        )?;
        let _ = within(
            "deceleration of the guard",
            settings.deceleration,
            MIN_DECELERATION,
            MAX_DECELERATION,
        )?;
        Ok(Guard {
            settings,
            stopped_by: None,
        })
    }

    /// The settings it was made from.
    #[must_use]
    pub fn settings(&self) -> &GuardSettings {
        &self.settings
    }

    /// How much of `twist` may be driven for `step`, so that the base can brake before the stop
    /// distance of each obstacle.
    ///
    /// A base inside of the stop distance may move away from the obstacle, and not along it if that
    /// takes it nearer. A base that touches an obstacle does not move at all. Clearances are looked
    /// at where the step begins and where it ends; no point of the base goes farther in one step
    /// than the clearance it began with.
    pub fn pass(
        &mut self,
        pose: PlanarPose,
        twist: &BodyTwist,
        step: Duration,
        obstacles: &[Obstacle],
    ) -> Passage {
        let mut share = 1.0;
        // What one obstacle leaves must be right for the others too, so they are asked again.
        for _ in 0..ROUNDS {
            let asked = share;
            for (number, obstacle) in obstacles.iter().enumerate() {
                let held = self.stopped_by == Some(number);
                match self.share_left(pose, &(*twist * share), step, (obstacle, held)) {
                    Ok(left) => share *= left,
                    Err(clearance) => return self.block(number, clearance),
                }
            }
            if share >= asked {
                break;
            }
        }
        self.stopped_by = None;
        if share < 1.0 {
            Passage::Slowed { share }
        } else {
            Passage::Free
        }
    }

    fn block(&mut self, obstacle: usize, clearance: Millimeters) -> Passage {
        self.stopped_by = Some(obstacle);
        Passage::Blocked(Blocked {
            obstacle,
            clearance,
        })
    }

    /// What blocked the last step; to be put back if the step is not driven.
    pub(crate) fn stopped_by(&self) -> Option<usize> {
        self.stopped_by
    }

    pub(crate) fn restore(&mut self, stopped_by: Option<usize>) {
        self.stopped_by = stopped_by;
    }

    /// The share that one obstacle leaves, or the clearance at which it leaves none.
    fn share_left(
        &self,
        pose: PlanarPose,
        twist: &BodyTwist,
        step: Duration,
        (obstacle, held): (&Obstacle, bool),
    ) -> Result<f64, Millimeters> {
        let footprint = &self.settings.footprint;
        let seconds = step.as_secs_f64();
        // No point of the base goes farther than this.
        let farthest = seconds * (twist.speed().0 + twist.turn.0.abs() * footprint.reach().0);
        let at_least = footprint.clearance_at_least(pose, obstacle);
        if at_least > self.settings.resume_distance.0 && farthest <= self.allowed(at_least, seconds)
        {
            return Ok(1.0);
        }
        let clearance = footprint.clearance(pose, obstacle);
        // No way, no question; and a touch cannot be judged, so it is not left by itself.
        if farthest <= 0.0 {
            return Ok(1.0);
        }
        if clearance.0 <= 0.0 {
            return Err(clearance);
        }
        let allowed = self.allowed(clearance.0, seconds);
        let mut share = (clearance.0 / farthest).min(1.0);
        for _ in 0..SHORTENINGS {
            // A step that leaves the range is refused by whoever drives it.
            let Ok(next) = pose.advanced(&(*twist * share), step) else {
                return Ok(1.0);
            };
            let nearer = clearance.0 - footprint.clearance(next, obstacle).0;
            if nearer <= 0.0 {
                return Ok(share);
            }
            if self.holds_back(clearance.0, held) {
                return Err(clearance);
            }
            if nearer <= allowed {
                return Ok(share);
            }
            // Clearance falls about evenly with the way, so one or two rounds do.
            share *= 0.999 * allowed / nearer;
        }
        Err(clearance)
    }

    /// Whether a base at this clearance may not come nearer.
    fn holds_back(&self, clearance: f64, held: bool) -> bool {
        let GuardSettings {
            stop_distance,
            resume_distance,
            ..
        } = self.settings;
        clearance - stop_distance.0 <= STANDSTILL || (held && clearance < resume_distance.0)
    }

    /// How much nearer the base may come in a step: as fast as it can brake from, and never past the
    /// stop distance.
    fn allowed(&self, clearance: f64, seconds: f64) -> f64 {
        let gap = clearance - self.settings.stop_distance.0;
        if gap <= 0.0 {
            return 0.0;
        }
        let speed = (2.0 * self.settings.deceleration.0 * gap).sqrt();
        (speed * seconds).min(gap)
    }
}
