//! Typed client of the robocell HTTP API, and of the virtual controller's panel.
//!
//! The bodies are those of the `api` crate: millimeters, degrees, the unit in the key. A [`Client`] speaks to the
//! server; [`Client::robot`] names one robot of one cell; an [`EmulatorClient`] looks at a virtual controller from
//! the controller's side.
//!
//! ```text
//! Client ──── cells, version, health, metrics, the thesis's own routes
//!   └─ Robot ── description, state, forward, inverse, motions
//! EmulatorClient ── state, ledger, alarms
//! ```
//!
//! Every error says what is known of a command's effect, see [`ClientError::outcome`]. Nothing is ever sent twice by
//! this library: whether a motion may be repeated is a decision for someone who has looked at the robot.
//!
//! ```no_run
//! # async fn example() -> Result<(), client::ClientError> {
//! use api::{MotionBody, MotionType, PoseBody, TargetBody};
//!
//! let client = client::Client::new("http://127.0.0.1:8080")?;
//! let robot = client.robot("demo", "r1");
//! let pose = PoseBody { x_mm: 600.0, y_mm: 200.0, z_mm: 600.0, w_deg: -180.0, p_deg: 30.0, r_deg: 0.0 };
//! let motion = robot
//!     .create_motion(&MotionBody {
//!         target: Some(TargetBody::Pose(pose)),
//!         speed_mm_s: Some(200.0),
//!         ..MotionBody::new(MotionType::Joint)
//!     })
//!     .await?;
//! assert_eq!(motion.state, api::MotionState::Accepted);
//! # Ok(())
//! # }
//! ```

mod answer;
mod emulator;
mod error;
mod http;
mod legacy;
mod panel;
mod robot;
mod server;

pub use answer::MAX_ANSWER_BYTES;
pub use emulator::EmulatorClient;
pub use error::ClientError;
pub use http::Timeouts;
pub use panel::{
    Alarm, EmulatorJoints, EmulatorState, JointLimit, LedgerEntry, LedgerEvent, Log, Tag, Task,
};
pub use robot::{Ask, Page, Robot};
pub use server::Client;
