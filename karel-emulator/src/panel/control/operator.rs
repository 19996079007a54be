//! The operator's keys and switches, and the power.

use axum::extract::{Json, State as Shared};
use serde::{Deserialize, Serialize};
use utoipa::ToSchema;
use utoipa_axum::{router::OpenApiRouter, routes};

use super::super::Visitors;
use super::parts::{AnyProblem, Body, Refusal};
use crate::controller::{CmosMemory, Controller, OperateError, Operation};
use crate::faults::Memory;
use crate::hardware::operator::OperatingMode;
use crate::ledger::JointsDeg;
use crate::virtual_controller::visit;

pub(super) fn routes() -> OpenApiRouter<Visitors> {
    OpenApiRouter::new()
        .routes(routes!(get_operator, set_operator))
        .routes(routes!(hold))
        .routes(routes!(cycle_start))
        .routes(routes!(reset))
        .routes(routes!(jog))
        .routes(routes!(power_cycle))
        .routes(routes!(type_text))
}

/// Keys and switches as they are.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, ToSchema)]
#[expect(clippy::struct_excessive_bools, reason = "each is a switch of its own")]
pub struct OperatorView {
    /// The mode switch.
    pub mode: OperatingMode,
    /// The teach pendant's switch.
    pub pendant_enabled: bool,
    /// Whether the emergency stop is pressed.
    pub emergency_stop: bool,
    /// Whether the servos have power.
    pub servo_power: bool,
    /// Whether the operator holds everything.
    pub hold: bool,
    /// Whether tasks pause after each line.
    pub single_step: bool,
    /// The general override.
    pub override_percent: i32,
    /// How many alarms wait for a reset.
    pub active_alarms: usize,
}

/// Switches to turn; what is missing stays as it is.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, ToSchema)]
#[serde(deny_unknown_fields)]
pub struct OperatorPatch {
    /// The mode switch. Leaving AUTO pauses what moves.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub mode: Option<OperatingMode>,
    /// The teach pendant's switch. Enabling it pauses what moves.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub pendant_enabled: Option<bool>,
    /// The emergency stop. After its release a reset is due.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub emergency_stop: Option<bool>,
    /// Servo power.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub servo_power: Option<bool>,
    /// The STEP key.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub single_step: Option<bool>,
    /// The general override, 0 to 100.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schema(minimum = 0, maximum = 100)]
    pub override_percent: Option<i32>,
}

/// What the battery keeps.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, ToSchema)]
#[serde(deny_unknown_fields)]
pub struct PowerBody {
    /// `kept`, or `lost` as after a battery was changed too late.
    pub memory: Memory,
}

/// What is typed at the pendant.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize, ToSchema)]
#[serde(deny_unknown_fields)]
pub struct KeyboardBody {
    /// Characters up to U+00FF, one key each: a line feed is ENTER, U+0080 and above are the keys of the header
    /// `klevkeys` that are no characters.
    #[schema(example = "42\n")]
    pub text: String,
}

fn view(core: &Controller) -> OperatorView {
    let state = core.state();
    OperatorView {
        mode: state.mode,
        pendant_enabled: state.pendant_enabled,
        emergency_stop: state.emergency_stop,
        servo_power: state.servo_power,
        hold: state.hold,
        single_step: state.single_step,
        override_percent: state.override_percent,
        active_alarms: state.active_alarms,
    }
}

/// Shows the keys and switches.
#[utoipa::path(get, path = "/api/v1/operator", tag = "operator",
    responses((status = 200, description = "The switches.", body = OperatorView), AnyProblem))]
async fn get_operator(Shared(visitors): Shared<Visitors>) -> Result<Json<OperatorView>, Refusal> {
    operate(&visitors, Vec::new()).await
}

/// Turns switches: mode, pendant, emergency stop, servo power, single step, override.
#[utoipa::path(patch, path = "/api/v1/operator", tag = "operator", request_body = OperatorPatch,
    responses((status = 200, description = "The switches.", body = OperatorView), AnyProblem))]
async fn set_operator(
    Shared(visitors): Shared<Visitors>,
    Body(patch): Body<OperatorPatch>,
) -> Result<Json<OperatorView>, Refusal> {
    // The override is the only one that can be refused: it goes first, so that nothing is done by halves.
    let operations = [
        patch.override_percent.map(Operation::SetOverride),
        patch.emergency_stop.map(Operation::EmergencyStop),
        patch.servo_power.map(Operation::SetServoPower),
        patch.pendant_enabled.map(Operation::SetPendant),
        patch.mode.map(Operation::SetMode),
        patch.single_step.map(Operation::SetSingleStep),
    ];
    operate(&visitors, operations.into_iter().flatten().collect()).await
}

/// HOLD: tasks pause, the arm brakes on its path and waits.
#[utoipa::path(post, path = "/api/v1/hold", tag = "operator",
    responses((status = 200, description = "The switches.", body = OperatorView), AnyProblem))]
async fn hold(Shared(visitors): Shared<Visitors>) -> Result<Json<OperatorView>, Refusal> {
    operate(&visitors, vec![Operation::Hold]).await
}

/// CYCLE START: what is paused goes on; for one line each, if single step is on.
#[utoipa::path(post, path = "/api/v1/cycle-start", tag = "operator",
    responses((status = 200, description = "The switches.", body = OperatorView), AnyProblem))]
async fn cycle_start(Shared(visitors): Shared<Visitors>) -> Result<Json<OperatorView>, Refusal> {
    operate(&visitors, vec![Operation::CycleStart]).await
}

/// RESET: no alarm is active any more, unless the emergency stop is pressed or the servos have no power.
#[utoipa::path(post, path = "/api/v1/reset", tag = "operator",
    responses((status = 200, description = "The switches.", body = OperatorView), AnyProblem))]
async fn reset(Shared(visitors): Shared<Visitors>) -> Result<Json<OperatorView>, Refusal> {
    operate(&visitors, vec![Operation::Reset]).await
}

/// Moves the arm by hand, which takes no time here. The pendant must be enabled.
#[utoipa::path(post, path = "/api/v1/jog", tag = "operator", request_body = JointsDeg,
    responses((status = 200, description = "The switches.", body = OperatorView), AnyProblem))]
async fn jog(
    Shared(visitors): Shared<Visitors>,
    Body(joints): Body<JointsDeg>,
) -> Result<Json<OperatorView>, Refusal> {
    operate(&visitors, vec![Operation::Jog(joints)]).await
}

/// Switches the power off and on.
#[utoipa::path(post, path = "/api/v1/power-cycle", tag = "operator", request_body = PowerBody,
    responses((status = 200, description = "The switches.", body = OperatorView), AnyProblem))]
async fn power_cycle(
    Shared(visitors): Shared<Visitors>,
    Body(PowerBody { memory }): Body<PowerBody>,
) -> Result<Json<OperatorView>, Refusal> {
    let answer = visit(&visitors.commands, move |driver| {
        driver.core.power_cycle(match memory {
            Memory::Kept => CmosMemory::Kept,
            Memory::Lost => CmosMemory::Lost,
        });
        view(&driver.core)
    });
    Ok(Json(answer.await?))
}

/// Types at the pendant: what a READ without a file, or a `READ_KB`, waits for.
#[utoipa::path(post, path = "/api/v1/keyboard", tag = "operator", request_body = KeyboardBody,
    responses((status = 200, description = "The switches.", body = OperatorView), AnyProblem))]
async fn type_text(
    Shared(visitors): Shared<Visitors>,
    Body(KeyboardBody { text }): Body<KeyboardBody>,
) -> Result<Json<OperatorView>, Refusal> {
    operate(&visitors, vec![Operation::Type(text)]).await
}

async fn operate(
    visitors: &Visitors,
    operations: Vec<Operation>,
) -> Result<Json<OperatorView>, Refusal> {
    let answer = visit(&visitors.commands, move |driver| {
        for operation in operations {
            driver.core.operate(operation)?;
        }
        Ok::<_, OperateError>(view(&driver.core))
    });
    Ok(Json(answer.await??))
}
