//! Paths of a mobile robot among polygons.

use serde::{Deserialize, Serialize};
use utoipa::ToSchema;

/// How a path is looked for.
#[derive(Clone, Copy, Debug, Default, Deserialize, Eq, PartialEq, Serialize, ToSchema)]
#[serde(rename_all = "kebab-case")]
pub enum RouteMethod {
    /// Exact cell decomposition: if there is a path, it is found.
    #[default]
    Trapezoidal,
    /// Approximate cell decomposition, down to a resolution.
    Quadtree,
    /// Descent in a potential field, (2.7) to (2.11), with random walks out of its minima.
    PotentialField,
    /// A probabilistic roadmap.
    Roadmap,
}

/// A rectangle of the floor.
#[derive(Clone, Copy, Debug, Deserialize, PartialEq, Serialize, ToSchema)]
#[serde(deny_unknown_fields)]
pub struct FloorBody {
    /// The corner with the least x and y.
    pub min_mm: [f64; 2],
    /// The corner with the greatest.
    pub max_mm: [f64; 2],
}

/// An outline on the floor whose edges do not cross.
#[derive(Clone, Debug, Deserialize, PartialEq, Serialize, ToSchema)]
#[serde(deny_unknown_fields)]
pub struct PolygonBody {
    /// What it is, for messages.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub name: Option<String>,
    /// Its corners, 3 to 256, either way around.
    pub corners_mm: Vec<[f64; 2]>,
}

/// A path of a disc among polygons that is asked for.
#[derive(Clone, Debug, Deserialize, PartialEq, Serialize, ToSchema)]
#[serde(deny_unknown_fields)]
#[schema(example = json!({
    "floor": {"min_mm": [0, 0], "max_mm": [1000, 1000]}, "radius_mm": 50,
    "start_mm": [100, 100], "goal_mm": [900, 100],
    "obstacles": [{"corners_mm": [[400, 0], [500, 0], [500, 700], [400, 700]]}]
}))]
pub struct PlanRouteBody {
    /// Where the robot may be at all.
    pub floor: FloorBody,
    /// What stands there; at most 200, with 1000 corners together.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub obstacles: Vec<PolygonBody>,
    /// The disc around the robot.
    #[schema(minimum = 0)]
    pub radius_mm: f64,
    /// The robot's middle at the start.
    pub start_mm: [f64; 2],
    /// The robot's middle at the goal.
    pub goal_mm: [f64; 2],
    /// How to look, and with what numbers.
    #[serde(default)]
    pub search: RouteSearch,
}

/// How a path is looked for, and with what numbers.
#[derive(Clone, Debug, Default, Deserialize, PartialEq, Serialize, ToSchema)]
#[serde(deny_unknown_fields)]
pub struct RouteSearch {
    /// `trapezoidal` where absent.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub method: Option<RouteMethod>,
    /// Of what is random: the same seed gives the same path. 0 where absent.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub seed: Option<u64>,
    /// The smallest cell of the quadtree; a two-hundredth of the floor where absent.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schema(minimum = 0.1, maximum = 100_000)]
    pub resolution_mm: Option<f64>,
    /// Samples of the roadmap after which it is given up; 5000 where absent.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schema(minimum = 1, maximum = 10_000)]
    pub samples: Option<u32>,
    /// Steps in the potential field after which it is given up; 400,000 where absent, a quarter of it among
    /// more than 250 corners. Steps times corners are at most 100,000,000.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schema(minimum = 1, maximum = 1_000_000)]
    pub steps: Option<u32>,
    /// From how near an obstacle is felt in the potential field; 150 where absent.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schema(minimum = 0.001, maximum = 1_000_000)]
    pub influence_mm: Option<f64>,
}

/// A path of a mobile robot of a cell, around what stands in the cell's set-up. Everything is in the cell frame. Exactly one
/// of `goal` and `goal_mm` is given.
#[derive(Clone, Debug, Default, Deserialize, PartialEq, Serialize, ToSchema)]
#[serde(deny_unknown_fields)]
#[schema(example = json!({"goal": "st1/p1"}))]
pub struct CellRouteBody {
    /// A point where mobile robots dock, `station/point`.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub goal: Option<String>,
    /// Where the robot's middle is to be.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub goal_mm: Option<[f64; 2]>,
    /// Where it starts; where it last told that it is, if absent.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub start_mm: Option<[f64; 2]>,
    /// The disc around the robot; around its footprint where absent.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schema(minimum = 0)]
    pub radius_mm: Option<f64>,
    /// Where it may be at all. Where absent, its work zones; if it has none, what the set-up has, start and goal, and some
    /// room around them.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub floor: Option<FloorBody>,
    /// What is in the way besides the set-up's keep-out zones for this robot, and the hand-over zones that neither its
    /// start nor its goal is in.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub obstacles: Vec<PolygonBody>,
    /// How to look, and with what numbers.
    #[serde(default)]
    pub search: RouteSearch,
}

/// A path of a disc among polygons.
#[derive(Clone, Debug, Deserialize, PartialEq, Serialize, ToSchema)]
pub struct PlanRouteResult {
    /// How it was looked for.
    pub method: RouteMethod,
    /// The floor it was looked for on.
    pub floor: FloorBody,
    /// What stood there.
    pub obstacles: Vec<PolygonBody>,
    /// The disc around the robot.
    pub radius_mm: f64,
    /// The corners of the path, start and goal included; straight between them.
    pub points_mm: Vec<[f64; 2]>,
    /// Its length.
    pub length_mm: f64,
    /// The least distance of the disc from obstacles and edges along it.
    pub clearance_mm: f64,
    /// The cells that a decomposition looked at, as outlines; empty for the other methods, where the straight
    /// way is free, and where there are more than 10,000.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub cells: Vec<RouteCell>,
    /// The edges of a roadmap, or the ways walked in a potential field, as pairs of points; empty alike.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub graph_mm: Vec<[[f64; 2]; 2]>,
}

/// A cell of a decomposition.
#[derive(Clone, Debug, Deserialize, PartialEq, Serialize, ToSchema)]
pub struct RouteCell {
    /// Its corners.
    pub corners_mm: Vec<[f64; 2]>,
    /// Whether the robot can stand anywhere in it.
    pub free: bool,
}
