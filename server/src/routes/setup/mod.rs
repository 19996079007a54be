//! The operator's set-up over HTTP: whole, part by part, checked, taught.
//!
//! Every answer about a set-up carries its entity tag; every change names the one it is based on, so that two operators
//! never overwrite each other unnoticed.

mod body;
mod check;
mod parts;
mod problems;
mod teach;
mod tools;
mod whole;

use std::sync::Arc;

use utoipa_axum::router::OpenApiRouter;
use utoipa_axum::routes;

use crate::state::App;

/// The routes below `…/cells/{cell}/setup`.
pub(super) fn documented() -> OpenApiRouter<Arc<App>> {
    OpenApiRouter::new()
        .routes(routes!(whole::get_setup, whole::put_setup))
        .routes(routes!(check::check_setup))
        .routes(routes!(tools::calibrate_tool))
        .routes(routes!(teach::teach_pose))
        .merge(parts::documented())
}
