//! The robot's position.

use super::{Builtin, Context, Outcome, Param, Returns};
use crate::{machine::fault::Fault, position::Position, types::PositionKind};

#[rustfmt::skip]
pub(super) const TABLE: &[Builtin] = &[
    Builtin {
        name: "CHECK_EPOS",
        params: &[Param::Position(PositionKind::XyzwprExt), Param::Position(PositionKind::Position), Param::Position(PositionKind::Position), Param::OutInteger, Param::Integer],
        required: 4, returns: Returns::Nothing, code: check_epos,
    },
    Builtin { name: "CURPOS", params: &[Param::OutInteger, Param::OutInteger, Param::Integer], required: 2, returns: Returns::XyzwprExt, code: curpos },
];

/// The motion group, if the argument is there.
pub(super) fn group(context: &Context<'_>, number: usize) -> i32 {
    if context.has_arg(number) {
        context.integer(number)
    } else {
        1
    }
}

/// The first two arguments would tell of axis limits; they are accepted and not written.
fn curpos(context: &mut Context<'_>) -> Result<Outcome, Fault> {
    let group = group(context, 2);
    let position = context
        .host
        .current_position(context.task, group)
        .map_err(|status| Fault::from_host(status, "CURPOS failed"))?;
    let target = context.result();
    context
        .memory
        .set_position(target, PositionKind::XyzwprExt, &position);
    Ok(Outcome::Done)
}

fn check_epos(context: &mut Context<'_>) -> Result<Outcome, Fault> {
    let position = context
        .memory
        .position(context.variable(0), PositionKind::XyzwprExt)?;
    let frame = context
        .memory
        .position(context.variable(1), PositionKind::Position)?;
    let tool = context
        .memory
        .position(context.variable(2), PositionKind::Position)?;
    let (frame, tool) = (Position::from(frame), Position::from(tool));
    let group = group(context, 4);
    let status = context
        .host
        .check_position(context.task, &position, &frame, &tool, group);
    context.put_status(3, status);
    Ok(Outcome::Done)
}
