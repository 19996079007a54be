//! Trajectories of joints and tools, and paths among obstacles.
//!
//! | module | what it plans |
//! |---|---|
//! | [`trajectory`] | polynomials in time through given states: quintic, 4-3-4, 3-5-3 |
//! | [`jerk`] | the shortest joint move within velocity, acceleration and jerk, joints together |
//! | [`blend`] | joint moves past via points with rounded corners |
//! | [`cartesian`] | lines, circles and splines of the tool, inverse kinematics at each step |
//! | [`plane`] | paths of a disc-shaped robot among polygons |
//! | [`arm`] | transfers of an arm among obstacles |
//!
//! Joint values are radians (or millimeters of a prismatic joint), times seconds. Nothing here does
//! I/O or reads a clock; what is random comes from a seed. What may search for long asks whether its answer is still
//! [`Wanted`].

#![expect(
    non_snake_case,
    reason = "frames are part of a pose's name: X_WF is the flange F in the world W"
)]

pub mod arm;
pub mod blend;
pub mod cartesian;
pub mod jerk;
pub mod plane;
pub mod trajectory;

mod sampling;
mod state;
mod wanted;

pub use sampling::Sampling;
pub use state::{NotFinite, Part, State};
pub use wanted::{BrokenOff, Wanted};
