//! Transfers of any arm among obstacles: a probabilistic roadmap in joint space.
//!
//! The arm is a set of capsules on its links (its model file has them, or [`skeleton`] makes them), obstacles are boxes, cylinders and keep-out zones;
//! `parry3d` measures how far they are apart. A motion is looked at in steps so short that no point
//! of the arm moves farther than the margin both ways: what keeps the margin at every step touches
//! nothing in between.

mod scene;
mod shape;
mod transfer;

pub use kinematics::Capsule;
pub use scene::{Obstacle, Scene};
pub use shape::{ArmShape, skeleton};
pub use transfer::{ArmError, ArmPath, Touch, Touched, Workplace};
