//! Who sends a request.

use std::convert::Infallible;
use std::sync::{Arc, LazyLock};

use axum::extract::FromRequestParts;
use axum::http::request::Parts;

use crate::state::App;

/// The caller, where nothing asks who it is.
static ANYONE: LazyLock<Arc<str>> = LazyLock::new(|| Arc::from("anyone"));

/// The name of the principal a request comes from.
pub(super) struct Caller(pub(super) Arc<str>);

impl FromRequestParts<Arc<App>> for Caller {
    type Rejection = Infallible;

    async fn from_request_parts(_: &mut Parts, _: &Arc<App>) -> Result<Self, Infallible> {
        Ok(Self(Arc::clone(&ANYONE)))
    }
}
