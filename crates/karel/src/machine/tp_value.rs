//! Values of TP programs.

use super::{
    exec::Exec,
    fault::Fault,
    task::Argument,
    tp_calculate::{combine, component_of, real},
};
use crate::{
    host::TpTarget,
    port::PortValue,
    position::{JointPosition, Position},
    registers::{Number, PositionRegister},
    status::Status,
    syspath::SysPath,
    tp::{Absent, Expr, FrameKind, Index, Operand},
    value::Value,
};

/// A value of an instruction.
#[derive(Clone, Debug, PartialEq)]
pub(super) enum Term {
    Number(Number),
    Switch(bool),
    Text(String),
    Position(PositionRegister),
}

impl Term {
    /// The value as a message names it.
    pub(super) fn shown(&self) -> String {
        match self {
            Term::Number(Number::Integer(value)) => value.to_string(),
            Term::Number(Number::Real(value)) => value.to_string(),
            Term::Switch(true) => "ON".to_owned(),
            Term::Switch(false) => "OFF".to_owned(),
            Term::Text(text) => format!("'{text}'"),
            Term::Position(_) => "a position".to_owned(),
        }
    }
}

impl Exec<'_> {
    pub(super) fn tp_index(&self, index: Index) -> Result<i32, Fault> {
        let (name, register, number) = match index {
            Index::Fixed(number) => return Ok(number),
            Index::Unset => return Err(not_entered()),
            Index::Register(register) => ("R", register, self.tp_register(register)?),
            Index::Argument(n) => match self.tp_argument(n)? {
                Term::Number(number) => ("AR", n, number),
                Term::Switch(_) | Term::Text(_) | Term::Position(_) => {
                    let message = format!("AR[{n}] is no number of a register");
                    return Err(Fault::argument(message));
                }
            },
        };
        match number {
            Number::Integer(number) => Ok(number),
            Number::Real(value) => Err(Fault::argument(format!(
                "{name}[{register}] is {value}, no number of a register"
            ))),
        }
    }

    fn tp_register(&self, n: i32) -> Result<Number, Fault> {
        self.registers
            .number(n)
            .map_err(|status| no_such("R", n, status))
    }

    fn tp_argument(&self, n: i32) -> Result<Term, Fault> {
        match argument(&self.task.tp.arguments, n) {
            Some(Argument::Number(number)) => Ok(Term::Number(*number)),
            Some(Argument::Text(text)) => Ok(Term::Text(text.clone())),
            None => Err(Fault::new(
                Status::INTP_UNINIT,
                format!("AR[{n}] was not given"),
            )),
        }
    }

    pub(super) fn tp_operand(&mut self, operand: &Operand) -> Result<Term, Fault> {
        Ok(match operand {
            Operand::Unset => return Err(not_entered()),
            Operand::Absent(absent) => return Err(absent_option(absent)),
            Operand::Integer(value) => Term::Number(Number::Integer(*value)),
            Operand::Real(value) => Term::Number(Number::Real(*value)),
            Operand::Switch(on) => Term::Switch(*on),
            Operand::Literal(text) => Term::Text(text.to_string()),
            Operand::Number(index) => Term::Number(self.tp_register(self.tp_index(*index)?)?),
            Operand::Text(index) => {
                let n = self.tp_index(*index)?;
                let text = self.registers.string(n);
                Term::Text(text.map_err(|status| no_such("SR", n, status))?.to_owned())
            }
            Operand::Argument(index) => self.tp_argument(self.tp_index(*index)?)?,
            Operand::Position(index) => {
                let n = self.tp_index(*index)?;
                let position = self.registers.position(n);
                Term::Position(position.map_err(|status| no_such("PR", n, status))?.clone())
            }
            Operand::Taught(index) => {
                let n = self.tp_index(*index)?;
                let changed = self.teaching.changed(self.program.name(), n);
                let known = self.program.code.positions.get(&n).map(AsRef::as_ref);
                let Some(taught) = changed.or(known) else {
                    let message = format!("P[{n}] has no value");
                    return Err(Fault::new(Status::INTP_UNINIT, message));
                };
                Term::Position(match &taught.target {
                    TpTarget::Cartesian(position) => PositionRegister::Cartesian(*position),
                    TpTarget::Joints(joints) => PositionRegister::Joints(joints.clone()),
                })
            }
            Operand::ErrorNumber => self.tp_error_number(),
            Operand::Function(function, operands) => self.tp_function(*function, operands)?,
            Operand::Component(register, component) => {
                let n = self.tp_index(*register)?;
                let component = self.tp_index(*component)?;
                let position = self.registers.position(n);
                let mut position = position.map_err(|status| no_such("PR", n, status))?.clone();
                let value = component_of(&mut position, component).copied();
                let none = || {
                    Fault::new(
                        Status::INTP_UNINIT,
                        format!("PR[{n},{component}] has no value"),
                    )
                };
                Term::Number(Number::Real(value.ok_or_else(none)?))
            }
            Operand::Port(port, index) => {
                let n = self.tp_index(*index)?;
                match self.host.port(*port, n) {
                    Ok(PortValue::Switch(on)) => Term::Switch(on),
                    Ok(PortValue::Number(value)) => Term::Number(Number::Integer(value)),
                    Err(status) => return Err(no_such(port.name(), n, status)),
                }
            }
            Operand::Frame(kind, index) => {
                let n = self.tp_index(*index)?;
                let position = self.tp_frame(*kind, n)?;
                Term::Position(PositionRegister::Cartesian(position.into()))
            }
            Operand::FrameNumber(kind) => Term::Number(Number::Integer(self.tp_active(*kind)?)),
            Operand::Timer(index) => {
                let n = self.tp_index(*index)?;
                let counted = self.timers.watch(n, self.host.now());
                let counted = counted.ok_or_else(|| no_such("TIMER", n, Status::VARS_INDEX))?;
                Term::Number(Number::Real(counted.as_secs_f32()))
            }
            Operand::LinearPosition => {
                let (frame, tool) = self.tp_frames()?;
                let joints = self.tp_joints()?;
                let position = self
                    .host
                    .joints_to_position(self.id, &joints, &frame, &tool, 1);
                let position =
                    position.map_err(|status| Fault::from_host(status, "LPOS failed"))?;
                Term::Position(PositionRegister::Cartesian(position))
            }
            Operand::JointPosition => Term::Position(PositionRegister::Joints(self.tp_joints()?)),
            Operand::System(path) => match self.tp_system(path)? {
                Value::Integer(value) => Term::Number(Number::Integer(value)),
                Value::Real(value) => Term::Number(Number::Real(value)),
                Value::Boolean(on) => Term::Switch(on),
                other @ (Value::String(_)
                | Value::Config(_)
                | Value::Xyzwpr(_)
                | Value::XyzwprExt(_)
                | Value::Position(_)
                | Value::Joints(_)) => {
                    let message = format!("{path} is {other:?}, which a line cannot use");
                    return Err(Fault::new(Status::INTP_TYPE, message));
                }
            },
        })
    }

    fn tp_joints(&mut self) -> Result<JointPosition, Fault> {
        let joints = self.host.current_joints(self.id, 1);
        joints.map_err(|status| Fault::from_host(status, "JPOS failed"))
    }

    fn tp_system(&self, path: &SysPath) -> Result<Value, Fault> {
        let value = self.host.system_variable(self.id, path);
        value.map_err(|status| Fault::new(status, format!("{path} cannot be read")))
    }

    /// The number of the frame in use.
    pub(super) fn tp_active(&self, kind: FrameKind) -> Result<i32, Fault> {
        let path = SysPath::from_name(kind.variables().1).index(&[1]);
        let Value::Integer(number) = self.tp_system(&path)? else {
            let message = format!("{path} is no number");
            return Err(Fault::new(Status::INTP_TYPE, message));
        };
        Ok(number)
    }

    fn tp_frame(&self, kind: FrameKind, n: i32) -> Result<Position, Fault> {
        let path = SysPath::from_name(kind.variables().0).index(&[1, n]);
        let Value::Position(position) = self.tp_system(&path)? else {
            let message = format!("{path} is no pose");
            return Err(Fault::new(Status::INTP_TYPE, message));
        };
        Ok(position)
    }

    /// The frames in use; number 0 is the world, or the flange.
    pub(super) fn tp_frames(&self) -> Result<(Position, Position), Fault> {
        let used = |kind| match self.tp_active(kind)? {
            0 => Ok(Position::default()),
            n => self.tp_frame(kind, n),
        };
        Ok((used(FrameKind::User)?, used(FrameKind::Tool)?))
    }

    pub(super) fn tp_real(&mut self, operand: &Operand, what: &str) -> Result<f32, Fault> {
        match self.tp_operand(operand)? {
            Term::Number(number) => Ok(real(number)),
            Term::Switch(_) | Term::Text(_) | Term::Position(_) => Err(Fault::new(
                Status::INTP_TYPE,
                format!("{what} needs a number"),
            )),
        }
    }

    pub(super) fn tp_whole(&mut self, operand: &Operand, what: &str) -> Result<i32, Fault> {
        match self.tp_operand(operand)? {
            Term::Number(Number::Integer(value)) => Ok(value),
            Term::Number(Number::Real(_)) | Term::Switch(_) | Term::Text(_) | Term::Position(_) => {
                let message = format!("{what} needs a whole number");
                Err(Fault::new(Status::INTP_TYPE, message))
            }
        }
    }

    pub(super) fn tp_holds(&mut self, condition: &Expr) -> Result<bool, Fault> {
        match self.tp_value(condition)? {
            Term::Switch(on) => Ok(on),
            Term::Number(_) | Term::Text(_) | Term::Position(_) => {
                Err(Fault::new(Status::INTP_TYPE, "A condition needs ON or OFF"))
            }
        }
    }

    /// The scanner bounds how deep this recurses.
    pub(super) fn tp_value(&mut self, value: &Expr) -> Result<Term, Fault> {
        match value {
            Expr::Operand(operand) => self.tp_operand(operand),
            Expr::Group(inner) => self.tp_value(inner),
            Expr::Edge {
                port,
                index,
                rising,
            } => self.tp_edge(*port, *index, *rising).map(Term::Switch),
            Expr::Not(inner) => match self.tp_value(inner)? {
                Term::Switch(on) => Ok(Term::Switch(!on)),
                Term::Number(_) | Term::Text(_) | Term::Position(_) => {
                    Err(Fault::new(Status::INTP_TYPE, "`!` needs ON or OFF"))
                }
            },
            Expr::Binary(operator, left, right) => {
                let left = self.tp_value(left)?;
                let right = self.tp_value(right)?;
                combine(*operator, left, right)
            }
        }
    }
}

/// `AR[n]` of the program that runs.
pub(crate) fn argument(arguments: &[(usize, Vec<Argument>)], n: i32) -> Option<&Argument> {
    let index = usize::try_from(n).ok()?.checked_sub(1)?;
    arguments.last()?.1.get(index)
}

/// A text of Latin-1 characters as its bytes.
pub(crate) fn text_bytes(text: &str) -> Vec<u8> {
    text.chars()
        .map(|c| u8::try_from(c).unwrap_or(b'?'))
        .collect()
}

pub(super) fn no_such(what: &str, n: i32, status: Status) -> Fault {
    Fault::new(status, format!("There is no {what}[{n}]"))
}

/// ASSUMPTION: as a built-in of an option that is not there.
pub(super) fn absent_option(absent: &Absent) -> Fault {
    let Absent { what, needs } = absent;
    let message = format!("{what} needs {needs}");
    Fault::new(Status::INTP_UNDEFINED_BUILTIN, message)
}

/// ASSUMPTION: what nobody has entered is as a variable without a value.
pub(super) fn not_entered() -> Fault {
    Fault::new(Status::INTP_UNINIT, "Nobody has entered the value")
}
