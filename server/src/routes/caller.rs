//! Who sends a request.

use std::sync::Arc;

use axum::extract::FromRequestParts;
use axum::http::request::Parts;

use crate::identity::Principal;
use crate::problem::Problem;
use crate::state::App;

/// The name of the principal a request comes from.
pub(super) struct Caller(pub(super) Arc<str>);

impl FromRequestParts<Arc<App>> for Caller {
    type Rejection = Problem;

    async fn from_request_parts(parts: &mut Parts, app: &Arc<App>) -> Result<Self, Problem> {
        let principal = Principal::from_request_parts(parts, app).await?;
        Ok(Self(Arc::from(principal.name())))
    }
}
