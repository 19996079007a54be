//! Ports by the number of their type, and their comments.

#![expect(
    clippy::unnecessary_wraps,
    reason = "all built-ins have the table's signature"
)]

use super::{Builtin, Context, Outcome, Param, Returns};
use crate::{
    machine::{cell::Cell, fault::Fault},
    port::{Commented, Port, PortValue},
    status::Status,
};

#[rustfmt::skip]
pub(super) const TABLE: &[Builtin] = &[
    Builtin { name: "GET_PORT_CMT", params: &[Param::Integer, Param::Integer, Param::OutText, Param::OutInteger], required: 4, returns: Returns::Nothing, code: get_comment },
    Builtin { name: "GET_PORT_VAL", params: &[Param::Integer, Param::Integer, Param::OutInteger, Param::OutInteger], required: 4, returns: Returns::Nothing, code: get_value },
    Builtin { name: "GET_PREG_CMT", params: &[Param::Integer, Param::OutText, Param::OutInteger], required: 3, returns: Returns::Nothing, code: |context| get_register_comment(context, Commented::Position) },
    Builtin { name: "GET_REG_CMT", params: &[Param::Integer, Param::OutText, Param::OutInteger], required: 3, returns: Returns::Nothing, code: |context| get_register_comment(context, Commented::Number) },
    Builtin { name: "GET_SREG_CMT", params: &[Param::Integer, Param::OutText, Param::OutInteger], required: 3, returns: Returns::Nothing, code: |context| get_register_comment(context, Commented::Text) },
    Builtin { name: "SET_PREG_CMT", params: &[Param::Integer, Param::Text, Param::OutInteger], required: 3, returns: Returns::Nothing, code: |context| set_register_comment(context, Commented::Position) },
    Builtin { name: "SET_REG_CMT", params: &[Param::Integer, Param::Text, Param::OutInteger], required: 3, returns: Returns::Nothing, code: |context| set_register_comment(context, Commented::Number) },
    Builtin { name: "SET_SREG_CMT", params: &[Param::Integer, Param::Text, Param::OutInteger], required: 3, returns: Returns::Nothing, code: |context| set_register_comment(context, Commented::Text) },
    Builtin { name: "SET_PORT_CMT", params: &[Param::Integer, Param::Integer, Param::Text, Param::OutInteger], required: 4, returns: Returns::Nothing, code: set_comment },
    Builtin { name: "SET_PORT_VAL", params: &[Param::Integer, Param::Integer, Param::Integer, Param::OutInteger], required: 4, returns: Returns::Nothing, code: set_value },
];

/// The port that the first two arguments mean, if it exists.
fn port(context: &Context<'_>) -> Result<(Port, i32, PortValue), Status> {
    let port = Port::of_type(context.integer(0)).ok_or(Status::INTP_ARGUMENT)?;
    let number = context.integer(1);
    let value = context.host.port(port, number)?;
    Ok((port, number, value))
}

fn get_value(context: &mut Context<'_>) -> Result<Outcome, Fault> {
    let status = match port(context) {
        Ok((_, _, value)) => {
            let value = match value {
                PortValue::Switch(on) => i32::from(on),
                PortValue::Number(value) => value,
            };
            context.put(2, Cell::Integer(value));
            Status::OK
        }
        Err(status) => status,
    };
    context.put_status(3, status);
    Ok(Outcome::Done)
}

/// ASSUMPTION: any value but 0 is ON; an input is written only while it is simulated.
fn set_value(context: &mut Context<'_>) -> Result<Outcome, Fault> {
    let value = context.integer(2);
    let set = port(context).and_then(|(port, number, _)| {
        let value = if port.is_switch() {
            PortValue::Switch(value != 0)
        } else {
            PortValue::Number(value)
        };
        if port.is_input() {
            if !context.host.port_is_simulated(port, number) {
                return Err(Status::INTP_ARGUMENT);
            }
            let value = Some(value);
            return context
                .host
                .simulate_port(context.task, port, number, value);
        }
        context.host.set_port(context.task, port, number, value)
    });
    context.put_status(3, set.err().unwrap_or(Status::OK));
    Ok(Outcome::Done)
}

fn get_comment(context: &mut Context<'_>) -> Result<Outcome, Fault> {
    let status = match port(context) {
        Ok((port, number, _)) => {
            let comment = context.comments.get((Commented::Port(port), number));
            context.put_text(2, comment);
            Status::OK
        }
        Err(status) => status,
    };
    context.put_status(3, status);
    Ok(Outcome::Done)
}

/// ASSUMPTION: a comment has at most 24 characters; it is cut.
fn set_comment(context: &mut Context<'_>) -> Result<Outcome, Fault> {
    let comment = context.text(2);
    let status = match port(context) {
        Ok((port, number, _))
            if context
                .comments
                .set((Commented::Port(port), number), comment) =>
        {
            Status::OK
        }
        Ok(_) => Status::INTP_LIMIT,
        Err(status) => status,
    };
    context.put_status(3, status);
    Ok(Outcome::Done)
}

/// Whether there is such a register.
fn register(context: &Context<'_>, what: Commented) -> Result<i32, Status> {
    let number = context.integer(0);
    match what {
        Commented::Number => context.registers.number(number).map(drop)?,
        Commented::Position => context.registers.position(number).map(drop)?,
        Commented::Text => context.registers.string(number).map(drop)?,
        Commented::Port(_) => {}
    }
    Ok(number)
}

fn get_register_comment(context: &mut Context<'_>, what: Commented) -> Result<Outcome, Fault> {
    let status = match register(context, what) {
        Ok(number) => {
            let comment = context.comments.get((what, number));
            context.put_text(1, comment);
            Status::OK
        }
        Err(status) => status,
    };
    context.put_status(2, status);
    Ok(Outcome::Done)
}

fn set_register_comment(context: &mut Context<'_>, what: Commented) -> Result<Outcome, Fault> {
    let comment = context.text(1);
    let status = match register(context, what) {
        Ok(number) if context.comments.set((what, number), comment) => Status::OK,
        Ok(_) => Status::INTP_LIMIT,
        Err(status) => status,
    };
    context.put_status(2, status);
    Ok(Outcome::Done)
}
