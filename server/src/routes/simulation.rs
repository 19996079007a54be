//! A job in virtual time, before it is asked for in earnest.

use std::sync::Arc;
use std::time::Duration;

use api::{JobBody, JobSimulation, ProblemCode};
use axum::Json;
use axum::extract::State;
use workflow::Input;

use super::jobs::{admitted, cell_to_change};
use super::params::{CellId, CellPath};
use super::responses::{AnyProblem, BodyProblem, CrossSite, NotFound};
use crate::extract::ListJson;
use crate::jobs;
use crate::problem::Problem;
use crate::simulation::scene;
use crate::state::App;

/// After which time a simulation that runs is likely to be over.
const SOON: Duration = Duration::from_secs(5);

/// Plays a whole job in virtual time, and tells what would become of it and how long it would take.
///
/// The job runs against virtual robots of its own, from where the cell is now: loads, arms and mobile robots. Nothing
/// of the cell changes, no robot of it is asked or told anything, and no key is needed. Other jobs are left out, and
/// `assumptions` says what was supposed instead. It is checked as a new job is; one simulation runs at a time, for at
/// most 30 s and two simulated hours, and it ends when the caller goes away.
#[utoipa::path(
    post, path = "/api/v1/cells/{cell}/jobs/simulate", tag = "jobs",
    params(CellPath),
    request_body = JobBody,
    responses(
        (status = 200, description = "What became of it.", body = JobSimulation),
        (status = 400, description = "`invalid-json`.", body = api::Problem, content_type = "application/problem+json"),
        (status = 409, description = "`custody-unknown`: nobody knows where a load is.",
            body = api::Problem, content_type = "application/problem+json"),
        (status = 422, description = "`validation`: an item does not fit the set-up, or where the loads are.",
            body = api::Problem, content_type = "application/problem+json"),
        (status = 500, description = "`simulation-failed`: it broke off.", body = api::Problem, content_type = "application/problem+json"),
        (status = 501, description = "`simulator-missing`: the server was started without one.", body = api::Problem, content_type = "application/problem+json"),
        (status = 503, description = "`simulator-busy`: another one runs. `cell-not-ready`.", body = api::Problem, content_type = "application/problem+json",
            headers(("retry-after" = u32, description = "Seconds after which to try again."))),
        CrossSite, NotFound, BodyProblem, AnyProblem,
    ),
)]
pub(super) async fn simulate_job(
    State(app): State<Arc<App>>,
    CellId(cell): CellId,
    ListJson(body): ListJson<JobBody>,
) -> Result<Json<JobSimulation>, Problem> {
    let cell = cell_to_change(&app, &cell)?;
    let Some(simulator) = &app.simulator else {
        return Err(Problem::not_sent(
            ProblemCode::SimulatorMissing,
            "this server was started without a simulator: the program `robocell` has one, a server that is embedded \
             needs `Plan::with_simulator`",
        ));
    };
    let job = admitted(cell, &body, app.clock.now()).await?;
    let input = Input::CreateJob { job: Box::new(job) };
    cell.work
        .would_take(input, &app.clock)
        .map_err(|refused| jobs::problem(refused, ProblemCode::WrongJobState, "params."))?;
    let scene = scene(cell, body, app.clock.now())?;
    let Ok(_alone) = app.simulating.try_acquire() else {
        return Err(Problem::not_sent(
            ProblemCode::SimulatorBusy,
            "another simulation runs, and there is one at a time",
        )
        .retry_after(SOON));
    };
    let simulated = simulator.simulate(scene).await.map_err(|error| {
        tracing::warn!(cell.id = cell.id, %error, "a simulation failed");
        Problem::not_sent(ProblemCode::SimulationFailed, error.to_string())
    })?;
    Ok(Json(*simulated))
}
