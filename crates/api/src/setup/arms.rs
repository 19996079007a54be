use jiff::Timestamp;
use serde::{Deserialize, Serialize};
use utoipa::ToSchema;

use crate::{JointsBody, PoseBody};

/// An arm's place in the cell. Its id is that of a robot of the configuration.
#[derive(Clone, Debug, Deserialize, PartialEq, Serialize, ToSchema)]
#[serde(deny_unknown_fields)]
pub struct ArmSetup {
    /// The robot's id in the configuration.
    pub id: String,
    /// The number of the tool it carries, 1 to 10.
    #[schema(minimum = 1, maximum = 10)]
    pub tool: u8,
    /// How thick the arm is about the lines between its joints, in millimeters; 100 where absent. Keep-out zones are
    /// checked against it.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schema(minimum = 0, maximum = 1000)]
    pub body_radius_mm: Option<f64>,
    /// `X_CW`: the arm's own world frame in the cell frame.
    pub base: PoseBody,
    /// Where it waits, out of every hand-over zone: joint values as on the pendant.
    pub safe: JointsBody,
    /// Where it stands at the beginning; the arm model's home where absent.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub home: Option<JointsBody>,
}

/// A tool on an arm's flange.
#[derive(Clone, Debug, Deserialize, PartialEq, Serialize, ToSchema)]
#[serde(deny_unknown_fields)]
pub struct ToolSetup {
    /// The arm's id.
    pub arm: String,
    /// Its number, 1 to 10, unique for the arm.
    #[schema(minimum = 1, maximum = 10)]
    pub number: u8,
    /// A name for people.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub name: Option<String>,
    /// How thick it is about the line from the flange to its center point, in millimeters; 50 where absent.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schema(minimum = 0, maximum = 1000)]
    pub radius_mm: Option<f64>,
    /// `X_FT`: the tool center point in the flange frame.
    pub frame: PoseBody,
    /// How the center point was measured, where it was.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub calibration: Option<CalibrationRecord>,
}

/// How well a tool center point is known.
#[derive(Clone, Debug, Deserialize, PartialEq, Serialize, ToSchema)]
#[serde(deny_unknown_fields)]
pub struct CalibrationRecord {
    /// How many postures were used.
    #[schema(minimum = 4, maximum = 100)]
    pub points: u32,
    /// Root mean square of the distances between the postures' tips and their mean, in millimeters.
    #[schema(minimum = 0)]
    pub rms_mm: f64,
    /// The largest of those distances, in millimeters.
    #[schema(minimum = 0)]
    pub max_mm: f64,
    /// When it was measured.
    #[serde(
        default,
        deserialize_with = "crate::moment::optional",
        skip_serializing_if = "Option::is_none"
    )]
    pub at: Option<Timestamp>,
}

/// What a zone is for.
#[derive(Clone, Copy, Debug, Deserialize, Eq, Hash, PartialEq, Serialize, ToSchema)]
#[serde(rename_all = "SCREAMING_SNAKE_CASE")]
pub enum ZoneKind {
    /// Shared by an arm and a mobile robot: never both at once.
    Handover,
    /// No part of the robot may be in it.
    KeepOut,
    /// The robot's work is done inside: an arm's tool center point, a mobile robot's way.
    Work,
}

/// A zone of the cell.
#[derive(Clone, Debug, Deserialize, PartialEq, Serialize, ToSchema)]
#[serde(deny_unknown_fields)]
pub struct ZoneBody {
    /// Its id.
    pub id: String,
    /// A name for people.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub name: Option<String>,
    /// What it is for.
    pub kind: ZoneKind,
    /// The robots it is for, arms and mobile ones, by their ids; all of them where absent.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub robots: Option<Vec<String>>,
    /// Its bounds in the cell frame.
    #[serde(rename = "box")]
    pub bounds: BoxBody,
}

/// A box with its edges along the axes of the cell frame.
#[derive(Clone, Copy, Debug, Deserialize, PartialEq, Serialize, ToSchema)]
#[serde(deny_unknown_fields)]
pub struct BoxBody {
    /// The corner with the smallest coordinates.
    pub min: PointBody,
    /// The corner with the largest coordinates.
    pub max: PointBody,
}

/// A point, in millimeters.
#[derive(Clone, Copy, Debug, Deserialize, PartialEq, Serialize, ToSchema)]
#[serde(deny_unknown_fields)]
pub struct PointBody {
    /// X in millimeters.
    #[schema(minimum = -1_000_000, maximum = 1_000_000)]
    pub x_mm: f64,
    /// Y in millimeters.
    #[schema(minimum = -1_000_000, maximum = 1_000_000)]
    pub y_mm: f64,
    /// Z in millimeters.
    #[schema(minimum = -1_000_000, maximum = 1_000_000)]
    pub z_mm: f64,
}

/// The frame a pose is written in.
#[derive(Clone, Copy, Debug, Default, Deserialize, Eq, PartialEq, Serialize, ToSchema)]
#[serde(rename_all = "SCREAMING_SNAKE_CASE")]
pub enum PoseFrame {
    /// The cell frame.
    #[default]
    Cell,
    /// The arm's own world frame.
    Arm,
}

/// How an arm grips at a place.
#[derive(Clone, Debug, Deserialize, PartialEq, Serialize, ToSchema)]
#[serde(deny_unknown_fields)]
pub struct TaughtPoseBody {
    /// The arm's id.
    pub arm: String,
    /// The place's id.
    pub place: String,
    /// The frame of `pose`; the cell frame where absent.
    #[serde(default)]
    pub frame: PoseFrame,
    /// The configuration, e.g. `N U T, 0, 0, 0`.
    pub configuration: String,
    /// The approach begins this far before the pose, against the tool's Z axis, in millimeters.
    #[schema(minimum = 1, maximum = 1000)]
    pub approach_mm: f64,
    /// A gripped load is lifted straight up by this much, in millimeters; `approach_mm` where absent.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schema(minimum = 1, maximum = 1000)]
    pub lift_mm: Option<f64>,
    /// The tool center point. For a place on a mobile robot: while the robot is docked exactly at the nominal pose.
    pub pose: PoseBody,
}
