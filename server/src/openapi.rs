//! The OpenAPI document, made from the routes.

use utoipa::openapi::OpenApi;

use crate::router;

/// The OpenAPI document of the server.
#[must_use]
pub fn openapi() -> OpenApi {
    complete(router::documented().1)
}

/// Adds what belongs to no single route.
pub(crate) fn complete(document: OpenApi) -> OpenApi {
    document
}
