//! Jobs in virtual time: a private cell, in a process of its own, whose clock goes as fast as the machine allows.
//!
//! ```text
//! server ── Scene ─▶ Simulator ── Task on stdin ─▶ robocell --simulate: server + emulators + world, paused clock
//!                        ◀────────── Report on stdout ──┘
//! ```
//!
//! A process of its own, because the real cell must not notice: its time is the real one, its runtime is not crowded,
//! and whatever goes wrong over there, killing the process takes every task, socket and byte of it away.

mod child;
mod pace;
mod task;
mod violations;

use std::collections::BTreeMap;
use std::path::PathBuf;
use std::process::Stdio;
use std::sync::Arc;
use std::time::Duration;

use anyhow::{Context as _, Result, bail};
use server::config::CellSection;
use server::{JobSimulator, Scene, Simulating, SimulationError};
use tokio::io::{AsyncReadExt as _, AsyncWriteExt as _};
use tokio::process::Command;
use tokio::time::timeout;

use crate::config::File;

use child::Report;
pub(crate) use child::child;
use task::Limits;
pub(crate) use task::Task;

/// How long a simulation may take in real time. What it has found out until then is told.
const WALL_LIMIT: Duration = Duration::from_secs(30);
/// How far a simulation may go.
const SIMULATED_LIMIT: Duration = Duration::from_hours(2);
/// Whoever controls real robots beside it goes first.
const NICE: i32 = 5;
/// How much later than its limit the process is ended by force.
const PATIENCE: Duration = Duration::from_secs(10);
/// The most a process may say: far more than the longest job has to tell.
const MAX_REPORT: u64 = 64 * 1024 * 1024;

/// Plays jobs in processes of their own.
#[derive(Clone, Debug)]
pub(crate) struct Simulator {
    /// This program, `robocell`.
    program: PathBuf,
    /// The cells as they are configured.
    cells: Arc<[CellSection]>,
    /// How virtual mobile robots drive, by cell and id.
    drives: Arc<BTreeMap<(String, String), PathBuf>>,
    wall_limit: Duration,
    /// How much the process steps back behind others.
    nice: i32,
}

impl Simulator {
    /// A simulator of the cells of a configuration, whose paths are relative to `folder`.
    pub(crate) fn new(program: PathBuf, file: &File, folder: &std::path::Path) -> Self {
        let drives = file.virtual_mobile_robots.iter().filter_map(|robot| {
            let config = folder.join(robot.config.as_ref()?);
            Some(((robot.cell.clone(), robot.id.clone()), config))
        });
        Self {
            program,
            cells: file.cells.clone().into(),
            drives: Arc::new(drives.collect()),
            wall_limit: WALL_LIMIT,
            nice: NICE,
        }
    }

    /// With a limit of its own, and no less important than other processes: for a machine that has nothing real to do.
    #[must_use]
    pub(crate) fn with_patience(mut self, wall_limit: Duration) -> Self {
        self.wall_limit = wall_limit;
        self.nice = 0;
        self
    }

    /// This running program as the simulator.
    ///
    /// # Errors
    /// The system does not say where it is.
    pub(crate) fn of_this_program(file: &File, folder: &std::path::Path) -> Result<Self> {
        let program = std::env::current_exe().context("finding this program")?;
        Ok(Self::new(program, file, folder))
    }

    fn task(&self, scene: &Scene) -> Result<Task> {
        let Some(section) = self.cells.iter().find(|cell| cell.id == scene.cell) else {
            bail!("cell `{}` is not in the configuration", scene.cell);
        };
        let drive = |mobile_robot: &str| {
            let key = (scene.cell.clone(), mobile_robot.to_owned());
            self.drives.get(&key).cloned()
        };
        Task::of(
            scene,
            &section.robots,
            drive,
            Limits {
                wall: self.wall_limit,
                simulated: SIMULATED_LIMIT,
                nice: self.nice,
            },
        )
    }

    async fn play(self, scene: Scene) -> Result<Box<api::JobSimulation>> {
        let task = serde_json::to_vec(&self.task(&scene)?)?;
        let mut process = Command::new(&self.program)
            .arg("--simulate")
            .stdin(Stdio::piped())
            .stdout(Stdio::piped())
            .kill_on_drop(true)
            .spawn()
            .with_context(|| format!("starting {}", self.program.display()))?;
        let (Some(mut stdin), Some(stdout)) = (process.stdin.take(), process.stdout.take()) else {
            bail!("the process of the simulation has no pipes");
        };
        let mut said = Vec::new();
        let talk = async {
            stdin.write_all(&task).await?;
            stdin.shutdown().await?;
            drop(stdin);
            let _bytes = stdout.take(MAX_REPORT).read_to_end(&mut said).await?;
            process.wait().await
        };
        let Ok(ended) = timeout(self.wall_limit + PATIENCE, talk).await else {
            bail!("its process did not end in time, and was ended");
        };
        let status = ended.context("talking to the process of the simulation")?;
        match serde_json::from_slice(&said) {
            Ok(Report::Done(simulation)) => Ok(simulation),
            Ok(Report::Failed(reason)) => bail!("{reason}"),
            Err(_) => bail!("its process ended without a result ({status})"),
        }
    }
}

impl JobSimulator for Simulator {
    fn simulate(&self, scene: Scene) -> Simulating {
        let this = self.clone();
        Box::pin(async move {
            this.play(scene).await.map_err(|error| SimulationError {
                reason: format!("{error:#}"),
            })
        })
    }
}
