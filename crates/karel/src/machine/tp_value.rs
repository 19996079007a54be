//! Values and assignments of TP programs.

use super::{exec::Exec, exec::Flow, fault::Fault, task::Argument};
use crate::{
    ast::Relation,
    port::{Port, PortValue},
    position::{JointPosition, Position, XyzwprExt},
    registers::{Number, PositionRegister},
    status::Status,
    syspath::SysPath,
    tp::{Arithmetic, Expr, FrameKind, Index, Operand, Operator, Place},
    value::{SysValue, Value, real_of},
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
    fn shown(&self) -> String {
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
    pub(super) fn tp_assign(&mut self, target: &Place, value: &Expr) -> Result<Flow, Fault> {
        let value = self.tp_value(value)?;
        match (target, value) {
            (Place::Number(index), Term::Number(value)) => {
                let n = self.tp_index(*index)?;
                self.tp_set_number(n, value)?;
            }
            (Place::Number(index), Term::Text(text)) => {
                // ASSUMPTION: a text that is no number is 0.
                let n = self.tp_index(*index)?;
                self.tp_set_number(n, number_in(&text))?;
            }
            (Place::Text(index), Term::Text(text)) => self.tp_set_text(*index, text)?,
            (Place::Text(index), Term::Number(number)) => {
                self.tp_set_text(*index, number_text(number))?;
            }
            (Place::Position(index), Term::Position(value)) => {
                let n = self.tp_index(*index)?;
                let set = self.registers.set_position(n, value);
                set.map_err(|status| no_such("PR", n, status))?;
            }
            (Place::Component(register, component), Term::Number(value)) => {
                let component = self.tp_index(*component)?;
                self.tp_set_component(*register, component, real(value))?;
            }
            (Place::Port(port, index), value) => self.tp_set_port(*port, *index, &value)?,
            (Place::Frame(kind, index), Term::Position(PositionRegister::Cartesian(position))) => {
                let n = self.tp_index(*index)?;
                let path = SysPath::from_name(kind.variables().0).index(&[1, n]);
                self.tp_set_system(&path, Value::Position(Position::from(position)))?;
            }
            (Place::FrameNumber(kind), Term::Number(Number::Integer(number))) => {
                let path = SysPath::from_name(kind.variables().1).index(&[1]);
                let value = SysValue::Value(Value::Integer(number));
                let set = self.host.set_system_variable(self.id, &path, value);
                let none = |status| Fault::new(status, format!("There is no frame {number}"));
                set.map_err(none)?;
            }
            (Place::System(path), Term::Number(Number::Integer(number))) => {
                self.tp_set_system(path, Value::Integer(number))?;
            }
            (Place::System(path), Term::Number(Number::Real(number))) => {
                self.tp_set_system(path, Value::Real(number))?;
            }
            (Place::System(path), Term::Switch(on)) => {
                self.tp_set_system(path, Value::Boolean(on))?;
            }
            (_, value) => {
                let message = format!("The target of this assignment cannot be {}", value.shown());
                return Err(Fault::new(Status::INTP_TYPE, message));
            }
        }
        Ok(Flow::Next)
    }

    pub(super) fn tp_set_system(&mut self, path: &SysPath, value: Value) -> Result<(), Fault> {
        let set = self
            .host
            .set_system_variable(self.id, path, SysValue::Value(value));
        set.map_err(|status| Fault::new(status, format!("{path} cannot be set")))
    }

    pub(super) fn tp_set_number(&mut self, n: i32, value: Number) -> Result<(), Fault> {
        let set = self.registers.set_number(n, value);
        set.map_err(|status| no_such("R", n, status))
    }

    fn tp_set_text(&mut self, index: Index, text: String) -> Result<(), Fault> {
        let n = self.tp_index(index)?;
        let set = self.registers.set_string(n, text);
        set.map_err(|status| no_such("SR", n, status))
    }

    /// ASSUMPTION: a register without a value gets the others as 0, as a pose.
    fn tp_set_component(
        &mut self,
        register: Index,
        component: i32,
        value: f32,
    ) -> Result<(), Fault> {
        let n = self.tp_index(register)?;
        let position = self.registers.position(n);
        let mut position = position.map_err(|status| no_such("PR", n, status))?.clone();
        if position == PositionRegister::Unset {
            position = PositionRegister::Cartesian(XyzwprExt::from(Position::default()));
        }
        let Some(slot) = component_of(&mut position, component) else {
            let message = format!("There is no PR[{n},{component}]");
            return Err(Fault::new(Status::VARS_INDEX, message));
        };
        *slot = value;
        let set = self.registers.set_position(n, position);
        set.map_err(|status| no_such("PR", n, status))
    }

    /// Groups and analog ports take whole numbers only.
    fn tp_set_port(&mut self, port: Port, index: Index, value: &Term) -> Result<(), Fault> {
        let n = self.tp_index(index)?;
        let value = match value {
            Term::Switch(on) if port.is_switch() => PortValue::Switch(*on),
            Term::Number(Number::Integer(value)) if !port.is_switch() => PortValue::Number(*value),
            Term::Number(Number::Real(_) | Number::Integer(_))
            | Term::Switch(_)
            | Term::Text(_)
            | Term::Position(_) => {
                let message = format!("{}[{n}] cannot be {}", port.name(), value.shown());
                return Err(Fault::new(Status::INTP_TYPE, message));
            }
        };
        let set = self.host.set_port(self.id, port, n, value);
        set.map_err(|status| no_such(port.name(), n, status))
    }

    pub(super) fn tp_index(&self, index: Index) -> Result<i32, Fault> {
        let (name, register, number) = match index {
            Index::Fixed(number) => return Ok(number),
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
    fn tp_active(&self, kind: FrameKind) -> Result<i32, Fault> {
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
    fn tp_frames(&self) -> Result<(Position, Position), Fault> {
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
    fn tp_value(&mut self, value: &Expr) -> Result<Term, Fault> {
        match value {
            Expr::Operand(operand) => self.tp_operand(operand),
            Expr::Group(inner) => self.tp_value(inner),
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

fn component_of(position: &mut PositionRegister, component: i32) -> Option<&mut f32> {
    match position {
        PositionRegister::Cartesian(p) => match component {
            1 => Some(&mut p.x),
            2 => Some(&mut p.y),
            3 => Some(&mut p.z),
            4 => Some(&mut p.w),
            5 => Some(&mut p.p),
            6 => Some(&mut p.r),
            _ => None,
        },
        PositionRegister::Joints(joints) => {
            let index = usize::try_from(component).ok()?.checked_sub(1)?;
            joints.axes.get_mut(index)
        }
        PositionRegister::Unset => None,
    }
}

fn number_in(text: &str) -> Number {
    let text = text.trim();
    let whole = text.parse().ok().map(Number::Integer);
    let real = || text.parse::<f32>().ok().filter(|value| value.is_finite());
    whole
        .or_else(|| real().map(Number::Real))
        .unwrap_or(Number::Integer(0))
}

fn number_text(number: Number) -> String {
    match number {
        Number::Integer(value) => value.to_string(),
        Number::Real(value) => value.to_string(),
    }
}

fn combine(operator: Operator, left: Term, right: Term) -> Result<Term, Fault> {
    match (operator, left, right) {
        (Operator::And, Term::Switch(a), Term::Switch(b)) => Ok(Term::Switch(a && b)),
        (Operator::Or, Term::Switch(a), Term::Switch(b)) => Ok(Term::Switch(a || b)),
        (Operator::Relation(relation), a, b) => compare(&a, relation, &b).map(Term::Switch),
        (Operator::Arithmetic(operator), Term::Number(a), Term::Number(b)) => {
            calculate(operator, a, b).map(Term::Number)
        }
        (Operator::Arithmetic(Arithmetic::Add), Term::Text(a), Term::Text(b)) => {
            Ok(Term::Text(a + &b))
        }
        (
            Operator::Arithmetic(operator @ (Arithmetic::Add | Arithmetic::Subtract)),
            Term::Position(a),
            Term::Position(b),
        ) => sum_of_positions(operator, a, &b).map(Term::Position),
        (operator, a, b) => {
            let message = format!("{a:?} {operator:?} {b:?} is nothing that can be calculated");
            Err(Fault::new(Status::INTP_TYPE, message))
        }
    }
}

/// Component by component; the configuration stays that of the left one.
fn sum_of_positions(
    operator: Arithmetic,
    mut left: PositionRegister,
    right: &PositionRegister,
) -> Result<PositionRegister, Fault> {
    let mut right = right.clone();
    let same = matches!(
        (&left, &right),
        (
            PositionRegister::Cartesian(_),
            PositionRegister::Cartesian(_)
        ) | (PositionRegister::Joints(_), PositionRegister::Joints(_))
    );
    if !same {
        let message = "Positions that are added need values of the same kind";
        return Err(Fault::new(Status::INTP_TYPE, message));
    }
    for component in 1..=6 {
        if let (Some(value), Some(other)) = (
            component_of(&mut left, component),
            component_of(&mut right, component),
        ) {
            let sum = if operator == Arithmetic::Add {
                *value + *other
            } else {
                *value - *other
            };
            *value = super::finite(sum)?;
        }
    }
    Ok(left)
}

fn calculate(operator: Arithmetic, a: Number, b: Number) -> Result<Number, Fault> {
    if let (Number::Integer(a), Number::Integer(b)) = (a, b)
        && operator != Arithmetic::Divide
    {
        if b == 0 && matches!(operator, Arithmetic::Div | Arithmetic::Mod) {
            return Err(Fault::divide_by_zero());
        }
        let result = match operator {
            Arithmetic::Add => a.checked_add(b),
            Arithmetic::Subtract => a.checked_sub(b),
            Arithmetic::Multiply => a.checked_mul(b),
            Arithmetic::Div => a.checked_div(b),
            Arithmetic::Mod => a.checked_rem(b),
            Arithmetic::Divide => None,
        };
        return result.map(Number::Integer).ok_or_else(Fault::overflow);
    }
    let (a, b) = (real(a), real(b));
    let result = match operator {
        Arithmetic::Add => a + b,
        Arithmetic::Subtract => a - b,
        Arithmetic::Multiply => a * b,
        Arithmetic::Divide | Arithmetic::Div | Arithmetic::Mod if b == 0.0 => {
            return Err(Fault::divide_by_zero());
        }
        Arithmetic::Divide => a / b,
        Arithmetic::Div => (a / b).trunc(),
        Arithmetic::Mod => a % b,
    };
    super::finite(result).map(Number::Real)
}

fn real(number: Number) -> f32 {
    match number {
        Number::Integer(value) => real_of(value),
        Number::Real(value) => value,
    }
}

fn compare(left: &Term, relation: Relation, right: &Term) -> Result<bool, Fault> {
    let order = match (left, right) {
        (Term::Number(Number::Integer(a)), Term::Number(Number::Integer(b))) => a.cmp(b),
        (Term::Number(a), Term::Number(b)) => super::arithmetic::order(real(*a), real(*b)),
        (Term::Text(a), Term::Text(b)) => a.cmp(b),
        (Term::Switch(a), Term::Switch(b))
            if matches!(relation, Relation::Equal | Relation::NotEqual) =>
        {
            a.cmp(b)
        }
        _ => {
            let message = format!("{left:?} cannot be compared with {right:?}");
            return Err(Fault::new(Status::INTP_TYPE, message));
        }
    };
    Ok(super::arithmetic::holds(relation, order))
}
