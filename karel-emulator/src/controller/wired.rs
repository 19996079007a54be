//! Registers, and what is wired to a controller: its ports.

use karel::{Host, Number, Port, PortValue, PositionRegister, Status, TaskId, Value};

use super::Controller;
use super::data::reason_of;
use super::programs::shown;
use super::values::{
    DataError, IoView, RegisterView, ValueBody, in_words, number_body, position_body, value_of,
};

impl Controller {
    /// The registers that are not as when new: numbers other than 0, strings that are not empty, positions that were
    /// set, flags that are on.
    #[must_use]
    pub fn register_views(&self) -> Vec<RegisterView> {
        let registers = self.machine.registers();
        let mut views = Vec::new();
        let mut push = |register: String, value: ValueBody| {
            views.push(RegisterView {
                register,
                value: Some(value),
            });
        };
        for n in 1.. {
            match registers.number(n) {
                Ok(Number::Integer(0)) => {}
                Ok(number) => push(format!("R[{n}]"), number_body(number)),
                Err(_) => break,
            }
        }
        for n in 1.. {
            match registers.position(n) {
                Ok(PositionRegister::Unset) => {}
                Ok(position) => {
                    if let Some(value) = position_body(position) {
                        push(format!("PR[{n}]"), value);
                    }
                }
                Err(_) => break,
            }
        }
        for n in 1.. {
            match registers.string(n) {
                Ok("") => {}
                Ok(text) => push(format!("SR[{n}]"), ValueBody::Text(text.to_owned())),
                Err(_) => break,
            }
        }
        for port in self.hardware.ports.view() {
            if let Some(flag) = port.port.strip_prefix("FLG") {
                push(format!("F{flag}"), ValueBody::Boolean(port.value != 0));
            }
        }
        views
    }

    /// A register: `R[3]`, `PR[1]`, `SR[2]`, `F[5]`.
    ///
    /// # Errors
    /// The text is no register, or there is none of this number.
    pub fn register(&self, text: &str) -> Result<Option<ValueBody>, DataError> {
        let (kind, n) = register_name(text)?;
        let registers = self.machine.registers();
        let found = match kind {
            RegisterKind::Number => registers.number(n).map(|number| Some(number_body(number))),
            RegisterKind::Position => registers.position(n).map(position_body),
            RegisterKind::String => registers
                .string(n)
                .map(|text| Some(ValueBody::Text(text.to_owned()))),
            RegisterKind::Flag => {
                let flag = self.hardware.ports.get(Port::Flag, n);
                flag.map(|value| Some(ValueBody::Boolean(value == PortValue::Switch(true))))
            }
        };
        found.map_err(|status| no_register(text, status))
    }

    /// Sets a register.
    ///
    /// # Errors
    /// The text is no register, there is none of this number, or a value that it cannot have.
    pub fn set_register(&mut self, text: &str, value: Option<&ValueBody>) -> Result<(), DataError> {
        let (kind, n) = register_name(text)?;
        let wrong = |reason: &str| DataError::Value {
            what: shown(text),
            value: in_words(value),
            reason: reason.to_owned(),
        };
        let registers = self.machine.registers_mut();
        let set = match (kind, value) {
            (RegisterKind::Number, Some(ValueBody::Integer(value))) => {
                registers.set_number(n, Number::Integer(*value))
            }
            (RegisterKind::Number, Some(ValueBody::Real(value))) if value.is_finite() => {
                registers.set_number(n, Number::Real(*value))
            }
            (RegisterKind::Number, _) => return Err(wrong("it holds a number")),
            (RegisterKind::String, Some(ValueBody::Text(value))) => {
                if value.chars().any(|c| u32::from(c) > 255) {
                    return Err(wrong("a string holds Latin-1 characters"));
                }
                if value.chars().count() > 254 {
                    return Err(wrong("a string holds at most 254 characters"));
                }
                registers.set_string(n, value.clone())
            }
            (RegisterKind::String, _) => return Err(wrong("it holds text")),
            (RegisterKind::Flag, Some(ValueBody::Boolean(on))) => {
                let on = PortValue::Switch(*on);
                self.hardware.ports.set(Port::Flag, n, on).map(drop)
            }
            (RegisterKind::Flag, _) => return Err(wrong("it is true or false")),
            (RegisterKind::Position, None) => registers.set_position(n, PositionRegister::Unset),
            (RegisterKind::Position, Some(body)) => {
                let position = value_of(text, body)?;
                let pose = position.as_xyzwprext().map(PositionRegister::Cartesian);
                let position = match (pose, position) {
                    (Some(pose), _) => pose,
                    (None, Value::Joints(joints)) => PositionRegister::Joints(joints),
                    (None, _) => return Err(wrong("it holds a pose or joints")),
                };
                registers.set_position(n, position)
            }
        };
        set.map_err(|status| no_register(text, status))
    }

    /// The ports that are not off or are simulated.
    #[must_use]
    pub fn io(&self) -> Vec<IoView> {
        let ports = self.hardware.ports.view();
        let view = |port: crate::ports::PortView| {
            let simulated = port_name(&port.port)
                .is_ok_and(|(kind, n)| self.hardware.ports.is_simulated(kind, n));
            IoView {
                port: port.port,
                value: port.value,
                simulated,
            }
        };
        ports.into_iter().map(view).collect()
    }

    /// A port, as programs see it: `DIN[3]`.
    ///
    /// # Errors
    /// The text is no port, or there is none of this number.
    pub fn io_port(&self, text: &str) -> Result<IoView, DataError> {
        let (port, n) = port_name(text)?;
        let found = self.hardware.port(port, n.into());
        let value = found.map_err(|_| self.no_port(port, n))?;
        Ok(IoView {
            port: format!("{port}[{n}]"),
            value: match value {
                PortValue::Switch(on) => on.into(),
                PortValue::Number(number) => number,
            },
            simulated: self.hardware.ports.is_simulated(port, n),
        })
    }

    /// Sets a port: an input as the world does, an output as an operator does; or simulates an input.
    ///
    /// # Errors
    /// The text is no port, there is none of this number, or a value that it cannot have.
    pub fn set_io(&mut self, text: &str, set: PortSet) -> Result<(), DataError> {
        let (port, n) = port_name(text)?;
        let fit = |number: i32| {
            if !port.is_switch() {
                return Ok(PortValue::Number(number));
            }
            match number {
                0 => Ok(PortValue::Switch(false)),
                1 => Ok(PortValue::Switch(true)),
                other => Err(DataError::Value {
                    what: format!("{port}[{n}]"),
                    value: other.to_string(),
                    reason: "it is 0 or 1".to_owned(),
                }),
            }
        };
        match set {
            PortSet::Simulate(number) => {
                self.hardware.ports.simulate(port, n, fit(number)?)?;
                self.follow_signals();
            }
            PortSet::EndSimulation => {
                self.hardware.ports.end_simulation(port, n)?;
                self.follow_signals();
            }
            PortSet::Value(number) if port.is_input() => self.set_input(port, n, fit(number)?)?,
            PortSet::Value(number) => {
                let value = fit(number)?;
                let set = self.hardware.set_port(TaskId(0), port, n.into(), value);
                set.map_err(|status| match status {
                    Status::PRIO_PORT_NUMBER => self.no_port(port, n),
                    _ => DataError::Value {
                        what: format!("{port}[{n}]"),
                        value: number.to_string(),
                        reason: reason_of(status),
                    },
                })?;
            }
        }
        Ok(())
    }

    fn no_port(&self, port: Port, n: u16) -> DataError {
        let reason = if matches!(port, Port::PanelIn | Port::PanelOut) {
            "they go from 0 to 15".to_owned()
        } else {
            format!("the last is {port}[{}]", self.hardware.ports.count(port))
        };
        let what = format!("{port}[{n}]");
        DataError::Missing { what, reason }
    }
}

/// What is done to a port.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum PortSet {
    /// It gets this value.
    Value(i32),
    /// Programs see this value whatever the input has.
    Simulate(i32),
    /// Programs see the input again.
    EndSimulation,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum RegisterKind {
    Number,
    Position,
    String,
    Flag,
}

/// `NAME[n]`.
fn indexed(text: &str) -> Option<(String, i32)> {
    let (name, rest) = text.trim().split_once('[')?;
    let number = rest.trim_end().strip_suffix(']')?.trim().parse().ok()?;
    Some((name.trim().to_ascii_uppercase(), number))
}

pub(super) fn register_name(text: &str) -> Result<(RegisterKind, i32), DataError> {
    let kind = indexed(text).and_then(|(name, n)| {
        let kind = match name.as_str() {
            "R" => RegisterKind::Number,
            "PR" => RegisterKind::Position,
            "SR" => RegisterKind::String,
            "F" => RegisterKind::Flag,
            _ => return None,
        };
        Some((kind, n))
    });
    kind.ok_or_else(|| DataError::Syntax {
        text: shown(text),
        wanted: "register",
        reason: "R[n], PR[n], SR[n] or F[n] with a number".to_owned(),
    })
}

/// Also the names of TP programs: `DI`, `DO`, `RI`, `RO`, `GI`, `GO`, `AI`, `AO`, `F`.
fn port_name(text: &str) -> Result<(Port, u16), DataError> {
    let found = indexed(text).and_then(|(name, n)| {
        let name = match name.as_str() {
            "DI" => "DIN",
            "DO" => "DOUT",
            "RI" => "RDI",
            "RO" => "RDO",
            "GI" => "GIN",
            "GO" => "GOUT",
            "AI" => "AIN",
            "AO" => "AOUT",
            "F" => "FLG",
            other => other,
        };
        let port = Port::ALL.into_iter().find(|port| port.name() == name)?;
        Some((port, u16::try_from(n).ok()?))
    });
    found.ok_or_else(|| DataError::Syntax {
        text: shown(text),
        wanted: "port",
        reason: "DIN[n], DOUT[n], RDI[n], RDO[n], GIN[n], GOUT[n], AIN[n], AOUT[n], FLG[n], OPIN[n] or OPOUT[n]"
            .to_owned(),
    })
}

fn no_register(text: &str, status: Status) -> DataError {
    DataError::Missing {
        what: format!("register {}", shown(text)),
        reason: reason_of(status),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn ports_have_the_names_of_both_languages() {
        assert_eq!(port_name("DI[3]").unwrap(), (Port::DigitalIn, 3));
        assert_eq!(port_name(" rdo[ 8 ] ").unwrap(), (Port::RobotOut, 8));
        for wrong in ["DIN", "DIN[x]", "DIN[-1]", "XX[1]", "DIN[99999999999]"] {
            assert!(port_name(wrong).is_err(), "{wrong}");
        }
    }
}
