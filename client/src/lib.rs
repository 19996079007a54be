//! Typed client of the robocell HTTP API, and of the virtual controller's panel.
//!
//! The bodies are those of the `api` crate: millimeters, degrees, the unit in the key. A [`Client`] speaks to the
//! server; [`Client::robot`] names one robot of one cell; an [`EmulatorClient`] looks at a virtual controller from
//! the controller's side.
//!
//! ```text
//! Client ──── cells, version, health, metrics, the thesis's own routes
//!   ├─ Control ── who may move the robots of a cell: take it, keep it, give it back
//!   ├─ CellSetup ── export, import, check, parts, teach, calibrate
//!   ├─ Arms ── arm models, trajectories, routes: nothing of a cell
//!   ├─ Robot ── description, state, forward, inverse, motions
//!   ├─ Jobs ── jobs, sessions, loads, the cell's state
//!   └─ MobileRobotClient ── state, signals, outbox
//! EmulatorClient ── state, ledger, alarms
//! ```
//!
//! Every error says what is known of a command's effect, see [`ClientError::outcome`]. Nothing is ever sent twice by
//! this library: whether a motion may be repeated is a decision for someone who has looked at the robot.
//!
//! ```no_run
//! # async fn example() -> Result<(), client::ClientError> {
//! use api::{AcquireBody, MotionBody, MotionType, PoseBody, Station, TargetBody};
//!
//! let client = client::Client::new("http://127.0.0.1:8080")?;
//! // Whoever moves a robot holds control of its cell meanwhile.
//! let terms = AcquireBody {
//!     station: Station::Remote,
//!     ttl_s: None,
//!     loss_behavior: None,
//!     reason: "an example".to_owned(),
//!     preempt: false,
//! };
//! let control = client.control("demo").hold(&terms).await?;
//! let robot = client.with_control(control.token()).robot("demo", "r1");
//! let pose = PoseBody { x_mm: 600.0, y_mm: 200.0, z_mm: 600.0, w_deg: -180.0, p_deg: 30.0, r_deg: 0.0 };
//! let motion = robot
//!     .create_motion(&MotionBody {
//!         target: Some(TargetBody::Pose(pose)),
//!         speed_mm_s: Some(200.0),
//!         ..MotionBody::new(MotionType::Joint)
//!     })
//!     .await?;
//! assert_eq!(motion.state, api::MotionState::Accepted);
//! let _view = control.release().await?;
//! # Ok(())
//! # }
//! ```

mod access;
mod answer;
mod arms;
mod control;
mod emulator;
mod error;
mod events;
mod http;
mod jobs;
mod legacy;
mod mobile;
mod panel;
mod robot;
mod server;
mod setup;

pub use answer::MAX_ANSWER_BYTES;
pub use arms::Arms;
pub use control::{Control, HeldControl};
pub use emulator::{Change, EmulatorClient};
pub use error::ClientError;
pub use events::{EventStream, Told};
pub use http::Timeouts;
pub use jobs::Jobs;
pub use mobile::{MobileRobotClient, SignalGap};
pub use panel::{
    Alarm, EmulatorJoints, EmulatorState, JointLimit, LedgerEntry, LedgerEvent, Log, Note, Notes,
    Tag, Task,
};
pub use robot::{Ask, Page, Robot};
pub use server::Client;
pub use setup::{CellSetup, SetupForm, SetupText, Tagged};
