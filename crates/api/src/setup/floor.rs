use serde::{Deserialize, Serialize};
use utoipa::ToSchema;

/// A station: load-handling points that belong together.
#[derive(Clone, Debug, Deserialize, PartialEq, Serialize, ToSchema)]
#[serde(deny_unknown_fields)]
pub struct StationBody {
    /// Its id.
    pub id: String,
    /// A name for people.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub name: Option<String>,
    /// Its load-handling points, at least one.
    pub points: Vec<LoadPointBody>,
}

/// Where a mobile robot docks.
#[derive(Clone, Debug, Deserialize, PartialEq, Serialize, ToSchema)]
#[serde(deny_unknown_fields)]
pub struct LoadPointBody {
    /// Its id, unique in the station.
    pub id: String,
    /// The arms that load and unload here; none where people or other machines do.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub arms: Vec<String>,
    /// The hand-over zone around it: required where an arm works here.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub zone: Option<String>,
    /// Where a mobile robot stands when docked.
    pub dock: PlanarPoseBody,
    /// How far from `dock` it may be found and still be served.
    pub dock_tolerance: DockToleranceBody,
}

/// A pose on the floor, in the cell frame.
#[derive(Clone, Copy, Debug, Deserialize, PartialEq, Serialize, ToSchema)]
#[serde(deny_unknown_fields)]
pub struct PlanarPoseBody {
    /// X in millimeters.
    #[schema(minimum = -1_000_000, maximum = 1_000_000)]
    pub x_mm: f64,
    /// Y in millimeters.
    #[schema(minimum = -1_000_000, maximum = 1_000_000)]
    pub y_mm: f64,
    /// The direction of its front, counterclockwise from X, in degrees.
    #[schema(minimum = -36_000, maximum = 36_000)]
    pub heading_deg: f64,
}

/// How far a docked mobile robot may be from the nominal pose.
#[derive(Clone, Copy, Debug, Deserialize, PartialEq, Serialize, ToSchema)]
#[serde(deny_unknown_fields)]
pub struct DockToleranceBody {
    /// Along each axis of the dock's frame, in millimeters.
    #[schema(minimum = 0.1, maximum = 500)]
    pub position_mm: f64,
    /// In degrees.
    #[schema(minimum = 0.1, maximum = 45)]
    pub angle_deg: f64,
}

/// What kind of place it is.
#[derive(Clone, Copy, Debug, Deserialize, Eq, PartialEq, Serialize, ToSchema)]
#[serde(rename_all = "SCREAMING_SNAKE_CASE")]
pub enum PlaceKind {
    /// It stands still and holds one load.
    Fixed,
    /// It stands still and takes what cannot go elsewhere for now: one load.
    Buffer,
    /// A bin for rejected loads: any number.
    Reject,
    /// A slot of whichever mobile robot is docked at a point.
    OnMobileRobot,
}

/// A place for loads.
#[derive(Clone, Debug, Deserialize, PartialEq, Serialize, ToSchema)]
#[serde(deny_unknown_fields)]
pub struct PlaceBody {
    /// Its id; may have one slash: `rack/a`.
    pub id: String,
    /// A name for people.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub name: Option<String>,
    /// What kind of place it is.
    pub kind: PlaceKind,
    /// The types of loads it takes, at least one.
    pub accepts: Vec<String>,
    /// For `ON_MOBILE_ROBOT`: the point the robot is docked at, `station/point`.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub point: Option<String>,
    /// For `ON_MOBILE_ROBOT`: the slot's id on the robot.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub slot: Option<String>,
}

/// Where loads leave the cell to, and come from.
#[derive(Clone, Debug, Deserialize, PartialEq, Serialize, ToSchema)]
#[serde(deny_unknown_fields)]
pub struct DestinationBody {
    /// Its id.
    pub id: String,
    /// A name for people.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub name: Option<String>,
    /// The point where a mobile robot docks there, `station/point`.
    pub point: String,
}

/// A mobile robot. Where the server pushes messages to is the integrator's configuration, never part of the set-up.
#[derive(Clone, Debug, Deserialize, PartialEq, Serialize, ToSchema)]
#[serde(deny_unknown_fields)]
pub struct MobileRobotSetup {
    /// Its id.
    pub id: String,
    /// A name for people.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub name: Option<String>,
    /// The point where it waits when there is nothing to do, `station/point`.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub home: Option<String>,
    /// Its size.
    pub footprint: FootprintBody,
    /// The fastest it can drive, in mm/s. Where the pose it tells goes farther between two signals it does not know
    /// where it is, and docks anew before an arm comes near. Not looked at where absent.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schema(minimum = 1, maximum = 1_000_000)]
    pub max_speed_mm_s: Option<u32>,
    /// Its slots for loads, at least one.
    pub slots: Vec<SlotBody>,
}

/// The size of a mobile robot: a box on the floor, its middle over the robot's position.
#[derive(Clone, Copy, Debug, Deserialize, PartialEq, Serialize, ToSchema)]
#[serde(deny_unknown_fields)]
pub struct FootprintBody {
    /// Along its heading, in millimeters.
    #[schema(minimum = 1, maximum = 10_000)]
    pub length_mm: f64,
    /// Across it, in millimeters.
    #[schema(minimum = 1, maximum = 10_000)]
    pub width_mm: f64,
    /// Above the floor, loads included, in millimeters.
    #[schema(minimum = 1, maximum = 10_000)]
    pub height_mm: f64,
}

/// A slot of a mobile robot.
#[derive(Clone, Debug, Deserialize, PartialEq, Serialize, ToSchema)]
#[serde(deny_unknown_fields)]
pub struct SlotBody {
    /// Its id, unique on the robot.
    pub id: String,
    /// The types of loads it takes, at least one.
    pub accepts: Vec<String>,
}

/// Which ways a route may be driven.
#[derive(Clone, Copy, Debug, Default, Deserialize, Eq, PartialEq, Serialize, ToSchema)]
#[serde(rename_all = "SCREAMING_SNAKE_CASE")]
pub enum RouteDirection {
    /// Both.
    #[default]
    BothWays,
    /// Only from `from` to `to`.
    OneWay,
}

/// A way between two load-handling points.
#[derive(Clone, Debug, Deserialize, PartialEq, Serialize, ToSchema)]
#[serde(deny_unknown_fields)]
pub struct RouteBody {
    /// Its id.
    pub id: String,
    /// Where it begins, `station/point`.
    pub from: String,
    /// Where it ends, `station/point`.
    pub to: String,
    /// Which ways it may be driven; both where absent.
    #[serde(default)]
    pub direction: RouteDirection,
    /// The mobile robots that may take it; all of them where absent.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub robots: Option<Vec<String>>,
    /// The points between the two docks, in order.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub waypoints: Vec<WaypointBody>,
}

/// A point of a route, in the cell frame.
#[derive(Clone, Copy, Debug, Deserialize, PartialEq, Serialize, ToSchema)]
#[serde(deny_unknown_fields)]
pub struct WaypointBody {
    /// X in millimeters.
    #[schema(minimum = -1_000_000, maximum = 1_000_000)]
    pub x_mm: f64,
    /// Y in millimeters.
    #[schema(minimum = -1_000_000, maximum = 1_000_000)]
    pub y_mm: f64,
}

/// A load. Exactly one of `place`, `on` and `destination` says where it is at first.
#[derive(Clone, Debug, Deserialize, PartialEq, Serialize, ToSchema)]
#[serde(deny_unknown_fields)]
pub struct LoadBody {
    /// Its id.
    pub id: String,
    /// Its type: what places and slots accept.
    #[serde(rename = "type")]
    pub load_type: String,
    /// A name for people.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub name: Option<String>,
    /// The place that stands still and has it at first.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub place: Option<String>,
    /// The destination where it is at first.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub destination: Option<String>,
    /// The slot of a mobile robot that has it at first.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub on: Option<OnMobileRobot>,
}

/// A slot of a certain mobile robot.
#[derive(Clone, Debug, Deserialize, Eq, Hash, PartialEq, Serialize, ToSchema)]
#[serde(deny_unknown_fields)]
pub struct OnMobileRobot {
    /// The mobile robot's id.
    pub mobile_robot: String,
    /// The slot's id.
    pub slot: String,
}
