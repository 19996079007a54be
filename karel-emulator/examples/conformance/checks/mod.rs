//! The observations of the three public drivers, each a module.
#![allow(dead_code, reason = "the tests use a part of what the command uses")]

pub(crate) mod fanucpy;
pub(crate) mod mappdk;
mod mappdk_ports;
mod mappdk_wire;
pub(crate) mod rig;
pub(crate) mod ros;
mod ros_setup;
pub(crate) mod seed;
mod simple_message;
pub(crate) mod table;
