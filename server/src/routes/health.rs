//! For whoever watches the server.

use std::sync::Arc;

use api::{JournalReadiness, LinkReadiness, Liveness, Readiness};
use axum::Json;
use axum::extract::State;
use axum::http::{HeaderName, StatusCode, header};

use super::responses::AnyProblem;
use crate::journal::Keeps;
use crate::state::{App, Robot};

/// Says that the process answers.
#[utoipa::path(
    get, path = "/livez", tag = "health",
    responses((status = 200, description = "It answers.", body = Liveness), AnyProblem),
)]
pub(super) async fn livez() -> Json<Liveness> {
    Json(Liveness { alive: true })
}

/// Says whether the server takes commands: every link does, and the journal can be written.
#[utoipa::path(
    get, path = "/readyz", tag = "health",
    responses(
        (status = 200, description = "Every link takes commands.", body = Readiness),
        (status = 503, description = "A link does not, as when the server is stopping, or the journal cannot be written, or has only its reserve left: then nothing moves.", body = Readiness),
        AnyProblem,
    ),
)]
pub(super) async fn readyz(State(app): State<Arc<App>>) -> (StatusCode, Json<Readiness>) {
    let links: Vec<_> = robots(&app).map(|robot| link_readiness(robot)).collect();
    let lost = app.audit_health.lost();
    let room = app.journal.room();
    let audit = (lost > 0)
        .then(|| format!("{lost} entries of who did what are in the log and not in the journal"));
    let problem = match (app.journal.broken(), &room) {
        (Some(trouble), _) | (None, Err(trouble)) => Some(trouble.to_string()),
        (None, Ok(())) => audit,
    };
    let journal = JournalReadiness {
        writable: app.journal.broken().is_none(),
        durable: app.journal.keeps() == Keeps::OverRestarts,
        epoch: app.journal.epoch().0,
        last_record: app.journal.head().position.0,
        on_reserve: room.is_err(),
        audit_lost: lost,
        problem,
    };
    let ready = journal.writable && !journal.on_reserve && links.iter().all(|link| link.running);
    let status = if ready {
        StatusCode::OK
    } else {
        StatusCode::SERVICE_UNAVAILABLE
    };
    let readiness = Readiness {
        ready,
        links,
        journal,
    };
    (status, Json(readiness))
}

/// Counts and durations, in the Prometheus text format.
#[utoipa::path(
    get, path = "/metrics", tag = "health",
    responses((status = 200, description = "The metrics.", body = String, content_type = "text/plain; version=0.0.4"), AnyProblem),
)]
pub(super) async fn metrics(
    State(app): State<Arc<App>>,
) -> ([(HeaderName, &'static str); 1], String) {
    for robot in robots(&app) {
        robot.metrics.queued(robot.link.depth().0);
    }
    let runtime = tokio::runtime::Handle::current();
    app.metrics.tasks(runtime.metrics().num_alive_tasks());
    let media_type = "text/plain; version=0.0.4; charset=utf-8";
    ([(header::CONTENT_TYPE, media_type)], app.metrics.render())
}

fn robots(app: &App) -> impl Iterator<Item = &Arc<Robot>> {
    app.cells.iter().flat_map(|cell| &cell.robots)
}

fn link_readiness(robot: &Robot) -> LinkReadiness {
    LinkReadiness {
        cell: robot.plan.cell.clone(),
        robot: robot.plan.id.clone(),
        running: robot.link.is_running(),
        state: robot.link.state(),
    }
}
