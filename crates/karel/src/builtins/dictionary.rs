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
        find_variable,
    },
    status::Status,
    syspath::SysPath,
    text_writer::MAX_WIDTH,
    value::{Text, Value},
};

#[rustfmt::skip]
pub(super) const TABLE: &[Builtin] = &[
    Builtin { name: "ADD_DICT", params: &[Param::Text, Param::Text, Param::Text, Param::Integer, Param::OutInteger], required: 5, returns: Returns::Nothing, code: add },
    Builtin { name: "CHECK_DICT", params: &[Param::Text, Param::Integer, Param::OutInteger], required: 3, returns: Returns::Nothing, code: check },
    Builtin { name: "READ_DICT", params: &[Param::Text, Param::Integer, Param::TextArray, Param::Integer, Param::OutInteger, Param::OutInteger], required: 6, returns: Returns::Nothing, code: read },
    Builtin { name: "REMOVE_DICT", params: &[Param::Text, Param::Text, Param::OutInteger], required: 3, returns: Returns::Nothing, code: remove },
    Builtin { name: "WRITE_DICT_V", params: &[Param::File, Param::Text, Param::Integer, Param::TextArray, Param::OutInteger], required: 5, returns: Returns::Nothing, code: write_values },
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
    let text = element(context, 1).map(|lines| joined(&lines));
    put(context, text, 3)
}

/// `WRITE_DICT_V(file, dictionary, element, names, status)`: each `%` of the element shows the variable whose name is
/// next, `[PROGRAM]NAME` or a name of the program that runs.
fn write_values(context: &mut Context<'_>) -> Result<Outcome, Fault> {
    let text = element(context, 1).and_then(|lines| with_values(context, &joined(&lines)));
    put(context, text, 4)
}

fn joined(lines: &[Text]) -> Vec<u8> {
    let lines: Vec<&[u8]> = lines.iter().map(Text::as_bytes).collect();
    lines.join(crate::text_writer::LINE_END)
}

fn put(
    context: &mut Context<'_>,
    text: Result<Vec<u8>, Status>,
    status_at: usize,
) -> Result<Outcome, Fault> {
    let status = match text {
        Ok(bytes) => {
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
    context.put_status(status_at, status);
    Ok(Outcome::Done)
}

/// The bytes of an element with the values of variables in it.
///
/// ASSUMPTION: `%`, a width and decimals that may be left out, `-` for the left, and a letter, as in C; `%%` is one.
/// More of them than names is status 12310, a variable without a value `********`.
fn with_values(context: &Context<'_>, text: &[u8]) -> Result<Vec<u8>, Status> {
    let names = context.texts(3);
    let mut names = names.into_iter();
    let mut shown = Vec::new();
    let mut rest = text;
    while let Some(at) = rest.iter().position(|byte| *byte == b'%') {
        let (before, found) = rest.split_at_checked(at).unwrap_or((rest, &[]));
        shown.extend(before);
        let format = found.get(1..).unwrap_or_default();
        if let Some(after) = format.strip_prefix(b"%") {
            shown.push(b'%');
            rest = after;
            continue;
        }
        let parameters = |byte: &&u8| byte.is_ascii_digit() || matches!(byte, b'-' | b'.' | b'+');
        let length = format.iter().take_while(parameters).count();
        let (parameters, after) = format.split_at_checked(length).unwrap_or((format, &[]));
        let (letter, after) = after.split_first().ok_or(Status::INTP_ILLEGAL_DATA)?;
        if !letter.is_ascii_alphabetic() {
            return Err(Status::INTP_ILLEGAL_DATA);
        }
        let name = names.next().flatten().ok_or(Status::INTP_SUBSCRIPT)?;
        shown.extend(value(context, &name, &String::from_utf8_lossy(parameters))?);
        rest = after;
    }
    shown.extend(rest);
    Ok(shown)
}

/// A variable as text, in the width that `-8.2` says.
fn value(context: &Context<'_>, name: &str, format: &str) -> Result<Vec<u8>, Status> {
    let (program, variable) = match name.trim().strip_prefix('[') {
        Some(rest) => rest.split_once(']').ok_or(Status::VARS_UNKNOWN)?,
        None => (context.program.name(), name.trim()),
    };
    let path = SysPath::parse(variable).map_err(|_| Status::VARS_UNKNOWN)?;
    let found = find_variable(context.names(), program.trim(), &path)?;
    let (width, decimals) = format.split_once('.').unwrap_or((format, ""));
    let left = width.starts_with('-');
    let width = width.trim_start_matches(['-', '+']).parse::<usize>();
    let width = width.unwrap_or(0).min(MAX_WIDTH);
    let decimals = decimals.parse::<usize>().ok().map(|n| n.min(MAX_WIDTH));
    let text = match (context.memory.value(found.at, &found.ty), decimals) {
        (None, _) => "*".repeat(8).into_bytes(),
        (Some(Value::Real(value)), Some(decimals)) => format!("{value:.decimals$}").into_bytes(),
        (Some(Value::Real(value)), None) => format!("{value:.6}").into_bytes(),
        (Some(Value::Integer(value)), _) => value.to_string().into_bytes(),
        (Some(Value::Boolean(value)), _) => value.to_string().to_ascii_uppercase().into_bytes(),
        (Some(Value::String(text)), _) => text.as_bytes().to_vec(),
        (Some(_), _) => return Err(Status::INTP_TYPE),
    };
    let blanks = vec![b' '; width.saturating_sub(text.len())];
    Ok(if left {
        [text, blanks].concat()
    } else {
        [blanks, text].concat()
    })
}
