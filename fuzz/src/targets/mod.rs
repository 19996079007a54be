//! The targets.

pub mod control;
pub mod core;
pub mod files;
pub mod peers;
pub mod program;
pub mod reading;
pub mod source;
pub mod wire;
