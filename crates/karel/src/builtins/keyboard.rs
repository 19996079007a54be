//! The keyboard of the pendant.

#![expect(
    clippy::unnecessary_wraps,
    reason = "all built-ins have the table's signature"
)]

use std::time::Duration;

use super::{Builtin, Context, Outcome, Param, Returns};
use crate::{
    host::{FileId, Wait},
    machine::{
        cell::{Cell, FileFlag},
        fault::Fault,
        task::Pending,
    },
    status::Status,
    value::Text,
};

#[rustfmt::skip]
pub(super) const TABLE: &[Builtin] = &[
    Builtin { name: "POP_KEY_RD", params: &[Param::Text, Param::Integer, Param::OutInteger], required: 3, returns: Returns::Nothing, code: pop },
    Builtin { name: "PUSH_KEY_RD", params: &[Param::Text, Param::Integer, Param::OutInteger, Param::OutInteger], required: 4, returns: Returns::Nothing, code: push },
    Builtin { name: "READ_KB", params: &[Param::File, Param::OutText, Param::Integer, Param::Integer, Param::Integer, Param::Integer, Param::Text, Param::OutInteger, Param::OutInteger, Param::OutInteger], required: 10, returns: Returns::Nothing, code: read },
];

/// Codes from here on are keys that are no characters; see the header `klevkeys`.
const FIRST_KEY: u8 = 128;

/// `READ_KB(file, buffer, size, accept mask, term mask, time, initial text, count, key, status)`.
///
/// ASSUMPTION: ENTER ends it always, a key that is no character if the term mask is not 0, and the
/// last character that fits if the size is not 0; with an accept mask of 0 characters are dropped.
/// The time is in milliseconds, below 0 for ever; when it is over the status is 12358. The initial
/// text stands before what was typed.
fn read(context: &mut Context<'_>) -> Result<Outcome, Fault> {
    let file = context.memory.file(context.variable(0));
    if file.file != Some(FileId::KEYBOARD) && !file.has(FileFlag::Window) {
        *context.pending = Pending::None;
        context.put_status(9, Status::INTP_NOT_OPEN);
        return Ok(Outcome::Done);
    }
    let size = usize::try_from(context.integer(2)).unwrap_or(0);
    let (accepts, terminates) = (context.integer(3) != 0, context.integer(4) != 0);
    let mut typed = context.text(6).as_bytes().to_vec();
    let mut used = 0;
    let mut key = None;
    for byte in context.host.input(FileId::KEYBOARD).bytes {
        used += 1;
        match byte {
            b'\r' | b'\n' => key = Some(13),
            byte if *byte >= FIRST_KEY => key = terminates.then(|| i32::from(*byte)),
            byte if accepts => {
                typed.push(*byte);
                if size > 0 && typed.len() >= size {
                    key = Some(0);
                }
            }
            _ => {}
        }
        if key.is_some() {
            break;
        }
    }
    let (now, until) = (context.host.now(), deadline(context));
    let status = match key {
        Some(_) => Status::OK,
        None if until <= now => Status::INTP_READ_TIMEOUT,
        None => {
            // What was typed so far stays there.
            *context.pending = Pending::Deadline(until);
            return Ok(Outcome::Pending(if until == Duration::MAX {
                Wait::Readable(FileId::KEYBOARD)
            } else {
                Wait::ReadableUntil(FileId::KEYBOARD, until)
            }));
        }
    };
    *context.pending = Pending::None;
    context.host.consume(FileId::KEYBOARD, used);
    let count = i32::try_from(typed.len()).unwrap_or(i32::MAX);
    context.put_text(1, Text::new(typed));
    context.put(7, Cell::Integer(count));
    context.put(8, Cell::Integer(key.unwrap_or(0)));
    context.put_status(9, status);
    Ok(Outcome::Done)
}

fn deadline(context: &Context<'_>) -> Duration {
    if let Pending::Deadline(until) = *context.pending {
        return until;
    }
    match u64::try_from(context.integer(5)) {
        Ok(time) => context
            .host
            .now()
            .saturating_add(Duration::from_millis(time)),
        Err(_) => Duration::MAX,
    }
}

/// ASSUMPTION: nobody else reads the keyboard, so there is nothing to suspend.
fn push(context: &mut Context<'_>) -> Result<Outcome, Fault> {
    context.put(2, Cell::Integer(0));
    context.put_status(3, Status::OK);
    Ok(Outcome::Done)
}

fn pop(context: &mut Context<'_>) -> Result<Outcome, Fault> {
    context.put_status(2, Status::OK);
    Ok(Outcome::Done)
}
