//! System variables: a flat table of every element, found by its full path.
//!
//! `$UTOOL` and `$GROUP[1].$UTOOL` are one variable. The values that mean something to the arm are read from here by
//! [`SystemVariables::integer`] and its sisters at the moment they are used, never copied.

pub mod codes;
mod table;

use std::collections::{BTreeMap, BTreeSet};

use crate::fidelity::ControllerGeneration;
use karel::{Position, Status, Step, SysPath, SysValue, Text, Value};

/// VARS-032: the value is outside of the variable's range.
///
/// ASSUMPTION: the number is the one that other programs test for "too big".
pub const VARS_RANGE: Status = Status::new(16, 32);
/// VARS-041: the variable cannot be written.
///
/// ASSUMPTION: the meaning of the number is guessed.
pub const VARS_READ_ONLY: Status = Status::new(16, 41);

/// What a variable may hold.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Kind {
    Integer { min: i32, max: i32 },
    Real { above: f32, max: f32 },
    Boolean,
    Text { max: usize },
    Position,
}

/// Who gives a variable its value.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Source {
    /// Programs.
    Stored,
    /// The controller, at each reading.
    Live(Live),
}

/// Variables that follow the state of the controller and cannot be written.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Live {
    /// What the arm consumes, kW.
    Power,
    /// Milliseconds since power-on, wrapping.
    FastClock,
    /// Whether the arm moves.
    RobotMoves,
    /// Bits of what keeps the arm from moving.
    SafetyStatus,
    /// Whether the servos are on.
    ServoReady,
}

#[derive(Clone, Debug)]
struct Variable {
    kind: Kind,
    source: Source,
    value: Option<Value>,
}

/// Every system variable this controller knows.
#[derive(Debug)]
pub struct SystemVariables {
    variables: BTreeMap<String, Variable>,
    /// The paths with their subscripts taken out, to tell a bad subscript from an unknown name.
    shapes: BTreeSet<String>,
}

/// What was found under a path.
#[derive(Clone, Debug, PartialEq)]
pub enum Reading {
    /// A stored value.
    Value(Value),
    /// Ask the controller.
    Live(Live),
}

impl SystemVariables {
    /// The variables with the values of power-on.
    #[must_use]
    pub fn new() -> Self {
        Self::of(ControllerGeneration::Any)
    }

    /// The same, of a controller of this generation.
    #[must_use]
    pub fn of(generation: ControllerGeneration) -> Self {
        let variables = table::power_on(generation);
        let shapes = variables.keys().map(|path| shape_of(path)).collect();
        Self { variables, shapes }
    }

    /// The paths of all variables, in order.
    pub fn paths(&self) -> impl Iterator<Item = &str> {
        self.variables.keys().map(String::as_str)
    }

    /// Reads a whole variable or array element.
    ///
    /// # Errors
    /// An unknown name, a bad subscript, or a variable without a value.
    pub fn get(&self, path: &SysPath) -> Result<Reading, Status> {
        let variable = self.find(path)?;
        match variable.source {
            Source::Live(live) => Ok(Reading::Live(live)),
            Source::Stored => variable
                .value
                .clone()
                .map(Reading::Value)
                .ok_or(Status::INTP_UNINIT),
        }
    }

    /// Stores a whole variable or array element. `Uninit` takes its value away.
    ///
    /// # Errors
    /// An unknown name, a bad subscript, a wrong type, a value out of range, or a variable that cannot be written.
    pub fn set(&mut self, path: &SysPath, value: SysValue) -> Result<(), Status> {
        let kind = match self.find(path)? {
            Variable {
                source: Source::Live(_),
                ..
            } => return Err(VARS_READ_ONLY),
            Variable { kind, .. } => *kind,
        };
        let value = match value {
            SysValue::Uninit => None,
            SysValue::Value(value) => Some(kind.check(value)?),
        };
        if let Some(variable) = self.variables.get_mut(&canonical(path)) {
            variable.value = value;
        }
        Ok(())
    }

    /// An INTEGER variable by its canonical path.
    ///
    /// # Errors
    /// It has no value.
    pub fn integer(&self, path: &str) -> Result<i32, Status> {
        if let Value::Integer(value) = self.value(path)? {
            Ok(*value)
        } else {
            Err(Status::VARS_TYPE)
        }
    }

    /// A STRING variable by its canonical path.
    ///
    /// # Errors
    /// It has no value.
    pub fn text(&self, path: &str) -> Result<String, Status> {
        if let Value::String(value) = self.value(path)? {
            Ok(value.to_string_lossless())
        } else {
            Err(Status::VARS_TYPE)
        }
    }

    /// A REAL variable by its canonical path.
    ///
    /// # Errors
    /// It has no value.
    pub fn real(&self, path: &str) -> Result<f32, Status> {
        if let Value::Real(value) = self.value(path)? {
            Ok(*value)
        } else {
            Err(Status::VARS_TYPE)
        }
    }

    /// A POSITION variable by its canonical path.
    ///
    /// # Errors
    /// It has no value.
    pub fn position(&self, path: &str) -> Result<Position, Status> {
        if let Value::Position(value) = self.value(path)? {
            Ok(*value)
        } else {
            Err(Status::VARS_TYPE)
        }
    }

    fn value(&self, path: &str) -> Result<&Value, Status> {
        let variable = self.variables.get(path).ok_or(Status::VARS_UNKNOWN)?;
        variable.value.as_ref().ok_or(Status::INTP_UNINIT)
    }

    fn find(&self, path: &SysPath) -> Result<&Variable, Status> {
        let key = canonical(path);
        self.variables.get(&key).ok_or_else(|| {
            let shape = shape_of(&key);
            let shape = shape.strip_prefix("$GROUP[].").unwrap_or(&shape);
            if self.shapes.contains(shape) {
                Status::VARS_INDEX
            } else {
                Status::VARS_UNKNOWN
            }
        })
    }
}

impl Default for SystemVariables {
    fn default() -> Self {
        Self::new()
    }
}

impl Kind {
    /// The value as the variable stores it.
    fn check(self, value: Value) -> Result<Value, Status> {
        match (self, value) {
            (Kind::Integer { min, max }, Value::Integer(n)) => {
                if (min..=max).contains(&n) {
                    Ok(Value::Integer(n))
                } else {
                    Err(VARS_RANGE)
                }
            }
            #[expect(
                clippy::cast_precision_loss,
                reason = "KAREL's own INTEGER to REAL conversion"
            )]
            (Kind::Real { above, max }, Value::Integer(n)) => in_range(n as f32, above, max),
            (Kind::Real { above, max }, Value::Real(x)) => in_range(x, above, max),
            (Kind::Boolean, Value::Boolean(b)) => Ok(Value::Boolean(b)),
            (Kind::Text { max }, Value::String(text)) => {
                // A STRING is cut on assignment, as everywhere in KAREL.
                let bytes = text.as_bytes();
                Ok(Value::String(Text::from(bytes.get(..max).unwrap_or(bytes))))
            }
            (Kind::Position, value) => value
                .as_xyzwprext()
                .map(|p| Value::Position(p.into()))
                .ok_or(Status::VARS_TYPE),
            (Kind::Integer { .. } | Kind::Real { .. } | Kind::Boolean | Kind::Text { .. }, _) => {
                Err(Status::VARS_TYPE)
            }
        }
    }
}

fn in_range(x: f32, above: f32, max: f32) -> Result<Value, Status> {
    // NaN fails both comparisons.
    if x > above && x <= max {
        Ok(Value::Real(x))
    } else {
        Err(VARS_RANGE)
    }
}

/// The path under which a variable is stored: the motion environment without its group.
fn canonical(path: &SysPath) -> String {
    let text = path.to_string();
    match path.steps() {
        [Step::Name(group), Step::Index(index), Step::Name(_), ..]
            if group == "$GROUP" && index.as_slice() == [1] =>
        {
            text.strip_prefix("$GROUP[1].")
                .map_or(text.clone(), str::to_owned)
        }
        _ => text,
    }
}

/// `$HOSTS_CFG[3].$STATE` becomes `$HOSTS_CFG[].$STATE`.
fn shape_of(path: &str) -> String {
    let mut shape = String::with_capacity(path.len());
    let mut inside = false;
    for c in path.chars() {
        match c {
            '[' => {
                inside = true;
                shape.push('[');
            }
            ']' => {
                inside = false;
                shape.push(']');
            }
            _ if inside => {}
            _ => shape.push(c),
        }
    }
    shape
}

#[cfg(test)]
mod tests {
    use super::*;

    fn path(text: &str) -> SysPath {
        SysPath::parse(text).unwrap()
    }

    fn set(variables: &mut SystemVariables, name: &str, value: Value) -> Result<(), Status> {
        variables.set(&path(name), SysValue::Value(value))
    }

    #[test]
    fn a_port_is_stored_for_its_tag_only() {
        let mut v = SystemVariables::new();
        set(&mut v, "$HOSTS_CFG[3].$SERVER_PORT", Value::Integer(59_002)).unwrap();
        assert_eq!(v.integer("$HOSTS_CFG[3].$SERVER_PORT"), Ok(59_002));
        assert_ne!(v.integer("$HOSTS_CFG[2].$SERVER_PORT"), Ok(59_002));
    }

    #[test]
    fn unknown_names_bad_subscripts_and_wrong_types_have_statuses_of_their_own() {
        let mut v = SystemVariables::new();
        let one = || Value::Integer(1);
        assert_eq!(set(&mut v, "$NO_SUCH", one()), Err(Status::VARS_UNKNOWN));
        assert_eq!(
            set(&mut v, "$HOSTS_CFG[9].$SERVER_PORT", one()),
            Err(Status::VARS_INDEX)
        );
        assert_eq!(
            set(&mut v, "$MNUFRAME[1,11]", one()),
            Err(Status::VARS_INDEX)
        );
        assert_eq!(set(&mut v, "$DMAURST", one()), Err(Status::VARS_TYPE));
        assert_eq!(
            set(&mut v, "$MOR_GRP[1].$ROB_MOVE", one()),
            Err(VARS_READ_ONLY)
        );
    }

    #[test]
    fn the_override_is_zero_to_a_hundred_percent() {
        let mut v = SystemVariables::new();
        for percent in [0, 25, 100] {
            set(&mut v, "$MCR.$GENOVERRIDE", Value::Integer(percent)).unwrap();
        }
        for percent in [101, -5] {
            let refused = set(&mut v, "$MCR.$GENOVERRIDE", Value::Integer(percent));
            assert_eq!(refused, Err(VARS_RANGE));
        }
        assert_eq!(
            v.integer("$MCR.$GENOVERRIDE"),
            Ok(100),
            "a refusal changes nothing"
        );
    }

    #[test]
    fn the_motion_environment_is_one_with_and_without_its_group() {
        let mut v = SystemVariables::new();
        set(&mut v, "$GROUP[1].$SPEED", Value::Integer(300)).unwrap();
        assert_eq!(v.real("$SPEED"), Ok(300.0));
        let refused = set(&mut v, "$GROUP[2].$SPEED", Value::Integer(300));
        assert_eq!(refused, Err(Status::VARS_INDEX));
    }

    #[test]
    fn speed_is_refused_at_zero_and_above_the_speed_limit() {
        let mut v = SystemVariables::new();
        for speed in [0.0, -1.0, 2000.5, f32::NAN, f32::INFINITY] {
            assert_eq!(
                set(&mut v, "$SPEED", Value::Real(speed)),
                Err(VARS_RANGE),
                "{speed}"
            );
        }
    }

    #[test]
    fn a_variable_can_lose_its_value() {
        let mut v = SystemVariables::new();
        v.set(&path("$UTOOL"), SysValue::Uninit).unwrap();
        assert_eq!(v.get(&path("$UTOOL")), Err(Status::INTP_UNINIT));
    }
}
