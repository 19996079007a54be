//! Variables, registers, I/O.

use axum::extract::{Json, Path, State as Shared};
use serde::{Deserialize, Serialize};
use utoipa::{IntoParams, ToSchema};
use utoipa_axum::{router::OpenApiRouter, routes};

use super::super::Visitors;
use super::parts::{AnyProblem, Asked, Body, Refusal};
use crate::controller::{
    Controller, DataError, IoView, PortSet, RegisterView, ValueBody, VariableItem,
};
use crate::driver::Driver;
use crate::virtual_controller::visit;

/// Variables in one answer at most.
const VARIABLES: usize = 5_000;

pub(super) fn routes() -> OpenApiRouter<Visitors> {
    OpenApiRouter::new()
        .routes(routes!(list_variables))
        .routes(routes!(get_variable, set_variable))
        .routes(routes!(list_registers))
        .routes(routes!(get_register, set_register))
        .routes(routes!(list_io))
        .routes(routes!(get_io, set_io))
        .routes(routes!(simulate_input, end_simulation))
}

/// Which variables.
#[derive(Clone, Debug, Deserialize, IntoParams)]
#[serde(deny_unknown_fields)]
struct VariablesQuery {
    /// The program, or `*SYSTEM*`.
    program: String,
    /// Only so many, up to 5000, which it is if it is missing.
    limit: Option<usize>,
}

/// Which variable.
#[derive(Clone, Debug, Serialize, Deserialize, IntoParams)]
#[serde(deny_unknown_fields)]
pub struct PathQuery {
    /// `[PROG]VAR.FIELD`, or `$NAME` for system variables.
    pub path: String,
}

/// Variables by name; arrays and structures as their parts.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, ToSchema)]
pub struct VariableList {
    /// The program, or `*SYSTEM*`.
    pub program: String,
    /// The variables.
    pub variables: Vec<VariableItem>,
    /// Whether there are more.
    pub more: bool,
}

/// A variable's new value.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, ToSchema)]
#[serde(deny_unknown_fields)]
pub struct SetVariable {
    /// `[PROG]VAR.FIELD`, or `$NAME` for system variables.
    pub path: String,
    /// The value; `null` makes it uninitialized.
    pub value: Option<ValueBody>,
}

/// A register's new value.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, ToSchema)]
#[serde(deny_unknown_fields)]
pub struct ValueOnly {
    /// The value; `null` clears a position register.
    pub value: Option<ValueBody>,
}

/// The registers that are not as when new.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, ToSchema)]
pub struct RegisterList {
    /// Numbers, positions, strings, flags.
    pub registers: Vec<RegisterView>,
}

/// The ports that are not off, or are simulated.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, ToSchema)]
pub struct IoList {
    /// By kind and number.
    pub ports: Vec<IoView>,
}

/// A port's new value.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, ToSchema)]
#[serde(deny_unknown_fields)]
pub struct SetIo {
    /// 0 or 1 for a switch.
    pub value: i32,
}

/// What programs see of a simulated input.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, ToSchema)]
#[serde(deny_unknown_fields)]
pub struct SetSimulation {
    /// 0 or 1 for a switch.
    pub value: i32,
}

/// Lists the variables of a program, or of the system.
#[utoipa::path(get, path = "/api/v1/variables", tag = "variables", params(VariablesQuery),
    responses((status = 200, description = "The variables.", body = VariableList), AnyProblem))]
async fn list_variables(
    Shared(visitors): Shared<Visitors>,
    Asked(query): Asked<VariablesQuery>,
) -> Result<Json<VariableList>, Refusal> {
    let limit = query.limit.unwrap_or(VARIABLES);
    if !(1..=VARIABLES).contains(&limit) {
        return Err(Refusal::range("limit", limit, "1 to 5000"));
    }
    let program = query.program.clone();
    let ask = move |driver: &mut Driver| driver.core.variables(&program, limit);
    let (variables, more) = visit(&visitors.commands, ask).await??;
    Ok(Json(VariableList {
        program: query.program.to_ascii_uppercase(),
        variables,
        more,
    }))
}

/// Shows a variable.
#[utoipa::path(get, path = "/api/v1/variable", tag = "variables", params(PathQuery),
    responses((status = 200, description = "The variable.", body = VariableItem), AnyProblem))]
async fn get_variable(
    Shared(visitors): Shared<Visitors>,
    Asked(PathQuery { path }): Asked<PathQuery>,
) -> Result<Json<VariableItem>, Refusal> {
    variable(&visitors, path, |_, _| Ok(())).await
}

/// Sets a variable, as an operator does on the data screen.
#[utoipa::path(put, path = "/api/v1/variable", tag = "variables", request_body = SetVariable,
    responses((status = 200, description = "The variable.", body = VariableItem), AnyProblem))]
async fn set_variable(
    Shared(visitors): Shared<Visitors>,
    Body(SetVariable { path, value }): Body<SetVariable>,
) -> Result<Json<VariableItem>, Refusal> {
    let set = move |core: &mut Controller, path: &str| core.set_variable(path, value.as_ref());
    variable(&visitors, path, set).await
}

async fn variable(
    visitors: &Visitors,
    path: String,
    change: impl FnOnce(&mut Controller, &str) -> Result<(), DataError> + Send + 'static,
) -> Result<Json<VariableItem>, Refusal> {
    let answer = visit(&visitors.commands, move |driver| {
        change(&mut driver.core, &path)?;
        let value = driver.core.variable(&path)?;
        Ok::<_, DataError>(VariableItem {
            path,
            type_name: None,
            value,
        })
    });
    Ok(Json(answer.await??))
}

/// Lists the registers that are not as when new.
#[utoipa::path(get, path = "/api/v1/registers", tag = "variables",
    responses((status = 200, description = "The registers.", body = RegisterList), AnyProblem))]
async fn list_registers(Shared(visitors): Shared<Visitors>) -> Result<Json<RegisterList>, Refusal> {
    let ask = |driver: &mut Driver| driver.core.register_views();
    let registers = visit(&visitors.commands, ask).await?;
    Ok(Json(RegisterList { registers }))
}

/// Shows a register.
#[utoipa::path(get, path = "/api/v1/registers/{register}", tag = "variables",
    params(("register" = String, Path, description = "`R[n]`, `PR[n]`, `SR[n]` or `F[n]`.")),
    responses((status = 200, description = "The register.", body = RegisterView), AnyProblem))]
async fn get_register(
    Shared(visitors): Shared<Visitors>,
    Path(register): Path<String>,
) -> Result<Json<RegisterView>, Refusal> {
    self::register(&visitors, register, |_, _| Ok(())).await
}

/// Sets a register.
#[utoipa::path(put, path = "/api/v1/registers/{register}", tag = "variables", request_body = ValueOnly,
    params(("register" = String, Path, description = "`R[n]`, `PR[n]`, `SR[n]` or `F[n]`.")),
    responses((status = 200, description = "The register.", body = RegisterView), AnyProblem))]
async fn set_register(
    Shared(visitors): Shared<Visitors>,
    Path(register): Path<String>,
    Body(ValueOnly { value }): Body<ValueOnly>,
) -> Result<Json<RegisterView>, Refusal> {
    let set = move |core: &mut Controller, name: &str| core.set_register(name, value.as_ref());
    self::register(&visitors, register, set).await
}

async fn register(
    visitors: &Visitors,
    register: String,
    change: impl FnOnce(&mut Controller, &str) -> Result<(), DataError> + Send + 'static,
) -> Result<Json<RegisterView>, Refusal> {
    let answer = visit(&visitors.commands, move |driver| {
        change(&mut driver.core, &register)?;
        let value = driver.core.register(&register)?;
        Ok::<_, DataError>(RegisterView { register, value })
    });
    Ok(Json(answer.await??))
}

/// Lists the ports that are not off, or are simulated.
#[utoipa::path(get, path = "/api/v1/io", tag = "io",
    responses((status = 200, description = "The ports.", body = IoList), AnyProblem))]
async fn list_io(Shared(visitors): Shared<Visitors>) -> Result<Json<IoList>, Refusal> {
    let ports = visit(&visitors.commands, |driver| driver.core.io()).await?;
    Ok(Json(IoList { ports }))
}

/// Shows a port as programs see it.
#[utoipa::path(get, path = "/api/v1/io/{port}", tag = "io",
    params(("port" = String, Path, description = "`DIN[n]`, `DOUT[n]`, .., or as TP programs have it, `DI[n]`.")),
    responses((status = 200, description = "The port.", body = IoView), AnyProblem))]
async fn get_io(
    Shared(visitors): Shared<Visitors>,
    Path(port): Path<String>,
) -> Result<Json<IoView>, Refusal> {
    let ask = move |driver: &mut Driver| driver.core.io_port(&port);
    Ok(Json(visit(&visitors.commands, ask).await??))
}

/// Sets a port: an input as the world does, an output as an operator does.
#[utoipa::path(put, path = "/api/v1/io/{port}", tag = "io", request_body = SetIo,
    params(("port" = String, Path, description = "The port.")),
    responses((status = 200, description = "The port.", body = IoView), AnyProblem))]
async fn set_io(
    Shared(visitors): Shared<Visitors>,
    Path(port): Path<String>,
    Body(SetIo { value }): Body<SetIo>,
) -> Result<Json<IoView>, Refusal> {
    io(&visitors, port, PortSet::Value(value)).await
}

/// Simulates an input: programs see this value, whatever the world puts there.
#[utoipa::path(put, path = "/api/v1/io/{port}/simulation", tag = "io", request_body = SetSimulation,
    params(("port" = String, Path, description = "The input.")),
    responses((status = 200, description = "The port.", body = IoView), AnyProblem))]
async fn simulate_input(
    Shared(visitors): Shared<Visitors>,
    Path(port): Path<String>,
    Body(SetSimulation { value }): Body<SetSimulation>,
) -> Result<Json<IoView>, Refusal> {
    io(&visitors, port, PortSet::Simulate(value)).await
}

/// Ends the simulation of an input.
#[utoipa::path(delete, path = "/api/v1/io/{port}/simulation", tag = "io",
    params(("port" = String, Path, description = "The input.")),
    responses((status = 200, description = "The port.", body = IoView), AnyProblem))]
async fn end_simulation(
    Shared(visitors): Shared<Visitors>,
    Path(port): Path<String>,
) -> Result<Json<IoView>, Refusal> {
    io(&visitors, port, PortSet::EndSimulation).await
}

async fn io(visitors: &Visitors, port: String, set: PortSet) -> Result<Json<IoView>, Refusal> {
    let answer = visit(&visitors.commands, move |driver| {
        driver.core.set_io(&port, set)?;
        driver.core.io_port(&port)
    });
    Ok(Json(answer.await??))
}
