//! Strings. Positions count from 1.

#![expect(
    clippy::unnecessary_wraps,
    reason = "all built-ins have the table's signature"
)]

use super::{Builtin, Context, Outcome, Param, Returns};
use crate::{
    machine::{cell::Cell, fault::Fault},
    value::Text,
};

#[rustfmt::skip]
pub(super) const TABLE: &[Builtin] = &[
    Builtin { name: "CHR", params: &[Param::Integer], required: 1, returns: Returns::Text, code: chr },
    Builtin { name: "INDEX", params: &[Param::Text, Param::Text], required: 2, returns: Returns::Integer, code: index },
    Builtin { name: "ORD", params: &[Param::Text, Param::Integer], required: 2, returns: Returns::Integer, code: ord },
    Builtin { name: "STR_LEN", params: &[Param::Text], required: 1, returns: Returns::Integer, code: str_len },
    Builtin { name: "SUB_STR", params: &[Param::Text, Param::Integer, Param::Integer], required: 3, returns: Returns::Text, code: sub_str },
];

fn length(bytes: &[u8]) -> i32 {
    i32::try_from(bytes.len()).unwrap_or(i32::MAX)
}

fn chr(context: &mut Context<'_>) -> Result<Outcome, Fault> {
    let code = context.integer(0);
    let byte = u8::try_from(code)
        .map_err(|_| Fault::argument(format!("CHR of {code}, not in 0 to 255")))?;
    Ok(Outcome::Value(Cell::Text(Text::new(vec![byte]))))
}

/// The first place where the second string is in the first, 0 if nowhere.
fn index(context: &mut Context<'_>) -> Result<Outcome, Fault> {
    let (text, wanted) = (context.text(0), context.text(1));
    let wanted = wanted.as_bytes();
    // ASSUMPTION: an empty string is nowhere.
    let found = if wanted.is_empty() {
        None
    } else {
        text.as_bytes()
            .windows(wanted.len())
            .position(|window| window == wanted)
    };
    let position = found
        .and_then(|index| i32::try_from(index + 1).ok())
        .unwrap_or(0);
    Ok(Outcome::Value(Cell::Integer(position)))
}

fn ord(context: &mut Context<'_>) -> Result<Outcome, Fault> {
    let (text, position) = (context.text(0), context.integer(1));
    let index = usize::try_from(position)
        .ok()
        .and_then(|position| position.checked_sub(1));
    let byte = index
        .and_then(|index| text.as_bytes().get(index))
        .ok_or_else(|| {
            let length = length(text.as_bytes());
            Fault::argument(format!(
                "ORD of character {position}, the string has {length}"
            ))
        })?;
    Ok(Outcome::Value(Cell::Integer(i32::from(*byte))))
}

fn str_len(context: &mut Context<'_>) -> Result<Outcome, Fault> {
    Ok(Outcome::Value(Cell::Integer(length(
        context.text(0).as_bytes(),
    ))))
}

/// A part that reaches beyond the end is shorter, and one that starts there is empty.
///
/// ASSUMPTION: a start below 1 or a negative length is a bad argument.
fn sub_str(context: &mut Context<'_>) -> Result<Outcome, Fault> {
    let text = context.text(0);
    let (start, count) = (context.integer(1), context.integer(2));
    let index = usize::try_from(start)
        .ok()
        .and_then(|start| start.checked_sub(1));
    let (Some(index), Ok(count)) = (index, usize::try_from(count)) else {
        return Err(Fault::argument(format!(
            "SUB_STR from {start}, length {count}"
        )));
    };
    let part: Vec<u8> = text
        .as_bytes()
        .iter()
        .skip(index)
        .take(count)
        .copied()
        .collect();
    Ok(Outcome::Value(Cell::Text(Text::new(part))))
}
