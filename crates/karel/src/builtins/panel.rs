//! The state of the controller as its operator sees it: mode, pendant, alarms.

use super::{Builtin, Context, Outcome, Param, Returns};
use crate::{
    host::{AlarmSeverity, ProgramAlarm},
    machine::{cell::Cell, fault::Fault},
    status::Status,
    value::Text,
};

/// A variable that a window shows again and again: the variable, the window, width, attributes, size, row, column,
/// interval, then how it is shown, the status.
#[rustfmt::skip]
const SHOWN_VALUE: &[Param] = &[
    Param::AnyVariable, Param::Text, Param::Integer, Param::Integer, Param::Integer, Param::Integer, Param::Integer, Param::Integer,
    Param::Integer, Param::Text, Param::OutInteger,
];
/// The same, in words: the values of an array.
#[rustfmt::skip]
const SHOWN_WORDS: &[Param] = &[
    Param::AnyVariable, Param::Text, Param::Integer, Param::Integer, Param::Integer, Param::Integer, Param::Integer, Param::Integer,
    Param::TextArray, Param::OutInteger,
];
/// The same, of a port.
#[rustfmt::skip]
const SHOWN_PORT: &[Param] = &[
    Param::Integer, Param::Integer, Param::Text, Param::Integer, Param::Integer, Param::Integer, Param::Integer, Param::Integer,
    Param::Integer, Param::TextArray, Param::OutInteger,
];
const SHOWN_NO_MORE: &[Param] = &[Param::AnyVariable, Param::Text, Param::OutInteger];

#[rustfmt::skip]
pub(super) const TABLE: &[Builtin] = &[
    Builtin { name: "ERR_DATA", params: &[Param::InOutInteger, Param::OutInteger, Param::OutText, Param::OutInteger, Param::OutText, Param::OutInteger, Param::OutInteger, Param::OutText], required: 8, returns: Returns::Nothing, code: err_data },
    Builtin { name: "ACT_SCREEN", params: &[Param::Text, Param::OutText, Param::OutInteger], required: 3, returns: Returns::Nothing, code: |context| nothing(context, 2) },
    Builtin { name: "ATT_WINDOW_S", params: &[Param::Text, Param::Text, Param::Integer, Param::Integer, Param::OutInteger], required: 5, returns: Returns::Nothing, code: |context| nothing(context, 4) },
    Builtin { name: "CLEAR_WIN", params: &[Param::File, Param::OutInteger], required: 2, returns: Returns::Nothing, code: clear_window },
    Builtin { name: "DEF_SCREEN", params: &[Param::Text, Param::Text, Param::OutInteger], required: 3, returns: Returns::Nothing, code: |context| nothing(context, 2) },
    Builtin { name: "DET_WINDOW", params: &[Param::Text, Param::Text, Param::OutInteger], required: 3, returns: Returns::Nothing, code: |context| nothing(context, 2) },
    Builtin { name: "FORCE_SPMENU", params: &[Param::Integer, Param::Integer, Param::Integer], required: 3, returns: Returns::Nothing, code: |_| Ok(Outcome::Done) },
    Builtin { name: "POST_ERR", params: &[Param::Integer, Param::Text, Param::Integer, Param::Integer], required: 4, returns: Returns::Nothing, code: post_err },
    Builtin { name: "POST_ERR_L", params: &[Param::Integer, Param::Text, Param::Integer, Param::Integer], required: 4, returns: Returns::Nothing, code: post_err },
    Builtin { name: "CNC_DYN_DISB", params: SHOWN_NO_MORE, required: 3, returns: Returns::Nothing, code: |context| nothing(context, 2) },
    Builtin { name: "CNC_DYN_DISE", params: SHOWN_NO_MORE, required: 3, returns: Returns::Nothing, code: |context| nothing(context, 2) },
    Builtin { name: "CNC_DYN_DISI", params: SHOWN_NO_MORE, required: 3, returns: Returns::Nothing, code: |context| nothing(context, 2) },
    Builtin { name: "CNC_DYN_DISP", params: &[Param::Integer, Param::Integer, Param::Text, Param::OutInteger], required: 4, returns: Returns::Nothing, code: |context| nothing(context, 3) },
    Builtin { name: "CNC_DYN_DISR", params: SHOWN_NO_MORE, required: 3, returns: Returns::Nothing, code: |context| nothing(context, 2) },
    Builtin { name: "CNC_DYN_DISS", params: SHOWN_NO_MORE, required: 3, returns: Returns::Nothing, code: |context| nothing(context, 2) },
    Builtin { name: "INI_DYN_DISB", params: SHOWN_WORDS, required: 10, returns: Returns::Nothing, code: |context| nothing(context, 9) },
    Builtin { name: "INI_DYN_DISE", params: SHOWN_WORDS, required: 10, returns: Returns::Nothing, code: |context| nothing(context, 9) },
    Builtin { name: "INI_DYN_DISI", params: SHOWN_VALUE, required: 11, returns: Returns::Nothing, code: |context| nothing(context, 10) },
    Builtin { name: "INI_DYN_DISP", params: SHOWN_PORT, required: 11, returns: Returns::Nothing, code: |context| nothing(context, 10) },
    Builtin { name: "INI_DYN_DISR", params: SHOWN_VALUE, required: 11, returns: Returns::Nothing, code: |context| nothing(context, 10) },
    Builtin { name: "INI_DYN_DISS", params: SHOWN_VALUE, required: 11, returns: Returns::Nothing, code: |context| nothing(context, 10) },
    Builtin { name: "RESET", params: &[Param::OutBoolean], required: 1, returns: Returns::Nothing, code: reset },
    Builtin { name: "SET_CURSOR", params: &[Param::File, Param::Integer, Param::Integer, Param::OutInteger], required: 4, returns: Returns::Nothing, code: |context| nothing(context, 3) },
    Builtin { name: "SET_LANG", params: &[Param::Text, Param::OutInteger], required: 2, returns: Returns::Nothing, code: |context| nothing(context, 1) },
    Builtin { name: "IN_AUTO_MODE", params: &[], required: 0, returns: Returns::Boolean, code: |context| Ok(Outcome::Value(Cell::Boolean(context.host.in_auto_mode()))) },
    Builtin { name: "TP_ENABLED", params: &[], required: 0, returns: Returns::Boolean, code: |context| Ok(Outcome::Value(Cell::Boolean(context.host.pendant_enabled()))) },
];

/// The alarm with a number of the history, `MAXINT` for the newest; the number is rewritten.
///
/// ASSUMPTION: without such an alarm the number and the code are 0; there is never a cause code,
/// and the time is 0.
fn err_data(context: &mut Context<'_>) -> Result<Outcome, Fault> {
    let Cell::Integer(wanted) = *context.in_out(0) else {
        return Err(Fault::uninit());
    };
    let alarm = context.host.alarm(wanted);
    let (seq, code, severity) = alarm
        .as_ref()
        .map_or((0, 0, 0), |alarm| (alarm.seq, alarm.code, alarm.severity));
    let text = |text: Option<&str>| Text::from(text.unwrap_or_default());
    context.put(0, Cell::Integer(seq));
    context.put(1, Cell::Integer(code));
    context.put_text(2, text(alarm.as_ref().map(|alarm| alarm.message.as_str())));
    context.put(3, Cell::Integer(0));
    context.put_text(4, text(None));
    context.put(5, Cell::Integer(0));
    context.put(6, Cell::Integer(severity));
    context.put_text(7, text(alarm.as_ref().map(|alarm| alarm.program.as_str())));
    Ok(Outcome::Done)
}

/// `RESET(successful)`: as the key of the operator.
#[expect(clippy::unnecessary_wraps, reason = "the table's signature")]
fn reset(context: &mut Context<'_>) -> Result<Outcome, Fault> {
    let done = context.host.reset();
    context.put(0, Cell::Boolean(done));
    Ok(Outcome::Done)
}

/// Menus, windows and cursors of a pendant that nobody sees.
///
/// ASSUMPTION: they always succeed.
#[expect(clippy::unnecessary_wraps, reason = "the table's signature")]
fn nothing(context: &mut Context<'_>, status: usize) -> Result<Outcome, Fault> {
    context.put_status(status, Status::OK);
    Ok(Outcome::Done)
}

/// The routine of the header `klrdutil`: clears a window and puts its cursor home.
#[expect(clippy::unnecessary_wraps, reason = "the table's signature")]
fn clear_window(context: &mut Context<'_>) -> Result<Outcome, Fault> {
    context.host.display(context.task, &[128, 137]);
    context.put_status(1, Status::OK);
    Ok(Outcome::Done)
}

/// `POST_ERR(code, text, cause, severity)`: an alarm of the program. It pauses or ends tasks, the own
/// one included, unless `%NOPAUSE = ERROR` or `%NOABORT = ERROR` protects them.
fn post_err(context: &mut Context<'_>) -> Result<Outcome, Fault> {
    let severity = match context.integer(3) {
        0 => AlarmSeverity::Warn,
        1 => AlarmSeverity::Pause,
        2 => AlarmSeverity::Abort,
        other => {
            let message = format!("POST_ERR with the severity {other}, not in 0 to 2");
            return Err(Fault::argument(message));
        }
    };
    let alarm = ProgramAlarm {
        status: Status(context.integer(0)),
        text: context.text(1).to_string_lossless(),
        severity,
        program: context.program.name_arc(),
        line: context.running.line,
    };
    context.host.raise_alarm(context.task, alarm);
    let protected = |name: &str| {
        let mut programs = context.programs.iter();
        let program = programs.find(|loaded| loaded.name().eq_ignore_ascii_case(name));
        program.is_some_and(|program| match severity {
            AlarmSeverity::Warn => true,
            AlarmSeverity::Pause => !program.is_pausable_by_error(),
            AlarmSeverity::Abort => !program.is_abortable_by_error(),
        })
    };
    let own_goes_on = protected(context.running.name);
    let mut stopped = Vec::new();
    for id in context.tasks.ids() {
        if let Some(task) = context.tasks.get(id)
            && !protected(&task.name)
        {
            stopped.push(id);
        }
    }
    for id in stopped {
        match severity {
            AlarmSeverity::Warn => {}
            AlarmSeverity::Pause => {
                let _changed = context.tasks.pause(id);
            }
            AlarmSeverity::Abort => {
                let _was_alive = context.tasks.request_end(id, context.host);
            }
        }
    }
    Ok(match severity {
        AlarmSeverity::Pause if !own_goes_on => Outcome::PauseTask,
        AlarmSeverity::Abort if !own_goes_on => Outcome::EndTask,
        AlarmSeverity::Warn | AlarmSeverity::Pause | AlarmSeverity::Abort => Outcome::Done,
    })
}
