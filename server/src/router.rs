use std::sync::Arc;

use axum::http::{Method, Uri, header};
use axum::response::Html;
use axum::routing::get;
use axum::{Router, middleware};
use utoipa::openapi::OpenApi;
use utoipa_swagger_ui::SwaggerUi;

use crate::edge::edge;
use crate::problem::{Problem, outcome_of_nothing_sent};
use crate::routes;
use crate::state::{App, shown};

/// The start page has its own script and style, asks this server, and takes nothing from elsewhere.
const START_PAGE_POLICY: &str = "default-src 'none'; img-src data:; script-src 'unsafe-inline'; \
    style-src 'unsafe-inline'; connect-src 'self'; base-uri 'none'; form-action 'none'; frame-ancestors 'none'";

/// The documented routes and their document.
pub(crate) fn documented() -> (Router<Arc<App>>, OpenApi) {
    routes::documented().split_for_parts()
}

/// The whole router: the documented routes, the pages that show the document, and the layer around all of them.
pub(crate) fn finish(routes: Router<Arc<App>>, document: OpenApi, app: Arc<App>) -> Router {
    routes
        .route(
            "/",
            get(async || {
                let policy = [(header::CONTENT_SECURITY_POLICY, START_PAGE_POLICY)];
                (policy, Html(include_str!("index.html")))
            }),
        )
        .merge(SwaggerUi::new("/docs").url("/api/v1/openapi.json", document))
        .fallback(not_found)
        .layer(middleware::from_fn_with_state(Arc::clone(&app), edge))
        .with_state(app)
}

async fn not_found(method: Method, uri: Uri) -> Problem {
    Problem::not_found(format!("there is nothing at `{}`", shown(uri.path())))
        .outcome(outcome_of_nothing_sent(&method))
}
