//! Variables of programs as files: `SAVE`, `LOAD`.
//!
//! ASSUMPTION: a `.vr` file of a controller is not known. Ours is text: a line for each scalar or
//! position, `[PROGRAM]PATH = value`; `*` for none; `[PROGRAM]PATH nodes 3` before those of a PATH.

#![expect(
    clippy::unnecessary_wraps,
    reason = "all built-ins have the table's signature"
)]

use std::fmt::Write as _;

use super::{Builtin, Context, Outcome, Param, Returns, variable_list};
use crate::{
    machine::{
        Names,
        fault::Fault,
        find_variable,
        inspect::{address, parts_of, paths_in},
        locate_variable,
    },
    position::{Config, JointPosition, Xyzwpr, XyzwprExt},
    status::Status,
    syspath::SysPath,
    types::{PositionKind, Type},
    value::{Text, Value},
};

#[rustfmt::skip]
pub(super) const TABLE: &[Builtin] = &[
    Builtin { name: "LOAD", params: &[Param::Text, Param::Integer, Param::OutInteger], required: 3, returns: Returns::Nothing, code: load },
    Builtin { name: "SAVE_DRAM", params: &[Param::Text, Param::OutInteger], required: 2, returns: Returns::Nothing, code: save_dram },
    Builtin { name: "SAVE", params: &[Param::Text, Param::Text, Param::OutInteger], required: 3, returns: Returns::Nothing, code: save },
];

/// Most lines of a file.
pub(super) const MAX_PARTS: usize = 20_000;

/// `SAVE(program, file, status)`.
fn save(context: &mut Context<'_>) -> Result<Outcome, Fault> {
    let status = saved(context).err().unwrap_or(Status::OK);
    context.put_status(2, status);
    Ok(Outcome::Done)
}

fn saved(context: &mut Context<'_>) -> Result<(), Status> {
    let program = variable_list::program_name(context, 0);
    let program = program.trim_end_matches(".VR");
    let mut programs = context.programs.iter();
    let loaded = programs.find(|loaded| loaded.name() == program);
    let loaded = loaded.ok_or(Status::MEMO_NO_PROGRAM)?;
    let names = context.names();
    let mut text = format!("-- variables of {program}\r\n");
    let created = context.created.of(loaded.name());
    let created = created.map(|(name, _, ty)| (name, ty));
    for (name, ty) in loaded.variables().chain(created) {
        for (path, id) in paths_of(names, program, name, ty) {
            let nodes = names.paths.len(id);
            let _ = write!(text, "[{program}]{path} nodes {nodes}\r\n");
        }
    }
    let parts = parts_of(names, loaded, MAX_PARTS);
    if parts.len() > MAX_PARTS {
        return Err(Status::INTP_LIMIT);
    }
    for (path, cell, ty) in parts.into_iter().filter(|(_, _, ty)| *ty != Type::File) {
        let value = context.memory.value(address(cell, &ty), &ty);
        let value = value.map_or_else(|| "*".to_owned(), |value| written(&value));
        let _ = write!(text, "[{program}]{path} = {value}\r\n");
    }
    let file = with_extension(&context.text(1).to_string_lossless());
    context.write_file(&file, Text::from(text.as_str()).as_bytes())
}

/// The PATHs of a variable by name, and their numbers.
pub(super) fn paths_of(
    names: Names<'_>,
    program: &str,
    name: &str,
    ty: &Type,
) -> Vec<(String, u32)> {
    if !ty.holds_path() {
        return Vec::new();
    }
    let Ok(found) = locate_variable(names, program, &SysPath::from_name(name)) else {
        return Vec::new();
    };
    let first = u32::try_from(found.at.global_index()).unwrap_or(u32::MAX);
    let paths = paths_in(name, first, &found.ty).into_iter();
    let paths = paths.filter_map(|(name, cell, _)| {
        let path = names.globals.get(cell as usize)?.path()?;
        Some((name, path))
    });
    paths.collect()
}

/// The file's name, with `.VR` if it has no extension.
fn with_extension(file: &str) -> String {
    let file = file.trim();
    let name = file.rsplit([':', '\\', '/']).next().unwrap_or(file);
    if name.contains('.') {
        file.to_owned()
    } else {
        format!("{file}.VR")
    }
}

pub(super) fn extension(file: &str) -> String {
    let extension = file.trim().rsplit_once('.').map(|(_, extension)| extension);
    extension.unwrap_or_default().to_ascii_uppercase()
}

/// `LOAD(file, option, status)`: variables from a `.vr` file.
///
/// ASSUMPTION: programs are loaded from outside: a `.pc` or `.tp` is status 7015 if its program is
/// there, else 7073. Variables that a file does not name stay as they are; the first line that
/// cannot be used gives the status, and the others are used all the same.
fn load(context: &mut Context<'_>) -> Result<Outcome, Fault> {
    let file = context.text(0).to_string_lossless();
    let loaded = match extension(&file).as_str() {
        "VR" => load_variables(context, &file),
        _ => Err(if is_loaded(context, &file) {
            Status::MEMO_EXISTS
        } else {
            Status::MEMO_NO_PROGRAM
        }),
    };
    context.put_status(2, loaded.err().unwrap_or(Status::OK));
    Ok(Outcome::Done)
}

pub(super) fn program_of(file: &str) -> String {
    let name = file.trim().rsplit([':', '\\', '/']).next().unwrap_or(file);
    let name = name.split('.').next().unwrap_or(name);
    name.to_ascii_uppercase()
}

pub(super) fn is_loaded(context: &Context<'_>, file: &str) -> bool {
    let name = program_of(file);
    context.programs.iter().any(|loaded| loaded.name() == name)
}

fn load_variables(context: &mut Context<'_>, file: &str) -> Result<(), Status> {
    let bytes = context.read_file(file)?;
    if bytes
        .iter()
        .any(|byte| byte.is_ascii_control() && !byte.is_ascii_whitespace())
    {
        context.explain(&|| {
            format!(
                "LOAD of {file:?} answers INTP-333: a controller's own .vr file cannot be read, \
                 only the text that SAVE writes here"
            )
        });
        return Err(Status::INTP_ILLEGAL_DATA);
    }
    let text = Text::new(bytes).to_string_lossless();
    let mut first = Ok(());
    for line in text.lines() {
        let line = line.trim();
        if line.is_empty() || line.starts_with("--") {
            continue;
        }
        let read = load_line(context, line);
        if first.is_ok() {
            first = read;
        }
    }
    first
}

fn load_line(context: &mut Context<'_>, line: &str) -> Result<(), Status> {
    let line = line.strip_prefix('[').ok_or(Status::INTP_ILLEGAL_DATA)?;
    let (program, rest) = line.split_once(']').ok_or(Status::INTP_ILLEGAL_DATA)?;
    if let Some((name, count)) = rest.split_once(" nodes ") {
        return set_nodes(context, program, name, count);
    }
    let (path, value) = rest.split_once(" = ").ok_or(Status::INTP_ILLEGAL_DATA)?;
    let path = SysPath::parse(path).map_err(|_| Status::INTP_ILLEGAL_DATA)?;
    let found = find_variable(context.names(), program, &path)?;
    if value == "*" {
        context.memory.clear(found.at, &found.ty);
        return Ok(());
    }
    let value = read(value, &found.ty).ok_or(Status::INTP_ILLEGAL_DATA)?;
    if context.memory.set_value(found.at, &found.ty, &value) {
        Ok(())
    } else {
        Err(Status::VARS_TYPE)
    }
}

fn set_nodes(
    context: &mut Context<'_>,
    program: &str,
    name: &str,
    count: &str,
) -> Result<(), Status> {
    let count: usize = count
        .trim()
        .parse()
        .map_err(|_| Status::INTP_ILLEGAL_DATA)?;
    let path = SysPath::parse(name).map_err(|_| Status::INTP_ILLEGAL_DATA)?;
    let found = locate_variable(context.names(), program, &path)?;
    if !matches!(found.ty, Type::Path(_)) {
        return Err(Status::VARS_TYPE);
    }
    let id = context.memory.get(found.at).expect_path();
    context.paths.clear(id);
    for before in 0..count.min(MAX_PARTS) {
        if !context.paths.insert(id, before, &mut context.memory) {
            return Err(Status::INTP_LIMIT);
        }
    }
    Ok(())
}

/// `SAVE_DRAM(program, status)`.
///
/// ASSUMPTION: what is not in CMOS loses its value without power all the same.
fn save_dram(context: &mut Context<'_>) -> Result<Outcome, Fault> {
    let program = context.text(0).to_string_lossless();
    let status = if is_loaded(context, &program) {
        Status::OK
    } else {
        Status::MEMO_NO_PROGRAM
    };
    context.put_status(1, status);
    Ok(Outcome::Done)
}

fn written(value: &Value) -> String {
    let numbers = |numbers: &[f32]| {
        let texts: Vec<String> = numbers.iter().map(|number| format!("{number:?}")).collect();
        texts.join(" ")
    };
    match value {
        Value::Integer(value) => value.to_string(),
        Value::Real(value) => format!("{value:?}"),
        Value::Boolean(true) => "TRUE".to_owned(),
        Value::Boolean(false) => "FALSE".to_owned(),
        Value::String(text) => quoted(text),
        Value::Config(config) => config.to_string(),
        Value::Joints(joints) => numbers(&joints.axes),
        Value::Xyzwpr(_) | Value::Position(_) | Value::XyzwprExt(_) => {
            let XyzwprExt {
                x,
                y,
                z,
                w,
                p,
                r,
                config,
                ext: [a, b, c],
            } = value.as_xyzwprext().unwrap_or_default();
            format!("{} {config}", numbers(&[x, y, z, w, p, r, a, b, c]))
        }
    }
}

/// In quotes; what is no printable ASCII as `\xNN`.
fn quoted(text: &Text) -> String {
    let mut quoted = String::from("'");
    for byte in text.as_bytes() {
        match byte {
            b'\'' => quoted.push_str("''"),
            b' '..=b'~' if *byte != b'\\' => quoted.push(char::from(*byte)),
            byte => {
                let _ = write!(quoted, "\\x{byte:02X}");
            }
        }
    }
    quoted.push('\'');
    quoted
}

fn unquoted(text: &str) -> Option<Text> {
    let inner = text.strip_prefix('\'')?.strip_suffix('\'')?;
    let mut bytes = Vec::new();
    let mut chars = inner.chars();
    while let Some(c) = chars.next() {
        bytes.push(match c {
            '\'' => {
                let _second = chars.next().filter(|c| *c == '\'')?;
                b'\''
            }
            '\\' => {
                let _x = chars.next().filter(|c| *c == 'x')?;
                let digits: String = chars.by_ref().take(2).collect();
                u8::from_str_radix(&digits, 16).ok()?
            }
            c => u8::try_from(c).ok()?,
        });
    }
    Some(Text::new(bytes))
}

fn read(text: &str, ty: &Type) -> Option<Value> {
    let real = |text: &str| text.parse::<f32>().ok().filter(|value| value.is_finite());
    Some(match ty {
        Type::Integer | Type::Small(_) => Value::Integer(text.parse().ok()?),
        Type::Real => Value::Real(real(text)?),
        Type::Boolean => Value::Boolean(match text {
            "TRUE" => true,
            "FALSE" => false,
            _ => return None,
        }),
        Type::Text(_) => Value::String(unquoted(text)?),
        Type::Config => Value::Config(Config::parse(text)?),
        Type::Joints(_) => {
            let axes: Option<Vec<f32>> = text.split_whitespace().map(real).collect();
            Value::Joints(JointPosition { axes: axes? })
        }
        Type::Position(kind) => {
            let mut words = text.splitn(10, ' ');
            let mut numbers = [0.0; 9];
            for number in &mut numbers {
                *number = real(words.next()?)?;
            }
            let [x, y, z, w, p, r, a, b, c] = numbers;
            let position = XyzwprExt {
                x,
                y,
                z,
                w,
                p,
                r,
                config: Config::parse(words.next()?)?,
                ext: [a, b, c],
            };
            match kind {
                PositionKind::XyzwprExt => Value::XyzwprExt(position),
                PositionKind::Xyzwpr => Value::Xyzwpr(Xyzwpr::from(position)),
                PositionKind::Position => Value::Position(position.into()),
            }
        }
        Type::File | Type::Array(_) | Type::Structure(_) | Type::Path(_) | Type::Error => {
            return None;
        }
    })
}
