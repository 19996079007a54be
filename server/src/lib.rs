//! HTTP API, controller links and cell state.

mod clock;
mod commands;
pub mod config;
mod edge;
mod extract;
mod guard;
mod link;
mod metrics;
mod motion_store;
mod openapi;
mod problem;
mod request_id;
mod router;
mod routes;
mod serve;
mod state;
mod target;
mod wire_bodies;

pub use clock::{SystemClock, WallClock};
pub use config::{ConfigError, Plan};
pub use link::{AddressError, Connector, ControllerAddress, TcpConnector};
pub use openapi::{OpenApiError, openapi, openapi_yaml};
pub use serve::{ServeError, run, start};
pub use state::Seams;
