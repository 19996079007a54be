//! What the end-to-end tests stand on.
//!
//! - [`wait_until`]: waits on a condition, with a bound, and says what was missing. Tests never sleep.
//! - [`Gate`]: holds something back until the test opens it.
//! - [`ChaosProxy`]: a TCP proxy that breaks the network in named ways.
//! - [`FakeRobot`]: a controller that answers what its script says, for what a real one cannot be made to do.
//! - [`TestServer`]: the real server on a free port, with a client.
//! - [`TestCell`]: server and virtual controller, from the HTTP request to the arm.

mod chaos_proxy;
mod fake_robot;
mod gate;
mod pump;
mod test_cell;
mod test_server;
mod wait;

pub use chaos_proxy::{ChaosProxy, Mode, Traffic};
pub use fake_robot::{ACCEPTED, FakeRobot, INCORRECT_INPUT, Turn, UNREACHABLE};
pub use gate::Gate;
pub use pump::Direction;
pub use test_cell::{TestCell, while_stepping};
pub use test_server::{CELL, MODEL, ROBOT, TestServer, robot_at};
pub use wait::{Look, TimedOut, wait_until};
