//! Tasks: starting, ending and looking at them.

#![expect(
    clippy::unnecessary_wraps,
    reason = "all built-ins have the table's signature"
)]

use super::{Builtin, Context, Outcome, Param, Returns};
use crate::{
    machine::{Loaded, StartError, cell::Cell, fault::Fault, task::Argument, tp_value},
    registers::Number,
    run::TaskState,
    status::{Status, task},
    value::Text,
};

#[rustfmt::skip]
pub(super) const TABLE: &[Builtin] = &[
    Builtin { name: "ABORT_TASK", params: &[Param::Text, Param::Boolean, Param::Boolean, Param::OutInteger], required: 4, returns: Returns::Nothing, code: abort_task },
    Builtin { name: "CALL_PROG", params: &[Param::Text, Param::InOutInteger], required: 2, returns: Returns::Nothing, code: |context| call(context, 0) },
    Builtin { name: "CALL_PROGLIN", params: &[Param::Text, Param::Integer, Param::InOutInteger, Param::Boolean], required: 4, returns: Returns::Nothing, code: |context| { let line = context.integer(1); call(context, line) } },
    Builtin { name: "CONT_TASK", params: &[Param::Text, Param::OutInteger], required: 2, returns: Returns::Nothing, code: cont_task },
    Builtin { name: "CURR_PROG", params: &[], required: 0, returns: Returns::Text, code: curr_prog },
    Builtin { name: "GET_TPE_PRM", params: &[Param::Integer, Param::OutInteger, Param::OutInteger, Param::OutReal, Param::OutText, Param::OutInteger], required: 6, returns: Returns::Nothing, code: argument },
    Builtin { name: "GET_TSK_INFO", params: &[Param::InOutText, Param::InOutInteger, Param::Integer, Param::OutInteger, Param::OutText, Param::OutInteger], required: 6, returns: Returns::Nothing, code: get_tsk_info },
    Builtin { name: "PAUSE_TASK", params: &[Param::Text, Param::Boolean, Param::Boolean, Param::OutInteger], required: 4, returns: Returns::Nothing, code: pause_task },
    Builtin { name: "LOAD_STATUS", params: &[Param::Text, Param::OutBoolean, Param::OutBoolean], required: 3, returns: Returns::Nothing, code: load_status },
    Builtin { name: "PROG_LIST", params: &[Param::Text, Param::Integer, Param::Integer, Param::OutInteger, Param::TextArray, Param::OutInteger, Param::OutInteger], required: 6, returns: Returns::Nothing, code: prog_list },
    Builtin { name: "SELECT_TPE", params: &[Param::Text, Param::OutInteger], required: 2, returns: Returns::Nothing, code: select },
    Builtin { name: "RUN_TASK", params: &[Param::Text, Param::Integer, Param::Boolean, Param::Boolean, Param::Integer, Param::OutInteger], required: 6, returns: Returns::Nothing, code: run_task },
];

/// ASSUMPTION: the types are 1 INTEGER, 2 REAL, 3 STRING; only the variable of that type is written;
/// an argument that was not given is status 12311.
fn argument(context: &mut Context<'_>) -> Result<Outcome, Fault> {
    let found = tp_value::argument(context.arguments, context.integer(0)).cloned();
    let (kind, status) = match found {
        Some(Argument::Number(Number::Integer(value))) => {
            context.put(2, Cell::Integer(value));
            (1, Status::OK)
        }
        Some(Argument::Number(Number::Real(value))) => {
            context.put(3, Cell::Real(value));
            (2, Status::OK)
        }
        Some(Argument::Text(text)) => {
            context.put_text(4, Text::from(tp_value::text_bytes(&text).as_slice()));
            (3, Status::OK)
        }
        None => (0, Status::INTP_UNINIT),
    };
    context.put(1, Cell::Integer(kind));
    context.put_status(5, status);
    Ok(Outcome::Done)
}

fn name(context: &Context<'_>, number: usize) -> String {
    context.text(number).to_string_lossless().trim().to_owned()
}

/// Starts a program as a task of its own, at its beginning.
///
/// ASSUMPTION: shift key, TP motion and the mask of locked groups change nothing here; another line
/// than 0 or 1 is refused with INTP-322.
fn run_task(context: &mut Context<'_>) -> Result<Outcome, Fault> {
    let status = if matches!(context.integer(1), 0 | 1) {
        let program = name(context, 0);
        match context
            .tasks
            .start(context.programs, context.limits, &program)
        {
            Ok(_) => Status::OK,
            Err(StartError::NotLoaded(_)) => Status::MEMO_NO_PROGRAM,
            Err(StartError::Running(_)) => Status::PROG_RUNNING,
            Err(StartError::TooMany(_) | StartError::TooLarge { .. }) => Status::PROG_NO_TASK,
        }
    } else {
        Status::INTP_ARGUMENT
    };
    context.put_status(5, status);
    Ok(Outcome::Done)
}

/// Ends a task by the name of its root program; a motion of it goes on unless it shall be cancelled.
///
/// ASSUMPTION: with force its condition handlers are not asked.
fn abort_task(context: &mut Context<'_>) -> Result<Outcome, Fault> {
    let wanted = name(context, 0);
    let (force, cancel_motion) = (context.boolean(1), context.boolean(2));
    if context.running.name.eq_ignore_ascii_case(&wanted) {
        context.put_status(3, Status::OK);
        if cancel_motion {
            context.host.cancel_motions(context.task);
        }
        return Ok(Outcome::EndTask);
    }
    let found = context.tasks.named(&wanted).map(|(id, _)| id);
    let mut end = |id| {
        if force {
            context.tasks.end(id, context.host)
        } else {
            context.tasks.request_end(id, context.host)
        }
    };
    let status = match found {
        Some(id) if end(id) => {
            if cancel_motion {
                context.host.cancel_motions(id);
            }
            Status::OK
        }
        Some(_) | None => Status::PROG_NO_TASK,
    };
    context.put_status(3, status);
    Ok(Outcome::Done)
}

/// Pauses another task, and holds what it moves if that is wanted.
///
/// ASSUMPTION: force or not is the same here; a task cannot pause itself by its name.
fn pause_task(context: &mut Context<'_>) -> Result<Outcome, Fault> {
    let wanted = name(context, 0);
    let hold = context.boolean(2);
    let found = context.tasks.named(&wanted).map(|(id, _)| id);
    let status = match found {
        Some(id) if context.tasks.pause(id) => {
            if hold {
                context.host.hold_motions(id);
            }
            Status::OK
        }
        Some(_) | None => Status::PROG_NO_TASK,
    };
    context.put_status(3, status);
    Ok(Outcome::Done)
}

/// Lets a paused task go on, with what it moved.
fn cont_task(context: &mut Context<'_>) -> Result<Outcome, Fault> {
    let wanted = name(context, 0);
    let found = context.tasks.named(&wanted).map(|(id, _)| id);
    let status = match found {
        Some(id) if context.tasks.resume(id) => {
            context.host.continue_motions(id);
            Status::OK
        }
        Some(_) | None => Status::PROG_NO_TASK,
    };
    context.put_status(1, status);
    Ok(Outcome::Done)
}

/// The name, or if that is empty the number, says which task; both are filled in.
///
/// ASSUMPTION: a program that was loaded and never started is as one that was aborted.
fn get_tsk_info(context: &mut Context<'_>) -> Result<Outcome, Fault> {
    let mut wanted = String::new();
    if let Cell::Text(text) = context.in_out(0) {
        text.to_string_lossless().trim().clone_into(&mut wanted);
    }
    let mut number = None;
    if let Cell::Integer(given) = context.in_out(1) {
        number = u32::try_from(*given).ok();
    }
    let status = match find(context, &wanted, number) {
        Ok(found) => report(context, &found),
        Err(status) => status,
    };
    context.put_status(5, status);
    Ok(Outcome::Done)
}

struct Found {
    name: String,
    number: Option<u32>,
    status: i32,
    program: String,
    line: u32,
}

fn find(context: &Context<'_>, wanted: &str, number: Option<u32>) -> Result<Found, Status> {
    let own = context.running.name.eq_ignore_ascii_case(wanted)
        || (wanted.is_empty() && number == Some(context.task.0));
    if own {
        return Ok(Found {
            name: context.running.name.to_owned(),
            number: Some(context.task.0),
            status: task::RUNNING,
            program: context.program.name().to_owned(),
            line: context.running.line,
        });
    }
    let found = if wanted.is_empty() {
        let id = number.map(crate::host::TaskId);
        id.and_then(|id| Some((id, context.tasks.get(id)?)))
    } else {
        context.tasks.named(wanted)
    };
    if let Some((id, found)) = found {
        let loaded = context.programs.get(found.program);
        let (program, line) = loaded.map_or((String::new(), 0), |loaded| loaded.place(found.pc));
        return Ok(Found {
            name: found.name.to_string(),
            number: Some(id.0),
            status: match found.state {
                TaskState::Ready | TaskState::Blocked(_) if found.paused => task::PAUSED,
                TaskState::Ready | TaskState::Blocked(_) => task::RUNNING,
                TaskState::Ended | TaskState::Aborted(_) => task::ABORTED,
            },
            program,
            line,
        });
    }
    let mut programs = context.programs.iter();
    let loaded = programs.find(|loaded| loaded.name().eq_ignore_ascii_case(wanted));
    let loaded = loaded.ok_or(if wanted.is_empty() {
        Status::PROG_NO_TASK
    } else {
        Status::MEMO_NO_PROGRAM
    })?;
    Ok(Found {
        name: loaded.name().to_owned(),
        number: None,
        status: task::ABORTED,
        program: loaded.name().to_owned(),
        line: 0,
    })
}

fn report(context: &mut Context<'_>, found: &Found) -> Status {
    let integer = |value: u32| Cell::Integer(i32::try_from(value).unwrap_or(i32::MAX));
    match context.integer(2) {
        task::STATUS => context.put(3, Cell::Integer(found.status)),
        task::LINE => context.put(3, integer(found.line)),
        task::PROGRAM => context.put_text(4, Text::from(found.program.as_str())),
        _ => return Status::INTP_ARGUMENT,
    }
    context.put_text(0, Text::from(found.name.as_str()));
    if let Some(number) = found.number {
        context.put(1, integer(number));
    }
    Status::OK
}

/// The program whose routine runs.
fn curr_prog(context: &mut Context<'_>) -> Result<Outcome, Fault> {
    let name = Text::from(context.program.name());
    Ok(Outcome::Value(Cell::Text(name)))
}

/// Runs a program in this task; the statement ends when that program does. One that is not loaded
/// ends the task.
///
/// ASSUMPTION: the index, a cache of the name, is not looked at; a program of KAREL is started at the
/// first statement at or behind the line; it is never paused at its entry.
fn call(context: &mut Context<'_>, line: i32) -> Result<Outcome, Fault> {
    let wanted = name(context, 0).to_ascii_uppercase();
    let line =
        u32::try_from(line).map_err(|_| Fault::argument(format!("{wanted} has no line {line}")))?;
    Ok(Outcome::CallProgram { name: wanted, line })
}

/// Whether a program is loaded, and so its variables.
fn load_status(context: &mut Context<'_>) -> Result<Outcome, Fault> {
    let wanted = name(context, 0);
    let mut programs = context.programs.iter();
    let loaded = programs.any(|loaded| loaded.name().eq_ignore_ascii_case(&wanted));
    context.put(1, Cell::Boolean(loaded));
    context.put(2, Cell::Boolean(loaded));
    Ok(Outcome::Done)
}

/// `SELECT_TPE(name, status)`: the program of the pendant.
///
/// ASSUMPTION: nothing but the status can be seen of it here.
fn select(context: &mut Context<'_>) -> Result<Outcome, Fault> {
    let wanted = name(context, 0);
    let mut programs = context.programs.iter();
    let loaded = programs.any(|loaded| loaded.name().eq_ignore_ascii_case(&wanted));
    let status = if loaded {
        Status::OK
    } else {
        Status::MEMO_NO_PROGRAM
    };
    context.put_status(1, status);
    Ok(Outcome::Done)
}

/// `PROG_LIST(pattern, type, skip, format, names, count, status)`.
///
/// ASSUMPTION: the type and the format change nothing; names that do not fit are left out.
fn prog_list(context: &mut Context<'_>) -> Result<Outcome, Fault> {
    let pattern = name(context, 0).to_ascii_uppercase();
    let skip = usize::try_from(context.integer(2)).unwrap_or(0);
    let start = pattern.trim_end_matches('*');
    let exact = start.len() == pattern.len();
    let there = context
        .programs
        .iter()
        .filter(|loaded| !loaded.is_deleted());
    let names = there.map(Loaded::name);
    let fits = |name: &&str| name.starts_with(start) && (!exact || *name == start);
    let texts = names.filter(fits).skip(skip).map(Text::from);
    let count = context.put_texts(4, texts);
    context.put(5, Cell::Integer(count));
    if context.has_arg(6) {
        context.put_status(6, Status::OK);
    }
    Ok(Outcome::Done)
}
