//! A cell as a whole, now.

use std::sync::Arc;

use api::{
    AlarmLevel, ArmState, CellAlarm, CellState, JobCount, JobState, OperationalMode, SafetyState,
};
use axum::Json;
use axum::extract::State;
use jiff::Timestamp;
use protocol::v2::OperatingMode;
use uuid::Uuid;
use workflow::view::{ClaimView, JobView};
use workflow::{Holder, Location, Resource};

use super::params::{CellId, CellPath};
use super::responses::{AnyProblem, NotFound};
use crate::cell::safety;
use crate::jobs;
use crate::link::cell_server::ControllerView;
use crate::problem::Problem;
use crate::state::{App, Cell, Robot, RobotLink};

/// The states of jobs from the one that needs a person most to the one that needs nobody: the cell is in the first that
/// any of its jobs is in.
const URGENCY: [JobState; 15] = [
    JobState::Aborting,
    JobState::Aborted,
    JobState::Clearing,
    JobState::Holding,
    JobState::Held,
    JobState::Stopping,
    JobState::Suspending,
    JobState::Unholding,
    JobState::Unsuspending,
    JobState::Execute,
    JobState::Starting,
    JobState::Completing,
    JobState::Suspended,
    JobState::Resetting,
    JobState::Idle,
];

/// Shows a cell: its state in the words of `PackML`, arms, permits, who has control, what waits for a person, what is wrong.
#[utoipa::path(
    get, path = "/api/v1/cells/{cell}/state", tag = "cells",
    params(CellPath),
    responses((status = 200, description = "The state.", body = CellState), NotFound, AnyProblem),
)]
pub(super) async fn get_cell_state(
    State(app): State<Arc<App>>,
    CellId(cell): CellId,
) -> Result<Json<CellState>, Problem> {
    let cell = app.cell(&cell)?;
    let work = cell.work.view();
    let now = cell.work.clock().now();
    let open: Vec<_> = work
        .jobs(now)
        .into_iter()
        .filter(|job| !job.state.is_final())
        .collect();
    let (state, job) = whole(&open);
    let claims = work.claims();
    let journal_writable = app.journal.broken().is_none();
    let loads_unknown: Vec<_> = work
        .custody()
        .into_iter()
        .filter(|load| matches!(load.load.location, Location::Unknown { .. }))
        .map(|load| load.id)
        .collect();
    let clock = i64::try_from(now).ok();
    let clock = clock.and_then(|now| Timestamp::from_millisecond(now).ok());
    Ok(Json(CellState {
        cell: cell.id.clone(),
        state,
        job,
        clock: clock.unwrap_or(Timestamp::MAX),
        control: cell.control.view(),
        jobs_may_act: cell.control.jobs_may_act(),
        journal_writable,
        arms: cell
            .robots
            .iter()
            .map(|arm| arm_state(arm, &claims))
            .collect(),
        permits: jobs::permits(&work, &work.sessions(now)),
        open_jobs: counts(&open),
        open_interventions: super::interventions::open(cell),
        alarms: alarms(cell, &loads_unknown, &open, journal_writable),
        loads_unknown,
    }))
}

/// The cell's state in one word, and the job it is of.
fn whole(open: &[JobView]) -> (JobState, Option<Uuid>) {
    let urgency = |job: &&JobView| {
        let state = jobs::state_of(job.state);
        let rank = URGENCY.iter().position(|known| *known == state);
        (rank.unwrap_or(URGENCY.len()), job.number)
    };
    match open.iter().min_by_key(urgency) {
        Some(job) if job.state != workflow::JobState::Idle => {
            (jobs::state_of(job.state), Some(job.id))
        }
        Some(_) | None => (JobState::Idle, None),
    }
}

fn counts(open: &[JobView]) -> Vec<JobCount> {
    let count = |state: JobState| {
        open.iter()
            .filter(|job| jobs::state_of(job.state) == state)
            .count()
    };
    URGENCY
        .into_iter()
        .map(|state| JobCount {
            state,
            jobs: count(state),
        })
        .filter(|one| one.jobs > 0)
        .collect()
}

fn arm_state(robot: &Robot, claims: &[ClaimView]) -> ArmState {
    let line = controller(robot).and_then(|view| view.status);
    let line = line.as_ref().map(|seen| &seen.line);
    let arm = Resource::Arm(robot.plan.id.clone());
    ArmState {
        id: robot.plan.id.clone(),
        link: robot.link.state(),
        safety: line.map_or(SafetyState::Unknown, |line| match safety(line) {
            workflow::Safety::Normal | workflow::Safety::Reduced => SafetyState::Normal,
            workflow::Safety::ProtectiveStop => SafetyState::ProtectiveStop,
            workflow::Safety::EmergencyStop => SafetyState::EmergencyStop,
            workflow::Safety::Fault => SafetyState::Fault,
            workflow::Safety::Unknown => SafetyState::Unknown,
        }),
        mode: line.map(|line| match line.mode {
            OperatingMode::T1 => OperationalMode::ManualReducedSpeed,
            OperatingMode::T2 => OperationalMode::ManualHighSpeed,
            OperatingMode::Auto => OperationalMode::Automatic,
        }),
        job: claims
            .iter()
            .find(|claim| claim.resource == arm)
            .and_then(|claim| match claim.by {
                Holder::Job(job) => Some(job),
                Holder::Session(_) => None,
            }),
    }
}

/// What a controller says of itself, while it is connected.
fn controller(robot: &Robot) -> Option<ControllerView> {
    match &robot.link {
        RobotLink::Seed(_) => None,
        RobotLink::CellServer(link) => Some(link.view()).filter(ControllerView::is_connected),
    }
}

fn alarms(
    cell: &Cell,
    loads_unknown: &[String],
    open: &[JobView],
    journal_writable: bool,
) -> Vec<CellAlarm> {
    let mut alarms = Vec::new();
    let mut say = |level, source: &str, text: String| {
        alarms.push(CellAlarm {
            level,
            source: source.to_owned(),
            text,
        });
    };
    if !journal_writable {
        let text = "the journal cannot be written: nothing new is begun".to_owned();
        say(AlarmLevel::Error, "journal", text);
    }
    for robot in &cell.robots {
        let id = &robot.plan.id;
        if let RobotLink::CellServer(link) = &robot.link {
            let view = link.view();
            if !view.is_connected() {
                let text = "the controller cannot be reached".to_owned();
                say(AlarmLevel::Error, id, text);
            } else if let Some(not_ready) = &view.not_ready {
                say(AlarmLevel::Warning, id, not_ready.to_string());
            }
        }
        if let Some(motion) = robot.motions.book.first_doubt() {
            let text = format!("nobody knows what became of motion {motion}");
            say(AlarmLevel::Error, id, text);
        }
    }
    for load in loads_unknown {
        let text = "nobody knows where it is".to_owned();
        say(AlarmLevel::Error, load, text);
    }
    let mobile_robots = cell.work.view().mobile_robots();
    for mobile in mobile_robots {
        if mobile.session.is_some() && !mobile.heard {
            let text = "it is in a hand-over and is not heard".to_owned();
            say(AlarmLevel::Error, &mobile.id, text);
        }
        for error in mobile.state.into_iter().flat_map(|state| state.errors) {
            let level = if error.fatal {
                AlarmLevel::Error
            } else {
                AlarmLevel::Warning
            };
            let text = format!("{}: {}", error.kind, error.description);
            say(level, &mobile.id, text);
        }
    }
    for job in open {
        if job.state == workflow::JobState::Aborted {
            let text = format!("aborted: {}", job.text);
            say(AlarmLevel::Error, &format!("job {}", job.number), text);
        }
    }
    alarms.sort_by_key(|alarm| alarm.level);
    alarms
}
