//! What a planner looked at on its way to a path: for drawings.

use super::Point;

/// A cell of a decomposition.
#[derive(Clone, Debug, PartialEq)]
pub struct SketchedCell {
    /// Its corners, in mm.
    pub corners: [Point; 4],
    /// Can the robot stand anywhere in it?
    pub free: bool,
}

/// What a planner looked at; empty where the straight way was free.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Sketch {
    /// The cells of a decomposition.
    pub cells: Vec<SketchedCell>,
    /// The free edges of a roadmap, or the steps taken in a potential field.
    pub edges: Vec<[Point; 2]>,
}
