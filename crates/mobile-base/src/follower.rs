//! Following a route, step by step.

use std::time::Duration;

use units::{Millimeters, MmPerSec, MmPerSec2, Radians};

use crate::base::{MecanumBase, ScaledTwist, WheelTooFast};
use crate::guard::{Blocked, Passage};
use crate::legs::{HeldIn, Sight, Wanted, held_in_world, look, wanted};
use crate::point_law::PointLaw;
use crate::pose::PlanarPose;
use crate::range::{OutOfRange, within};
use crate::route::Route;
use crate::tracking::TrackingLaw;
use crate::twist::BodyTwist;
use crate::wheels::WheelSpeeds;

const MAX_STEP: Duration = Duration::from_secs(1);
const MIN_ACCELERATION: MmPerSec2 = MmPerSec2(1.0);
const MAX_ACCELERATION: MmPerSec2 = MmPerSec2(1e6);

/// How routes are followed.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FollowerSettings {
    /// For waypoints.
    pub point_law: PointLaw,
    /// For paths.
    pub tracking_law: TrackingLaw,
    /// How fast the base gains speed, and brakes for the end of the route.
    pub acceleration: MmPerSec2,
    /// How near the heading must be to the wanted one at the end of the route.
    pub heading_tolerance: Radians,
    /// A base that is farther than this from its place on a path stops.
    pub max_deviation: Millimeters,
}

/// What a follower is doing.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum DriveState {
    /// On its way.
    Driving,
    /// Standing before the end of the route.
    Stopped(StopReason),
    /// Standing at the end of the route.
    Arrived(Docking),
}

/// Why a base stands before the end of its route.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum StopReason {
    /// Something is in the way; the base goes on by itself when it is gone.
    Obstacle(Blocked),
    /// [`Follower::stop`] was called; [`Follower::resume`] goes on.
    Requested,
    /// The base is too far from its place on the path; [`Follower::resume`] tries again.
    OffPath {
        /// How far.
        deviation: Millimeters,
        /// How far it may be.
        limit: Millimeters,
    },
}

/// How well the base stands at the end, by the pose that the follower was given.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Docking {
    /// From the end of the route.
    pub distance: Millimeters,
    /// From the wanted heading; nothing if the heading was left open, as in mode 1.
    pub heading: Option<Radians>,
}

/// How far along the route a base is.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Progress {
    /// The leg it is on, from 0; the last one once it has arrived.
    pub leg: usize,
    /// How many legs there are.
    pub legs: usize,
    /// The way that was commanded so far.
    pub driven: Millimeters,
    /// The way that is left.
    pub left: Millimeters,
}

/// What to drive in one step.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct DriveCommand {
    /// In the base's frame.
    pub twist: BodyTwist,
    /// The wheel speeds that drive it; within the limits of the base.
    pub wheels: WheelSpeeds,
    /// The share of what the law wanted that wheels, acceleration and obstacles left.
    pub factor: f64,
}

/// Why a step was refused; the follower is then as it was before.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
pub enum DriveError {
    /// The step's time, or a pose that comes of it, is out of range.
    #[error("following the route")]
    Range(#[from] OutOfRange),
    /// A twist that has no direction.
    #[error("limiting the wheel speeds")]
    Wheels(#[from] WheelTooFast),
}

/// Drives a base along a route.
#[derive(Clone, Debug, PartialEq)]
pub struct Follower {
    base: MecanumBase,
    settings: FollowerSettings,
    route: Route,
    place: Place,
    state: DriveState,
    driven: f64,
}

/// Where on the route a follower is.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Place {
    pub(crate) leg: usize,
    /// Along the leg's path.
    pub(crate) along: f64,
    /// The heading with which the leg began.
    pub(crate) heading: Radians,
    /// Commanded in the last step.
    pub(crate) speed: f64,
}

/// See [`Follower::checkpoint`].
#[derive(Clone, Copy, Debug)]
pub(crate) struct Checkpoint(Place, DriveState, f64);

impl FollowerSettings {
    fn check(&self) -> Result<(), OutOfRange> {
        let _ = within(
            "acceleration of the follower",
            self.acceleration,
            MIN_ACCELERATION,
            MAX_ACCELERATION,
        )?;
        let (min, max) = (Radians(1e-6), Radians(std::f64::consts::PI));
        let _ = within("heading tolerance", self.heading_tolerance, min, max)?;
        let (min, max) = (Millimeters(1.0), Millimeters(1e5));
        let _ = within("largest deviation", self.max_deviation, min, max)?;
        Ok(())
    }
}

impl Follower {
    /// A follower at the beginning of `route`, for a base that stands at `pose`.
    ///
    /// # Errors
    /// A setting that is out of its range.
    pub fn try_new(
        base: MecanumBase,
        settings: &FollowerSettings,
        route: Route,
        pose: PlanarPose,
    ) -> Result<Follower, OutOfRange> {
        settings.check()?;
        Ok(Follower {
            base,
            settings: *settings,
            route,
            place: Place {
                leg: 0,
                along: 0.0,
                heading: pose.heading(),
                speed: 0.0,
            },
            state: DriveState::Driving,
            driven: 0.0,
        })
    }

    /// What it is doing.
    #[must_use]
    pub fn state(&self) -> DriveState {
        self.state
    }

    /// How far along the route a base at `pose` is.
    #[must_use]
    pub fn progress(&self, pose: PlanarPose) -> Progress {
        let Place { leg, along, .. } = self.place;
        let on_leg = self
            .route
            .legs()
            .get(leg)
            .map_or(0.0, |current| crate::legs::left_on(current, along, pose));
        Progress {
            leg,
            legs: self.route.legs().len(),
            driven: Millimeters(self.driven),
            left: Millimeters(on_leg) + self.route.left_after(leg),
        }
    }

    /// Stands still from the next step on, until [`Follower::resume`]. An arrived base stays arrived.
    pub fn stop(&mut self) {
        if !matches!(self.state, DriveState::Arrived(_)) {
            self.state = DriveState::Stopped(StopReason::Requested);
            self.place.speed = 0.0;
        }
    }

    /// Goes on after a stop. An arrived base stays arrived.
    pub fn resume(&mut self) {
        if !matches!(self.state, DriveState::Arrived(_)) {
            self.state = DriveState::Driving;
        }
    }

    /// What to drive for `step`, from `pose`. `passage` says what the obstacles leave of a twist; see
    /// [`Guard::pass`](crate::Guard::pass).
    ///
    /// Wheel limits, acceleration and obstacles shorten the law's twist as a whole, and the progress
    /// along a path with it: the base is later, not elsewhere. In front of an obstacle that appears
    /// nearer than the way to brake the command is rest at once.
    ///
    /// # Errors
    /// A step that is not from 1 ns to 1 s, or a pose out of range; the follower is then as before.
    pub fn step(
        &mut self,
        pose: PlanarPose,
        step: Duration,
        passage: impl FnOnce(&BodyTwist) -> Passage,
    ) -> Result<DriveCommand, DriveError> {
        let _ = within("step", step, Duration::from_nanos(1), MAX_STEP)?;
        match self.state {
            DriveState::Arrived(_)
            | DriveState::Stopped(StopReason::Requested | StopReason::OffPath { .. }) => {
                return Ok(DriveCommand::REST);
            }
            DriveState::Driving | DriveState::Stopped(StopReason::Obstacle(_)) => {}
        }
        let place = match look(&self.route, &self.settings, self.place, pose, step) {
            Sight::Ahead(place) => place,
            Sight::Arrived(place, docking) => {
                self.place = place;
                return Ok(self.stand(DriveState::Arrived(docking)));
            }
        };
        let wanted = wanted(&self.route, &self.settings, place, pose, step)?;
        let (deviation, limit) = (wanted.deviation, self.settings.max_deviation);
        if deviation > limit {
            self.place = place;
            let reason = StopReason::OffPath { deviation, limit };
            return Ok(self.stand(DriveState::Stopped(reason)));
        }
        let possible = self.limited(&wanted, pose, step)?;
        let passed = match passage(&possible.twist) {
            Passage::Free => 1.0,
            Passage::Slowed { share } => share,
            Passage::Blocked(blocked) => {
                self.place = place;
                let reason = StopReason::Obstacle(blocked);
                return Ok(self.stand(DriveState::Stopped(reason)));
            }
        };
        let twist = possible.twist * passed;
        let factor = possible.factor * passed;
        self.state = DriveState::Driving;
        self.place = place;
        self.place.along += factor * (wanted.next_along - place.along);
        self.place.speed = twist.speed().0;
        self.driven += twist.speed().0 * step.as_secs_f64();
        Ok(DriveCommand {
            twist,
            wheels: self.base.inverse(&twist),
            factor,
        })
    }

    /// As much of what is wanted as starting, braking and the wheels allow.
    fn limited(
        &self,
        wanted: &Wanted,
        pose: PlanarPose,
        step: Duration,
    ) -> Result<ScaledTwist, DriveError> {
        let slowed = share_of(wanted.twist.speed(), wanted.speed_limit);
        let driven = self.base.scale_to_limits(&(wanted.twist * slowed))?;
        let twist = match wanted.held_in {
            HeldIn::Body => driven.twist,
            HeldIn::World => held_in_world(pose, &driven.twist, step)?,
        };
        // Holding the direction in the world takes the wheels a little more, or less.
        let held = self.base.scale_to_limits(&twist)?;
        Ok(ScaledTwist {
            twist: held.twist,
            factor: slowed * driven.factor * held.factor,
        })
    }

    /// What a step changes, to be put back if the step is not driven.
    pub(crate) fn checkpoint(&self) -> Checkpoint {
        Checkpoint(self.place, self.state, self.driven)
    }

    pub(crate) fn restore(&mut self, Checkpoint(place, state, driven): Checkpoint) {
        (self.place, self.state, self.driven) = (place, state, driven);
    }

    fn stand(&mut self, state: DriveState) -> DriveCommand {
        self.state = state;
        self.place.speed = 0.0;
        DriveCommand::REST
    }
}

impl DriveCommand {
    /// Standing still.
    pub const REST: DriveCommand = DriveCommand {
        twist: BodyTwist::ZERO,
        wheels: WheelSpeeds::ZERO,
        factor: 1.0,
    };
}

/// What a limit leaves of a speed.
fn share_of(speed: MmPerSec, limit: MmPerSec) -> f64 {
    if speed <= limit {
        1.0
    } else {
        limit.0 / speed.0
    }
}
