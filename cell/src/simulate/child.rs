//! The process that simulates: reads a task, runs its cell in virtual time, writes what became of the job.

use std::io::{Read as _, Write as _};
use std::time::Duration;

use anyhow::{Context as _, Result};
use api::{Job, JobSimulation, JobState, LinkState, SimulationEnd, Tier};
use client::{Ask, Client};
use serde::{Deserialize, Serialize};
use server::{SharedJournal, WallClock as _, simulated_story};
use tokio::net::TcpListener;
use tokio::time::{Instant, sleep};
use tokio_util::sync::CancellationToken;

use super::Task;
use super::pace::{Reached, SimulatedClock, pace};
use super::violations::violations;
use crate::Assembly;
use crate::start::url_of;

/// How often the job is looked at. What is told of it comes from the journal, so this makes nothing less precise.
const LOOK: Duration = Duration::from_millis(200);
/// How long a private cell may take until its robots are there, in simulated time.
const WARM_UP: Duration = Duration::from_secs(30);
/// How long a job has to stand with its question before it is taken for standing.
const STANDING: Duration = Duration::from_secs(3);

/// What the process says on standard output.
#[derive(Debug, Deserialize, Serialize)]
#[serde(rename_all = "snake_case")]
pub(super) enum Report {
    /// What became of the job.
    Done(Box<JobSimulation>),
    /// Why that is not known.
    Failed(String),
}

/// Does what the task on standard input says.
///
/// # Errors
/// Standard input or output is closed. What fails in the simulation is part of the report.
pub(crate) fn child() -> Result<()> {
    let mut task = Vec::new();
    let _bytes = std::io::stdin().read_to_end(&mut task)?;
    let report = match played(&task) {
        Ok(simulation) => Report::Done(Box::new(simulation)),
        Err(error) => Report::Failed(format!("{error:#}")),
    };
    let mut out = std::io::stdout().lock();
    out.write_all(&serde_json::to_vec(&report)?)?;
    Ok(out.flush()?)
}

fn played(task: &[u8]) -> Result<JobSimulation> {
    let task: Task = serde_json::from_slice(task).context("reading the task")?;
    if let Err(error) = rustix::process::nice(task.limits.nice) {
        tracing::debug!(%error, "the simulation runs at the usual priority");
    }
    // One thread, and no other: time passes only when everything has been done.
    let runtime = tokio::runtime::Builder::new_current_thread()
        .enable_all()
        .start_paused(true)
        .build()?;
    runtime.block_on(play(task))
}

/// A private cell that runs.
struct Running {
    assembly: Assembly,
    client: Client,
    journal: SharedJournal,
    clock: std::sync::Arc<SimulatedClock>,
    /// When the emulators' clocks began.
    began: Instant,
}

async fn play(task: Task) -> Result<JobSimulation> {
    let real = std::time::Instant::now();
    let mut pacing = tokio::spawn(pace(task.limits));
    let ready = async {
        let cell = Running::start(&task).await?;
        cell.until_ready(&task).await?;
        let asked = Instant::now();
        let jobs = cell.client.jobs(&task.cell);
        let job = jobs.create(&task.job, &Ask::default()).await?;
        anyhow::Ok((cell, asked, job))
    };
    let (cell, asked, first) = tokio::select! {
        ready = ready => ready?,
        reached = &mut pacing => anyhow::bail!("{:?} time ran out before the job began", reached?),
    };
    let mut last = first;
    let ended = tokio::select! {
        ended = cell.follow(&task, &mut last) => ended?,
        reached = &mut pacing => match reached? {
            Reached::Wall => SimulationEnd::WallTimeLimit,
            Reached::Simulated => SimulationEnd::SimulatedTimeLimit,
        },
    };
    // Nothing below waits for time: if the pacing is over, time stands.
    let story = simulated_story(&cell.journal, &task.cell, last.id, cell.clock.now()).await?;
    let offset = millis(asked - cell.began);
    let total_ms = story.report.total_ms;
    let violations = violations(&cell.assembly, &task.cell, offset, total_ms, &story.loads).await?;
    Ok(JobSimulation {
        outcome: story.report.state,
        ended,
        text: last.text,
        fault: last.fault,
        simulated_s: Duration::from_millis(total_ms).as_secs_f64(),
        wall_ms: millis(real.elapsed()),
        report: story.report,
        motions: story.motions,
        permits: story.permits,
        custody: story.custody,
        interventions: story.interventions,
        violations,
        loads: story.loads,
        assumptions: task.assumptions,
    })
}

impl Running {
    async fn start(task: &Task) -> Result<Self> {
        let began = Instant::now();
        let clock = SimulatedClock::from(task.now);
        let mut assembly = Assembly::start(&task.config, &task.setup).await?;
        for (name, percent) in &task.overrides {
            if let Some(controller) = assembly.controller(name) {
                controller.set_override(i32::from(*percent)).await?;
            }
        }
        let listener = TcpListener::bind("127.0.0.1:0").await?;
        let address = listener.local_addr()?;
        let journal = SharedJournal::volatile();
        let serving = assembly.serve_by(
            clock.clone(),
            listener,
            journal.clone(),
            CancellationToken::new(),
        )?;
        drop(tokio::spawn(serving));
        assembly.start_mobile_robots(address)?;
        Ok(Self {
            assembly,
            client: Client::new(&url_of(address))?,
            journal,
            clock,
            began,
        })
    }

    /// Waits until the arms' controllers and the mobile robots are heard: the cell that is simulated runs already.
    async fn until_ready(&self, task: &Task) -> Result<()> {
        let until = Instant::now() + WARM_UP;
        let jobs = self.client.jobs(&task.cell);
        loop {
            sleep(LOOK).await;
            let robots = self.client.robots(&task.cell).await?;
            let state = jobs.state().await?;
            let arms = state.arms.iter().all(|arm| {
                let tier = robots.iter().find(|robot| robot.id == arm.id);
                let asked = tier.is_some_and(|robot| robot.tier == Tier::CellServer);
                !asked || matches!(arm.link, LinkState::Monitor | LinkState::Control)
            });
            let mobile = self.client.mobile_robots(&task.cell).await?;
            let all = mobile.len() >= task.mobile_robots;
            if arms && all && mobile.iter().all(|robot| robot.connected) {
                return Ok(());
            }
            if Instant::now() >= until {
                anyhow::bail!("the private cell did not come up: {state:?}, {mobile:?}");
            }
        }
    }

    /// Follows the job until nothing more happens by itself.
    async fn follow(&self, task: &Task, last: &mut Job) -> Result<SimulationEnd> {
        let jobs = self.client.jobs(&task.cell);
        let mut standing = None;
        loop {
            let job = jobs.get(last.id).await?;
            if job.state.is_final() || job.state == JobState::Aborted {
                *last = job;
                return Ok(SimulationEnd::JobOver);
            }
            let same = job.state == last.state && job.intervention == last.intervention;
            let asks = job.intervention.is_some();
            *last = job;
            if !asks || !same {
                standing = None;
            } else if Instant::now() >= *standing.get_or_insert_with(|| Instant::now() + STANDING) {
                return Ok(SimulationEnd::AsksAPerson);
            }
            sleep(LOOK).await;
        }
    }
}

fn millis(duration: Duration) -> u64 {
    u64::try_from(duration.as_millis()).unwrap_or(u64::MAX)
}
