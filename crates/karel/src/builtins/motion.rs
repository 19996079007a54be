//! The robot's position.

use super::{Builtin, Context, Outcome, Param, Returns};
use crate::{
    machine::{cell::Cell, fault::Fault},
    position::Position,
    status::Status,
    types::PositionKind,
};

#[rustfmt::skip]
pub(super) const TABLE: &[Builtin] = &[
    Builtin {
        name: "CHECK_EPOS",
        params: &[Param::Position(PositionKind::XyzwprExt), Param::Position(PositionKind::Position), Param::Position(PositionKind::Position), Param::OutInteger, Param::Integer],
        required: 4, returns: Returns::Nothing, code: check_epos,
    },
    Builtin { name: "CNCL_STP_MTN", params: &[], required: 0, returns: Returns::Nothing, code: cancel_stopped },
    Builtin { name: "LOCK_GROUP", params: &[Param::Integer, Param::OutInteger], required: 2, returns: Returns::Nothing, code: lock },
    Builtin { name: "MOTION_CTL", params: &[Param::Integer], required: 1, returns: Returns::Boolean, code: has_control },
    Builtin { name: "UNLOCK_GROUP", params: &[Param::Integer, Param::OutInteger], required: 2, returns: Returns::Nothing, code: lock },
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

/// ASSUMPTION: it cancels whatever the arm does, as CANCEL.
#[expect(clippy::unnecessary_wraps, reason = "the table's signature")]
fn cancel_stopped(context: &mut Context<'_>) -> Result<Outcome, Fault> {
    context.host.cancel_arm(context.task);
    Ok(Outcome::Done)
}

/// ASSUMPTION: there is one group and nobody else wants it; a mask of others is INTP-322.
#[expect(clippy::unnecessary_wraps, reason = "the table's signature")]
fn lock(context: &mut Context<'_>) -> Result<Outcome, Fault> {
    let status = if matches!(context.integer(0), 0 | 1) {
        Status::OK
    } else {
        Status::INTP_ARGUMENT
    };
    context.put_status(1, status);
    Ok(Outcome::Done)
}

#[expect(clippy::unnecessary_wraps, reason = "the table's signature")]
fn has_control(context: &mut Context<'_>) -> Result<Outcome, Fault> {
    let own = matches!(context.integer(0), 0 | 1);
    Ok(Outcome::Value(Cell::Boolean(own)))
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
