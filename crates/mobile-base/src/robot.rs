//! A simulated mobile robot: a base, its encoders, its route, and what stands in its way.

use std::time::Duration;

use units::Radians;

use crate::base::MecanumBase;
use crate::follower::{DriveCommand, DriveError, DriveState, Follower, FollowerSettings, Progress};
use crate::guard::{Guard, GuardSettings, Passage};
use crate::odometry::{NoisyEncoders, Odometry};
use crate::pose::PlanarPose;
use crate::range::OutOfRange;
use crate::route::Route;
use crate::shapes::Obstacle;
use crate::twist::BodyTwist;
use crate::wheels::WheelSpeeds;

/// How a robot knows where it is.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Localization {
    /// From outside, without error.
    Exact,
    /// From its wheels, with the errors of [`NoisyEncoders`].
    Odometry {
        /// Standard deviation of a wheel's angle after one radian.
        noise: Radians,
        /// The same seed gives the same errors.
        seed: u64,
    },
}

/// The parts of a robot.
#[derive(Clone, Debug, PartialEq)]
pub struct RobotSettings {
    /// Geometry and wheel limits.
    pub base: MecanumBase,
    /// How it follows routes.
    pub follower: FollowerSettings,
    /// How it stops in front of obstacles; nothing: it does not look.
    pub guard: Option<GuardSettings>,
    /// How it knows where it is.
    pub localization: Localization,
}

/// A robot that moves when it is told how much time has passed.
///
/// Deterministic: the same settings, calls and steps give the same motion. It has no mass; what the
/// follower commands is what the wheels do.
#[derive(Clone, Debug)]
pub struct Robot {
    settings: RobotSettings,
    guard: Option<Guard>,
    obstacles: Vec<Obstacle>,
    follower: Option<Follower>,
    encoders: Option<NoisyEncoders>,
    odometry: Odometry,
    pose: PlanarPose,
    command: DriveCommand,
}

impl Robot {
    /// A robot that stands at `pose`, knows it, and has no route.
    ///
    /// # Errors
    /// A setting that is out of its range.
    pub fn try_new(settings: RobotSettings, pose: PlanarPose) -> Result<Robot, OutOfRange> {
        let encoders = match settings.localization {
            Localization::Exact => None,
            Localization::Odometry { noise, seed } => Some(NoisyEncoders::try_new(noise, seed)?),
        };
        let guard = settings.guard.clone().map(Guard::try_new).transpose()?;
        Ok(Robot {
            guard,
            obstacles: Vec::new(),
            follower: None,
            encoders,
            odometry: Odometry::new(settings.base, pose),
            pose,
            command: DriveCommand::REST,
            settings,
        })
    }

    /// Sets out on a route; one that it was on is given up.
    ///
    /// # Errors
    /// A setting of the follower that is out of its range.
    pub fn start(&mut self, route: Route) -> Result<(), OutOfRange> {
        let pose = self.believed_pose();
        let settings = &self.settings.follower;
        self.follower = Some(Follower::try_new(
            self.settings.base,
            settings,
            route,
            pose,
        )?);
        Ok(())
    }

    /// Stands still from the next step on, until [`Robot::resume`].
    pub fn stop(&mut self) {
        if let Some(follower) = &mut self.follower {
            follower.stop();
        }
    }

    /// Goes on after a stop.
    pub fn resume(&mut self) {
        if let Some(follower) = &mut self.follower {
            follower.resume();
        }
    }

    /// Tells the robot where it is, as a marker at a dock would.
    pub fn correct_odometry(&mut self, measured: PlanarPose) {
        self.odometry.correct(measured);
    }

    /// What stands around, from now on. The robot sees it from where it truly is.
    pub fn set_obstacles(&mut self, obstacles: Vec<Obstacle>) {
        self.obstacles = obstacles;
    }

    /// Lets `time` pass: one command, driven as one arc.
    ///
    /// # Errors
    /// A time that is not from 1 ns to 1 s, or a pose out of range; nothing has moved then.
    pub fn step(&mut self, time: Duration) -> Result<Option<DriveState>, DriveError> {
        let (here, believed) = (self.pose, self.believed_pose());
        let Some(follower) = &mut self.follower else {
            self.command = DriveCommand::REST;
            return Ok(None);
        };
        let (guard, obstacles) = (&mut self.guard, &self.obstacles);
        // Both are put back if the step ends out of range.
        let before = (follower.checkpoint(), guard.as_ref().map(Guard::stopped_by));
        let command = follower.step(believed, time, |twist| match guard.as_mut() {
            Some(guard) => guard.pass(here, twist, time, obstacles),
            None => Passage::Free,
        })?;
        let turned = command.wheels.over(time);
        let moved = here.moved_by(&self.settings.base.displacement(&turned));
        let read = match &mut self.encoders {
            Some(encoders) => encoders.read(&turned),
            None => turned,
        };
        match moved.and_then(|pose| self.odometry.add(&read).map(|_| pose)) {
            Ok(pose) => self.pose = pose,
            Err(refused) => {
                follower.restore(before.0);
                if let (Some(guard), Some(stopped_by)) = (guard, before.1) {
                    guard.restore(stopped_by);
                }
                return Err(refused.into());
            }
        }
        self.command = command;
        Ok(Some(follower.state()))
    }

    /// Where it truly is.
    #[must_use]
    pub fn pose(&self) -> PlanarPose {
        self.pose
    }

    /// Where it believes it is.
    #[must_use]
    pub fn believed_pose(&self) -> PlanarPose {
        match self.encoders {
            Some(_) => self.odometry.pose(),
            None => self.pose,
        }
    }

    /// How it moved in the last step, in its own frame.
    #[must_use]
    pub fn twist(&self) -> BodyTwist {
        self.command.twist
    }

    /// How its wheels turned in the last step.
    #[must_use]
    pub fn wheel_speeds(&self) -> WheelSpeeds {
        self.command.wheels
    }

    /// The share of what the law wanted that was driven in the last step.
    #[must_use]
    pub fn factor(&self) -> f64 {
        self.command.factor
    }

    /// What it is doing; nothing if it has no route.
    #[must_use]
    pub fn state(&self) -> Option<DriveState> {
        self.follower.as_ref().map(Follower::state)
    }

    /// How far along its route it is.
    #[must_use]
    pub fn progress(&self) -> Option<Progress> {
        let follower = self.follower.as_ref()?;
        Some(follower.progress(self.believed_pose()))
    }
}
