//! Alarms: active ones, the history, and alarms from nowhere in particular.

use axum::extract::{Json, State as Shared};
use axum::http::StatusCode;
use serde::{Deserialize, Serialize};
use utoipa::{IntoParams, ToSchema};
use utoipa_axum::{router::OpenApiRouter, routes};

use super::super::Visitors;
use super::parts::{AnyProblem, Asked, Body, Refusal};
use crate::alarms::{Alarm, Severity};
use crate::controller::Operation;
use crate::virtual_controller::visit;

/// Longest text of an alarm from outside.
const TEXT: usize = 200;

pub(super) fn routes() -> OpenApiRouter<Visitors> {
    OpenApiRouter::new().routes(routes!(list_alarms, raise_alarm))
}

/// Which alarms.
#[derive(Clone, Debug, Deserialize, IntoParams)]
#[serde(deny_unknown_fields)]
struct AlarmsQuery {
    /// Only those that wait for a reset.
    #[serde(default)]
    active: bool,
    /// Only so many, the newest.
    limit: Option<usize>,
}

/// Alarms.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, ToSchema)]
pub struct AlarmList {
    /// Older alarms that are not kept any more.
    pub dropped: u64,
    /// Oldest first.
    pub alarms: Vec<Alarm>,
}

/// An alarm to raise.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, ToSchema)]
#[serde(deny_unknown_fields)]
pub struct AlarmBody {
    /// Four letters, such as `SRVO`.
    pub facility: String,
    /// The number within the facility, up to 999.
    #[schema(maximum = 999)]
    pub number: u16,
    /// What is wrong, up to 200 characters.
    pub text: String,
    /// How much it stops.
    pub severity: Severity,
}

/// Lists the alarms: the history, or those that are active.
#[utoipa::path(get, path = "/api/v1/alarms", tag = "operator", params(AlarmsQuery),
    responses((status = 200, description = "The alarms.", body = AlarmList), AnyProblem))]
async fn list_alarms(
    Shared(visitors): Shared<Visitors>,
    Asked(query): Asked<AlarmsQuery>,
) -> Result<Json<AlarmList>, Refusal> {
    let answer = visit(&visitors.commands, move |driver| {
        let mut alarms = driver.core.alarms();
        alarms.retain(|alarm| alarm.active || !query.active);
        let surplus = query
            .limit
            .map_or(0, |limit| alarms.len().saturating_sub(limit));
        drop(alarms.drain(..surplus));
        AlarmList {
            dropped: driver.core.alarms_dropped(),
            alarms,
        }
    });
    Ok(Json(answer.await?))
}

/// Raises an alarm. "pause" pauses the tasks, "abort" ends them.
#[utoipa::path(post, path = "/api/v1/alarms", tag = "operator", request_body = AlarmBody,
    responses((status = 204, description = "The alarm is raised."), AnyProblem))]
async fn raise_alarm(
    Shared(visitors): Shared<Visitors>,
    Body(alarm): Body<AlarmBody>,
) -> Result<StatusCode, Refusal> {
    let AlarmBody {
        facility,
        number,
        text,
        severity,
    } = alarm;
    let length = text.chars().count();
    if length > TEXT {
        return Err(Refusal::range("the length of text", length, "at most 200"));
    }
    let operation = Operation::RaiseAlarm {
        facility,
        number,
        text,
        severity,
    };
    visit(&visitors.commands, |driver| driver.core.operate(operation)).await??;
    Ok(StatusCode::NO_CONTENT)
}
