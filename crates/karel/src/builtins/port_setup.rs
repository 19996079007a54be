//! Simulation, assignment and modes of ports.

#![expect(
    clippy::unnecessary_wraps,
    reason = "all built-ins have the table's signature"
)]

use super::{Builtin, Context, Outcome, Param, Returns};
use crate::{
    machine::{cell::Cell, fault::Fault},
    port::{Port, PortValue},
    status::Status,
};

#[rustfmt::skip]
pub(super) const TABLE: &[Builtin] = &[
    Builtin { name: "CLR_PORT_SIM", params: &[Param::Integer, Param::Integer, Param::OutInteger], required: 3, returns: Returns::Nothing, code: end_simulation },
    Builtin { name: "GET_PORT_ASG", params: &[Param::Integer, Param::Integer, Param::OutInteger, Param::OutInteger, Param::OutInteger, Param::OutInteger, Param::OutInteger, Param::OutInteger], required: 8, returns: Returns::Nothing, code: get_assignment },
    Builtin { name: "GET_PORT_MOD", params: &[Param::Integer, Param::Integer, Param::OutInteger, Param::OutInteger], required: 4, returns: Returns::Nothing, code: get_mode },
    Builtin { name: "GET_PORT_SIM", params: &[Param::Integer, Param::Integer, Param::OutBoolean, Param::OutInteger], required: 4, returns: Returns::Nothing, code: is_simulated },
    Builtin { name: "SET_PORT_ASG", params: &[Param::Integer, Param::Integer, Param::Integer, Param::Integer, Param::Integer, Param::Integer, Param::Integer, Param::OutInteger], required: 8, returns: Returns::Nothing, code: set_assignment },
    Builtin { name: "SET_PORT_MOD", params: &[Param::Integer, Param::Integer, Param::Integer, Param::OutInteger], required: 4, returns: Returns::Nothing, code: set_mode },
    Builtin { name: "SET_PORT_SIM", params: &[Param::Integer, Param::Integer, Param::Integer, Param::OutInteger], required: 4, returns: Returns::Nothing, code: simulate },
];

/// The port that the first two arguments mean, if it exists.
fn port(context: &Context<'_>) -> Result<(Port, i32), Status> {
    let port = Port::of_type(context.integer(0)).ok_or(Status::INTP_ARGUMENT)?;
    let number = context.integer(1);
    let _value = context.host.port(port, number)?;
    Ok((port, number))
}

/// `SET_PORT_SIM(type, number, value, status)`: programs see that value until `CLR_PORT_SIM`.
fn simulate(context: &mut Context<'_>) -> Result<Outcome, Fault> {
    let value = context.integer(2);
    let set = port(context).and_then(|(port, number)| {
        let value = if port.is_switch() {
            PortValue::Switch(value != 0)
        } else {
            PortValue::Number(value)
        };
        context
            .host
            .simulate_port(context.task, port, number, Some(value))
    });
    context.put_status(3, set.err().unwrap_or(Status::OK));
    Ok(Outcome::Done)
}

fn end_simulation(context: &mut Context<'_>) -> Result<Outcome, Fault> {
    let set = port(context)
        .and_then(|(port, number)| context.host.simulate_port(context.task, port, number, None));
    context.put_status(2, set.err().unwrap_or(Status::OK));
    Ok(Outcome::Done)
}

fn is_simulated(context: &mut Context<'_>) -> Result<Outcome, Fault> {
    let status = match port(context) {
        Ok((port, number)) => {
            let simulated = context.host.port_is_simulated(port, number);
            context.put(2, Cell::Boolean(simulated));
            Status::OK
        }
        Err(status) => status,
    };
    context.put_status(3, status);
    Ok(Outcome::Done)
}

/// `SET_PORT_ASG(type, number, rack, slot, physical type, physical number, count, status)`.
///
/// ASSUMPTION: the assignment is kept and changes nothing: there are no racks.
fn set_assignment(context: &mut Context<'_>) -> Result<Outcome, Fault> {
    let values = [2, 3, 4, 5, 6].map(|number| context.integer(number));
    let set = port(context).and_then(|port| {
        let kept = context.port_setup.assign(port, values);
        if kept {
            Ok(())
        } else {
            Err(Status::INTP_LIMIT)
        }
    });
    context.put_status(7, set.err().unwrap_or(Status::OK));
    Ok(Outcome::Done)
}

/// ASSUMPTION: a port that no program assigned is where it is by itself: rack 0, slot 1, one port.
fn get_assignment(context: &mut Context<'_>) -> Result<Outcome, Fault> {
    let status = match port(context) {
        Ok(port) => {
            let own = [0, 1, context.integer(0), port.1, 1];
            let values = context.port_setup.assignment(port).unwrap_or(own);
            for (value, number) in values.into_iter().zip(2..) {
                context.put(number, Cell::Integer(value));
            }
            Status::OK
        }
        Err(status) => status,
    };
    context.put_status(7, status);
    Ok(Outcome::Done)
}

/// ASSUMPTION: the mode (inverted, complementary) is kept and changes nothing.
fn set_mode(context: &mut Context<'_>) -> Result<Outcome, Fault> {
    let mode = context.integer(2);
    let set = port(context).and_then(|port| {
        let kept = context.port_setup.set_mode(port, mode);
        if kept {
            Ok(())
        } else {
            Err(Status::INTP_LIMIT)
        }
    });
    context.put_status(3, set.err().unwrap_or(Status::OK));
    Ok(Outcome::Done)
}

fn get_mode(context: &mut Context<'_>) -> Result<Outcome, Fault> {
    let status = match port(context) {
        Ok(port) => {
            let mode = context.port_setup.mode(port);
            context.put(2, Cell::Integer(mode));
            Status::OK
        }
        Err(status) => status,
    };
    context.put_status(3, status);
    Ok(Outcome::Done)
}
