//! TP programs as data: opening, positions, comments, making more of them.
//!
//! ASSUMPTION: lines are not written by programs; a line that is deleted becomes an empty one, so
//! that labels and the lines behind it stay where they are. Nothing of this is kept without power
//! or written to a listing.

#![expect(
    clippy::unnecessary_wraps,
    reason = "all built-ins have the table's signature"
)]

use std::{collections::BTreeMap, time::Duration};

use super::{
    Builtin, Context, Outcome, Param, Returns,
    joints::{to_cartesian, to_joints},
};
use crate::{
    host::TpTarget,
    machine::{Loaded, cell::Cell, fault::Fault, teaching::Open},
    position::{JointPosition, XyzwprExt},
    program::Program,
    status::{Status, attribute_of_program as attribute, open_mode},
    tp::Taught,
    types::{JointKind, PositionKind, Type},
    value::Text,
};

const EXTENDED: Param = Param::Position(PositionKind::XyzwprExt);

#[rustfmt::skip]
pub(super) const TABLE: &[Builtin] = &[
    Builtin { name: "AVL_POS_NUM", params: &[Param::Integer, Param::OutInteger, Param::OutInteger], required: 3, returns: Returns::Nothing, code: free_position },
    Builtin { name: "CLOSE_TPE", params: &[Param::Integer, Param::OutInteger], required: 2, returns: Returns::Nothing, code: close },
    Builtin { name: "COPY_TPE", params: &[Param::Text, Param::Text, Param::Boolean, Param::OutInteger], required: 4, returns: Returns::Nothing, code: copy },
    Builtin { name: "CREATE_TPE", params: &[Param::Text, Param::Integer, Param::OutInteger], required: 3, returns: Returns::Nothing, code: create },
    Builtin { name: "DEL_INST_TPE", params: &[Param::Integer, Param::Integer, Param::OutInteger], required: 3, returns: Returns::Nothing, code: delete_line },
    Builtin { name: "GET_ATTR_PRG", params: &[Param::Text, Param::Integer, Param::OutInteger, Param::OutText, Param::OutInteger], required: 5, returns: Returns::Nothing, code: get_attribute },
    Builtin { name: "GET_JPOS_TPE", params: &[Param::Integer, Param::Integer, Param::OutInteger, Param::Integer], required: 3, returns: Returns::Joints, code: get_joints },
    Builtin { name: "GET_POS_FRM", params: &[Param::Integer, Param::Integer, Param::Integer, Param::OutInteger, Param::OutInteger, Param::OutInteger], required: 6, returns: Returns::Nothing, code: get_frames },
    Builtin { name: "GET_POS_TPE", params: &[Param::Integer, Param::Integer, Param::OutInteger, Param::Integer], required: 3, returns: Returns::XyzwprExt, code: get_position },
    Builtin { name: "GET_POS_TYP", params: &[Param::Integer, Param::Integer, Param::Integer, Param::OutInteger, Param::OutInteger, Param::OutInteger], required: 6, returns: Returns::Nothing, code: get_type },
    Builtin { name: "GET_TPE_CMT", params: &[Param::Integer, Param::Integer, Param::OutText, Param::OutInteger], required: 4, returns: Returns::Nothing, code: get_comment },
    Builtin { name: "OPEN_TPE", params: &[Param::Text, Param::Integer, Param::Integer, Param::OutInteger, Param::OutInteger], required: 5, returns: Returns::Nothing, code: open },
    Builtin { name: "SET_ATTR_PRG", params: &[Param::Text, Param::Integer, Param::Integer, Param::Text, Param::OutInteger], required: 5, returns: Returns::Nothing, code: set_attribute },
    Builtin { name: "SET_EPOS_TPE", params: &[Param::Integer, Param::Integer, EXTENDED, Param::OutInteger, Param::Integer], required: 4, returns: Returns::Nothing, code: set_position },
    Builtin { name: "SET_JPOS_TPE", params: &[Param::Integer, Param::Integer, Param::Joints, Param::OutInteger, Param::Integer], required: 4, returns: Returns::Nothing, code: set_joints },
    Builtin { name: "SET_POS_TPE", params: &[Param::Integer, Param::Integer, EXTENDED, Param::OutInteger, Param::Integer], required: 4, returns: Returns::Nothing, code: set_position },
    Builtin { name: "SET_TPE_CMT", params: &[Param::Integer, Param::Integer, Param::Text, Param::OutInteger], required: 4, returns: Returns::Nothing, code: set_comment },
    Builtin { name: "SET_TRNS_TPE", params: &[Param::Integer, Param::Integer, EXTENDED, Param::OutInteger], required: 4, returns: Returns::Nothing, code: set_position },
];

/// Highest number of a position.
const MOST_POSITIONS: i32 = 1500;

/// A statement that changes programs ends its slice, and a loop around it must not stop the time.
pub(super) const PAUSE: Duration = Duration::from_millis(1);

/// Longest comment of a position, and of a program.
const COMMENT: usize = 16;

fn status_of(result: Result<(), Status>) -> Status {
    result.err().unwrap_or(Status::OK)
}

fn name(context: &Context<'_>, number: usize) -> String {
    let name = context.text(number).to_string_lossless();
    name.trim().to_ascii_uppercase()
}

fn program<'a>(context: &Context<'a>, name: &str) -> Option<&'a Loaded> {
    let mut programs = context.programs.iter();
    programs.find(|loaded| loaded.name() == name)
}

/// The program that is opened under the number of the first argument.
fn opened(context: &Context<'_>, writes: bool) -> Result<Open, Status> {
    let open = context.teaching.opened(context.integer(0));
    let open = open.ok_or(Status::INTP_NOT_OPEN)?;
    if writes && !open.writes {
        return Err(Status::MEMO_IN_USE);
    }
    Ok(open.clone())
}

/// `OPEN_TPE(program, mode, reject, number, status)`.
///
/// ASSUMPTION: one at a time may write a program; what others may do meanwhile changes nothing.
fn open(context: &mut Context<'_>) -> Result<Outcome, Fault> {
    let program_name = name(context, 0);
    let mode = context.integer(1);
    let status = match program(context, &program_name) {
        None => Status::MEMO_NO_PROGRAM,
        Some(loaded) if !loaded.is_listing() => Status::INTP_TYPE,
        Some(_) if !matches!(mode, open_mode::READ | open_mode::WRITE) => Status::INTP_ARGUMENT,
        Some(_) if mode == open_mode::WRITE && context.teaching.is_written(&program_name) => {
            Status::MEMO_IN_USE
        }
        Some(_) => match context
            .teaching
            .open(program_name, mode == open_mode::WRITE)
        {
            Some(id) => {
                context.put(3, Cell::Integer(id));
                Status::OK
            }
            None => Status::INTP_LIMIT,
        },
    };
    context.put_status(4, status);
    Ok(Outcome::Done)
}

fn close(context: &mut Context<'_>) -> Result<Outcome, Fault> {
    let id = context.integer(0);
    let status = if context.teaching.close(id) {
        Status::OK
    } else {
        Status::INTP_NOT_OPEN
    };
    context.put_status(1, status);
    Ok(Outcome::Done)
}

/// The position of the second argument, as programs left it.
fn taught(context: &Context<'_>, group: Option<usize>) -> Result<Taught, Status> {
    let open = opened(context, false)?;
    if group.is_some_and(|number| context.has_arg(number) && context.integer(number) != 1) {
        return Err(Status::VARS_INDEX);
    }
    let number = context.integer(1);
    if let Some(changed) = context.teaching.changed(&open.program, number) {
        return Ok(changed.clone());
    }
    let loaded = program(context, &open.program).ok_or(Status::MEMO_NO_PROGRAM)?;
    loaded.taught(number).cloned().ok_or(Status::INTP_UNINIT)
}

/// A joint position becomes a cartesian one by `$UFRAME` and `$UTOOL`; on failure the result has
/// no value.
fn get_position(context: &mut Context<'_>) -> Result<Outcome, Fault> {
    let found: Result<XyzwprExt, Status> =
        taught(context, Some(3)).and_then(|taught| match taught.target {
            TpTarget::Cartesian(position) => Ok(position),
            TpTarget::Joints(joints) => to_cartesian(context, &joints),
        });
    let at = context.result();
    let kind = PositionKind::XyzwprExt;
    match &found {
        Ok(position) => context.memory.set_position(at, kind, position),
        Err(_) => context.memory.clear(at, &Type::Position(kind)),
    }
    context.put_status(2, status_of(found.map(drop)));
    Ok(Outcome::Done)
}

fn get_joints(context: &mut Context<'_>) -> Result<Outcome, Fault> {
    let found: Result<JointPosition, Status> =
        taught(context, Some(3)).and_then(|taught| match taught.target {
            TpTarget::Joints(joints) => Ok(joints),
            TpTarget::Cartesian(position) => to_joints(context, &position),
        });
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
    context.put_status(2, status);
    Ok(Outcome::Done)
}

/// A position that is new gets the frames that are active.
fn teach(context: &mut Context<'_>, target: TpTarget) -> Result<(), Status> {
    let open = opened(context, true)?;
    if context.has_arg(4) && context.integer(4) != 1 {
        return Err(Status::VARS_INDEX);
    }
    let number = context.integer(1);
    if !(1..=MOST_POSITIONS).contains(&number) {
        return Err(Status::INTP_ARGUMENT);
    }
    let (frame, tool) = match taught(context, None) {
        Ok(before) => (before.frame, before.tool),
        Err(_) => (None, None),
    };
    let taught = Taught {
        number,
        frame,
        tool,
        target,
    };
    if context.teaching.change(&open.program, taught) {
        Ok(())
    } else {
        Err(Status::INTP_LIMIT)
    }
}

fn set_position(context: &mut Context<'_>) -> Result<Outcome, Fault> {
    let position = context.position(2, PositionKind::XyzwprExt)?;
    let status = status_of(teach(context, TpTarget::Cartesian(position)));
    context.put_status(3, status);
    Ok(Outcome::Done)
}

fn set_joints(context: &mut Context<'_>) -> Result<Outcome, Fault> {
    let joints = context.joints(2)?;
    let status = status_of(teach(context, TpTarget::Joints(joints)));
    context.put_status(3, status);
    Ok(Outcome::Done)
}

/// `GET_POS_TYP(number, position, group, type, axes, status)`, in the numbers of `POS_REG_TYPE`.
fn get_type(context: &mut Context<'_>) -> Result<Outcome, Fault> {
    let status = match taught(context, Some(2)) {
        Ok(taught) => {
            let (kind, axes) = match &taught.target {
                TpTarget::Cartesian(_) => (2, 0),
                TpTarget::Joints(joints) => (9, joints.axes.len()),
            };
            context.put(3, Cell::Integer(kind));
            context.put(4, Cell::Integer(i32::try_from(axes).unwrap_or(0)));
            Status::OK
        }
        Err(status) => status,
    };
    context.put_status(5, status);
    Ok(Outcome::Done)
}

/// ASSUMPTION: `F`, whatever is active, is the number 15.
fn get_frames(context: &mut Context<'_>) -> Result<Outcome, Fault> {
    let status = match taught(context, Some(2)) {
        Ok(taught) => {
            context.put(3, Cell::Integer(taught.frame.unwrap_or(15)));
            context.put(4, Cell::Integer(taught.tool.unwrap_or(15)));
            Status::OK
        }
        Err(status) => status,
    };
    context.put_status(5, status);
    Ok(Outcome::Done)
}

/// The lowest number without a position.
fn free_position(context: &mut Context<'_>) -> Result<Outcome, Fault> {
    let status = match opened(context, false) {
        Ok(open) => {
            let loaded = program(context, &open.program);
            let mut free = 1..=MOST_POSITIONS;
            let free = free.find(|number| {
                let changed = context.teaching.changed(&open.program, *number).is_some();
                !changed && loaded.is_none_or(|loaded| loaded.taught(*number).is_none())
            });
            match free {
                Some(number) => {
                    context.put(1, Cell::Integer(number));
                    Status::OK
                }
                None => Status::INTP_LIMIT,
            }
        }
        Err(status) => status,
    };
    context.put_status(2, status);
    Ok(Outcome::Done)
}

fn get_comment(context: &mut Context<'_>) -> Result<Outcome, Fault> {
    let status = match (opened(context, false), taught(context, None)) {
        (Ok(open), Ok(taught)) => {
            let comment = context.teaching.comment(&open.program, taught.number);
            context.put_text(2, comment);
            Status::OK
        }
        (Err(status), _) | (_, Err(status)) => status,
    };
    context.put_status(3, status);
    Ok(Outcome::Done)
}

fn set_comment(context: &mut Context<'_>) -> Result<Outcome, Fault> {
    let mut comment = context.text(2);
    comment.truncate(COMMENT);
    let status = match (opened(context, true), taught(context, None)) {
        (Ok(open), Ok(taught)) => {
            let number = taught.number;
            if context.teaching.set_comment(&open.program, number, comment) {
                Status::OK
            } else {
                Status::INTP_LIMIT
            }
        }
        (Err(status), _) | (_, Err(status)) => status,
    };
    context.put_status(3, status);
    Ok(Outcome::Done)
}

/// Makes a program; the next statement sees it.
fn make(context: &mut Context<'_>, new: Program) -> Result<(), Status> {
    let valid = |name: &str| {
        let mut chars = name.chars();
        let first = chars.next().is_some_and(|c| c.is_ascii_alphabetic());
        first && name.len() <= 36 && chars.all(|c| c.is_ascii_alphanumeric() || c == '_')
    };
    if !valid(new.name()) {
        return Err(Status::INTP_ARGUMENT);
    }
    if program(context, new.name()).is_some() {
        return Err(Status::MEMO_EXISTS);
    }
    let programs = context.programs.iter();
    let programs = programs.filter(|loaded| !loaded.is_deleted()).count();
    if programs + context.teaching.made.len() >= context.limits.programs {
        return Err(Status::INTP_LIMIT);
    }
    context.teaching.made.push(new);
    Ok(())
}

/// An empty program; its type changes nothing.
fn create(context: &mut Context<'_>) -> Result<Outcome, Fault> {
    let new = Program::of_listing(&name(context, 0), Vec::new(), BTreeMap::new());
    let status = status_of(make(context, new));
    context.put_status(2, status);
    Ok(Outcome::DoneThenPause(PAUSE))
}

/// `COPY_TPE(from, to, overwrite, status)`.
///
/// ASSUMPTION: a program that is there is never replaced: status 7004.
fn copy(context: &mut Context<'_>) -> Result<Outcome, Fault> {
    let (from, to) = (name(context, 0), name(context, 1));
    let made = match program(context, &from) {
        None => Err(Status::MEMO_NO_PROGRAM),
        Some(loaded) if !loaded.is_listing() => Err(Status::INTP_TYPE),
        Some(_) if program(context, &to).is_some() && context.boolean(2) => {
            Err(Status::MEMO_IN_USE)
        }
        Some(loaded) => {
            let (instructions, positions) = loaded.listing();
            let new = Program::of_listing(&to, instructions, positions);
            make(context, new).map(|()| {
                for number in 1..=MOST_POSITIONS {
                    if let Some(changed) = context.teaching.changed(&from, number).cloned() {
                        let _fits = context.teaching.change(&to, changed);
                    }
                }
            })
        }
    };
    context.put_status(3, status_of(made));
    Ok(Outcome::DoneThenPause(PAUSE))
}

fn delete_line(context: &mut Context<'_>) -> Result<Outcome, Fault> {
    let line = u32::try_from(context.integer(1)).unwrap_or(0);
    let status = match opened(context, true) {
        Ok(open) => {
            let loaded = program(context, &open.program);
            let lines = loaded.map_or(0, Loaded::lines);
            if line == 0 || line as usize > lines {
                Status::INTP_ARGUMENT
            } else {
                context.teaching.blanked.push((open.program, line));
                Status::OK
            }
        }
        Err(status) => status,
    };
    context.put_status(2, status);
    Ok(Outcome::DoneThenPause(PAUSE))
}

/// `GET_ATTR_PRG(program, attribute, number, text, status)`: type, name, comment and size.
///
/// ASSUMPTION: the type is 1 for a TP program and 2 for KAREL; the size is its instructions.
fn get_attribute(context: &mut Context<'_>) -> Result<Outcome, Fault> {
    let program_name = name(context, 0);
    let status = match (program(context, &program_name), context.integer(1)) {
        (None, _) => Status::MEMO_NO_PROGRAM,
        (Some(loaded), attribute::TYPE) => {
            let kind = if loaded.is_listing() { 1 } else { 2 };
            context.put(2, Cell::Integer(kind));
            Status::OK
        }
        (Some(_), attribute::NAME) => {
            context.put_text(3, Text::from(program_name.as_str()));
            Status::OK
        }
        (Some(_), attribute::COMMENT) => {
            let note = context.teaching.note(&program_name);
            context.put_text(3, note);
            Status::OK
        }
        (Some(loaded), attribute::SIZE) => {
            context.put(2, Cell::Integer(loaded.size()));
            Status::OK
        }
        (Some(_), _) => Status::INTP_ARGUMENT,
    };
    context.put_status(4, status);
    Ok(Outcome::Done)
}

/// Only the comment can be set.
fn set_attribute(context: &mut Context<'_>) -> Result<Outcome, Fault> {
    let program_name = name(context, 0);
    let status = match (program(context, &program_name), context.integer(1)) {
        (None, _) => Status::MEMO_NO_PROGRAM,
        (Some(_), attribute::COMMENT) => {
            let mut note = context.text(3);
            note.truncate(COMMENT);
            context.teaching.set_note(&program_name, note);
            Status::OK
        }
        (Some(_), _) => Status::INTP_ARGUMENT,
    };
    context.put_status(4, status);
    Ok(Outcome::Done)
}
