//! The operator's set-up of a cell: one file, or its parts as resources.
//!
//! Everything is in the **cell frame** unless a key says otherwise: Z up, millimeters, degrees. Where each arm stands
//! in it is part of the set-up ([`ArmSetup::base`]).
//!
//! Ids are `[a-z0-9][a-z0-9_-]{0,63}`. A place's id may be two of them with a slash between (`rack/a`); a load-handling
//! point is named `station/point` wherever it is referred to.

mod arms;
mod check;
mod floor;
mod teach;
mod timers;
mod triggers;

use serde::{Deserialize, Serialize};
use utoipa::ToSchema;

pub use arms::{
    ArmSetup, BoxBody, CalibrationRecord, PointBody, PoseFrame, TaughtPoseBody, ToolSetup,
    ZoneBody, ZoneKind,
};
pub use check::{
    CheckFinding, JointMarginBody, RouteCheck, SetupCheck, Severity, TaughtPoseCheck, ZoneMargin,
};
pub use floor::{
    DestinationBody, DockToleranceBody, FootprintBody, LoadBody, LoadPointBody, MobileRobotSetup,
    OnMobileRobot, PlaceBody, PlaceKind, PlanarPoseBody, RouteBody, RouteDirection, SlotBody,
    StationBody, WaypointBody,
};
pub use teach::{
    CalibrationBody, CalibrationPoint, CalibrationResult, ExplicitPose, TeachBody, TeachResult,
};
pub use timers::TimersBody;
pub use triggers::{TriggerBody, TriggerJob, TriggerOn};

/// The version of the set-up file that this API reads and writes.
pub const SETUP_FORMAT: u32 = 1;

/// The whole set-up of a cell: what is imported and exported, as TOML or as JSON.
#[derive(Clone, Debug, Deserialize, PartialEq, Serialize, ToSchema)]
#[serde(deny_unknown_fields)]
#[schema(example = json!({"format": 1}))]
pub struct SetupFile {
    /// The version of this form; 1.
    #[schema(minimum = 1, maximum = 1)]
    pub format: u32,
    /// A name for people.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub name: Option<String>,
    /// Where the timers of the workflows differ from their defaults.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub timers: Option<TimersBody>,
    /// The arms that take part: where they stand, and where they wait.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub arms: Vec<ArmSetup>,
    /// The arms' tools.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub tools: Vec<ToolSetup>,
    /// Work areas, keep-out zones and hand-over zones.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub zones: Vec<ZoneBody>,
    /// Stations with their load-handling points.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub stations: Vec<StationBody>,
    /// Where loads can be.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub places: Vec<PlaceBody>,
    /// How each arm grips at the places.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub taught_poses: Vec<TaughtPoseBody>,
    /// Where mobile robots take loads to and get them from, outside the arms' reach.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub destinations: Vec<DestinationBody>,
    /// The mobile robots.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub mobile_robots: Vec<MobileRobotSetup>,
    /// The ways mobile robots take between load-handling points.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub routes: Vec<RouteBody>,
    /// The loads, and where they are at first.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub loads: Vec<LoadBody>,
    /// Jobs that mobile robots start by their own signals.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub triggers: Vec<TriggerBody>,
}

impl SetupFile {
    /// A set-up with nothing in it.
    #[must_use]
    pub fn empty() -> Self {
        Self {
            format: SETUP_FORMAT,
            name: None,
            timers: None,
            arms: Vec::new(),
            tools: Vec::new(),
            zones: Vec::new(),
            stations: Vec::new(),
            places: Vec::new(),
            taught_poses: Vec::new(),
            destinations: Vec::new(),
            mobile_robots: Vec::new(),
            routes: Vec::new(),
            loads: Vec::new(),
            triggers: Vec::new(),
        }
    }
}

/// What became of a change to the set-up.
#[derive(Clone, Debug, Deserialize, PartialEq, Serialize, ToSchema)]
pub struct SetupRevision {
    /// Counts the changes of the whole set-up.
    pub revision: u64,
    /// The entity tag of the whole set-up: what `If-Match` takes.
    pub etag: String,
    /// The resources that differ from before, e.g. `places/rack/a`. Empty: nothing had to be changed.
    pub changed: Vec<String>,
}
