//! Which variables programs have, and making more of them.

#![expect(
    clippy::unnecessary_wraps,
    reason = "all built-ins have the table's signature"
)]

use std::sync::Arc;

use super::{Builtin, Context, Outcome, Param, Returns};
use crate::{
    machine::{cell::Cell, fault::Fault, locate_variable},
    status::Status,
    syspath::SysPath,
    types::{ArrayType, PathType, PositionKind, Small, TextLength, Type},
    value::Text,
};

#[rustfmt::skip]
pub(super) const TABLE: &[Builtin] = &[
    Builtin { name: "CREATE_VAR", params: &[Param::Text, Param::Text, Param::Text, Param::Text, Param::Integer, Param::Integer, Param::Integer, Param::Integer, Param::OutInteger, Param::AnyValue], required: 9, returns: Returns::Nothing, code: create },
    Builtin { name: "RENAME_VAR", params: &[Param::Text, Param::Text, Param::Text, Param::OutInteger], required: 4, returns: Returns::Nothing, code: rename },
    Builtin { name: "VAR_INFO", params: &[Param::Text, Param::Text, Param::OutBoolean, Param::OutText, Param::OutInteger, Param::IntegerArray, Param::OutInteger, Param::OutInteger], required: 8, returns: Returns::Nothing, code: info },
    Builtin { name: "VAR_LIST", params: &[Param::Text, Param::Text, Param::Integer, Param::Integer, Param::Integer, Param::TextArray, Param::OutInteger, Param::OutInteger], required: 8, returns: Returns::Nothing, code: list },
];

/// Longest name of a variable.
const MAX_NAME: usize = 36;

/// The number of a type.
///
/// ASSUMPTION: 16, 17, 31 and 209 are seen in programs, and 2, 6 and 9 in descriptions; the others
/// are from memory or ours.
fn code_of(ty: &Type) -> i32 {
    match ty {
        Type::Position(PositionKind::Position) => 1,
        Type::Position(PositionKind::Xyzwpr) => 2,
        Type::Position(PositionKind::XyzwprExt) => 6,
        Type::Joints(_) => 9,
        Type::Integer => 16,
        Type::Real => 17,
        Type::Boolean => 18,
        Type::Structure(_) if ty.is_vector() => 19,
        Type::Small(Small::Short) => 23,
        Type::Small(Small::Byte) => 24,
        Type::Config => 28,
        Type::File => 29,
        Type::Path(_) => 31,
        Type::Text(_) => 209,
        Type::Structure(_) => 210,
        Type::Array(array) => code_of(&array.element),
        Type::Error => 0,
    }
}

/// A program's name, that of the program itself if it is empty.
pub(super) fn program_name(context: &Context<'_>, number: usize) -> String {
    let name = context.text(number).to_string_lossless();
    match name.trim() {
        "" => context.program.name().to_owned(),
        name => name.to_ascii_uppercase(),
    }
}

fn upper(context: &Context<'_>, number: usize) -> String {
    let name = context.text(number).to_string_lossless();
    name.trim().to_ascii_uppercase()
}

/// `CREATE_VAR(program, name, type's program, type, group, inner, mid, outer, status, pool)`:
/// dimensions of 0 are none. `SET_VAR`, `GET_VAR` and `BYNAME` reach it.
///
/// ASSUMPTION: it loses its value without power, whatever the memory pool is.
fn create(context: &mut Context<'_>) -> Result<Outcome, Fault> {
    let status = created(context).err().unwrap_or(Status::OK);
    context.put_status(8, status);
    Ok(Outcome::Done)
}

fn created(context: &mut Context<'_>) -> Result<(), Status> {
    let (program, name) = (program_name(context, 0), upper(context, 1));
    check_name(&name)?;
    if context.integer(4) > 1 {
        return Err(Status::INTP_ARGUMENT);
    }
    match locate_variable(context.names(), &program, &SysPath::from_name(&name)) {
        Ok(_) => return Err(Status::VARS_EXISTS),
        Err(Status::VARS_UNKNOWN) => {}
        Err(status) => return Err(status),
    }
    let mut ty = named_type(context, &program)?;
    let mut dims = Vec::new();
    for number in [7, 6, 5] {
        match u32::try_from(context.integer(number)) {
            Ok(0) => {}
            Ok(length) => dims.push(length),
            Err(_) => return Err(Status::INTP_ARGUMENT),
        }
    }
    if !dims.is_empty() {
        if matches!(ty, Type::Path(_) | Type::Array(_)) {
            return Err(Status::VARS_TYPE);
        }
        let depth = 1 + ty.depth();
        let element = ty;
        ty = Type::Array(Arc::new(ArrayType {
            dims,
            element,
            depth,
        }));
    }
    if !ty.is_copied() && !matches!(ty, Type::Path(_)) {
        return Err(Status::VARS_TYPE);
    }
    let name = (program.as_str(), name.as_str());
    let made = context
        .created
        .create(name, &ty, context.paths, &mut context.memory);
    if made {
        Ok(())
    } else {
        Err(Status::INTP_LIMIT)
    }
}

/// `INTEGER`, `STRING[20]`, or a type of a program.
fn named_type(context: &Context<'_>, program: &str) -> Result<Type, Status> {
    let home = upper(context, 2);
    let home = if home.is_empty() { program } else { &home };
    let name = upper(context, 3);
    let mut programs = context.programs.iter();
    let home = programs.find(|loaded| loaded.name() == home);
    if let Some(ty) = home.and_then(|loaded| loaded.named_type(&name)) {
        return Ok(ty.clone());
    }
    if name == "PATH" {
        let node = Type::standard_node();
        let depth = 1 + node.depth();
        let header = None;
        return Ok(Type::Path(Arc::new(PathType {
            header,
            node,
            depth,
        })));
    }
    if let Some(length) = name.strip_prefix("STRING") {
        let length = length.trim().strip_prefix('[');
        let length = length.and_then(|length| length.strip_suffix(']'));
        let length = length.and_then(|length| length.trim().parse().ok());
        let length = length.filter(|length| (1..=crate::types::MAX_STRING).contains(length));
        let length = length.and_then(|length| u32::try_from(length).ok());
        let length = length.ok_or(Status::VARS_TYPE)?;
        return Ok(Type::Text(TextLength::AtMost(length)));
    }
    Type::named(&name).ok_or(Status::VARS_TYPE)
}

fn check_name(name: &str) -> Result<(), Status> {
    let letter = name.starts_with(|c: char| c.is_ascii_alphabetic());
    let others = name.chars().all(|c| c.is_ascii_alphanumeric() || c == '_');
    if letter && others && name.len() <= MAX_NAME {
        Ok(())
    } else {
        Err(Status::INTP_ARGUMENT)
    }
}

/// ASSUMPTION: only variables that `CREATE_VAR` made can get another name; those of a program are
/// known to its code by their places.
fn rename(context: &mut Context<'_>) -> Result<Outcome, Fault> {
    let status = renamed(context).err().unwrap_or(Status::OK);
    context.put_status(3, status);
    Ok(Outcome::Done)
}

fn renamed(context: &mut Context<'_>) -> Result<(), Status> {
    let (program, old, new) = (
        program_name(context, 0),
        upper(context, 1),
        upper(context, 2),
    );
    check_name(&new)?;
    let find = |name: &str| locate_variable(context.names(), &program, &SysPath::from_name(name));
    let _there = find(&old)?;
    if find(&new).is_ok() || !context.created.rename(&program, &old, &new) {
        return Err(Status::VARS_EXISTS);
    }
    Ok(())
}

/// `VAR_INFO(program, variable, uninit, type name, type code, dims, string length, status)`.
fn info(context: &mut Context<'_>) -> Result<Outcome, Fault> {
    let status = inform(context).err().unwrap_or(Status::OK);
    context.put_status(7, status);
    Ok(Outcome::Done)
}

fn inform(context: &mut Context<'_>) -> Result<(), Status> {
    let program = program_name(context, 0);
    let path = SysPath::parse(&context.text(1).to_string_lossless());
    let path = path.map_err(|_| Status::VARS_UNKNOWN)?;
    let found = locate_variable(context.names(), &program, &path)?;
    let uninit = context.memory.is_uninit(found.at, &found.ty);
    let (element, dims) = if let Type::Array(array) = &found.ty {
        (&array.element, array.dims.as_slice())
    } else {
        (&found.ty, [].as_slice())
    };
    context.put(2, Cell::Boolean(uninit));
    context.put_text(3, Text::from(element.to_string().as_str()));
    let at = context.variable(5);
    let room = super::variable::array_length(context.ty(5), at.extra);
    for offset in 0..room {
        let length = dims.get(offset as usize).copied().unwrap_or(0);
        let length = i32::try_from(length).unwrap_or(i32::MAX);
        context.memory.set(at.plus(offset), Cell::Integer(length));
    }
    context.put(4, Cell::Integer(code_of(element)));
    let length = element
        .length()
        .and_then(|length| i32::try_from(length).ok());
    context.put(6, Cell::Integer(length.unwrap_or(0)));
    Ok(())
}

/// `VAR_LIST(program, pattern, type code, skip, format, names, count, status)`: by name.
///
/// ASSUMPTION: a pattern may end with `*`, also that of the program; 0 is any type; format 1 is the
/// program, 2 the variable, 3 both as `[PROGRAM]VARIABLE`.
fn list(context: &mut Context<'_>) -> Result<Outcome, Fault> {
    let (programs, pattern) = (program_name(context, 0), upper(context, 1));
    let (wanted, format) = (context.integer(2), context.integer(4));
    let skip = usize::try_from(context.integer(3)).unwrap_or(0);
    let fits = |pattern: &str, name: &str| match pattern.strip_suffix('*') {
        Some(start) => name.starts_with(start),
        None => name == pattern,
    };
    let mut found = Vec::new();
    let mut any_program = false;
    for loaded in context.programs {
        if !fits(&programs, loaded.name()) {
            continue;
        }
        any_program = true;
        let created = context.created.of(loaded.name());
        let created = created.map(|(name, _, ty)| (name, ty));
        let mut own: Vec<(&str, &Type)> = loaded.variables().chain(created).collect();
        own.retain(|(name, ty)| fits(&pattern, name) && (wanted == 0 || code_of(ty) == wanted));
        own.sort_unstable_by_key(|(name, _)| *name);
        found.extend(own.into_iter().map(|(name, _)| match format {
            1 => loaded.name().to_owned(),
            3 => format!("[{}]{name}", loaded.name()),
            _ => name.to_owned(),
        }));
    }
    let texts = found
        .iter()
        .skip(skip)
        .map(|name| Text::from(name.as_str()));
    let count = context.put_texts(5, texts);
    context.put(6, Cell::Integer(count));
    let status = match (any_program, format) {
        (false, _) => Status::MEMO_NO_PROGRAM,
        (true, 1..=3) => Status::OK,
        (true, _) => Status::INTP_ARGUMENT,
    };
    context.put_status(7, status);
    Ok(Outcome::Done)
}
