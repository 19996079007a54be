//! Why a virtual controller does not start, or does not answer.

use std::io;
use std::net::{IpAddr, SocketAddr};

use kinematics::LimitViolations;

/// The controller did not start.
#[derive(Debug, thiserror::Error)]
pub enum StartError {
    /// Nothing to run.
    #[error("no KAREL program was given")]
    NoProgram,
    /// The gripper is wired to ports that do not exist, or to one input twice.
    #[error("the gripper uses {what}")]
    Gripper {
        /// The output or input.
        what: String,
    },
    /// Too many programs.
    #[error("{count} programs were given, the limit is {limit}")]
    TooManyPrograms {
        /// How many.
        count: usize,
        /// The limit.
        limit: usize,
    },
    /// A source is too long.
    #[error("{file} has {bytes} bytes, the limit is {limit}")]
    ProgramTooLong {
        /// The file.
        file: String,
        /// Its length.
        bytes: usize,
        /// The limit.
        limit: usize,
    },
    /// A source is not a correct KAREL program.
    #[error("{file} is not a correct KAREL program ({errors} errors):\n{rendered}")]
    Program {
        /// The file.
        file: String,
        /// How many errors.
        errors: usize,
        /// Every diagnostic with its source line and a caret.
        rendered: String,
    },
    /// A program cannot be loaded, for example because its name is taken.
    #[error("loading {file}: {reason}")]
    Load {
        /// The file.
        file: String,
        /// Why.
        reason: String,
    },
    /// A program that shall run does not exist.
    #[error("starting the program {name}: {reason}")]
    Task {
        /// The program.
        name: String,
        /// Why.
        reason: String,
    },
    /// Something that shall be set before the start cannot be.
    #[error("setting {item}: {reason}")]
    Preset {
        /// The item.
        item: String,
        /// Why.
        reason: String,
    },
    /// A fault that shall be there from the start cannot be.
    #[error("injecting the fault {fault}: {reason}")]
    Fault {
        /// Its name.
        fault: &'static str,
        /// Why.
        reason: String,
    },
    /// The arm cannot stand where it shall.
    #[error("the start joints are outside of the limits of {model}: {violations}")]
    StartJoints {
        /// The arm.
        model: String,
        /// Which joints.
        violations: LimitViolations,
    },
    /// The address is reachable from other machines.
    #[error(
        "{ip} is not a loopback address: this is an unauthenticated motion server, \
         and only an explicit permission opens it to other machines"
    )]
    NotLoopback {
        /// The address.
        ip: IpAddr,
    },
    /// A mapped port is taken or forbidden.
    #[error("opening port {host_port} for the program's port {program_port}")]
    Port {
        /// As the program names it.
        program_port: u16,
        /// As this machine names it.
        host_port: u16,
        /// The system's answer.
        #[source]
        source: io::Error,
    },
    /// The panel's address cannot be opened.
    #[error("opening the panel on {address}")]
    Panel {
        /// The address.
        address: SocketAddr,
        /// The system's answer.
        #[source]
        source: io::Error,
    },
}

/// The controller has stopped, so there is no answer.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
#[error("the virtual controller has stopped")]
pub struct ControllerStopped;
