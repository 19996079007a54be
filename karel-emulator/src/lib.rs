//! A virtual FANUC controller that runs KAREL programs.
//!
//! The program is interpreted from its source, so its bytes on the wire are its own. A motion is planned with the
//! arm's kinematics, checked against its joint limits, and takes the time it takes; the [ledger] tells what
//! the arm really did. Many controllers live in one process, each in one task, and each with a [clock](Clock) of its
//! own that is real, scaled, or stepped by a test.
//!
//! ```text
//!   TCP clients      panel, tests         clock
//!       |                 |                 |
//!   +---v-----------------v-----------------v---+   driver: one task, bytes and time
//!   |    events v                 ^ effects     |
//!   |   +-------------------------------+       |   controller: deterministic core
//!   |   | karel::Machine <-> hardware   |       |   hardware: arm, tags, variables, alarms, ledger
//!   |   +-------------------------------+       |
//!   +-------------------------------------------+
//! ```
//!
//! ```
//! use karel_emulator::{Clock, ControllerConfig, PeerLabels, ProgramSource, VirtualController};
//! use kinematics::ArmModel;
//! use std::time::Duration;
//!
//! # #[tokio::main(flavor = "current_thread")]
//! # async fn main() -> Result<(), Box<dyn std::error::Error>> {
//! let program = "PROGRAM lift
//! VAR p : XYZWPR
//! BEGIN
//!   p = CURPOS(0, 0)
//!   p.z = p.z + 50
//!   $SPEED = 500
//!   MOVE TO p
//! END lift
//! ";
//! let model = ArmModel::builtin("fanuc-m20ia").ok_or("no such arm")?;
//! let config = ControllerConfig::new("doc", model)
//!     .with_program(ProgramSource::new("lift.kl", program));
//! let (clock, stepper) = Clock::stepped();
//! let controller = VirtualController::start(&config, clock, PeerLabels::new())?;
//!
//! let before = controller.state().await?.pose.z_mm;
//! let _time = stepper.advance(Duration::from_secs(10)).await?;
//! let after = controller.state().await?.pose.z_mm;
//! assert!((after - before - 50.0).abs() < 1e-3);
//! assert_eq!(controller.ledger().await?.len(), 2, "started, finished");
//! controller.shutdown().await;
//! # Ok(())
//! # }
//! ```
//!
//! It does not know loads, collisions, servo lag or brakes, and it is no safety function.

pub mod alarms;
pub mod cell_server;
pub mod clock;
pub mod config;
pub mod controller;
pub mod devices;
mod driver;
pub mod effects;
pub mod error;
pub mod faults;
pub mod fidelity;
pub mod gripper;
mod hardware;
mod json;
pub mod labels;
pub mod ledger;
pub mod motion;
pub mod panel;
pub mod ports;
pub mod state;
pub mod sysvars;
pub mod tags;
mod virtual_controller;

pub use clock::{Clock, Stepper};
pub use config::{
    ControlAccess, ControllerConfig, Exposure, ProgramSource, ScreenSink, SecondClient,
};
pub use controller::{
    CmosMemory, Controller, OperateError, Operation, ProgramSelection, RemoteStart,
};
pub use error::{ControllerStopped, StartError};
pub use faults::{ControllerOption, FaultBody, FaultError, FaultKind, FaultView};
pub use fidelity::{ControllerGeneration, Fidelity, Note, Profile};
pub use gripper::{GripperConfig, Workpieces};
pub use hardware::operator::OperatingMode;
pub use hardware::safety::{StopCategory, StopSource};
pub use json::{JsonError, from_json};
pub use labels::PeerLabels;
pub use ledger::{CommandId, LedgerEntry, LedgerEvent};
pub use panel::control::openapi_yaml;
pub use ports::SetInputError;
pub use state::State;
pub use virtual_controller::VirtualController;
