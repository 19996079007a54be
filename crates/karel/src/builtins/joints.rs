//! Joint positions: arrays of axes, the arm's own, limits, and positions of the tool.

use super::{Builtin, Context, Outcome, Param, Returns, motion::group};
use crate::{
    machine::{
        cell::{Address, Cell},
        fault::Fault,
    },
    position::{JointPosition, Position, XyzwprExt},
    status::Status,
    syspath::SysPath,
    types::{JointKind, PositionKind, Type},
};

#[rustfmt::skip]
pub(super) const TABLE: &[Builtin] = &[
    Builtin { name: "CNV_JPOS_REL", params: &[Param::Joints, Param::RealArray, Param::OutInteger], required: 3, returns: Returns::Nothing, code: to_array },
    Builtin { name: "CNV_REL_JPOS", params: &[Param::RealArray, Param::OutJoints, Param::OutInteger], required: 3, returns: Returns::Nothing, code: from_array },
    Builtin { name: "CURJPOS", params: &[Param::OutInteger, Param::OutInteger, Param::Integer], required: 2, returns: Returns::Joints, code: curjpos },
    Builtin { name: "JOINT2POS", params: &[Param::Joints, Param::Position(PositionKind::Position), Param::Position(PositionKind::Position), Param::Integer, Param::OutPosition, Param::OutConfig, Param::RealArray, Param::OutInteger], required: 8, returns: Returns::Nothing, code: joint2pos },
    Builtin { name: "J_IN_RANGE", params: &[Param::Joints], required: 1, returns: Returns::Boolean, code: in_range },
    Builtin { name: "POS2JOINT", params: &[Param::Position(PositionKind::XyzwprExt), Param::Position(PositionKind::Position), Param::Position(PositionKind::Position), Param::Integer, Param::Config, Param::RealArray, Param::OutJoints, Param::OutInteger], required: 8, returns: Returns::Nothing, code: pos2joint },
];

/// Address and length of an array argument.
fn array(context: &Context<'_>, number: usize) -> (Address, u32) {
    let at = context.variable(number);
    (at, context.ty(number).length().unwrap_or(at.extra))
}

fn joint_kind(context: &Context<'_>, number: usize) -> JointKind {
    let Type::Joints(kind) = context.ty(number) else {
        unreachable!("the checker insists on a JOINTPOS")
    };
    *kind
}

/// Writes the axes that exist; the other elements of the array stay as they are.
fn to_array(context: &mut Context<'_>) -> Result<Outcome, Fault> {
    let joints = context.joints(0)?;
    let (at, length) = array(context, 1);
    let status = if joints.axes.len() > length as usize {
        Status::INTP_ARRAY_LENGTH
    } else {
        for (value, offset) in joints.axes.iter().zip(0..) {
            context.memory.set(at.plus(offset), Cell::Real(*value));
        }
        Status::OK
    };
    context.put_status(2, status);
    Ok(Outcome::Done)
}

/// Reads as many elements as the target has axes. An uninitialized one ends the task.
///
/// ASSUMPTION: a JOINTPOS without a number of axes reads up to nine, and keeps those that the arm has: a
/// published program gives it ten elements, six of them meant, and moves there.
fn from_array(context: &mut Context<'_>) -> Result<Outcome, Fault> {
    let (at, length) = array(context, 0);
    let kind = joint_kind(context, 1);
    let wanted = match kind {
        JointKind::OfGroup => length.min(kind.size()),
        JointKind::Axes(axes) => u32::from(axes),
    };
    if wanted > length {
        context.put_status(2, Status::INTP_ARRAY_LENGTH);
        return Ok(Outcome::Done);
    }
    let mut axes = Vec::new();
    for offset in 0..wanted {
        let Cell::Real(value) = context.memory.get(at.plus(offset)) else {
            return Err(Fault::uninit());
        };
        axes.push(*value);
    }
    if kind == JointKind::OfGroup
        && let Ok(arm) = context.host.current_joints(context.task, 1)
    {
        axes.truncate(arm.axes.len());
    }
    let target = context.variable(1);
    let _fits = context
        .memory
        .set_joints(target, kind, &JointPosition { axes });
    context.put_status(2, Status::OK);
    Ok(Outcome::Done)
}

/// The first two arguments would tell of axis limits; they are accepted and not written.
fn curjpos(context: &mut Context<'_>) -> Result<Outcome, Fault> {
    let group = group(context, 2);
    let joints = context.host.current_joints(context.task, group);
    let joints = joints.map_err(|status| Fault::from_host(status, "CURJPOS failed"))?;
    let at = context.result();
    let _fits = context.memory.set_joints(at, JointKind::OfGroup, &joints);
    Ok(Outcome::Done)
}

fn in_range(context: &mut Context<'_>) -> Result<Outcome, Fault> {
    let joints = context.joints(0)?;
    let status = context.host.check_joints(context.task, &joints, 1);
    Ok(Outcome::Value(Cell::Boolean(status.is_ok())))
}

/// ASSUMPTION: the reference for the configuration changes nothing: the arm's own is the answer.
fn joint2pos(context: &mut Context<'_>) -> Result<Outcome, Fault> {
    let joints = context.joints(0)?;
    let frame = context.position(1, PositionKind::Position)?.into();
    let tool = context.position(2, PositionKind::Position)?.into();
    let task = context.task;
    let found = context
        .host
        .joints_to_position(task, &joints, &frame, &tool, 1);
    let status = match found {
        Ok(position) => {
            if let Type::Position(kind) = *context.ty(4) {
                let at = context.variable(4);
                context.memory.set_position(at, kind, &position);
            }
            context.put(5, Cell::Config(position.config));
            let (at, length) = array(context, 6);
            for (value, offset) in position.ext.iter().zip(0..length) {
                context.memory.set(at.plus(offset), Cell::Real(*value));
            }
            Status::OK
        }
        Err(status) => status,
    };
    context.put_status(7, status);
    Ok(Outcome::Done)
}

/// ASSUMPTION: the configuration is that of the position, not the one beside it.
fn pos2joint(context: &mut Context<'_>) -> Result<Outcome, Fault> {
    let position = context.position(0, PositionKind::XyzwprExt)?;
    let frame = context.position(1, PositionKind::Position)?.into();
    let tool = context.position(2, PositionKind::Position)?.into();
    let task = context.task;
    let found = context
        .host
        .position_to_joints(task, &position, &frame, &tool, 1);
    let status = match found {
        Ok(joints) => {
            let (at, kind) = (context.variable(6), joint_kind(context, 6));
            if context.memory.set_joints(at, kind, &joints) {
                Status::OK
            } else {
                Status::INTP_ARRAY_LENGTH
            }
        }
        Err(status) => status,
    };
    context.put_status(7, status);
    Ok(Outcome::Done)
}

/// Where `$UTOOL` is in `$UFRAME` at these joints.
///
/// ASSUMPTION: registers are converted in the KAREL motion environment.
pub(super) fn to_cartesian(
    context: &mut Context<'_>,
    joints: &JointPosition,
) -> Result<XyzwprExt, Status> {
    let (frame, tool) = environment(context)?;
    let task = context.task;
    context
        .host
        .joints_to_position(task, joints, &frame, &tool, 1)
}

pub(super) fn to_joints(
    context: &mut Context<'_>,
    position: &XyzwprExt,
) -> Result<JointPosition, Status> {
    let (frame, tool) = environment(context)?;
    let task = context.task;
    context
        .host
        .position_to_joints(task, position, &frame, &tool, 1)
}

fn environment(context: &Context<'_>) -> Result<(Position, Position), Status> {
    let read = |name| {
        let path = SysPath::from_name(name);
        let value = context.host.system_variable(context.task, &path)?;
        value
            .as_xyzwprext()
            .map(Position::from)
            .ok_or(Status::VARS_TYPE)
    };
    Ok((read("$UFRAME")?, read("$UTOOL")?))
}
