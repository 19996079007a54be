//! Dictionaries; see `machine/dictionaries.rs` for what their files are.

#![expect(
    clippy::unnecessary_wraps,
    reason = "all built-ins have the table's signature"
)]

use super::{Builtin, Context, Outcome, Param, Returns};
use crate::{
    host::Progress,
    machine::{
        cell::{Cell, FileFlag},
        dictionaries::parse,
        fault::Fault,
    },
    status::Status,
    value::Text,
};

#[rustfmt::skip]
pub(super) const TABLE: &[Builtin] = &[
    Builtin { name: "ADD_DICT", params: &[Param::Text, Param::Text, Param::Text, Param::Integer, Param::OutInteger], required: 5, returns: Returns::Nothing, code: add },
    Builtin { name: "CHECK_DICT", params: &[Param::Text, Param::Integer, Param::OutInteger], required: 3, returns: Returns::Nothing, code: check },
    Builtin { name: "READ_DICT", params: &[Param::Text, Param::Integer, Param::TextArray, Param::Integer, Param::OutInteger, Param::OutInteger], required: 6, returns: Returns::Nothing, code: read },
    Builtin { name: "REMOVE_DICT", params: &[Param::Text, Param::Text, Param::OutInteger], required: 3, returns: Returns::Nothing, code: remove },
    Builtin { name: "WRITE_DICT", params: &[Param::File, Param::Text, Param::Integer, Param::OutInteger], required: 4, returns: Returns::Nothing, code: write },
];

fn name(context: &Context<'_>, number: usize) -> String {
    let name = context.text(number).to_string_lossless();
    name.trim().to_ascii_uppercase()
}

/// `ADD_DICT(file, dictionary, language, option, status)`: without an extension, `.UTX`.
///
/// ASSUMPTION: there is one language, and the option changes nothing.
fn add(context: &mut Context<'_>) -> Result<Outcome, Fault> {
    let status = added(context).err().unwrap_or(Status::OK);
    context.put_status(4, status);
    Ok(Outcome::Done)
}

fn added(context: &mut Context<'_>) -> Result<(), Status> {
    let mut file = name(context, 0);
    if !file.contains('.') {
        file.push_str(".UTX");
    }
    let bytes = context.read_file(&file)?;
    let dictionary = parse(&bytes).ok_or(Status::INTP_ILLEGAL_DATA)?;
    let name = name(context, 1);
    if context.dictionaries.add(name, dictionary) {
        Ok(())
    } else {
        Err(Status::INTP_LIMIT)
    }
}

fn remove(context: &mut Context<'_>) -> Result<Outcome, Fault> {
    let status = if context.dictionaries.remove(&name(context, 0)) {
        Status::OK
    } else {
        Status::DICT_MISSING
    };
    context.put_status(2, status);
    Ok(Outcome::Done)
}

fn element(context: &Context<'_>, dictionary: usize) -> Result<Vec<Text>, Status> {
    let number = context.integer(dictionary + 1);
    let found = context
        .dictionaries
        .element(&name(context, dictionary), number);
    found.map(<[Text]>::to_vec).ok_or(Status::DICT_MISSING)
}

fn check(context: &mut Context<'_>) -> Result<Outcome, Fault> {
    let status = element(context, 0).err().unwrap_or(Status::OK);
    context.put_status(2, status);
    Ok(Outcome::Done)
}

/// `READ_DICT(dictionary, element, lines, first line, last line, status)`: the lines from the first
/// one on, counted from 1, as many as there is room for.
fn read(context: &mut Context<'_>) -> Result<Outcome, Fault> {
    let first = usize::try_from(context.integer(3)).unwrap_or(0).max(1);
    let status = match element(context, 0) {
        Ok(lines) => {
            let lines = lines.into_iter().skip(first - 1);
            let count = context.put_texts(2, lines);
            let last = i32::try_from(first)
                .unwrap_or(i32::MAX)
                .saturating_add(count)
                - 1;
            context.put(4, Cell::Integer(last));
            Status::OK
        }
        Err(status) => status,
    };
    context.put_status(5, status);
    Ok(Outcome::Done)
}

/// `WRITE_DICT(file, dictionary, element, status)`: also to a window.
fn write(context: &mut Context<'_>) -> Result<Outcome, Fault> {
    let status = match element(context, 1) {
        Ok(lines) => {
            let lines: Vec<&[u8]> = lines.iter().map(Text::as_bytes).collect();
            let bytes = lines.join(crate::text_writer::LINE_END);
            let file = context.memory.file(context.variable(0));
            match file.file {
                None if file.has(FileFlag::Window) => {
                    context.host.display(context.task, &bytes);
                    Status::OK
                }
                None => Status::INTP_NOT_OPEN,
                Some(id) => match context.host.output(id, &bytes) {
                    Progress::Ready(status) => status,
                    Progress::Pending(wait) => return Ok(Outcome::Pending(wait)),
                },
            }
        }
        Err(status) => status,
    };
    context.put_status(3, status);
    Ok(Outcome::Done)
}
