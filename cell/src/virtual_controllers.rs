//! Starts the virtual controllers of a configuration and tells the robots where they are.

use std::collections::BTreeMap;
use std::path::Path;
use std::sync::Arc;

use anyhow::{Context as _, Result, bail};
use api::Tier;
use karel_emulator::cell_server::STATUS_PORT;
use karel_emulator::gripper::GripperConfig;
use karel_emulator::{
    Clock, ControlAccess, ControllerConfig, PeerLabels, ProgramSource, SecondClient,
    VirtualController,
};
use kinematics::{ArmModel, PendantJoints};
use server::config::{CellSection, RobotSection};

use crate::config::{PanelAccess, Runs, SecondClientWord, VirtualControllerSection};
use crate::plant::ControllerAt;
use crate::world::World;

/// The program a virtual controller runs unless the configuration names another.
const SOCK_SERVER: &str = include_str!("../../programs/sock_server.kl");
/// How a robot's `controller` refers to a virtual one.
const SCHEME: &str = "virtual:";

/// A virtual controller that runs, and where robots reach it.
#[derive(Debug)]
pub(crate) struct Running {
    pub(crate) name: String,
    pub(crate) at: ControllerAt,
    pub(crate) controller: VirtualController,
}

/// A virtual controller that was checked and has not started.
#[derive(Debug)]
pub(crate) struct Prepared {
    key: String,
    name: String,
    robot_port: u16,
    status_port: Option<u16>,
    config: ControllerConfig,
    clock: Clock,
}

impl Prepared {
    pub(crate) fn name(&self) -> &str {
        &self.name
    }
}

/// The virtual controller that a robot refers to.
pub(crate) fn name_of(robot: &RobotSection) -> Option<&str> {
    robot.controller.strip_prefix(SCHEME)
}

/// Checks every section and reads its programs, in the order of the file.
///
/// # Errors
/// The first key that does not fit, with its value and the limit.
pub(crate) fn prepare_all(
    sections: &[VirtualControllerSection],
    folder: &Path,
    world_of: &dyn Fn(&str) -> Option<World>,
) -> Result<Vec<Prepared>> {
    let mut prepared: Vec<Prepared> = Vec::with_capacity(sections.len());
    for (index, section) in sections.iter().enumerate() {
        let key = format!("virtual_controllers[{index}]");
        if prepared.iter().any(|other| other.name == section.name) {
            bail!(
                "{key}.name: `{}` is the name of an earlier controller",
                section.name
            );
        }
        let (mut config, clock) = prepare(section, folder, &key)?;
        if let Some(world) = world_of(&section.name) {
            config = config.with_workpieces(Arc::new(world));
        }
        prepared.push(Prepared {
            key,
            name: section.name.clone(),
            robot_port: section.robot_port,
            status_port: (section.runs != Runs::SockServer && section.programs.is_empty())
                .then_some(STATUS_PORT),
            config,
            clock,
        });
    }
    Ok(prepared)
}

/// Starts every controller.
///
/// # Errors
/// The first that does not start, by its name.
pub(crate) async fn start_all(
    prepared: Vec<Prepared>,
    labels: &PeerLabels,
) -> Result<Vec<Running>> {
    let mut running = Vec::with_capacity(prepared.len());
    for part in prepared {
        let controller = VirtualController::start(&part.config, part.clock, labels.clone())
            .with_context(|| format!("starting {} `{}`", part.key, part.name))?;
        let status = match part.status_port {
            Some(port) => Some(controller.address_of_port(port).await?),
            None => None,
        };
        running.push(Running {
            at: ControllerAt {
                command: controller.address_of_port(part.robot_port).await?,
                status,
            },
            name: part.name,
            controller,
        });
    }
    Ok(running)
}

/// What a section says, checked.
fn prepare(
    section: &VirtualControllerSection,
    folder: &Path,
    key: &str,
) -> Result<(ControllerConfig, Clock)> {
    let Some(model) = ArmModel::builtin(&section.model) else {
        let known = ArmModel::builtin_names().join(", ");
        bail!(
            "{key}.model: `{}` is none of the models: {known}",
            section.model
        );
    };
    let runs_ours = section.programs.is_empty();
    let mut config = match section.runs {
        Runs::CellServer if runs_ours => ControllerConfig::cell_server(&*section.name, model)
            .with_gripper(GripperConfig::default()),
        Runs::SeedStatus if runs_ours => ControllerConfig::seed_status(&*section.name, model),
        Runs::CellServer | Runs::SeedStatus | Runs::SockServer => {
            ControllerConfig::new(&*section.name, model)
        }
    };
    for path in &section.programs {
        let path = folder.join(path);
        let text = std::fs::read(&path)
            .with_context(|| format!("{key}.programs: reading {}", path.display()))?;
        config = config.with_program(ProgramSource::new(path.display().to_string(), text));
    }
    if runs_ours && section.runs == Runs::SockServer {
        config = config.with_program(ProgramSource::new("sock_server.kl", SOCK_SERVER));
    }
    config.port_map.extend(
        section
            .ports
            .iter()
            .map(|(program, host)| (*program, *host)),
    );
    config.fidelity = section.fidelity;
    config.generation = section.generation;
    config.second_client = match section.second_client {
        SecondClientWord::Backlog => SecondClient::Backlog,
        SecondClientWord::Refuse => SecondClient::Refuse,
    };
    if let Some(degrees) = section.start_joints_deg {
        config.start_joints = PendantJoints::try_from_degrees(degrees)
            .with_context(|| format!("{key}.start_joints_deg"))?;
    }
    if let Some(panel) = &section.panel {
        let address = panel
            .parse()
            .with_context(|| format!("{key}.panel: `{panel}` is not `address:port`"))?;
        config.panel = Some(address);
        config.control = match section.panel_access {
            PanelAccess::LookOnly => ControlAccess::LookOnly,
            PanelAccess::Control => ControlAccess::Control,
        };
    }
    let scale = section.time_scale;
    let clock = Clock::scaled(scale)
        .with_context(|| format!("{key}.time_scale: {scale} is not above 0 and at most 1000"))?;
    Ok((config, clock))
}

/// Puts the addresses of the running controllers in the place of `virtual:NAME`.
///
/// # Errors
/// A robot refers to a controller that is not in the file.
pub(crate) fn resolve(
    cells: &mut [CellSection],
    addresses: &BTreeMap<String, ControllerAt>,
) -> Result<()> {
    for (c, cell) in cells.iter_mut().enumerate() {
        for (r, robot) in cell.robots.iter_mut().enumerate() {
            let Some(name) = robot.controller.strip_prefix(SCHEME) else {
                continue;
            };
            let Some(at) = addresses.get(name) else {
                bail!("cells[{c}].robots[{r}].controller: no virtual controller is named `{name}`");
            };
            robot.controller = at.command.to_string();
            if robot.tier != Tier::Seed && robot.status_controller.is_none() {
                robot.status_controller = at.status.map(|status| status.to_string());
            }
        }
    }
    Ok(())
}
