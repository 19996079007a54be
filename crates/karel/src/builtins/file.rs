//! Files and sockets.

#![expect(
    clippy::unnecessary_wraps,
    reason = "all built-ins have the table's signature"
)]

use std::time::Duration;

use super::{Builtin, Context, Outcome, Param, Returns};
use crate::{
    host::{InputEnd, Progress},
    machine::{cell::Cell, fault::Fault},
    status::{Status, attribute},
    text_reader::LineState,
};

#[rustfmt::skip]
pub(super) const TABLE: &[Builtin] = &[
    Builtin { name: "BYTES_AHEAD", params: &[Param::File, Param::OutInteger, Param::OutInteger], required: 3, returns: Returns::Nothing, code: bytes_ahead },
    Builtin { name: "CLR_IO_STAT", params: &[Param::File], required: 1, returns: Returns::Nothing, code: clr_io_stat },
    Builtin { name: "IO_STATUS", params: &[Param::File], required: 1, returns: Returns::Integer, code: io_status },
    Builtin { name: "MSG_CONNECT", params: &[Param::Text, Param::OutInteger], required: 2, returns: Returns::Nothing, code: msg_connect },
    Builtin { name: "SET_FILE_ATR", params: &[Param::File, Param::Integer, Param::Integer], required: 2, returns: Returns::Nothing, code: set_file_atr },
    Builtin { name: "MSG_DISCO", params: &[Param::Text, Param::OutInteger], required: 2, returns: Returns::Nothing, code: msg_disco },
];

/// Programs retry a failed connect in a tight loop.
///
/// ASSUMPTION: how long a controller takes to refuse is not known; this only keeps such a loop
/// from starving the others.
const PAUSE_AFTER_FAILED_CONNECT: Duration = Duration::from_millis(1);

fn io_status(context: &mut Context<'_>) -> Result<Outcome, Fault> {
    let file = context.memory.file(context.variable(0));
    Ok(Outcome::Value(Cell::Integer(file.status)))
}

fn clr_io_stat(context: &mut Context<'_>) -> Result<Outcome, Fault> {
    let at = context.variable(0);
    let mut file = context.memory.file(at);
    file.status = 0;
    context.memory.set_file(at, file);
    Ok(Outcome::Done)
}

/// Attributes of a FILE variable, for all files that it opens and the one that is open.
fn set_file_atr(context: &mut Context<'_>) -> Result<Outcome, Fault> {
    let at = context.variable(0);
    match context.integer(1) {
        attribute::IMMEDIATE => {}
        attribute::TIMEOUT if context.has_arg(2) => {
            let given = context.integer(2);
            let timeout = u32::try_from(given)
                .map_err(|_| Fault::argument(format!("ATR_TIMEOUT of {given} ms, less than 0")))?;
            let mut file = context.memory.file(at);
            file.timeout_ms = timeout;
            context.memory.set_file(at, file);
        }
        attribute::TIMEOUT => return Err(Fault::argument("ATR_TIMEOUT needs milliseconds")),
        other => {
            return Err(Fault::argument(format!(
                "SET_FILE_ATR with the attribute {other}, which is not supported"
            )));
        }
    }
    Ok(Outcome::Done)
}

/// Bytes that can be read without waiting.
///
/// ASSUMPTION: an LF that follows the CR of a line that was read does not count. Once they are used up and the peer is gone, the status
/// says so and the number stays uninitialized.
fn bytes_ahead(context: &mut Context<'_>) -> Result<Outcome, Fault> {
    let file = context.memory.file(context.variable(0));
    let Some(id) = file.file else {
        context.put(1, Cell::Uninit);
        context.put_status(2, Status::INTP_NOT_OPEN);
        return Ok(Outcome::Done);
    };
    let input = context.host.input(id);
    // The LF of a line that ended with CR LF was read with that line.
    let of_last_line = file.line_state == LineState::AfterCr && input.bytes.first() == Some(&b'\n');
    let ahead = input.bytes.len() - usize::from(of_last_line);
    let count = i32::try_from(ahead).unwrap_or(i32::MAX);
    let (count, status) = match input.end {
        InputEnd::Closed(status) if count == 0 => (Cell::Uninit, status),
        InputEnd::Closed(_) | InputEnd::Open => (Cell::Integer(count), Status::OK),
    };
    context.put(1, count);
    context.put_status(2, status);
    Ok(Outcome::Done)
}

fn msg_connect(context: &mut Context<'_>) -> Result<Outcome, Fault> {
    let tag = tag_name(context);
    match context.host.msg_connect(context.task, &tag) {
        Progress::Pending(wait) => Ok(Outcome::Pending(wait)),
        Progress::Ready(status) => {
            context.put_status(1, status);
            Ok(if status.is_ok() {
                Outcome::Done
            } else {
                Outcome::DoneThenPause(PAUSE_AFTER_FAILED_CONNECT)
            })
        }
    }
}

fn msg_disco(context: &mut Context<'_>) -> Result<Outcome, Fault> {
    let tag = tag_name(context);
    let status = context.host.msg_disco(context.task, &tag);
    context.put_status(1, status);
    Ok(Outcome::Done)
}

/// `s3:` and `S3:` are the tag S3.
fn tag_name(context: &Context<'_>) -> String {
    let tag = context.text(0).to_string_lossless();
    tag.trim().trim_end_matches(':').to_ascii_uppercase()
}
