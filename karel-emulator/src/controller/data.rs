//! What a controller remembers and what is wired to it: variables, registers, ports.

use karel::{
    Host, Number, Port, PortValue, PositionRegister, Status, Step, SysPath, SysValue, TaskId,
    Value, VariableView, XyzwprExt,
};

use super::Controller;
use super::programs::shown;
use super::values::{
    DataError, IoView, RegisterView, ValueBody, VariableItem, candidates, in_words, number_body,
    position_body, value_of, value_of_text,
};

/// The program name that stands for the system variables, as in `GET_VAR`.
pub const SYSTEM: &str = "*SYSTEM*";

/// A path with its program: `[PROG]VAR.FIELD`, or `$NAME` for the system's.
#[derive(Clone, Debug, PartialEq)]
struct FullPath {
    /// `None` for system variables.
    program: Option<String>,
    path: SysPath,
}

impl FullPath {
    fn parse(text: &str) -> Result<Self, DataError> {
        let wrong = |reason: String| DataError::Syntax {
            text: shown(text),
            wanted: "variable path such as [PROG]CFG.CHECKED or $MCR.$GENOVERRIDE",
            reason,
        };
        let trimmed = text.trim();
        let (program, rest) = match trimmed.strip_prefix('[') {
            Some(rest) => {
                let (program, rest) = rest
                    .split_once(']')
                    .ok_or_else(|| wrong("`]` is missing after the program".to_owned()))?;
                (Some(program.trim()), rest)
            }
            None => (None, trimmed),
        };
        let program = program.filter(|name| !name.eq_ignore_ascii_case(SYSTEM));
        let path = SysPath::parse(rest).map_err(|error| wrong(error.to_string()))?;
        if program.is_none() && !path.root().starts_with('$') {
            return Err(wrong(
                "a variable of a program needs its program, [PROG]VAR".to_owned(),
            ));
        }
        Ok(Self {
            program: program.map(str::to_owned),
            path,
        })
    }
}

impl Controller {
    /// A variable by its path, `None` if it is uninitialized.
    ///
    /// # Errors
    /// The text is no path, or there is no such variable.
    pub fn variable(&mut self, text: &str) -> Result<Option<ValueBody>, DataError> {
        let FullPath { program, path } = FullPath::parse(text)?;
        let found = match &program {
            Some(program) => self.machine.variable(program, &path),
            None => self.system_value(&path).map(Some),
        };
        match found {
            Ok(value) => Ok(value.as_ref().map(ValueBody::from)),
            Err(Status::INTP_UNINIT) => Ok(None),
            Err(status) => Err(missing(text, status)),
        }
    }

    /// Sets a variable by its path; `None` makes it uninitialized.
    ///
    /// # Errors
    /// The text is no path, there is no such variable, or a value that it cannot have.
    pub fn set_variable(&mut self, text: &str, value: Option<&ValueBody>) -> Result<(), DataError> {
        let FullPath { program, path } = FullPath::parse(text)?;
        let mut last = Status::VARS_TYPE;
        for candidate in candidates(text, value)? {
            let set = match (&program, candidate) {
                (Some(program), value) => self.machine.set_variable(program, &path, value.as_ref()),
                (None, value) => self.set_system_value(&path, value),
            };
            match set {
                Ok(()) => return Ok(()),
                // That another type does not fit either tells nothing new.
                Err(Status::VARS_TYPE) => {}
                Err(status) => last = status,
            }
        }
        if matches!(
            last,
            Status::VARS_UNKNOWN | Status::VARS_INDEX | Status::MEMO_NO_PROGRAM
        ) {
            return Err(missing(text, last));
        }
        Err(DataError::Value {
            what: shown(text),
            value: in_words(value),
            reason: reason_of(last),
        })
    }

    /// The variables of a program, or of the system, at most `limit`; and whether there are more.
    ///
    /// # Errors
    /// There is no such program.
    pub fn variables(
        &mut self,
        program: &str,
        limit: usize,
    ) -> Result<(Vec<VariableItem>, bool), DataError> {
        if program.eq_ignore_ascii_case(SYSTEM) {
            let paths: Vec<SysPath> = self
                .hardware
                .variables
                .paths()
                .filter_map(|path| SysPath::parse(path).ok())
                .collect();
            let more = paths.len() > limit;
            let item = |path: &SysPath| VariableItem {
                path: path.to_string(),
                type_name: None,
                value: self.system_value(path).ok().as_ref().map(ValueBody::from),
            };
            return Ok((paths.iter().take(limit).map(item).collect(), more));
        }
        let listed = self.machine.variables_of(program, limit);
        let (views, more) = listed.map_err(|_| DataError::Missing {
            what: format!("program {}", shown(program)),
            reason: format!("there are {}", self.known_programs()),
        })?;
        let item = |view: VariableView| VariableItem {
            path: view.path,
            type_name: Some(view.type_name),
            value: view.value.as_ref().map(ValueBody::from),
        };
        Ok((views.into_iter().map(item).collect(), more))
    }

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
            }
            PortSet::EndSimulation => self.hardware.ports.end_simulation(port, n)?,
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

    /// Sets an item by its name from text: a variable, a register, or a port. `ON` and `OFF` are switches, `null` takes
    /// a value away, numbers and `true` are themselves, `{..}` is a position, and the rest is text.
    ///
    /// # Errors
    /// As for each kind of item.
    pub fn set_item(&mut self, item: &str, text: &str) -> Result<(), DataError> {
        let value = value_of_text(item, text)?;
        match kind_of(item) {
            ItemKind::Variable => self.set_variable(item, value.as_ref()),
            ItemKind::Register => self.set_register(item, value.as_ref()),
            ItemKind::Port => {
                let number = match &value {
                    Some(ValueBody::Boolean(on)) => i32::from(*on),
                    Some(ValueBody::Integer(number)) => *number,
                    _ => {
                        return Err(DataError::Value {
                            what: shown(item),
                            value: in_words(value.as_ref()),
                            reason: "it is ON, OFF or a number".to_owned(),
                        });
                    }
                };
                self.set_io(item, PortSet::Value(number))
            }
        }
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

    fn known_programs(&self) -> String {
        let names: Vec<&str> = self.loaded.iter().map(|p| p.name.as_str()).collect();
        format!("{} and {SYSTEM}", names.join(", "))
    }

    fn system_value(&self, path: &SysPath) -> Result<Value, Status> {
        let Some((whole, component)) = split_component(path) else {
            return self.hardware.system_variable(TaskId(0), path);
        };
        let mut position = self.system_pose(&whole)?;
        let slot = component_of(&mut position, &component).ok_or(Status::VARS_UNKNOWN)?;
        Ok(Value::Real(*slot))
    }

    fn set_system_value(&mut self, path: &SysPath, value: Option<Value>) -> Result<(), Status> {
        let Some((whole, component)) = split_component(path) else {
            let value = value.map_or(SysValue::Uninit, SysValue::Value);
            return self.hardware.set_system_variable(TaskId(0), path, value);
        };
        let mut position = self.system_pose(&whole)?;
        let slot = component_of(&mut position, &component).ok_or(Status::VARS_UNKNOWN)?;
        *slot = match value {
            Some(Value::Real(value)) => value,
            Some(_) => return Err(Status::VARS_TYPE),
            None => return Err(Status::INTP_UNINIT),
        };
        let position = SysValue::Value(Value::Position(position.into()));
        self.hardware
            .set_system_variable(TaskId(0), &whole, position)
    }

    fn system_pose(&self, path: &SysPath) -> Result<XyzwprExt, Status> {
        let value = self.hardware.system_variable(TaskId(0), path)?;
        value.as_xyzwprext().ok_or(Status::VARS_UNKNOWN)
    }
}

/// The kinds of items that have values.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ItemKind {
    /// `[PROG]VAR` or `$NAME`.
    Variable,
    /// `R[n]`, `PR[n]`, `SR[n]`, `F[n]`.
    Register,
    /// Everything else.
    Port,
}

/// What kind of item a name means.
#[must_use]
pub fn kind_of(item: &str) -> ItemKind {
    if item.trim_start().starts_with(['[', '$']) {
        ItemKind::Variable
    } else if register_name(item).is_ok() {
        ItemKind::Register
    } else {
        ItemKind::Port
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
enum RegisterKind {
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

fn register_name(text: &str) -> Result<(RegisterKind, i32), DataError> {
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

fn missing(text: &str, status: Status) -> DataError {
    DataError::Missing {
        what: format!("variable {}", shown(text)),
        reason: reason_of(status),
    }
}

fn reason_of(status: Status) -> String {
    let words = match status {
        Status::MEMO_NO_PROGRAM => "no such program is loaded",
        Status::VARS_UNKNOWN => "no such name",
        Status::VARS_INDEX => "a number or subscript is out of range",
        Status::VARS_TYPE => "its type is another, or it is a whole array or structure",
        Status::INTP_ARGUMENT => "the value is out of range",
        crate::sysvars::VARS_RANGE => "the value is out of its range",
        crate::sysvars::VARS_READ_ONLY => "it cannot be written",
        _ => return status.to_string(),
    };
    format!("{words} ({status})")
}

/// Splits `$UTOOL.X` into `$UTOOL` and `X`.
fn split_component(path: &SysPath) -> Option<(SysPath, String)> {
    let (last, rest) = path.steps().split_last()?;
    let Step::Name(component) = last else {
        return None;
    };
    if rest.is_empty() || component.starts_with('$') {
        return None;
    }
    let mut whole = SysPath::from_name(path.root());
    for step in rest.iter().skip(1) {
        whole = match step {
            Step::Name(name) => whole.field(name),
            Step::Index(subscripts) => whole.index(subscripts),
        };
    }
    Some((whole, component.clone()))
}

fn component_of<'a>(pose: &'a mut XyzwprExt, name: &str) -> Option<&'a mut f32> {
    Some(match name {
        "X" => &mut pose.x,
        "Y" => &mut pose.y,
        "Z" => &mut pose.z,
        "W" => &mut pose.w,
        "P" => &mut pose.p,
        "R" => &mut pose.r,
        _ => return None,
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn paths_name_their_program_or_begin_with_a_dollar() {
        assert_eq!(
            FullPath::parse("[ros_relay]cfg_.checked")
                .unwrap()
                .program
                .as_deref(),
            Some("ros_relay")
        );
        assert_eq!(FullPath::parse("$UTOOL.X").unwrap().program, None);
        assert_eq!(FullPath::parse("[*SYSTEM*]$UTOOL").unwrap().program, None);
        for wrong in ["", "x", "[a", "[a]", "[a]b[", "$"] {
            assert!(
                matches!(FullPath::parse(wrong), Err(DataError::Syntax { .. })) || wrong == "$",
                "{wrong}"
            );
        }
    }

    #[test]
    fn ports_have_the_names_of_both_languages() {
        assert_eq!(port_name("DI[3]").unwrap(), (Port::DigitalIn, 3));
        assert_eq!(port_name(" rdo[ 8 ] ").unwrap(), (Port::RobotOut, 8));
        for wrong in ["DIN", "DIN[x]", "DIN[-1]", "XX[1]", "DIN[99999999999]"] {
            assert!(port_name(wrong).is_err(), "{wrong}");
        }
    }
}
