//! Controller time.

use axum::extract::{Json, State as Shared};
use serde::{Deserialize, Serialize};
use utoipa::ToSchema;
use utoipa_axum::{router::OpenApiRouter, routes};

use super::super::Visitors;
use super::parts::{AnyProblem, Body, Refusal};
use crate::clock::{TimeError, TimeView};
use crate::driver::Driver;
use crate::error::ControllerStopped;
use crate::virtual_controller::visit;

pub(super) fn routes() -> OpenApiRouter<Visitors> {
    OpenApiRouter::new()
        .routes(routes!(get_time, set_time))
        .routes(routes!(step_time))
}

/// How time shall pass; what is missing stays as it is.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize, ToSchema)]
#[serde(deny_unknown_fields)]
pub struct TimePatch {
    /// Whether it stands still.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub paused: Option<bool>,
    /// Controller seconds in a second, above 0 and at most 1000.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub scale: Option<f64>,
}

/// How much time shall pass.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, ToSchema)]
#[serde(deny_unknown_fields)]
pub struct StepBody {
    /// Milliseconds of controller time, up to a day.
    #[schema(minimum = 1, maximum = 86_400_000)]
    pub ms: u64,
}

/// Shows how time passes.
#[utoipa::path(get, path = "/api/v1/time", tag = "time",
    responses((status = 200, description = "The time.", body = TimeView), AnyProblem))]
async fn get_time(Shared(visitors): Shared<Visitors>) -> Result<Json<TimeView>, Refusal> {
    Ok(Json(
        visit(&visitors.commands, |driver| view(driver)).await?,
    ))
}

/// Pauses time, lets it go on, or changes its scale.
#[utoipa::path(patch, path = "/api/v1/time", tag = "time", request_body = TimePatch,
    responses((status = 200, description = "The time.", body = TimeView), AnyProblem))]
async fn set_time(
    Shared(visitors): Shared<Visitors>,
    Body(TimePatch { paused, scale }): Body<TimePatch>,
) -> Result<Json<TimeView>, Refusal> {
    let answer = visit(&visitors.commands, move |driver| {
        let now = driver.core.now();
        if let Some(scale) = scale {
            driver.time.set_scale(now, scale)?;
        }
        if let Some(paused) = paused {
            driver.time.pause(now, paused)?;
        }
        Ok::<_, TimeError>(view(driver))
    });
    Ok(Json(answer.await??))
}

/// Lets some time pass while it is paused, and answers when it has passed and everything in it has happened.
#[utoipa::path(post, path = "/api/v1/time/step", tag = "time", request_body = StepBody,
    responses((status = 200, description = "The time.", body = TimeView), AnyProblem))]
async fn step_time(
    Shared(visitors): Shared<Visitors>,
    Body(StepBody { ms }): Body<StepBody>,
) -> Result<Json<TimeView>, Refusal> {
    let begin = move |driver: &mut Driver| driver.time.step(driver.core.now(), ms);
    let passed = visit(&visitors.commands, begin).await??;
    let _now = passed.await.map_err(|_| ControllerStopped)?;
    get_time(Shared(visitors)).await
}

fn view(driver: &Driver) -> TimeView {
    driver.time.view(driver.core.now())
}
