//! The state of a cell in short, for whoever watches it.

use api::{CellStatus, JobStatus, LoadStatus, PointStatus, TimerStatus};
use workflow::view::TimerView;
use workflow::{Cell, Millis, Permit, TimerKey};

use crate::words::word;

/// What is shown of a cell at a time of its own clock.
pub(super) fn status(cell: &Cell, now: Millis) -> CellStatus {
    let sessions = cell.sessions(now);
    let open = cell
        .jobs(now)
        .into_iter()
        .filter(|job| !job.state.is_final());
    let questions = cell.interventions().into_iter().filter(|one| one.open);
    CellStatus {
        jobs: open
            .map(|job| JobStatus {
                job: job.id,
                number: job.number,
                state: word(&job.state),
                phase: job.phase.as_ref().map(word),
                code: job.code.filter(|code| !code.is_empty()).map(str::to_owned),
                timers: job.timers.iter().map(timer).collect(),
            })
            .collect(),
        points: cell
            .permits()
            .into_iter()
            .map(|(point, permit)| PointStatus {
                arm_entry_permit: permit == Permit::ArmEntry,
                mr_move_permit: permit == Permit::MrMove,
                session: sessions
                    .iter()
                    .find(|session| session.point == point && !session.state.is_closed())
                    .map(|session| word(&session.state)),
                point,
            })
            .collect(),
        loads: cell
            .custody()
            .into_iter()
            .map(|view| LoadStatus {
                load: view.id,
                at: view.load.location.to_string(),
            })
            .collect(),
        questions: questions
            .map(|one| format!("{} {}", one.code, one.question.question))
            .collect(),
    }
}

fn timer(view: &TimerView) -> TimerStatus {
    let name = match &view.timer {
        TimerKey::Queue { .. } => "queue",
        TimerKey::Deadline { .. } => "deadline",
        TimerKey::Step { .. } => "step",
        TimerKey::State { .. } => "state",
        TimerKey::Prefetch { .. } => "hold",
        TimerKey::Operation { .. } => "operation",
        TimerKey::Safe { .. } => "safe",
        TimerKey::Session { .. } => "session",
        TimerKey::Heartbeat { .. } => "heartbeat",
        TimerKey::ArmSeen { .. } => "arm",
        TimerKey::Parked { .. } => "parked",
        TimerKey::Question { .. } => "question",
    };
    TimerStatus {
        timer: name.to_owned(),
        left_ms: view.left_ms,
        total_ms: view.total_ms,
    }
}
