//! A virtual mecanum robot: drives, docks, carries loads, and talks to the signal endpoints of a cell.
//!
//! It drives with the laws of `mobile-base`, waits for its permit before it moves in a point's zone, docks, tells the
//! cell what it does with numbered signals that it repeats until they are answered, and reads its messages from the
//! cell's outbox. What it truly did stands in its [ledger](MobileRobot::ledger); what it tells may differ, on demand
//! ([`Fault`]). Many robots live in one process, each with a [`Clock`] of its own: real, scaled, or stepped.
//!
//! ```text
//!   cell (HTTP)      view, tests          clock
//!       |                 |                 |
//!   +---v-----------------v-----------------v---+   driver: one task; signals, messages, time
//!   |  messages v               ^ signals       |
//!   |   +-------------------------------+       |   core: deterministic, in fixed steps
//!   |   | mission <-> motion (the laws) |       |   mission: where it is in its order
//!   |   +-------------------------------+       |
//!   +-------------------------------------------+
//! ```
//!
//! ```
//! use std::time::Duration;
//! use mobile_emulator::{CellAddress, Clock, MobileConfig, MobileRobot};
//!
//! # #[tokio::main(flavor = "current_thread")]
//! # async fn main() -> Result<(), Box<dyn std::error::Error>> {
//! let config = MobileConfig::new("mr1").with_slot("a", Some("box-1"));
//! let (clock, stepper) = Clock::stepped();
//! // Nobody listens there: the robot stands and keeps trying.
//! let cell = CellAddress::new("http://127.0.0.1:9", "demo")?;
//! let robot = MobileRobot::start(&config, clock, &cell)?;
//!
//! let _now = stepper.advance(Duration::from_secs(3)).await?;
//! assert_eq!(robot.take("a").await?, "box-1");
//! let state = robot.state().await?;
//! assert!(state.cell.away && state.cell.waiting_signals > 0);
//! robot.shutdown().await;
//! # Ok(())
//! # }
//! ```
//!
//! Nothing here has a mass, and nothing is a safety function.

mod cell;
mod clock;
pub mod config;
mod core;
mod driver;
mod error;
mod fault;
mod fault_book;
mod floor;
mod ledger;
mod mission;
mod motion;
mod outbound;
mod plan;
mod robot;
mod route;
mod slots;
mod state;
mod view;

pub use cell::CellAddress;
pub use clock::{Clock, Stepper};
pub use config::MobileConfig;
pub use error::{ConfigError, Refusal, RobotStopped, StartError};
pub use fault::{Fault, LostNumber, MAX_FAULTS, SlipMoment};
pub use fault_book::ActiveFault;
pub use ledger::{
    DriveEnd, LEDGER_ENTRIES, LedgerEntry, LedgerEvent, OrderOutcome, Purpose, Violation,
};
pub use mission::Phase;
pub use robot::MobileRobot;
pub use state::{CellLink, PlannedStop, State, ZoneState};
