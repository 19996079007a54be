//! What the cell knows of its mobile robots.

use std::sync::Arc;

use api::{
    MobileErrorBody, MobileErrorLevel, MobileRobotState, MobileRobotSummary, OperatingMode,
    SignalData, SlotLoadBody,
};
use axum::Json;
use axum::extract::State;
use workflow::view::MobileRobotView;
use workflow::{MobileMode, MobileState};

use super::super::params::{CellId, CellPath};
use super::super::responses::{AnyProblem, NotFound};
use super::{MobileRobotOf, MobileRobotPath};
use crate::problem::Problem;
use crate::state::App;
use crate::wire_bodies::{self, floor_pose};

/// Lists the mobile robots of a cell's set-up.
#[utoipa::path(
    get, path = "/api/v1/cells/{cell}/mobile-robots", tag = "mobile-robots",
    params(CellPath),
    responses((status = 200, description = "Them.", body = [MobileRobotSummary]), NotFound, AnyProblem),
)]
pub(crate) async fn list_mobile_robots(
    State(app): State<Arc<App>>,
    CellId(cell): CellId,
) -> Result<Json<Vec<MobileRobotSummary>>, Problem> {
    let views = app.cell(&cell)?.work.view().mobile_robots();
    let summaries = views.into_iter().map(|view| MobileRobotSummary {
        connected: view.heard,
        mode: view.state.as_ref().map(|state| mode(state.mode)),
        order: view.state.as_ref().and_then(|state| state.order),
        id: view.id,
    });
    Ok(Json(summaries.collect()))
}

/// Shows what a mobile robot last told, and what it has been told.
#[utoipa::path(
    get, path = "/api/v1/cells/{cell}/mobile-robots/{mobile_robot}", tag = "mobile-robots",
    params(MobileRobotPath),
    responses((status = 200, description = "It.", body = MobileRobotState), NotFound, AnyProblem),
)]
pub(crate) async fn get_mobile_robot(
    app: State<Arc<App>>,
    robot: MobileRobotOf,
) -> Result<Json<MobileRobotState>, Problem> {
    get_mobile_robot_state(app, robot).await
}

/// The same, where states of robots are.
#[utoipa::path(
    get, path = "/api/v1/cells/{cell}/mobile-robots/{mobile_robot}/state", tag = "mobile-robots",
    params(MobileRobotPath),
    responses((status = 200, description = "It.", body = MobileRobotState), NotFound, AnyProblem),
)]
pub(crate) async fn get_mobile_robot_state(
    State(app): State<Arc<App>>,
    MobileRobotOf {
        cell: id,
        id: robot,
    }: MobileRobotOf,
) -> Result<Json<MobileRobotState>, Problem> {
    let cell = app.cell(&id)?;
    let work = cell.work.view();
    let view = work.mobile_robots().into_iter().find(|m| m.id == robot);
    let Some(view) = view else {
        return Err(Problem::not_found("the mobile robot is gone"));
    };
    let sessions = work.sessions(0);
    let session = sessions
        .into_iter()
        .find(|session| Some(session.id) == view.session);
    let move_permit = session.is_some_and(|session| session.mr_move_permit);
    let last_signal_at = cell.work.heard_at(&robot);
    Ok(Json(shown(id, view, move_permit, last_signal_at)))
}

fn shown(
    cell: String,
    view: MobileRobotView,
    move_permit: bool,
    last_signal_at: Option<jiff::Timestamp>,
) -> MobileRobotState {
    // A cell that was just started knows the last number, and has not heard of the robot.
    let ever = view.boot > 0 || view.last_seq > 0;
    MobileRobotState {
        cell,
        connected: view.heard,
        last_signal_at,
        boot: ever.then_some(view.boot),
        seq: ever.then_some(view.last_seq),
        data: view.state.map(|state| data(state, &view.slots)),
        session: view.session,
        move_permit,
        unacknowledged: view.waiting_messages,
        id: view.id,
    }
}

fn data(state: MobileState, slots: &[String]) -> SignalData {
    let told = state.loads;
    SignalData {
        pose: floor_pose(state.pose),
        driving: state.driving,
        localized: state.localized,
        battery_percent: wire_bodies::shown(state.battery_percent),
        mode: mode(state.mode),
        // The cell keeps the slots that are occupied; the others of the robot are empty, if it told of any.
        loads: told.map(|told| {
            let known = slots
                .iter()
                .filter(|slot| !told.iter().any(|one| one.slot == **slot));
            let empty = known.map(|slot| SlotLoadBody {
                slot: slot.clone(),
                load: None,
            });
            let empty: Vec<_> = empty.collect();
            told.into_iter()
                .map(|one| SlotLoadBody {
                    slot: one.slot,
                    load: one.load,
                })
                .chain(empty)
                .collect()
        }),
        order: state.order,
        at_point: state.at_point,
        errors: state
            .errors
            .into_iter()
            .map(|error| MobileErrorBody {
                level: if error.fatal {
                    MobileErrorLevel::Fatal
                } else {
                    MobileErrorLevel::Warning
                },
                error_type: error.kind,
                description: error.description,
            })
            .collect(),
    }
}

fn mode(mode: MobileMode) -> OperatingMode {
    match mode {
        MobileMode::Automatic => OperatingMode::Automatic,
        MobileMode::Semiautomatic => OperatingMode::Semiautomatic,
        MobileMode::Intervened => OperatingMode::Intervened,
        MobileMode::Manual => OperatingMode::Manual,
        MobileMode::Service => OperatingMode::Service,
    }
}
