//! Bodies of the thesis's own routes, with its key names: millimeters and degrees without the unit in the key.

use serde::{Deserialize, Serialize};
use utoipa::ToSchema;

/// An absolute point, millimeters and degrees.
#[derive(Clone, Copy, Debug, Deserialize, PartialEq, Serialize, ToSchema)]
#[serde(deny_unknown_fields)]
#[schema(example = json!({"x": 600, "y": 200, "z": 600, "w": -180, "p": 30, "r": 0}))]
pub struct LegacyPoint {
    /// X in millimeters.
    #[schema(minimum = -1_000_000, maximum = 1_000_000)]
    pub x: f64,
    /// Y in millimeters.
    #[schema(minimum = -1_000_000, maximum = 1_000_000)]
    pub y: f64,
    /// Z in millimeters.
    #[schema(minimum = -1_000_000, maximum = 1_000_000)]
    pub z: f64,
    /// W in degrees.
    #[schema(minimum = -36_000, maximum = 36_000)]
    pub w: f64,
    /// P in degrees.
    #[schema(minimum = -36_000, maximum = 36_000)]
    pub p: f64,
    /// R in degrees.
    #[schema(minimum = -36_000, maximum = 36_000)]
    pub r: f64,
}

/// A change to the last accepted point, millimeters and degrees, added to each number.
#[derive(Clone, Copy, Debug, Deserialize, PartialEq, Serialize, ToSchema)]
#[serde(deny_unknown_fields)]
#[schema(example = json!({"dx": 0, "dy": 0, "dz": -50, "dw": 0, "dp": 0, "dr": 0}))]
pub struct LegacyDelta {
    /// Change of X in millimeters.
    pub dx: f64,
    /// Change of Y in millimeters.
    pub dy: f64,
    /// Change of Z in millimeters.
    pub dz: f64,
    /// Change of W in degrees.
    pub dw: f64,
    /// Change of P in degrees.
    pub dp: f64,
    /// Change of R in degrees.
    pub dr: f64,
}

/// The point the controller accepted. The arm may still be on its way to it.
#[derive(Clone, Copy, Debug, Deserialize, PartialEq, Serialize, ToSchema)]
pub struct LegacyMoved {
    /// The accepted point, rounded to thousandths as sent.
    pub current_position: LegacyPoint,
}

/// A refusal in the seed's shape.
#[derive(Clone, Debug, Deserialize, PartialEq, Serialize, ToSchema)]
pub struct LegacyRefusal {
    /// Begins with `ERROR:`.
    pub detail: String,
}

/// A body or query that does not fit, in the seed's shape.
#[derive(Clone, Debug, Deserialize, PartialEq, Serialize, ToSchema)]
pub struct LegacyValidation {
    /// One entry for each thing wrong.
    pub detail: Vec<LegacyValidationItem>,
}

/// One thing wrong with a request.
#[derive(Clone, Debug, Deserialize, PartialEq, Serialize, ToSchema)]
pub struct LegacyValidationItem {
    /// Where: `["body", "x"]` or `["query", "velocity"]`.
    pub loc: Vec<String>,
    /// What, with the value and the limit.
    pub msg: String,
    /// A stable word for programs.
    #[serde(rename = "type")]
    pub kind: String,
}

/// The server's version, a list as the seed serves it.
#[derive(Clone, Debug, Deserialize, PartialEq, Serialize, ToSchema)]
pub struct LegacyVersion {
    /// One element.
    pub version: Vec<String>,
}
