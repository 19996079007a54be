//! Tasks: starting, ending and looking at them.

#![expect(
    clippy::unnecessary_wraps,
    reason = "all built-ins have the table's signature"
)]

use super::{Builtin, Context, Outcome, Param, Returns};
use crate::{
    machine::{StartError, cell::Cell, fault::Fault},
    run::TaskState,
    status::{Status, task},
    value::Text,
};

#[rustfmt::skip]
pub(super) const TABLE: &[Builtin] = &[
    Builtin { name: "ABORT_TASK", params: &[Param::Text, Param::Boolean, Param::Boolean, Param::OutInteger], required: 4, returns: Returns::Nothing, code: abort_task },
    Builtin { name: "CONT_TASK", params: &[Param::Text, Param::OutInteger], required: 2, returns: Returns::Nothing, code: cont_task },
    Builtin { name: "CURR_PROG", params: &[], required: 0, returns: Returns::Text, code: curr_prog },
    Builtin { name: "GET_TIME", params: &[Param::OutInteger], required: 1, returns: Returns::Nothing, code: get_time },
    Builtin { name: "GET_TSK_INFO", params: &[Param::InOutText, Param::InOutInteger, Param::Integer, Param::OutInteger, Param::OutText, Param::OutInteger], required: 6, returns: Returns::Nothing, code: get_tsk_info },
    Builtin { name: "PAUSE_TASK", params: &[Param::Text, Param::Boolean, Param::Boolean, Param::OutInteger], required: 4, returns: Returns::Nothing, code: pause_task },
    Builtin { name: "RUN_TASK", params: &[Param::Text, Param::Integer, Param::Boolean, Param::Boolean, Param::Integer, Param::OutInteger], required: 6, returns: Returns::Nothing, code: run_task },
];

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

/// Date and time in one number: seconds/2 in 5 bits, minutes in 6, hours in 5, day in 5, month in
/// 4, years since 1980 in 7.
///
/// ASSUMPTION: this crate has no calendar; the controller's clock starts at 1980-01-01 00:00 when it
/// is switched on.
fn get_time(context: &mut Context<'_>) -> Result<Outcome, Fault> {
    let seconds = context.host.now().as_secs();
    let (minutes, hours, days) = (seconds / 60 % 60, seconds / 3600 % 24, seconds / 86_400);
    // Beyond a month nobody looks; the day stays the last.
    let day = 1 + days.min(30);
    let date = (day << 16) | (1 << 21);
    let packed = date | (hours << 11) | (minutes << 5) | (seconds % 60 / 2);
    context.put(0, Cell::Integer(i32::try_from(packed).unwrap_or(i32::MAX)));
    Ok(Outcome::Done)
}

/// The program whose routine runs.
fn curr_prog(context: &mut Context<'_>) -> Result<Outcome, Fault> {
    let name = Text::from(context.program.name());
    Ok(Outcome::Value(Cell::Text(name)))
}
