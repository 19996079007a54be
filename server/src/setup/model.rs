//! The parts of a checked set-up.

#![expect(
    non_snake_case,
    reason = "frames are part of a pose's name: X_CW is an arm's world W in the cell C"
)]

use api::setup::{RouteDirection, TimersBody, ZoneKind};
use kinematics::{ArmModel, Configuration, Frames, PendantJoints, Pose};
use units::Millimeters;

use super::geometry::{DockPose, DockTolerance, ZoneBox};

/// A checked set-up: every number in its range, every reference to something that is there.
#[derive(Clone, Debug)]
pub(crate) struct Setup {
    pub(crate) arms: Vec<Arm>,
    pub(crate) zones: Vec<Zone>,
    pub(crate) points: Vec<LoadPoint>,
    pub(crate) places: Vec<Place>,
    pub(crate) taught: Vec<Taught>,
    pub(crate) destinations: Vec<Destination>,
    pub(crate) mobile_robots: Vec<MobileRobot>,
    pub(crate) routes: Vec<Route>,
    pub(crate) loads: Vec<Load>,
    /// In the words of the workflows already: nothing here looks at them.
    pub(crate) triggers: Vec<workflow::Trigger>,
    pub(crate) timers: TimersBody,
}

/// An arm with the tool it carries.
#[derive(Clone, Debug)]
pub(crate) struct Arm {
    pub(crate) id: String,
    pub(crate) model: &'static ArmModel,
    /// The frames its controller works with, which need not be those of the set-up.
    pub(crate) controller_frames: Frames,
    pub(crate) X_CW: Pose,
    pub(crate) body_radius: Millimeters,
    pub(crate) tool: Tool,
    pub(crate) safe: PendantJoints,
    pub(crate) home: PendantJoints,
}

/// A tool.
#[derive(Clone, Debug)]
pub(crate) struct Tool {
    #[expect(
        dead_code,
        reason = "shown by the resource; the controller's tool is set with its robot"
    )]
    pub(crate) number: u8,
    pub(crate) X_FT: Pose,
    pub(crate) radius: Millimeters,
}

/// Which robots something is for.
#[derive(Clone, Debug, Eq, PartialEq)]
pub(crate) enum Scope {
    All,
    Only(Vec<String>),
}

impl Scope {
    pub(crate) fn includes(&self, robot: &str) -> bool {
        match self {
            Self::All => true,
            Self::Only(robots) => robots.iter().any(|known| known == robot),
        }
    }
}

/// A zone.
#[derive(Clone, Debug)]
pub(crate) struct Zone {
    pub(crate) id: String,
    pub(crate) kind: ZoneKind,
    pub(crate) robots: Scope,
    pub(crate) bounds: ZoneBox,
}

/// A load-handling point.
#[derive(Clone, Debug)]
pub(crate) struct LoadPoint {
    /// `station/point`.
    pub(crate) id: String,
    pub(crate) arms: Vec<String>,
    /// There is one wherever there is an arm.
    pub(crate) zone: Option<String>,
    pub(crate) dock: DockPose,
    pub(crate) tolerance: DockTolerance,
}

/// A place.
#[derive(Clone, Debug)]
pub(crate) struct Place {
    pub(crate) id: String,
    pub(crate) site: Site,
    pub(crate) accepts: Vec<String>,
}

/// What a place is.
#[derive(Clone, Debug, Eq, PartialEq)]
pub(crate) enum Site {
    Fixed,
    Buffer,
    Reject,
    /// The slot of whichever mobile robot is docked at the point.
    OnMobileRobot {
        point: String,
        slot: String,
    },
}

/// How an arm grips at a place; for a place on a mobile robot, at the nominal dock pose.
#[derive(Clone, Debug)]
pub(crate) struct Taught {
    pub(crate) arm: String,
    pub(crate) place: String,
    /// The tool center point in the cell frame.
    pub(crate) X_CT: Pose,
    pub(crate) configuration: Configuration,
    pub(crate) approach: Millimeters,
    pub(crate) lift: Millimeters,
}

/// Where loads leave the cell to.
#[derive(Clone, Debug)]
pub(crate) struct Destination {
    pub(crate) id: String,
    pub(crate) point: String,
}

/// A mobile robot.
#[derive(Clone, Debug)]
pub(crate) struct MobileRobot {
    pub(crate) id: String,
    #[expect(dead_code, reason = "no workflow sends a mobile robot home yet")]
    pub(crate) home: Option<String>,
    pub(crate) length: Millimeters,
    pub(crate) width: Millimeters,
    pub(crate) height: Millimeters,
    pub(crate) max_speed_mm_s: Option<u32>,
    pub(crate) slots: Vec<Slot>,
}

/// A slot of a mobile robot.
#[derive(Clone, Debug)]
pub(crate) struct Slot {
    pub(crate) id: String,
    pub(crate) accepts: Vec<String>,
}

/// A way between two load-handling points.
#[derive(Clone, Debug)]
pub(crate) struct Route {
    pub(crate) id: String,
    pub(crate) from: String,
    pub(crate) to: String,
    pub(crate) direction: RouteDirection,
    pub(crate) robots: Scope,
    pub(crate) waypoints: Vec<[Millimeters; 2]>,
}

/// A load.
#[derive(Clone, Debug)]
pub(crate) struct Load {
    pub(crate) id: String,
    /// Its type.
    pub(crate) kind: String,
    pub(crate) at: Whereabouts,
}

/// Where a load is at first.
#[derive(Clone, Debug, Eq, PartialEq)]
pub(crate) enum Whereabouts {
    Place(String),
    Destination(String),
    OnMobileRobot { mobile_robot: String, slot: String },
}

impl Setup {
    pub(crate) fn arm(&self, id: &str) -> Option<&Arm> {
        self.arms.iter().find(|arm| arm.id == id)
    }

    pub(crate) fn place(&self, id: &str) -> Option<&Place> {
        self.places.iter().find(|place| place.id == id)
    }

    /// A load-handling point by `station/point`.
    pub(crate) fn point(&self, id: &str) -> Option<&LoadPoint> {
        self.points.iter().find(|point| point.id == id)
    }

    pub(crate) fn taught(&self, arm: &str, place: &str) -> Option<&Taught> {
        self.taught
            .iter()
            .find(|taught| taught.arm == arm && taught.place == place)
    }

    /// How many zones are for this robot.
    pub(crate) fn count_zones_of(&self, robot: &str) -> usize {
        let of_robot = |zone: &&Zone| zone.robots.includes(robot);
        self.zones.iter().filter(of_robot).count()
    }

    /// Whether any zone is for this robot.
    pub(crate) fn has_zones_of(&self, robot: &str) -> bool {
        self.count_zones_of(robot) > 0
    }

    /// The zones of a kind that are for a robot.
    pub(crate) fn zones_of<'a>(
        &'a self,
        robot: &'a str,
        kind: ZoneKind,
    ) -> impl Iterator<Item = &'a Zone> {
        self.zones
            .iter()
            .filter(move |zone| zone.kind == kind && zone.robots.includes(robot))
    }
}
