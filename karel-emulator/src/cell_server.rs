//! The cell server's programs, which this project ships for controllers, ready to run here.

use kinematics::ArmModel;

use crate::config::{ControllerConfig, ProgramSource};

/// Port of the commands, tag S3.
pub const COMMAND_PORT: u16 = 59_002;
/// Port of the status, tag S4.
pub const STATUS_PORT: u16 = 59_003;

/// `R[]` in which the TP programs find epoch and number of their command.
const COMMAND_REGISTERS: (u16, u16) = (3, 4);

const PROGRAMS: &[(&str, &str)] = &[
    (
        "cell_server.kl",
        include_str!("../../programs/cell_server.kl"),
    ),
    (
        "cell_status.kl",
        include_str!("../../programs/cell_status.kl"),
    ),
    (
        "cell_watch.kl",
        include_str!("../../programs/cell_watch.kl"),
    ),
    (
        "cell_joint.ls",
        include_str!("../../programs/cell_joint.ls"),
    ),
    ("cell_line.ls", include_str!("../../programs/cell_line.ls")),
];

const INCLUDES: &[(&str, &str)] = &[
    (
        "include/cell_share.kl",
        include_str!("../../programs/include/cell_share.kl"),
    ),
    (
        "include/cell_wire.kl",
        include_str!("../../programs/include/cell_wire.kl"),
    ),
    (
        "include/cell_look.kl",
        include_str!("../../programs/include/cell_look.kl"),
    ),
];

const SEED_PROGRAMS: &[(&str, &str)] = &[
    (
        "sock_server.kl",
        include_str!("../../programs/sock_server.kl"),
    ),
    (
        "seed_status.kl",
        include_str!("../../programs/seed_status.kl"),
    ),
];

impl ControllerConfig {
    /// A controller of `model` that runs the cell server: commands on port 59002 (tag S3), status on port 59003
    /// (tag S4), each on a free port of this machine; see [`crate::VirtualController::address_of_port`].
    #[must_use]
    pub fn cell_server(name: impl Into<String>, model: &ArmModel) -> Self {
        let mut config = two_ports(name, model, PROGRAMS);
        config.run = vec!["CELL_SERVER".to_owned()];
        config.command_registers = Some(COMMAND_REGISTERS);
        config
    }

    /// A controller of `model` that runs the pose server, on port 59002 (tag S3), and the status program beside it, on
    /// port 59003 (tag S4), each on a free port of this machine.
    #[must_use]
    pub fn seed_status(name: impl Into<String>, model: &ArmModel) -> Self {
        let mut config = two_ports(name, model, SEED_PROGRAMS);
        config.run = vec!["SEED_STATUS".to_owned()];
        config
    }
}

fn two_ports(
    name: impl Into<String>,
    model: &ArmModel,
    programs: &[(&str, &str)],
) -> ControllerConfig {
    let mut config = ControllerConfig::new(name, model)
        .with_port(COMMAND_PORT, 0)
        .with_port(STATUS_PORT, 0);
    for (name, text) in programs {
        config = config.with_program(ProgramSource::new(*name, *text));
    }
    for (name, text) in INCLUDES {
        config = config.with_include(ProgramSource::new(*name, *text));
    }
    config
}
