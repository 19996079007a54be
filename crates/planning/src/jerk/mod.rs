//! The shortest joint move within velocity, acceleration and jerk, from any state to any state, all
//! joints arriving together.
//!
//! For one joint and one duration T the displacements that can be reached form an interval, because
//! the joint is a linear system and its limits are convex. Its upper end is reached by the jerk
//! pattern up, down, up, its lower end by down, up, down (`side`); both have closed forms. The
//! shortest time is where the wanted displacement first lies in the interval (`axis`). A joint
//! that has to wait for a slower one takes the mean of the two extreme profiles that ends where it
//! should: a mean of two profiles within the limits is within the limits, so no second search is
//! needed.
//!
//! [`Progress`] is the same for one number from rest to rest, the progress along a way, with the time of each position
//! too; [`SpeedChange`] goes from one speed to another.
//!
//! ```
//! use planning::State;
//! use planning::jerk::{JointMove, MotionLimits};
//!
//! let limits = [MotionLimits { velocity: 1.0, acceleration: 1.0, jerk: 1.0 }; 2];
//! let start = [State::at_rest(0.0), State::at_rest(0.0)];
//! let goal = [State::at_rest(6.0), State::at_rest(0.5)];
//! let shortest = JointMove::try_new(&start, &goal, &limits)?;
//! // 6 at the speed 1, and 1 s each for the acceleration and for the jerk.
//! assert!((shortest.duration() - 8.0).abs() < 1e-12);
//! # Ok::<(), planning::jerk::MoveError>(())
//! ```

mod axis;
mod joint_move;
mod phases;
mod progress;
mod side;
mod speed_change;
mod straight;

pub use joint_move::{JointMove, MotionLimits, MoveError, Quantity};
pub use progress::Progress;
pub use speed_change::SpeedChange;
pub use straight::straight_in_joint_space;
