//! The set-up file as text: TOML or JSON, read strictly and written whole.
//!
//! Both forms hold the same keys. Unknown and doubled keys are refused; so is a list where an object belongs, which
//! serde would take for its values in order. What does not fit is told of entry by entry, not only the first.

use api::Violation;
use api::setup::SetupFile;
use serde::Serialize;
use serde::de::DeserializeOwned;
use serde_json::Value;
use thiserror::Error;

use super::faults::{Faults, SetupErrors};
use crate::extract::{item_of, message_of};

/// The form of a set-up.
#[derive(Clone, Copy, Debug, Eq, PartialEq)]
pub(crate) enum Form {
    Json,
    Toml,
}

/// Why a text is no set-up.
#[derive(Clone, Debug, Error, PartialEq)]
pub(crate) enum DocumentError {
    /// Not TOML or not JSON.
    #[error("{message} (line {line}, column {column})")]
    Syntax {
        form: Form,
        message: String,
        line: usize,
        column: usize,
    },
    /// Keys or types do not fit.
    #[error(transparent)]
    Shape(#[from] SetupErrors),
}

/// Reads a set-up.
///
/// # Errors
/// Where it is no TOML or JSON; or every entry that does not fit.
pub(crate) fn parse_setup(text: &[u8], form: Form) -> Result<SetupFile, DocumentError> {
    let value = tree(text, form)?;
    let read = match form {
        Form::Json => serde_json::from_slice(text).map_err(|error| message_of(&error)),
        Form::Toml => str::from_utf8(text)
            .map_err(|error| error.to_string())
            .and_then(|text| toml::from_str(text).map_err(|error| error.message().to_owned())),
    };
    let mut faults = Faults::default();
    match read {
        Ok(setup) => {
            only_lists_are_lists(&mut faults, "", &value, &setup);
            match faults.into_errors() {
                None => Ok(setup),
                Some(errors) => Err(errors.into()),
            }
        }
        Err(first) => {
            explain(&mut faults, &value);
            if faults.is_empty() {
                // Such as a key that stands twice: the tree has no trace of it.
                faults.add("body", first);
            }
            match faults.into_errors() {
                Some(errors) => Err(errors.into()),
                None => unreachable!("a fault was added"),
            }
        }
    }
}

/// Reads one part of a set-up, as JSON.
///
/// # Errors
/// As [`parse_setup`].
pub(crate) fn parse_part<T: DeserializeOwned + Serialize>(text: &[u8]) -> Result<T, DocumentError> {
    let value = tree(text, Form::Json)?;
    let mut faults = Faults::default();
    let mut json = serde_json::Deserializer::from_slice(text);
    match serde_path_to_error::deserialize::<_, T>(&mut json) {
        Ok(part) => {
            only_lists_are_lists(&mut faults, "", &value, &part);
            match faults.into_errors() {
                None => Ok(part),
                Some(errors) => Err(errors.into()),
            }
        }
        Err(error) => {
            let message = message_of(error.inner());
            let item = item_of(&error.path().to_string(), &message);
            faults.push(Violation {
                item,
                message,
                ..Violation::default()
            });
            match faults.into_errors() {
                Some(errors) => Err(errors.into()),
                None => unreachable!("a fault was added"),
            }
        }
    }
}

/// Writes a set-up. What is written reads back as the same.
pub(crate) fn write_setup(setup: &SetupFile, form: Form) -> String {
    // A set-up is made of texts and finite numbers, which both forms can say.
    match form {
        Form::Json => serde_json::to_string_pretty(setup).unwrap_or_default(),
        Form::Toml => toml::to_string(setup).unwrap_or_default(),
    }
}

/// The text as a tree of values.
fn tree(text: &[u8], form: Form) -> Result<Value, DocumentError> {
    match form {
        Form::Json => serde_json::from_slice(text).map_err(|error| DocumentError::Syntax {
            form,
            message: message_of(&error),
            line: error.line(),
            column: error.column(),
        }),
        Form::Toml => {
            let at = |offset: usize, message: String| {
                let before = text.get(..offset).unwrap_or(text);
                let line_start = before.iter().rposition(|byte| *byte == b'\n');
                DocumentError::Syntax {
                    form,
                    message,
                    line: before.split(|byte| *byte == b'\n').count(),
                    column: offset - line_start.map_or(0, |newline| newline + 1) + 1,
                }
            };
            let utf8 = str::from_utf8(text)
                .map_err(|error| at(error.valid_up_to(), "the text is not UTF-8".to_owned()))?;
            let table: toml::Table = toml::from_str(utf8).map_err(|error| {
                let offset = error.span().map_or(0, |span| span.start);
                at(offset, error.message().to_owned())
            })?;
            Ok(json_of(toml::Value::Table(table)))
        }
    }
}

/// A tree of TOML as one of JSON, for its form: numbers that JSON cannot say are read from the text itself.
fn json_of(value: toml::Value) -> Value {
    match value {
        toml::Value::String(text) => Value::String(text),
        toml::Value::Integer(number) => number.into(),
        toml::Value::Float(number) if number.is_finite() => number.into(),
        toml::Value::Float(_) => Value::from(0.0),
        toml::Value::Boolean(value) => Value::Bool(value),
        toml::Value::Datetime(time) => Value::String(time.to_string()),
        toml::Value::Array(list) => list.into_iter().map(json_of).collect(),
        toml::Value::Table(table) => table
            .into_iter()
            .map(|(key, value)| (key, json_of(value)))
            .collect(),
    }
}

/// Tells of every list that was read as an object: where the text has a list, what was read has one, too.
fn only_lists_are_lists<T: Serialize>(faults: &mut Faults, path: &str, text: &Value, read: &T) {
    let read = serde_json::to_value(read).unwrap_or_default();
    compare(faults, path, text, &read);
}

fn compare(faults: &mut Faults, path: &str, text: &Value, read: &Value) {
    match (text, read) {
        (Value::Array(_), Value::Object(_)) => {
            let path = if path.is_empty() { "body" } else { path };
            faults.add(
                path,
                "invalid type: array, expected an object with named values",
            );
        }
        (Value::Array(text), Value::Array(read)) => {
            for (index, (text, read)) in text.iter().zip(read).enumerate() {
                compare(faults, &format!("{path}[{index}]"), text, read);
            }
        }
        (Value::Object(text), Value::Object(read)) => {
            for (key, text) in text {
                if let Some(read) = read.get(key) {
                    let dot = if path.is_empty() { "" } else { "." };
                    compare(faults, &format!("{path}{dot}{key}"), text, read);
                }
            }
        }
        _ => {}
    }
}

/// Reads the sections one by one, and the lists entry by entry, to tell of every one that does not fit.
fn explain(faults: &mut Faults, value: &Value) {
    use api::setup as part;
    let Value::Object(sections) = value else {
        faults.add("body", "is no object with named values");
        return;
    };
    if !sections.contains_key("format") {
        faults.add("format", "is missing; it is 1");
    }
    for (key, value) in sections {
        match key.as_str() {
            "format" => read::<u32>(faults, key, value),
            "name" => read::<Option<String>>(faults, key, value),
            "timers" => read::<part::TimersBody>(faults, key, value),
            "arms" => each::<part::ArmSetup>(faults, key, value),
            "tools" => each::<part::ToolSetup>(faults, key, value),
            "zones" => each::<part::ZoneBody>(faults, key, value),
            "stations" => each::<part::StationBody>(faults, key, value),
            "places" => each::<part::PlaceBody>(faults, key, value),
            "taught_poses" => each::<part::TaughtPoseBody>(faults, key, value),
            "destinations" => each::<part::DestinationBody>(faults, key, value),
            "mobile_robots" => each::<part::MobileRobotSetup>(faults, key, value),
            "routes" => each::<part::RouteBody>(faults, key, value),
            "loads" => each::<part::LoadBody>(faults, key, value),
            "triggers" => each::<part::TriggerBody>(faults, key, value),
            _ => faults.add(
                crate::state::shown(key),
                "is no section of a set-up; there are format, name, timers, arms, tools, zones, stations, places, \
                 taught_poses, destinations, mobile_robots, routes, loads, triggers",
            ),
        }
    }
}

fn each<T: DeserializeOwned>(faults: &mut Faults, key: &str, value: &Value) {
    let Value::Array(list) = value else {
        faults.add(key, "is no list");
        return;
    };
    for (index, entry) in list.iter().enumerate() {
        read::<T>(faults, &format!("{key}[{index}]"), entry);
    }
}

fn read<T: DeserializeOwned>(faults: &mut Faults, path: &str, value: &Value) {
    if let Err(error) = serde_path_to_error::deserialize::<_, T>(value) {
        let message = message_of(error.inner());
        let inside = item_of(&error.path().to_string(), &message);
        let item = match inside.as_str() {
            "body" => path.to_owned(),
            inside if inside.starts_with('[') => format!("{path}{inside}"),
            inside => format!("{path}.{inside}"),
        };
        faults.add(item, message);
    }
}
