//! Registers: `R[n]`, `SR[n]`, `PR[n]`. A bad number is a status, never the end of the task.

use super::{Builtin, Context, Outcome, Param, Returns, joints::to_cartesian, motion::group};
use crate::{
    machine::{cell::Cell, fault::Fault},
    position::{JointPosition, XyzwprExt},
    registers::{Number, PositionRegister},
    status::Status,
    types::{JointKind, PositionKind, Type},
    value::Text,
};

#[rustfmt::skip]
pub(super) const TABLE: &[Builtin] = &[
    Builtin { name: "CLR_POS_REG", params: &[Param::Integer, Param::Integer, Param::OutInteger], required: 3, returns: Returns::Nothing, code: clear_position },
    Builtin { name: "GET_JPOS_REG", params: &[Param::Integer, Param::OutInteger, Param::Integer], required: 2, returns: Returns::Joints, code: get_joints },
    Builtin { name: "GET_POS_REG", params: &[Param::Integer, Param::OutInteger, Param::Integer], required: 2, returns: Returns::XyzwprExt, code: get_position },
    Builtin { name: "GET_REG", params: &[Param::Integer, Param::OutBoolean, Param::OutInteger, Param::OutReal, Param::OutInteger], required: 5, returns: Returns::Nothing, code: get_number },
    Builtin { name: "GET_STR_REG", params: &[Param::Integer, Param::OutText, Param::OutInteger], required: 3, returns: Returns::Nothing, code: get_string },
    Builtin { name: "POS_REG_TYPE", params: &[Param::Integer, Param::Integer, Param::OutInteger, Param::OutInteger, Param::OutInteger], required: 5, returns: Returns::Nothing, code: position_type },
    Builtin { name: "SET_EPOS_REG", params: &[Param::Integer, Param::Position(PositionKind::XyzwprExt), Param::OutInteger, Param::Integer], required: 3, returns: Returns::Nothing, code: set_position },
    Builtin { name: "SET_INT_REG", params: &[Param::Integer, Param::Integer, Param::OutInteger], required: 3, returns: Returns::Nothing, code: |context| { let value = context.integer(1); set_number(context, Number::Integer(value)) } },
    Builtin { name: "SET_JPOS_REG", params: &[Param::Integer, Param::Joints, Param::OutInteger, Param::Integer], required: 3, returns: Returns::Nothing, code: set_joints },
    Builtin { name: "SET_POS_REG", params: &[Param::Integer, Param::Position(PositionKind::XyzwprExt), Param::OutInteger, Param::Integer], required: 3, returns: Returns::Nothing, code: set_position },
    Builtin { name: "SET_REAL_REG", params: &[Param::Integer, Param::Real, Param::OutInteger], required: 3, returns: Returns::Nothing, code: |context| { let value = context.real(1); set_number(context, Number::Real(value)) } },
    Builtin { name: "SET_STR_REG", params: &[Param::Integer, Param::Text, Param::OutInteger], required: 3, returns: Returns::Nothing, code: set_string },
];

fn status_of(result: Result<(), Status>) -> Status {
    result.err().unwrap_or(Status::OK)
}

/// Position registers are kept for the only motion group that there is.
fn only_group(group: i32) -> Result<(), Status> {
    if group == 1 {
        Ok(())
    } else {
        Err(Status::VARS_INDEX)
    }
}

#[expect(clippy::unnecessary_wraps, reason = "it ends a built-in")]
fn set_number(context: &mut Context<'_>, value: Number) -> Result<Outcome, Fault> {
    let status = status_of(context.registers.set_number(context.integer(0), value));
    context.put_status(2, status);
    Ok(Outcome::Done)
}

/// Only the variable of the register's own type is written.
#[expect(clippy::unnecessary_wraps, reason = "the table's signature")]
fn get_number(context: &mut Context<'_>) -> Result<Outcome, Fault> {
    let status = match context.registers.number(context.integer(0)) {
        Ok(Number::Integer(value)) => {
            context.put(1, Cell::Boolean(false));
            context.put(2, Cell::Integer(value));
            Status::OK
        }
        Ok(Number::Real(value)) => {
            context.put(1, Cell::Boolean(true));
            context.put(3, Cell::Real(value));
            Status::OK
        }
        Err(status) => status,
    };
    context.put_status(4, status);
    Ok(Outcome::Done)
}

#[expect(clippy::unnecessary_wraps, reason = "the table's signature")]
fn set_string(context: &mut Context<'_>) -> Result<Outcome, Fault> {
    let value = context.text(1).to_string_lossless();
    let status = status_of(context.registers.set_string(context.integer(0), value));
    context.put_status(2, status);
    Ok(Outcome::Done)
}

#[expect(clippy::unnecessary_wraps, reason = "the table's signature")]
fn get_string(context: &mut Context<'_>) -> Result<Outcome, Fault> {
    let found = context.registers.string(context.integer(0)).map(Text::from);
    let status = match found {
        Ok(text) => {
            context.put_text(1, text);
            Status::OK
        }
        Err(status) => status,
    };
    context.put_status(2, status);
    Ok(Outcome::Done)
}

fn store(context: &mut Context<'_>, group: i32, value: PositionRegister) -> Status {
    let n = context.integer(0);
    let stored = only_group(group).and_then(|()| context.registers.set_position(n, value));
    status_of(stored)
}

fn set_position(context: &mut Context<'_>) -> Result<Outcome, Fault> {
    let position = context.position(1, PositionKind::XyzwprExt)?;
    let group = group(context, 3);
    let status = store(context, group, PositionRegister::Cartesian(position));
    context.put_status(2, status);
    Ok(Outcome::Done)
}

fn set_joints(context: &mut Context<'_>) -> Result<Outcome, Fault> {
    let joints = context.joints(1)?;
    let group = group(context, 3);
    let status = store(context, group, PositionRegister::Joints(joints));
    context.put_status(2, status);
    Ok(Outcome::Done)
}

#[expect(clippy::unnecessary_wraps, reason = "the table's signature")]
fn clear_position(context: &mut Context<'_>) -> Result<Outcome, Fault> {
    let group = context.integer(1);
    let status = store(context, group, PositionRegister::Unset);
    context.put_status(2, status);
    Ok(Outcome::Done)
}

/// What is in the register; one that is not set has a status for it.
fn fetch(context: &Context<'_>) -> Result<PositionRegister, Status> {
    only_group(group(context, 2))?;
    match context.registers.position(context.integer(0))? {
        PositionRegister::Unset => Err(Status::INTP_UNINIT),
        set @ (PositionRegister::Cartesian(_) | PositionRegister::Joints(_)) => Ok(set.clone()),
    }
}

/// Joints become a position by `$UFRAME` and `$UTOOL`; on failure the result has no value.
#[expect(clippy::unnecessary_wraps, reason = "the table's signature")]
fn get_position(context: &mut Context<'_>) -> Result<Outcome, Fault> {
    let found: Result<XyzwprExt, Status> = match fetch(context) {
        Ok(PositionRegister::Cartesian(position)) => Ok(position),
        Ok(PositionRegister::Joints(joints)) => to_cartesian(context, &joints),
        Ok(PositionRegister::Unset) => Err(Status::INTP_UNINIT),
        Err(status) => Err(status),
    };
    let at = context.result();
    let kind = PositionKind::XyzwprExt;
    match &found {
        Ok(position) => context.memory.set_position(at, kind, position),
        Err(_) => context.memory.clear(at, &Type::Position(kind)),
    }
    context.put_status(1, status_of(found.map(drop)));
    Ok(Outcome::Done)
}

#[expect(clippy::unnecessary_wraps, reason = "the table's signature")]
fn get_joints(context: &mut Context<'_>) -> Result<Outcome, Fault> {
    let found: Result<JointPosition, Status> = match fetch(context) {
        Ok(PositionRegister::Joints(joints)) => Ok(joints),
        Ok(PositionRegister::Cartesian(position)) => super::joints::to_joints(context, &position),
        Ok(PositionRegister::Unset) => Err(Status::INTP_UNINIT),
        Err(status) => Err(status),
    };
    let at = context.result();
    let kind = JointKind::OfGroup;
    let status = match found {
        Ok(joints) if context.memory.set_joints(at, kind, &joints) => Status::OK,
        Ok(_) => Status::INTP_ARGUMENT,
        Err(status) => status,
    };
    if !status.is_ok() {
        context.memory.clear(at, &Type::Joints(kind));
    }
    context.put_status(1, status);
    Ok(Outcome::Done)
}

/// ASSUMPTION: 2 is XYZWPR, 6 is XYZWPREXT, 9 is JOINTPOS; the axes are those of the joints, or the
/// extended ones that are not 0.
#[expect(clippy::unnecessary_wraps, reason = "the table's signature")]
fn position_type(context: &mut Context<'_>) -> Result<Outcome, Fault> {
    let register = only_group(context.integer(1))
        .and_then(|()| context.registers.position(context.integer(0)).cloned());
    let (kind, axes) = match register {
        Ok(PositionRegister::Joints(joints)) => (9, joints.axes.len()),
        Ok(PositionRegister::Cartesian(position)) => {
            let used = position.ext.iter().rposition(|value| *value != 0.0);
            match used {
                Some(last) => (6, last + 1),
                None => (2, 0),
            }
        }
        Ok(PositionRegister::Unset) => {
            context.put_status(4, Status::INTP_UNINIT);
            return Ok(Outcome::Done);
        }
        Err(status) => {
            context.put_status(4, status);
            return Ok(Outcome::Done);
        }
    };
    context.put(2, Cell::Integer(kind));
    context.put(3, Cell::Integer(i32::try_from(axes).unwrap_or(0)));
    context.put_status(4, Status::OK);
    Ok(Outcome::Done)
}
