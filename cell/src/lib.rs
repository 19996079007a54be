//! The whole cell: the server and the virtual parts it works with, from one file of configuration.
//!
//! The emulators know nothing of each other and the server nothing of them; here they meet. [`Plant`] starts the
//! virtual controllers, the virtual mobile robots and the [`World`] in which a gripper finds what a mobile robot
//! carries. [`start()`] is the program `robocell`.

mod access;
mod assembly;
mod banner;
mod cli;
mod config;
mod mobile_robots;
mod plant;
mod simulate;
mod start;
mod supervise;
mod virtual_controllers;
pub mod world;

pub use assembly::Assembly;
pub use cli::Cli;
pub use plant::{Plant, PlantError};
pub use start::start;
pub use world::World;
