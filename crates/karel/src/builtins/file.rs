//! Files and sockets.

#![expect(
    clippy::unnecessary_wraps,
    reason = "all built-ins have the table's signature"
)]

use std::time::Duration;

use super::{Builtin, Context, Outcome, Param, Returns};
use crate::{
    host::{FileOperation, InputEnd, Progress},
    machine::{
        cell::{Cell, FileFlag},
        fault::Fault,
        task::Pending,
    },
    status::{Status, attribute},
    text_reader::LineState,
    value::Text,
};

#[rustfmt::skip]
pub(super) const TABLE: &[Builtin] = &[
    Builtin { name: "BYTES_AHEAD", params: &[Param::File, Param::OutInteger, Param::OutInteger], required: 3, returns: Returns::Nothing, code: bytes_ahead },
    Builtin { name: "BYTES_LEFT", params: &[Param::File], required: 1, returns: Returns::Integer, code: bytes_left },
    Builtin { name: "COPY_FILE", params: &[Param::Text, Param::Text, Param::Boolean, Param::Boolean, Param::OutInteger], required: 5, returns: Returns::Nothing, code: copy_file },
    Builtin { name: "DELETE_FILE", params: &[Param::Text, Param::Boolean, Param::OutInteger], required: 3, returns: Returns::Nothing, code: delete_file },
    Builtin { name: "DISMOUNT_DEV", params: &[Param::Text, Param::OutInteger], required: 2, returns: Returns::Nothing, code: mount },
    Builtin { name: "FILE_LIST", params: &[Param::Text, Param::Integer, Param::Integer, Param::TextArray, Param::OutInteger, Param::OutInteger], required: 6, returns: Returns::Nothing, code: file_list },
    Builtin { name: "CHECK_NAME", params: &[Param::Text, Param::OutInteger], required: 2, returns: Returns::Nothing, code: check_name },
    Builtin { name: "PRINT_FILE", params: &[Param::Text, Param::Boolean, Param::OutInteger], required: 3, returns: Returns::Nothing, code: refuse },
    Builtin { name: "PURGE_DEV", params: &[Param::Text, Param::OutInteger], required: 2, returns: Returns::Nothing, code: mount },
    Builtin { name: "TRANSLATE", params: &[Param::Text, Param::Boolean, Param::OutInteger], required: 3, returns: Returns::Nothing, code: refuse },
    Builtin { name: "FORMAT_DEV", params: &[Param::Text, Param::Text, Param::Boolean, Param::OutInteger], required: 4, returns: Returns::Nothing, code: format_device },
    Builtin { name: "MOUNT_DEV", params: &[Param::Text, Param::OutInteger], required: 2, returns: Returns::Nothing, code: mount },
    Builtin { name: "MSG_PING", params: &[Param::Text, Param::OutInteger], required: 2, returns: Returns::Nothing, code: ping },
    Builtin { name: "RENAME_FILE", params: &[Param::Text, Param::Text, Param::Boolean, Param::OutInteger], required: 4, returns: Returns::Nothing, code: rename_file },
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
///
/// ASSUMPTION: sizes of buffers, fields, flow control and lines of a serial port change nothing here.
fn set_file_atr(context: &mut Context<'_>) -> Result<Outcome, Fault> {
    let at = context.variable(0);
    let value = context.has_arg(2).then(|| context.integer(2));
    let mut file = context.memory.file(at);
    match context.integer(1) {
        attribute::IMMEDIATE
        | attribute::FIELD
        | attribute::PASS_ALL
        | attribute::READ_AHEAD
        | attribute::PIPE_OVERFLOW
        | attribute::FLOW
        | attribute::MODEM => {}
        attribute::UNFORMATTED => file.set(FileFlag::Binary),
        attribute::REVERSE => file.set(FileFlag::Reverse),
        attribute::PIPE_WAIT => file.set(FileFlag::PipeWaits),
        attribute::END_OF_LINE => {
            let given = value.ok_or_else(|| Fault::argument("ATR_EOL needs the code of a byte"))?;
            file.line_end = u8::try_from(given)
                .map_err(|_| Fault::argument(format!("ATR_EOL of {given}, not in 0 to 255")))?;
        }
        attribute::TIMEOUT => {
            let given = value.ok_or_else(|| Fault::argument("ATR_TIMEOUT needs milliseconds"))?;
            file.timeout_ms = u32::try_from(given)
                .map_err(|_| Fault::argument(format!("ATR_TIMEOUT of {given} ms, less than 0")))?;
        }
        other => {
            return Err(Fault::argument(format!(
                "SET_FILE_ATR with the attribute {other}, which there is not"
            )));
        }
    }
    context.memory.set_file(at, file);
    Ok(Outcome::Done)
}

/// Bytes that are left in the record that is read.
///
/// ASSUMPTION: that is what [`bytes_ahead`] tells.
fn bytes_left(context: &mut Context<'_>) -> Result<Outcome, Fault> {
    let file = context.memory.file(context.variable(0));
    let Some(id) = file.file else {
        return Ok(Outcome::Value(Cell::Integer(0)));
    };
    let count = context.host.input(id).bytes.len();
    Ok(Outcome::Value(Cell::Integer(
        i32::try_from(count).unwrap_or(i32::MAX),
    )))
}

fn ping(context: &mut Context<'_>) -> Result<Outcome, Fault> {
    let host = context.text(0).to_string_lossless();
    let status = context.host.ping(context.task, host.trim());
    context.put_status(1, status);
    Ok(Outcome::Done)
}

fn name(context: &Context<'_>, number: usize) -> String {
    context.text(number).to_string_lossless().trim().to_owned()
}

/// `COPY_FILE(from, to, overwrite, no-wait, status)`.
fn copy_file(context: &mut Context<'_>) -> Result<Outcome, Fault> {
    let (from, to) = (name(context, 0), name(context, 1));
    let operation = FileOperation::Copy {
        from: &from,
        to: &to,
        overwrite: context.boolean(2),
    };
    let status = context.host.file_operation(context.task, operation);
    context.put_status(4, status);
    Ok(Outcome::Done)
}

fn delete_file(context: &mut Context<'_>) -> Result<Outcome, Fault> {
    let file = name(context, 0);
    let operation = FileOperation::Delete(&file);
    let status = context.host.file_operation(context.task, operation);
    context.put_status(2, status);
    Ok(Outcome::Done)
}

fn rename_file(context: &mut Context<'_>) -> Result<Outcome, Fault> {
    let (from, to) = (name(context, 0), name(context, 1));
    let operation = FileOperation::Rename {
        from: &from,
        to: &to,
    };
    let status = context.host.file_operation(context.task, operation);
    context.put_status(3, status);
    Ok(Outcome::Done)
}

/// ASSUMPTION: devices are always mounted; the status says whether there is such a device.
fn mount(context: &mut Context<'_>) -> Result<Outcome, Fault> {
    let device = name(context, 0);
    let operation = FileOperation::Mount(&device);
    let status = context.host.file_operation(context.task, operation);
    context.put_status(1, status);
    Ok(Outcome::Done)
}

/// What this controller cannot do: it has no printer, and sources are translated outside. The status
/// is 12320, as for a built-in of an option that is missing.
fn refuse(context: &mut Context<'_>) -> Result<Outcome, Fault> {
    context.put_status(2, Status::INTP_UNDEFINED_BUILTIN);
    Ok(Outcome::Done)
}

/// ASSUMPTION: a letter first, then letters, digits and `_`, 36 at most; behind a device and with
/// an extension.
fn check_name(context: &mut Context<'_>) -> Result<Outcome, Fault> {
    let whole = name(context, 0);
    let last = whole.rsplit(':').next().unwrap_or(&whole);
    let (stem, extension) = last.split_once('.').unwrap_or((last, "X"));
    let legal = |c: char| c.is_ascii_alphanumeric() || c == '_';
    let good = stem.starts_with(|c: char| c.is_ascii_alphabetic())
        && stem.len() <= 36
        && stem.chars().all(legal)
        && !extension.is_empty()
        && extension.chars().all(legal);
    let status = if good {
        Status::OK
    } else {
        Status::FILE_ILLEGAL_PARAMETER
    };
    context.put_status(1, status);
    Ok(Outcome::Done)
}

fn format_device(context: &mut Context<'_>) -> Result<Outcome, Fault> {
    let device = name(context, 0);
    let operation = FileOperation::Format(&device);
    let status = context.host.file_operation(context.task, operation);
    context.put_status(3, status);
    Ok(Outcome::Done)
}

/// `FILE_LIST(pattern, skip, format, names, count, status)`.
///
/// ASSUMPTION: the format changes nothing; names that do not fit into the array are left out.
fn file_list(context: &mut Context<'_>) -> Result<Outcome, Fault> {
    let pattern = name(context, 0);
    let skip = usize::try_from(context.integer(1)).unwrap_or(0);
    let (count, status) = match context.host.list_files(context.task, &pattern) {
        Ok(names) => {
            let texts = names.iter().skip(skip);
            let texts = texts.map(|name| Text::from(name.as_str()));
            (context.put_texts(3, texts), Status::OK)
        }
        Err(status) => (0, status),
    };
    context.put(4, Cell::Integer(count));
    context.put_status(5, status);
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
    let of_last_line = !file.has(FileFlag::Binary)
        && file.line_state == LineState::AfterCr
        && input.bytes.first() == Some(&b'\n');
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

/// ASSUMPTION: a `MSG_CONNECT` that waits when an abort is taken back by `NOABORT` fails with HOST-144; the
/// published programs that use NOABORT could not end otherwise.
fn msg_connect(context: &mut Context<'_>) -> Result<Outcome, Fault> {
    let tag = tag_name(context);
    if matches!(std::mem::take(context.pending), Pending::GivesUp) {
        let _status = context.host.msg_disco(context.task, &tag);
        context.put_status(1, Status::HOST_TAG);
        return Ok(Outcome::DoneThenPause(PAUSE_AFTER_FAILED_CONNECT));
    }
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
