//! The robot's body: the laws of `mobile-base`, with zones as obstacles while there is no permit.

use std::sync::Arc;
use std::time::Duration;

use mobile_base::{
    DriveState, Leg, Localization, Obstacle, PlanarPose, Robot, RobotSettings, Route, StopReason,
};
use units::{Millimeters, MmPerSec, RadPerSec};

use crate::ledger::DriveEnd;
use crate::plan::Plan;

/// How fast, and how exactly.
#[derive(Clone, Copy, Debug, Eq, PartialEq)]
pub(crate) enum Manner {
    Driving,
    Docking,
}

/// What a step came to.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Stepped {
    /// No route.
    Idle,
    /// On its way.
    Moving,
    /// Before something in the way: the number of the obstacle as given.
    Blocked(usize),
    /// Too far from its path.
    OffPath,
    /// At the end of its route.
    Arrived,
}

/// A body with a route.
#[derive(Debug)]
pub(crate) struct Motion {
    plan: Arc<Plan>,
    robot: Robot,
    manner: Manner,
    /// Rebuilt so often; each time its encoders get a seed of their own.
    builds: u64,
    legs: Vec<Leg>,
    obstacles: Vec<Obstacle>,
    odometer_mm: f64,
    active: bool,
    moved: bool,
}

impl Motion {
    pub(crate) fn try_new(plan: Arc<Plan>) -> Result<Self, mobile_base::OutOfRange> {
        let robot = build(&plan, Manner::Driving, 0, plan.start)?;
        Ok(Self {
            plan,
            robot,
            manner: Manner::Driving,
            builds: 0,
            legs: Vec::new(),
            obstacles: Vec::new(),
            odometer_mm: 0.0,
            active: false,
            moved: false,
        })
    }

    /// Sets out.
    pub(crate) fn start(
        &mut self,
        legs: Vec<Leg>,
        manner: Manner,
    ) -> Result<(), mobile_base::OutOfRange> {
        let route = Route::try_new(legs.clone())?;
        self.manner = manner;
        self.rebuild(self.pose(), self.believed())?;
        self.robot.start(route)?;
        self.legs = legs;
        self.active = true;
        Ok(())
    }

    /// Gives the route up and stands.
    pub(crate) fn give_up(&mut self) {
        self.active = false;
        self.moved = false;
        // Both poses were legal before, and so they are now.
        let _legal = self.rebuild(self.pose(), self.believed());
    }

    /// What stands around, from now on.
    pub(crate) fn set_obstacles(&mut self, obstacles: Vec<Obstacle>) {
        self.robot.set_obstacles(obstacles.clone());
        self.obstacles = obstacles;
    }

    /// Lets a step pass.
    pub(crate) fn step(&mut self, step: Duration) -> Stepped {
        self.moved = false;
        if !self.active {
            return Stepped::Idle;
        }
        let Ok(state) = self.robot.step(step) else {
            // The next pose would be off the floor: it stands where it is.
            return Stepped::OffPath;
        };
        let way = self.robot.twist().speed().0 * step.as_secs_f64();
        self.odometer_mm += way;
        match state {
            None => Stepped::Idle,
            Some(DriveState::Driving) => {
                self.moved = true;
                Stepped::Moving
            }
            Some(DriveState::Stopped(StopReason::Obstacle(blocked))) => {
                Stepped::Blocked(blocked.obstacle)
            }
            Some(DriveState::Stopped(StopReason::Requested | StopReason::OffPath { .. })) => {
                Stepped::OffPath
            }
            Some(DriveState::Arrived(_)) => {
                self.active = false;
                Stepped::Arrived
            }
        }
    }

    /// Stands for a step.
    pub(crate) fn rest(&mut self) {
        self.moved = false;
    }

    /// Is put elsewhere, and believes what it is told. It goes on with the leg it was on.
    pub(crate) fn place(&mut self, truly: PlanarPose, believed: PlanarPose) {
        let legs = self.legs.get(self.leg()..).unwrap_or_default().to_vec();
        // Settings and legs were legal before, and so they are now.
        let _legal = self.rebuild(truly, believed);
        if self.active {
            let _legal = self.start(legs, self.manner);
        }
    }

    /// Sees a marker: it now knows where it is.
    pub(crate) fn measure(&mut self) {
        self.robot.correct_odometry(self.robot.pose());
    }

    /// Where it truly is.
    pub(crate) fn pose(&self) -> PlanarPose {
        self.robot.pose()
    }

    /// Where it believes it is.
    pub(crate) fn believed(&self) -> PlanarPose {
        self.robot.believed_pose()
    }

    /// Whether it has somewhere to go.
    pub(crate) fn has_route(&self) -> bool {
        self.active
    }

    /// Whether it moved in the last step.
    pub(crate) fn moved(&self) -> bool {
        self.moved
    }

    pub(crate) fn speed(&self) -> MmPerSec {
        if self.moved {
            self.robot.twist().speed()
        } else {
            MmPerSec(0.0)
        }
    }

    pub(crate) fn wheels(&self) -> [RadPerSec; 4] {
        if self.moved {
            self.robot.wheel_speeds().0
        } else {
            [RadPerSec(0.0); 4]
        }
    }

    /// The way that is left.
    pub(crate) fn left(&self) -> Millimeters {
        match self.robot.progress() {
            Some(progress) if self.active => progress.left,
            Some(_) | None => Millimeters(0.0),
        }
    }

    /// The leg of its route it is on, from 0.
    pub(crate) fn leg(&self) -> usize {
        self.robot.progress().map_or(0, |progress| progress.leg)
    }

    /// All it has driven.
    pub(crate) fn odometer_mm(&self) -> f64 {
        self.odometer_mm
    }

    fn rebuild(
        &mut self,
        truly: PlanarPose,
        believed: PlanarPose,
    ) -> Result<(), mobile_base::OutOfRange> {
        self.builds += 1;
        let mut robot = build(&self.plan, self.manner, self.builds, truly)?;
        robot.correct_odometry(believed);
        robot.set_obstacles(self.obstacles.clone());
        self.robot = robot;
        Ok(())
    }
}

fn build(
    plan: &Plan,
    manner: Manner,
    builds: u64,
    pose: PlanarPose,
) -> Result<Robot, mobile_base::OutOfRange> {
    let localization = match plan.localization {
        Localization::Exact => Localization::Exact,
        Localization::Odometry { noise, seed } => Localization::Odometry {
            noise,
            seed: seed.wrapping_add(builds.wrapping_mul(0x9e37_79b9_7f4a_7c15)),
        },
    };
    let settings = RobotSettings {
        base: plan.base,
        follower: match manner {
            Manner::Driving => plan.driving,
            Manner::Docking => plan.docking,
        },
        guard: Some(plan.guard.clone()),
        localization,
    };
    Robot::try_new(settings, pose)
}

impl Stepped {
    /// Why it stands, if it does.
    pub(crate) fn end(self, zones_from: usize) -> Option<DriveEnd> {
        match self {
            Self::Idle | Self::Moving => None,
            Self::Blocked(number) if number >= zones_from => Some(DriveEnd::NoPermit),
            Self::Blocked(_) => Some(DriveEnd::Obstacle),
            Self::OffPath => Some(DriveEnd::OffPath),
            Self::Arrived => Some(DriveEnd::Arrived),
        }
    }
}
