//! Assignments of TP programs.

use super::{
    exec::{Exec, Flow},
    fault::Fault,
    tp_calculate::{component_of, number_in, number_text, real},
    tp_value::{Term, no_such},
};
use crate::{
    host::TpTarget,
    port::{Port, PortValue},
    position::{Position, XyzwprExt},
    registers::{Number, PositionRegister},
    status::Status,
    syspath::SysPath,
    tp::{Expr, FrameKind, Index, Place, Taught},
    value::{SysValue, Value},
};

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
            (Place::Taught(index), Term::Position(value)) => {
                let n = self.tp_index(*index)?;
                self.tp_teach(n, value)?;
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

    /// The program's own position is taught, in the frames that are active; as by a built-in, the listing stays as it is.
    fn tp_teach(&mut self, number: i32, value: PositionRegister) -> Result<(), Fault> {
        let target = match value {
            PositionRegister::Cartesian(position) => TpTarget::Cartesian(position),
            PositionRegister::Joints(joints) => TpTarget::Joints(joints),
            PositionRegister::Unset => {
                let message = format!("P[{number}] cannot be set: the position has no value");
                return Err(Fault::new(Status::INTP_UNINIT, message));
            }
        };
        let taught = Taught {
            number,
            frame: Some(self.tp_active(FrameKind::User)?),
            tool: Some(self.tp_active(FrameKind::Tool)?),
            target,
        };
        if self.teaching.change(self.program.name(), taught) {
            return Ok(());
        }
        Err(Fault::new(Status::INTP_LIMIT, "Too many positions"))
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
}
