//! A virtual FANUC controller that runs KAREL programs.
pub mod alarms;
pub mod clock;
pub mod config;
pub mod controller;
pub mod effects;
pub mod error;
mod driver;
mod hardware;
pub mod labels;
pub mod ledger;
pub mod motion;
mod panel;
pub mod state;
pub mod sysvars;
pub mod tags;
mod virtual_controller;

pub use virtual_controller::VirtualController;
