//! The routes, one file a resource. `routes!` registers a handler and its description in one step, so that no route
//! can miss the OpenAPI document.

mod legacy;
mod legacy_error;
mod responses;

use std::sync::Arc;

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
}
