//! HTTP API, controller links and cell state.
//!
//! A request becomes a checked command, the command waits for the one task that owns its robot's socket, and what the
//! controller answers becomes the response. Nothing here knows a file or a command line: the caller gives a listener,
//! a checked [`Plan`], the [`Seams`] and a token that stops it.
//!
//! ```text
//! connection ── edge ── route ── target ──────────── link ─────────────── controller
//!  serve.rs     id,     JSON     rounding,           queue, deadline,     one connection
//!  connections/ time,   to       inverse             one owner task,      a command
//!               problem units    kinematics, limits  at most one send
//! ```
//!
//! What is promised of a command: it is sent at most once; an answer says `NOT_SENT`, `REJECTED` or, where the robot
//! may have moved, `UNKNOWN`. It is not a safety function: emergency stop and guards stay hard-wired in the controller.
//!
//! ```
//! use std::sync::Arc;
//!
//! use server::config::{CellSection, RobotSection, ServerSection};
//! use server::{Plan, Seams, SharedJournal, SystemClock, TcpConnector};
//! use tokio::net::TcpListener;
//! use tokio_util::sync::CancellationToken;
//!
//! # #[tokio::main]
//! # async fn main() -> Result<(), Box<dyn std::error::Error>> {
//! let cell = CellSection {
//!     id: "cell-1".to_owned(),
//!     name: None,
//!     robots: vec![RobotSection::new("arm", "fanuc-m20ia", "127.0.0.1:59002")],
//!     setup: None,
//!     push_urls: Default::default(),
//! };
//! // Everybody on this machine may do everything; a plant has `Plan::with_identity`.
//! let section = ServerSection { demo: true, ..ServerSection::default() };
//! let plan = Plan::try_new(&section, &[cell])?;
//! let seams = Seams {
//!     connector: TcpConnector::default(),
//!     clock: Arc::new(SystemClock),
//!     journal: SharedJournal::volatile(),
//! };
//! let listener = TcpListener::bind("127.0.0.1:0").await?;
//! let stop = CancellationToken::new();
//! let serving = tokio::spawn(server::run(listener, plan, seams, stop.clone()));
//! stop.cancel();
//! serving.await??;
//! # Ok(())
//! # }
//! ```

pub mod authority;
mod cell;
mod clock;
mod compute;
pub mod config;
mod connections;
mod edge;
mod events;
mod extract;
mod guard;
pub mod identity;
mod jobs;
mod journal;
mod link;
mod metrics;
mod motions;
mod openapi;
mod problem;
mod request_id;
mod router;
mod routes;
mod serve;
mod setup;
mod simulation;
mod state;
mod target;
mod wire_bodies;
mod words;

pub use self::journal::{JournalError, Retention, SharedJournal, Upkeep, open as open_journal};
pub use cell::StartError as CellStartError;
pub use clock::{SystemClock, WallClock};
pub use config::{ConfigError, Plan};
pub use connections::Listener;
pub use link::{AddressError, Connector, ControllerAddress, TcpConnection, TcpConnector};
pub use openapi::{OpenApiError, openapi, openapi_yaml};
pub use serve::{ServeError, run, start};
pub use setup::{SetupErrors, StoreError};
pub use simulation::{
    JobSimulator, Scene, SceneArm, SceneMobileRobot, SimulatedStory, Simulating, SimulationError,
    StoryError, simulated_story,
};
pub use state::Seams;
