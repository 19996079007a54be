//! Questions about arms, trajectories and paths, answered: a body of the API in, a body out.
//!
//! The server's routes and the command line ask the same functions, so both give the same answer. Nothing here does
//! I/O or reads a clock, and what is random comes from a seed in the question.
//!
//! | question | function | source |
//! |---|---|---|
//! | which models there are, and what one is | [`models`](models()), [`describe`](describe()) | textbook (1.12), thesis table 1, paper figure 1 |
//! | where the tool is | [`forward`](forward()) | textbook (1.22), thesis (12), paper (1), (2) |
//! | which joints reach a pose | [`inverse`](inverse()) | thesis (14) to (18), textbook (1.34) to (1.57), paper (3), (4) |
//! | Jacobians, rank, what is lost | [`jacobian`](jacobian()) | textbook (1.78) to (1.90) |
//! | joint rates of a velocity | [`rates`](rates()) | textbook (1.91) to (1.93) |
//! | motion by a velocity vector | [`velocity_motion`](velocity_motion()) | paper, section 6 |
//! | torques of the joints for a motion | [`inverse_dynamics`](inverse_dynamics()) | Luh, Walker and Paul (1980) |
//! | a tool out of taught points | [`calibrate`](calibrate()) | thesis, R and p after (12) |
//! | which poses are reached | [`reach`](reach()) | as `inverse` |
//! | joints in time | [`trajectory`](trajectory()) | textbook (2.16) to (2.42) |
//! | the tool along a path | [`tool_path`](tool_path()) | lectures 5.2 |
//! | an arm among obstacles | [`transfer`](transfer()) | textbook 2.2.3 |
//! | a disc among polygons, or what of a cell is in its way | [`plan_route`](plan_route()), [`route_in_cell`](route_in_cell()) | textbook 2.2, (2.7) to (2.11) |
//!
//! Lengths are millimeters, angles degrees, the unit is in the key. Poses are `X_UT`, the tool in the user frame;
//! both frames are the identity where the question does not give them. Every number has a bound; what is wrong comes
//! back as a [`Refusal`] that names the item by its path in the body, its value and its limit.
//!
//! What may search for long has a sister, such as [`transfer_while`], that ends when its answer is no longer [`Wanted`].
//!
//! ```
//! use api::arms::ArmForwardBody;
//!
//! let question = ArmForwardBody {
//!     joints_deg_mm: vec![0.0, 0.0, 0.0, 0.0, -90.0, 0.0],
//!     frames: Default::default(),
//! };
//! let answer = robotics::forward("fanuc-m20ia", &question)?;
//! assert!((answer.tcp.x_mm - 985.0).abs() < 1e-9 && (answer.tcp.z_mm - 940.0).abs() < 1e-9);
//! # Ok::<(), robotics::Refusal>(())
//! ```

#![expect(
    non_snake_case,
    reason = "frames are part of a pose's name: X_WF is the flange F in the world W"
)]

mod arm;
mod calibrate;
mod cell_route;
mod convert;
mod describe;
mod dynamics;
mod forward;
mod inverse;
mod joint_seconds;
mod reach;
mod refusal;
mod route;
mod sampled;
mod shape;
mod tool_path;
mod trajectory;
mod transfer;
mod velocity;

pub use arm::Arm;
pub use calibrate::calibrate;
pub use cell_route::route_in_cell;
pub use convert::{point_of, pose_body, shown};
pub use describe::{describe, models};
pub use dynamics::inverse_dynamics;
pub use forward::forward;
pub use inverse::{inverse, is_search};
pub use joint_seconds::joint_seconds;
pub use planning::Wanted;
pub use reach::{reach, reach_while};
pub use refusal::{Refusal, RefusalKind};
pub use route::{plan_route, plan_route_while};
pub use tool_path::{tool_path, tool_path_while};
pub use trajectory::trajectory;
pub use transfer::{transfer, transfer_while};
pub use velocity::{jacobian, rates, velocity_motion};
