//! Variables: of the system and of programs by path, uninitialized ones, lengths of arrays.

#![expect(
    clippy::unnecessary_wraps,
    reason = "all built-ins have the table's signature"
)]

use super::{Builtin, Context, Outcome, Param, Returns};
use crate::{
    machine::{cell::Cell, component_of, fault::Fault, find_variable, set_component},
    status::Status,
    syspath::SysPath,
    sysvars,
    types::{Type, split_grid, split_text_array},
    value::{SysValue, Value},
};

#[rustfmt::skip]
pub(super) const TABLE: &[Builtin] = &[
    Builtin { name: "ARRAY_LEN", params: &[Param::AnyArray], required: 1, returns: Returns::Integer, code: array_len },
    Builtin { name: "GET_VAR", params: &[Param::OutInteger, Param::Text, Param::Text, Param::OutAny, Param::OutInteger], required: 5, returns: Returns::Nothing, code: get_var },
    Builtin { name: "SET_VAR", params: &[Param::OutInteger, Param::Text, Param::Text, Param::AnyValue, Param::OutInteger], required: 5, returns: Returns::Nothing, code: set_var },
    Builtin { name: "UNINIT", params: &[Param::AnyVariable], required: 1, returns: Returns::Boolean, code: uninit },
];

fn uninit(context: &mut Context<'_>) -> Result<Outcome, Fault> {
    let at = context.variable(0);
    let uninit = context.memory.is_uninit(at, context.ty(0));
    Ok(Outcome::Value(Cell::Boolean(uninit)))
}

fn array_len(context: &mut Context<'_>) -> Result<Outcome, Fault> {
    let length = array_length(context.ty(0), context.variable(0).extra);
    Ok(Outcome::Value(Cell::Integer(
        i32::try_from(length).unwrap_or(i32::MAX),
    )))
}

/// The length of an array that is passed with `extra` beside its address.
pub(super) fn array_length(ty: &Type, extra: u32) -> u32 {
    let Type::Array(array) = ty else {
        return extra;
    };
    match array.dims.first() {
        Some(0) => {
            let lengths = split_grid(extra, array.dims.len());
            lengths.first().copied().unwrap_or(0)
        }
        Some(length) => *length,
        None if array.element == Type::TEXT => split_text_array(extra).0,
        None => extra,
    }
}

/// Where the path of the second and third argument leads.
enum Target {
    System(SysPath),
    Program { program: String, path: SysPath },
}

fn target(context: &Context<'_>) -> Result<Target, Status> {
    let program = context
        .text(1)
        .to_string_lossless()
        .trim()
        .to_ascii_uppercase();
    let path = SysPath::parse(&context.text(2).to_string_lossless());
    let path = path.map_err(|_| Status::VARS_UNKNOWN)?;
    Ok(match program.as_str() {
        "*SYSTEM*" => Target::System(path),
        "" => Target::Program {
            program: context.program.name().to_owned(),
            path,
        },
        _ => Target::Program { program, path },
    })
}

/// A status, never an abort. The entry argument is an opaque cache and is not looked at.
fn set_var(context: &mut Context<'_>) -> Result<Outcome, Fault> {
    let at = context.variable(3);
    let value = context.memory.value(at, context.ty(3));
    let status = match target(context) {
        Ok(Target::System(path)) => set_system(context, &path, value.as_ref()),
        Ok(Target::Program { program, path }) => {
            set_program(context, &program, &path, value.as_ref())
        }
        Err(status) => Err(status),
    };
    let status = match (status, value) {
        (Err(status), _) => status,
        // The target became uninitialized, and the status says so.
        (Ok(()), None) => Status::INTP_UNINIT,
        (Ok(()), Some(_)) => Status::OK,
    };
    context.put_status(4, status);
    Ok(Outcome::Done)
}

fn set_system(
    context: &mut Context<'_>,
    path: &SysPath,
    value: Option<&Value>,
) -> Result<(), Status> {
    if let Some((whole_path, component)) = path.split_component() {
        let whole = context.host.system_variable(context.task, &whole_path)?;
        let mut position = whole.as_xyzwprext().ok_or(Status::VARS_UNKNOWN)?;
        let ty = sysvars::type_of_path(&whole_path).ok_or(Status::VARS_UNKNOWN)?;
        let (offset, _) = ty.field(component).ok_or(Status::VARS_UNKNOWN)?;
        let cell = match value {
            Some(Value::Real(value)) => Cell::Real(*value),
            Some(Value::Integer(value)) => Cell::Real(crate::value::real_of(*value)),
            Some(Value::Config(value)) => Cell::Config(*value),
            Some(_) => return Err(Status::VARS_TYPE),
            None => return Err(Status::INTP_UNINIT),
        };
        if !set_component(&mut position, offset, &cell) {
            return Err(Status::VARS_TYPE);
        }
        let whole = Value::Position(position.into());
        return context
            .host
            .set_system_variable(context.task, &whole_path, whole.into());
    }
    let value = match value {
        None => SysValue::Uninit,
        Some(value) => SysValue::Value(fitting(path, value)?),
    };
    context.host.set_system_variable(context.task, path, value)
}

/// The value as the variable's type, if the type is known: INTEGER becomes REAL, and one
/// cartesian type another.
fn fitting(path: &SysPath, value: &Value) -> Result<Value, Status> {
    let Some(ty) = sysvars::type_of_path(path) else {
        return Ok(value.clone());
    };
    match (&ty, value) {
        (Type::Real, Value::Integer(integer)) => Ok(Value::Real(crate::value::real_of(*integer))),
        (Type::Position(_), _) => {
            let position = value.as_xyzwprext().ok_or(Status::VARS_TYPE)?;
            Ok(Value::Position(position.into()))
        }
        (Type::Integer, Value::Integer(_))
        | (Type::Real, Value::Real(_))
        | (Type::Boolean, Value::Boolean(_))
        | (Type::Text(_), Value::String(_)) => Ok(value.clone()),
        _ => Err(Status::VARS_TYPE),
    }
}

fn set_program(
    context: &mut Context<'_>,
    program: &str,
    path: &SysPath,
    value: Option<&Value>,
) -> Result<(), Status> {
    let found = find_variable(context.names(), program, path)?;
    match value {
        None => context.memory.clear(found.at, &found.ty),
        Some(value) => {
            if !context.memory.set_value(found.at, &found.ty, value) {
                return Err(Status::VARS_TYPE);
            }
        }
    }
    Ok(())
}

/// An uninitialized source makes the target uninitialized; an unknown one leaves it as it is.
fn get_var(context: &mut Context<'_>) -> Result<Outcome, Fault> {
    let found = match target(context) {
        Ok(Target::System(path)) => get_system(context, &path),
        Ok(Target::Program { program, path }) => find_variable(context.names(), &program, &path)
            .and_then(|found| {
                context
                    .memory
                    .value(found.at, &found.ty)
                    .ok_or(Status::INTP_UNINIT)
            }),
        Err(status) => Err(status),
    };
    let at = context.variable(3);
    let ty = context.ty(3).clone();
    let status = match found {
        Ok(value) if context.memory.set_value(at, &ty, &value) => Status::OK,
        Ok(_) => Status::VARS_TYPE,
        Err(Status::INTP_UNINIT) => {
            context.memory.clear(at, &ty);
            Status::INTP_UNINIT
        }
        Err(status) => status,
    };
    context.put_status(4, status);
    Ok(Outcome::Done)
}

fn get_system(context: &Context<'_>, path: &SysPath) -> Result<Value, Status> {
    let Some((whole_path, component)) = path.split_component() else {
        return context.host.system_variable(context.task, path);
    };
    let whole = context.host.system_variable(context.task, &whole_path)?;
    let ty = sysvars::type_of_path(&whole_path).ok_or(Status::VARS_UNKNOWN)?;
    let (offset, _) = ty.field(component).ok_or(Status::VARS_UNKNOWN)?;
    match component_of(&whole, offset) {
        Some(Cell::Real(value)) => Ok(Value::Real(value)),
        Some(Cell::Config(value)) => Ok(Value::Config(value)),
        _ => Err(Status::VARS_UNKNOWN),
    }
}
