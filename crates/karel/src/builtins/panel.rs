//! The state of the controller as its operator sees it: mode, pendant, alarms.

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
    Builtin { name: "ERR_DATA", params: &[Param::InOutInteger, Param::OutInteger, Param::OutText, Param::OutInteger, Param::OutText, Param::OutInteger, Param::OutInteger, Param::OutText], required: 8, returns: Returns::Nothing, code: err_data },
    Builtin { name: "IN_AUTO_MODE", params: &[], required: 0, returns: Returns::Boolean, code: |context| Ok(Outcome::Value(Cell::Boolean(context.host.in_auto_mode()))) },
    Builtin { name: "TP_ENABLED", params: &[], required: 0, returns: Returns::Boolean, code: |context| Ok(Outcome::Value(Cell::Boolean(context.host.pendant_enabled()))) },
];

/// The alarm with a number of the history, `MAXINT` for the newest; the number is rewritten.
///
/// ASSUMPTION: without such an alarm the number and the code are 0; there is never a cause code,
/// and the time is 0.
fn err_data(context: &mut Context<'_>) -> Result<Outcome, Fault> {
    let wanted = match context.in_out(0) {
        Cell::Integer(wanted) => *wanted,
        _ => return Err(Fault::uninit()),
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
