//! Starts the virtual mobile robots of a configuration, and keeps their slots and the world's parts the same.

use std::collections::BTreeMap;
use std::path::Path;
use std::sync::Arc;

use anyhow::{Context as _, Result, anyhow, bail};
use api::setup::{MobileRobotSetup, SetupFile};
use api::{FloorPoseBody, TokenSecret};
use client::Client;
use mobile_emulator::config::{FootprintSection, PointSection, ViewSection};
use mobile_emulator::{CellAddress, Clock, MobileConfig, MobileRobot};
use tokio_util::sync::CancellationToken;
use tokio_util::task::TaskTracker;

use crate::config::VirtualMobileRobotSection;
use crate::world::{SlotChange, World};

/// How long goods are handed over at a destination outside the cell.
const UNLOAD_S: f64 = 2.0;

/// A virtual mobile robot that was checked and has not started.
#[derive(Debug)]
pub(crate) struct Prepared {
    pub(crate) cell: String,
    config: MobileConfig,
    clock: Clock,
    token: Option<TokenSecret>,
}

/// Checks a section against the set-up of its cell.
///
/// # Errors
/// The key that does not fit, with its value.
pub(crate) fn prepare(
    section: &VirtualMobileRobotSection,
    setup: &SetupFile,
    folder: &Path,
    key: &str,
) -> Result<Prepared> {
    let Some(robot) = setup
        .mobile_robots
        .iter()
        .find(|robot| robot.id == section.id)
    else {
        let known: Vec<_> = setup
            .mobile_robots
            .iter()
            .map(|robot| robot.id.as_str())
            .collect();
        bail!(
            "{key}.id: `{}` is none of the mobile robots of the set-up: {}",
            section.id,
            known.join(", ")
        );
    };
    let mut config = match &section.config {
        Some(path) => {
            let path = folder.join(path);
            let text = std::fs::read_to_string(&path)
                .with_context(|| format!("{key}.config: reading {}", path.display()))?;
            MobileConfig::from_toml(&text).with_context(|| format!("in {}", path.display()))?
        }
        None => MobileConfig::default(),
    };
    take_setup(&mut config, robot, setup);
    if let Some(start) = section.start {
        config.start = FloorPoseBody {
            x_mm: start.x_mm,
            y_mm: start.y_mm,
            heading_deg: start.heading_deg,
        };
    }
    if let Some(view) = &section.view {
        let address = view
            .parse()
            .with_context(|| format!("{key}.view: `{view}` is not `address:port`"))?;
        config.view = Some(ViewSection {
            address,
            expose_to_network: false,
        });
    }
    config
        .check()
        .with_context(|| format!("{key} `{}`", section.id))?;
    let scale = section.time_scale;
    let clock = Clock::scaled(scale)
        .ok_or_else(|| anyhow!("{key}.time_scale: {scale} is not above 0 and at most 1000"))?;
    let token = section
        .token_file
        .as_ref()
        .map(|path| {
            let path = folder.join(path);
            let text = std::fs::read_to_string(&path)
                .with_context(|| format!("{key}.token_file: reading {}", path.display()))?;
            Ok::<_, anyhow::Error>(TokenSecret::new(text.trim().to_owned()))
        })
        .transpose()?;
    Ok(Prepared {
        cell: section.cell.clone(),
        config,
        clock,
        token,
    })
}

/// What the set-up says of a mobile robot holds: its slots, its outline, where it begins, and the map.
fn take_setup(config: &mut MobileConfig, robot: &MobileRobotSetup, setup: &SetupFile) {
    config.id.clone_from(&robot.id);
    config.footprint = FootprintSection {
        length_mm: robot.footprint.length_mm,
        width_mm: robot.footprint.width_mm,
    };
    config.slots.clear();
    for slot in &robot.slots {
        let load = setup.loads.iter().find(|load| {
            let on = load.on.as_ref();
            on.is_some_and(|on| on.mobile_robot == robot.id && on.slot == slot.id)
        });
        *config = std::mem::take(config).with_slot(&slot.id, load.map(|load| load.id.as_str()));
    }
    let mut map = Vec::new();
    for station in &setup.stations {
        for point in &station.points {
            let id = format!("{}/{}", station.id, point.id);
            let pose = FloorPoseBody {
                x_mm: point.dock.x_mm,
                y_mm: point.dock.y_mm,
                heading_deg: point.dock.heading_deg,
            };
            if robot.home.as_deref() == Some(&id) {
                config.start = pose;
            }
            let is_destination = setup.destinations.iter().any(|known| known.point == id);
            // Points where an arm works come with each order, and with the zone.
            if point.arms.is_empty() {
                map.push(PointSection {
                    id,
                    pose,
                    zone: None,
                    unload_s: is_destination.then_some(UNLOAD_S),
                });
            }
        }
    }
    config.points = map;
}

impl Prepared {
    /// Where the robot stands at the start.
    pub(crate) fn start_pose(&self) -> FloorPoseBody {
        self.config.start
    }

    /// Starts the robot; from then on the world and its slots are the same.
    ///
    /// # Errors
    /// Its view cannot be opened, or the server's address is none.
    pub(crate) fn start(
        self,
        server: &str,
        world: &World,
        tracker: &TaskTracker,
        stop: &CancellationToken,
    ) -> Result<Arc<MobileRobot>> {
        let id = self.config.id.clone();
        let mut client = Client::new(server)?;
        if let Some(token) = &self.token {
            client = client.with_token(token)?;
        }
        let cell = CellAddress::through(client, &self.cell);
        let changes = world.add_mobile_robot(&id, self.start_pose());
        let robot = MobileRobot::start(&self.config, self.clock, &cell)
            .with_context(|| format!("starting the virtual mobile robot `{id}`"))?;
        let states = robot.subscribe();
        let robot = Arc::new(robot);
        drop(tracker.spawn(follow(id, states, world.clone(), stop.clone())));
        drop(tracker.spawn(hand_over(Arc::clone(&robot), changes, stop.clone())));
        Ok(robot)
    }
}

/// Tells the world where the robot truly is and what it truly carries.
async fn follow(
    id: String,
    mut states: tokio::sync::watch::Receiver<mobile_emulator::State>,
    world: World,
    stop: CancellationToken,
) {
    loop {
        {
            let state = states.borrow_and_update();
            world.mobile_robot_at(&id, state.pose);
            let slots: BTreeMap<_, _> = state
                .slots
                .iter()
                .map(|slot| (slot.slot.clone(), slot.load.clone()))
                .collect();
            drop(state);
            world.mobile_robot_carries(&id, &slots);
        }
        let changed = stop.run_until_cancelled(states.changed()).await;
        if !matches!(changed, Some(Ok(()))) {
            return;
        }
    }
}

/// Puts into the robot's slots what a gripper let go there, and takes out what one took.
async fn hand_over(
    robot: Arc<MobileRobot>,
    mut changes: tokio::sync::mpsc::Receiver<SlotChange>,
    stop: CancellationToken,
) {
    while let Some(Some(change)) = stop.run_until_cancelled(changes.recv()).await {
        let done = match &change {
            SlotChange::Put { slot, part } => robot.put(slot, part).await,
            SlotChange::Taken { slot } => robot.take(slot).await.map(drop),
        };
        if let Err(refusal) = done {
            tracing::warn!(?change, %refusal, "a slot of a mobile robot is not what the world says");
        }
    }
}
