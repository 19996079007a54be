//! Faults.

use axum::extract::{Json, Path, State as Shared};
use axum::http::StatusCode;
use serde::{Deserialize, Serialize};
use utoipa::ToSchema;
use utoipa_axum::{router::OpenApiRouter, routes};

use super::super::Visitors;
use super::parts::{AnyProblem, Body, Refusal};
use crate::driver::Driver;
use crate::faults::{FaultBody, FaultView};
use crate::virtual_controller::visit;

pub(super) fn routes() -> OpenApiRouter<Visitors> {
    OpenApiRouter::new()
        .routes(routes!(list_faults, inject_fault, clear_faults))
        .routes(routes!(clear_fault))
}

/// The faults that are active.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, ToSchema)]
pub struct FaultList {
    /// Oldest first.
    pub faults: Vec<FaultView>,
}

/// The number of a fault.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, ToSchema)]
pub struct FaultId {
    /// Counts from 1.
    pub id: u64,
}

/// How many faults were cleared.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, ToSchema)]
pub struct Cleared {
    /// How many.
    pub cleared: usize,
}

/// Lists the faults that are active.
#[utoipa::path(get, path = "/api/v1/faults", tag = "faults",
    responses((status = 200, description = "The faults.", body = FaultList), AnyProblem))]
async fn list_faults(Shared(visitors): Shared<Visitors>) -> Result<Json<FaultList>, Refusal> {
    let faults = visit(&visitors.commands, |driver| driver.core.faults()).await?;
    Ok(Json(FaultList { faults }))
}

/// Injects a fault.
#[utoipa::path(post, path = "/api/v1/faults", tag = "faults",
    request_body(content = FaultBody, example = json!({
        "fault": {"delay": {"ms": 200, "jitter_ms": 50}},
        "scope": {"port": 59002, "direction": "in"},
        "times": 3,
    })),
    responses((status = 201, description = "It is active, or has happened.", body = FaultId), AnyProblem))]
async fn inject_fault(
    Shared(visitors): Shared<Visitors>,
    Body(fault): Body<FaultBody>,
) -> Result<(StatusCode, Json<FaultId>), Refusal> {
    let inject = move |driver: &mut Driver| driver.core.inject(fault);
    let id = visit(&visitors.commands, inject).await??;
    Ok((StatusCode::CREATED, Json(FaultId { id })))
}

/// Clears a fault.
#[utoipa::path(delete, path = "/api/v1/faults/{id}", tag = "faults",
    params(("id" = u64, Path, description = "The fault's number.")),
    responses((status = 204, description = "It is over."), AnyProblem))]
async fn clear_fault(
    Shared(visitors): Shared<Visitors>,
    Path(id): Path<String>,
) -> Result<StatusCode, Refusal> {
    let id = id.parse().map_err(|_| {
        let text = format!("{id:?} is no number of a fault, a whole number from 1 on");
        Refusal::new(StatusCode::NOT_FOUND, text)
    })?;
    visit(&visitors.commands, move |driver| {
        driver.core.clear_fault(id)
    })
    .await??;
    Ok(StatusCode::NO_CONTENT)
}

/// Clears all faults.
#[utoipa::path(delete, path = "/api/v1/faults", tag = "faults",
    responses((status = 200, description = "They are over.", body = Cleared), AnyProblem))]
async fn clear_faults(Shared(visitors): Shared<Visitors>) -> Result<Json<Cleared>, Refusal> {
    let cleared = visit(&visitors.commands, |driver| driver.core.clear_faults()).await?;
    Ok(Json(Cleared { cleared }))
}
