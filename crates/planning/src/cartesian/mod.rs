//! Straight lines, circles and splines of the tool, with inverse kinematics at every step.
//!
//! Section 5.2 of the lectures: `q = ikin(H(t))` at each step, H the pose on the path. The path
//! parameter runs from 0 to 1 with a jerk-limited profile; where a joint would be too fast, the
//! whole move is slowed down, and says so.

mod demands;
mod error;
mod follower;
mod path;
mod solved;
mod stepwise;
mod tool_move;
mod wrist;

pub use demands::{Demand, Demands};
pub use error::{JointValue, ToolError, ToolMoveError};
pub use follower::ToolFollower;
pub use path::{Extent, PathError, ToolPath};
pub use solved::{SolvedArm, Solver};
pub use tool_move::{Sample, ToolLimits, ToolMove};
