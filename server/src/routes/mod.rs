//! The routes, one file a resource. `routes!` registers a handler and its description in one step, so that no route
//! can miss the OpenAPI document.

mod arms;
mod audit;
mod caller;
mod cell_state;
mod cells;
mod control;
mod events;
mod health;
mod identity;
mod interventions;
mod job_history;
mod jobs;
mod kinematics;
mod legacy;
mod legacy_error;
mod loads;
mod mobile_robots;
mod motion_body;
mod motion_control;
mod motion_zones;
mod motions;
mod page;
mod params;
mod prefer;
mod preview;
mod preview_profile;
mod problems;
mod responses;
mod robots;
mod sessions;
mod setup;
mod simulation;

use std::sync::Arc;

pub(crate) use params::cell_of;

use utoipa_axum::router::OpenApiRouter;
use utoipa_axum::routes;

use crate::state::App;

/// Every documented route.
pub(crate) fn documented() -> OpenApiRouter<Arc<App>> {
    OpenApiRouter::new()
        .routes(routes!(legacy::fanuc_move))
        .routes(routes!(legacy::fanuc_home))
        .routes(routes!(legacy::fanuc_delta))
        .routes(routes!(legacy::version))
        .routes(routes!(cells::list_cells))
        .routes(routes!(cells::get_cell))
        .routes(routes!(cells::list_robots))
        .routes(routes!(cell_state::get_cell_state))
        .routes(routes!(control::get_control, control::acquire_control))
        .routes(routes!(control::keep_control, control::release_control))
        .routes(routes!(control::transfer_control))
        .routes(routes!(audit::list_audit))
        .routes(routes!(robots::get_robot))
        .routes(routes!(robots::get_robot_description))
        .routes(routes!(robots::get_robot_state))
        .routes(routes!(kinematics::forward))
        .routes(routes!(kinematics::inverse))
        .merge(arms::documented())
        .routes(routes!(motions::create_motion, motions::list_motions))
        .routes(routes!(preview::preview_motion))
        .routes(routes!(motions::get_motion))
        .routes(routes!(identity::me))
        .routes(routes!(identity::list_tokens, identity::create_token))
        .routes(routes!(identity::revoke_token))
        .routes(routes!(identity::rotate_token))
        .merge(setup::documented())
        .routes(routes!(motion_control::cancel_motion))
        .routes(routes!(motion_control::pause_motion))
        .routes(routes!(motion_control::resume_motion))
        .routes(routes!(motion_control::stop_robot))
        .routes(routes!(
            motion_control::get_speed_override,
            motion_control::put_speed_override
        ))
        .routes(routes!(events::get_events))
        .routes(routes!(mobile_robots::list_mobile_robots))
        .routes(routes!(mobile_robots::get_mobile_robot))
        .routes(routes!(mobile_robots::get_mobile_robot_state))
        .routes(routes!(mobile_robots::post_signal))
        .routes(routes!(mobile_robots::get_outbox))
        .routes(routes!(mobile_robots::post_instant_action))
        .routes(routes!(interventions::list_interventions))
        .routes(routes!(interventions::get_intervention))
        .routes(routes!(interventions::respond))
        .routes(routes!(jobs::create_job, jobs::list_jobs))
        .routes(routes!(simulation::simulate_job))
        .routes(routes!(jobs::get_job))
        .routes(routes!(jobs::command_job))
        .routes(routes!(job_history::job_events))
        .routes(routes!(job_history::job_report))
        .routes(routes!(sessions::list_sessions))
        .routes(routes!(sessions::get_session))
        .routes(routes!(sessions::list_point_sessions))
        .routes(routes!(loads::list_loads))
        .routes(routes!(loads::get_load))
        .routes(routes!(loads::put_custody))
        .routes(routes!(problems::list_problems))
        .routes(routes!(problems::get_problem))
        .routes(routes!(health::livez))
        .routes(routes!(health::readyz))
        .routes(routes!(health::metrics))
}
