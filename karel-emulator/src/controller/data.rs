//! What a controller remembers: variables of programs and of the system.

use karel::{Host, Status, Step, SysPath, SysValue, TaskId, Value, VariableView, XyzwprExt};

use super::Controller;
use super::programs::shown;
use super::values::{DataError, ValueBody, VariableItem, candidates, in_words, value_of_text};
use super::wired::{PortSet, register_name};

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

fn missing(text: &str, status: Status) -> DataError {
    DataError::Missing {
        what: format!("variable {}", shown(text)),
        reason: reason_of(status),
    }
}

pub(super) fn reason_of(status: Status) -> String {
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
}
