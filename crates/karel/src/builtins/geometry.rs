//! Positions and vectors: operators, frames, directions.

use super::{Builtin, Context, Outcome, Param, Returns};
use crate::{
    frame::{Frame, Vector},
    machine::{cell::Cell, fault::Fault, real},
    position::{Config, Position, XyzwprExt},
    status::Status,
    types::PositionKind,
};

const POSITION: Param = Param::Position(PositionKind::Position);

// The names of the operators are their signs and the kinds of their operands.
#[rustfmt::skip]
pub(super) const TABLE: &[Builtin] = &[
    Builtin { name: ":PP", params: &[POSITION, POSITION], required: 2, returns: Returns::Position, code: compose },
    Builtin { name: ":PV", params: &[POSITION, Param::Vector], required: 2, returns: Returns::Vector, code: apply },
    Builtin { name: ">=<PP", params: &[POSITION, POSITION], required: 2, returns: Returns::Boolean, code: nearly },
    Builtin { name: "=VV", params: &[Param::Vector, Param::Vector], required: 2, returns: Returns::Boolean, code: |context| same(context, true) },
    Builtin { name: "<>VV", params: &[Param::Vector, Param::Vector], required: 2, returns: Returns::Boolean, code: |context| same(context, false) },
    Builtin { name: "+VV", params: &[Param::Vector, Param::Vector], required: 2, returns: Returns::Vector, code: |context| vectors(context, Vector::plus) },
    Builtin { name: "-VV", params: &[Param::Vector, Param::Vector], required: 2, returns: Returns::Vector, code: |context| vectors(context, |a, b| a.plus(b.times(-1.0))) },
    Builtin { name: "#VV", params: &[Param::Vector, Param::Vector], required: 2, returns: Returns::Vector, code: |context| vectors(context, Vector::cross) },
    Builtin { name: "@VV", params: &[Param::Vector, Param::Vector], required: 2, returns: Returns::Real, code: inner },
    Builtin { name: "*VR", params: &[Param::Vector, Param::Real], required: 2, returns: Returns::Vector, code: |context| { let factor = f64::from(context.real(1)); scale(context, 0, factor) } },
    Builtin { name: "*RV", params: &[Param::Real, Param::Vector], required: 2, returns: Returns::Vector, code: |context| { let factor = f64::from(context.real(0)); scale(context, 1, factor) } },
    Builtin { name: "/VR", params: &[Param::Vector, Param::Real], required: 2, returns: Returns::Vector, code: divide },
    Builtin { name: "APPROACH", params: &[POSITION], required: 1, returns: Returns::Vector, code: |context| direction(context, 2) },
    Builtin { name: "FRAME", params: &[POSITION, POSITION, POSITION, POSITION], required: 3, returns: Returns::Position, code: frame },
    Builtin { name: "INV", params: &[POSITION], required: 1, returns: Returns::Position, code: inverse },
    Builtin { name: "IN_RANGE", params: &[Param::Position(PositionKind::XyzwprExt)], required: 1, returns: Returns::Boolean, code: in_range },
    Builtin { name: "NORMAL", params: &[POSITION], required: 1, returns: Returns::Vector, code: |context| direction(context, 0) },
    Builtin { name: "ORIENT", params: &[POSITION], required: 1, returns: Returns::Vector, code: |context| direction(context, 1) },
    Builtin { name: "POS", params: &[Param::Real, Param::Real, Param::Real, Param::Real, Param::Real, Param::Real, Param::Config], required: 7, returns: Returns::Position, code: pos },
    Builtin { name: "UNPOS", params: &[POSITION, Param::OutReal, Param::OutReal, Param::OutReal, Param::OutReal, Param::OutReal, Param::OutReal, Param::OutConfig], required: 8, returns: Returns::Nothing, code: unpos },
];

fn position(context: &Context<'_>, number: usize) -> Result<XyzwprExt, Fault> {
    context.position(number, PositionKind::Position)
}

fn frame_of(context: &Context<'_>, number: usize) -> Result<Frame, Fault> {
    Ok(Frame::from(&position(context, number)?))
}

fn vector(context: &Context<'_>, number: usize) -> Result<Vector, Fault> {
    let at = context.variable(number);
    let mut components = [0.0; 3];
    for (component, offset) in components.iter_mut().zip(0..) {
        let Cell::Real(value) = context.memory.get(at.plus(offset)) else {
            return Err(Fault::uninit());
        };
        *component = f64::from(*value);
    }
    Ok(Vector(components))
}

fn put_vector(context: &mut Context<'_>, value: Vector) -> Result<Outcome, Fault> {
    let at = context.result();
    for (component, offset) in value.0.into_iter().zip(0..) {
        let component = real(component)?;
        context.memory.set(at.plus(offset), Cell::Real(component));
    }
    Ok(Outcome::Done)
}

fn put_position(
    context: &mut Context<'_>,
    frame: &Frame,
    config: Config,
) -> Result<Outcome, Fault> {
    let mut components = [0.0; 6];
    for (component, value) in components.iter_mut().zip(frame.components()) {
        *component = real(value)?;
    }
    let [x, y, z, w, p, r] = components;
    let value = XyzwprExt {
        x,
        y,
        z,
        w,
        p,
        r,
        config,
        ext: [0.0; 3],
    };
    let at = context.result();
    context
        .memory
        .set_position(at, PositionKind::Position, &value);
    Ok(Outcome::Done)
}

/// `a : b`: b, given in the frame a.
///
/// ASSUMPTION: the configuration is that of the right operand.
fn compose(context: &mut Context<'_>) -> Result<Outcome, Fault> {
    let result = frame_of(context, 0)?.times(&frame_of(context, 1)?);
    let config = position(context, 1)?.config;
    put_position(context, &result, config)
}

/// `a : v`: the point v, given in the frame a.
fn apply(context: &mut Context<'_>) -> Result<Outcome, Fault> {
    let result = frame_of(context, 0)?.point(vector(context, 1)?);
    put_vector(context, result)
}

fn vectors(
    context: &mut Context<'_>,
    compute: fn(Vector, Vector) -> Vector,
) -> Result<Outcome, Fault> {
    let result = compute(vector(context, 0)?, vector(context, 1)?);
    put_vector(context, result)
}

fn inner(context: &mut Context<'_>) -> Result<Outcome, Fault> {
    let product = vector(context, 0)?.dot(vector(context, 1)?);
    Ok(Outcome::Value(Cell::Real(real(product)?)))
}

fn scale(context: &mut Context<'_>, number: usize, factor: f64) -> Result<Outcome, Fault> {
    let result = vector(context, number)?.times(factor);
    put_vector(context, result)
}

fn divide(context: &mut Context<'_>) -> Result<Outcome, Fault> {
    let divisor = f64::from(context.real(1));
    if divisor == 0.0 {
        return Err(Fault::divide_by_zero());
    }
    scale(context, 0, 1.0 / divisor)
}

fn same(context: &mut Context<'_>, wanted: bool) -> Result<Outcome, Fault> {
    let equal = vector(context, 0)? == vector(context, 1)?;
    Ok(Outcome::Value(Cell::Boolean(equal == wanted)))
}

/// `a >=< b`: nearly the same position.
///
/// ASSUMPTION: within 0.01 mm and 0.01 degrees, in the same configuration.
fn nearly(context: &mut Context<'_>) -> Result<Outcome, Fault> {
    let (a, b) = (position(context, 0)?, position(context, 1)?);
    let (first, second) = (Frame::from(&a), Frame::from(&b));
    let near = first.distance(&second) <= 0.01 && first.angle_deg(&second) <= 0.01;
    Ok(Outcome::Value(Cell::Boolean(near && a.config == b.config)))
}

fn inverse(context: &mut Context<'_>) -> Result<Outcome, Fault> {
    let config = position(context, 0)?.config;
    let result = frame_of(context, 0)?.inverse();
    put_position(context, &result, config)
}

/// One of the directions of a position: X, Y or Z of the tool.
fn direction(context: &mut Context<'_>, axis: usize) -> Result<Outcome, Fault> {
    let result = frame_of(context, 0)?.axis(axis);
    put_vector(context, result)
}

/// `FRAME(origin, on X, on XY plane [, origin instead of the first])`.
///
/// ASSUMPTION: the configuration is that of the first position. Points on one line end the task with
/// INTP-360.
fn frame(context: &mut Context<'_>) -> Result<Outcome, Fault> {
    let origin = frame_of(context, 0)?.origin();
    let back = origin.times(-1.0);
    let x = frame_of(context, 1)?.origin().plus(back);
    let in_plane = frame_of(context, 2)?.origin().plus(back);
    let origin = if context.has_arg(3) {
        frame_of(context, 3)?.origin()
    } else {
        origin
    };
    let z = x.cross(in_plane);
    let (Some(x), Some(z)) = (x.unit(), z.unit()) else {
        let message = "FRAME of points that are on one line";
        return Err(Fault::new(Status::INTP_ZERO_VECTOR, message));
    };
    let result = Frame::from_axes(x, z.cross(x), z, origin);
    let config = position(context, 0)?.config;
    put_position(context, &result, config)
}

/// Whether the position can be reached in the motion environment's frame with its tool.
fn in_range(context: &mut Context<'_>) -> Result<Outcome, Fault> {
    let wanted = context.position(0, PositionKind::XyzwprExt)?;
    let mut frames = [Position::default(); 2];
    for (frame, name) in frames.iter_mut().zip(["$UFRAME", "$UTOOL"]) {
        let path = crate::syspath::SysPath::from_name(name);
        let value = context.host.system_variable(context.task, &path);
        let value = value.map_err(|status| Fault::new(status, format!("{name} cannot be read")))?;
        *frame = value
            .as_xyzwprext()
            .map_or(Position::default(), Position::from);
    }
    let [user_frame, tool] = frames;
    let status = context
        .host
        .check_position(context.task, &wanted, &user_frame, &tool, 1);
    Ok(Outcome::Value(Cell::Boolean(status.is_ok())))
}

fn pos(context: &mut Context<'_>) -> Result<Outcome, Fault> {
    let Cell::Config(config) = *context.arg(6) else {
        return Err(Fault::uninit());
    };
    let value = XyzwprExt {
        x: context.real(0),
        y: context.real(1),
        z: context.real(2),
        w: context.real(3),
        p: context.real(4),
        r: context.real(5),
        config,
        ext: [0.0; 3],
    };
    let at = context.result();
    context
        .memory
        .set_position(at, PositionKind::Position, &value);
    Ok(Outcome::Done)
}

fn unpos(context: &mut Context<'_>) -> Result<Outcome, Fault> {
    let value = position(context, 0)?;
    let components = [value.x, value.y, value.z, value.w, value.p, value.r];
    for (component, number) in components.into_iter().zip(1..) {
        context.put(number, Cell::Real(component));
    }
    context.put(7, Cell::Config(value.config));
    Ok(Outcome::Done)
}
