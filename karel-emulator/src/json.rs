//! JSON and queries from outside: what does not fit is named with its value, and with what would fit.

use serde::de::DeserializeOwned;
use serde_json::Value;
use serde_path_to_error::{Path, Segment};

/// Longest value that is repeated, in characters.
const SHOWN: usize = 60;

/// Why a text was not read.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum JsonError {
    /// It is no JSON.
    #[error("{0}")]
    Syntax(String),
    /// It is JSON and says something else.
    #[error("{0}")]
    Shape(String),
}

/// Reads a value; `whole` is what the text is called, such as "the body".
///
/// # Errors
/// One sentence that names the item, its value and what it can be.
pub fn from_json<T: DeserializeOwned>(text: &[u8], whole: &str) -> Result<T, JsonError> {
    let mut json = serde_json::Deserializer::from_slice(text);
    let syntax =
        |error: &serde_json::Error| JsonError::Syntax(format!("{whole} is no JSON: {error}"));
    let value =
        serde_path_to_error::deserialize(&mut json).map_err(
            |error| match serde_json::from_slice::<Value>(text) {
                Ok(given) => JsonError::Shape(misfit::<T>(given, whole, &error)),
                Err(_) => syntax(error.inner()),
            },
        )?;
    json.end().map_err(|error| syntax(&error))?;
    Ok(value)
}

/// What a query says wrong; `error` is what its reader says: a key, and what is the matter with it.
pub(crate) fn of_query(query: &str, error: &str) -> String {
    let head = "Failed to deserialize query string: ";
    let error = error.strip_prefix(head).unwrap_or(error);
    let (item, message) = error.split_once(": ").unwrap_or(("the query", error));
    let mut pairs = query.split('&').filter_map(|pair| pair.split_once('='));
    let given = pairs.find(|(key, _)| *key == item);
    let given = given.map(|(_, value)| format!("{value:?}"));
    sentence(item, given.as_deref(), message, "the query")
}

/// What of a JSON value does not fit.
fn misfit<T: DeserializeOwned>(
    mut given: Value,
    whole: &str,
    error: &serde_path_to_error::Error<serde_json::Error>,
) -> String {
    let inner = error.inner();
    let message = inner.to_string();
    let place = format!(" at line {} column {}", inner.line(), inner.column());
    let mut message = message.strip_suffix(&place).unwrap_or(&message).to_owned();
    let path = error.path().to_string();
    let item = if path == "." { whole } else { &path };
    let Some(there) = at(&mut given, error.path()) else {
        return sentence(item, None, &message, whole);
    };
    let shown = there.to_string();
    if message == "expected value" {
        // Not the name of a choice: what another name is told says which there are.
        *there = Value::String(String::new());
        if let Err(other) = serde_path_to_error::deserialize::<_, T>(given) {
            message = other.inner().to_string();
        }
    }
    sentence(item, Some(&shown), &message, whole)
}

/// The value at a path. The name of a variant alone is a text.
fn at<'a>(value: &'a mut Value, path: &Path) -> Option<&'a mut Value> {
    path.iter().try_fold(value, |value, segment| match segment {
        Segment::Seq { index } => value.get_mut(index),
        Segment::Map { key } => value.get_mut(key),
        Segment::Enum { .. } if value.is_string() => Some(value),
        Segment::Enum { variant } => value.get_mut(variant),
        Segment::Unknown => None,
    })
}

/// The words of serde about an item, in ours.
fn sentence(item: &str, given: Option<&str>, message: &str, whole: &str) -> String {
    if let Some(rest) = message.strip_prefix("unknown variant `")
        && let Some((found, known)) = rest.split_once("`, ")
    {
        let found = match given {
            Some(given) if found.is_empty() => short(given),
            Some(_) | None => format!("{:?}", short(found)),
        };
        return format!("{item} is {found}, it must be {}", known_ones(known));
    }
    if let Some(rest) = message.strip_prefix("unknown field `")
        && let Some((found, known)) = rest.split_once("`, ")
    {
        let item = if item == whole { found } else { item };
        return format!(
            "{} is no key here, there is {}",
            short(item),
            known_ones(known)
        );
    }
    if let Some(rest) = message.strip_prefix("missing field `") {
        let field = rest.trim_end_matches('`');
        return if item == whole {
            format!("{field} is missing")
        } else {
            format!("{item}.{field} is missing")
        };
    }
    let wrong = ["invalid type: ", "invalid value: ", "invalid length "];
    let expected = match message {
        "invalid type: unit variant, expected struct variant" => Some("an object with its keys"),
        "invalid digit found in string" | "cannot parse integer from empty string" => {
            Some("a whole number, 0 or more")
        }
        "invalid float literal" => Some("a number"),
        "number too large to fit in target type" => Some("a smaller number"),
        "provided string was not `true` or `false`" => Some("true or false"),
        other if wrong.iter().any(|start| other.starts_with(start)) => other
            .rsplit_once(", expected ")
            .map(|(_, expected)| expected),
        // What an untagged choice expects.
        other => other.strip_prefix("it must be "),
    };
    match (expected, given) {
        (Some(expected), Some(given)) => {
            format!("{item} is {}, it must be {}", short(given), kind(expected))
        }
        (Some(expected), None) => format!("{item} must be {}", kind(expected)),
        (None, _) => format!("{item}: {message}"),
    }
}

/// A type as people say it.
fn kind(expected: &str) -> String {
    let words = match expected {
        "u64" | "usize" | "u32" => "a whole number, 0 or more",
        "u16" => "a whole number, 0 to 65535",
        "u8" => "a whole number, 0 to 255",
        "i32" => "a whole number, -2147483648 to 2147483647",
        "f32" | "f64" => "a number",
        "a boolean" => "true or false",
        "a string" => "a text",
        "a sequence" => "a list",
        "unit" => "its name alone, without keys",
        other if other.starts_with("struct") => "an object with its keys",
        other => other,
    };
    words.to_owned()
}

/// `` one of `a`, `b`, `c` `` as "a, b or c".
fn known_ones(known: &str) -> String {
    let names: Vec<&str> = known.split('`').skip(1).step_by(2).collect();
    match names.as_slice() {
        [] => "none".to_owned(),
        [only] => (*only).to_owned(),
        [first @ .., last] => format!("{} or {last}", first.join(", ")),
    }
}

fn short(text: &str) -> String {
    if text.chars().count() <= SHOWN {
        return text.to_owned();
    }
    let start: String = text.chars().take(SHOWN).collect();
    format!("{start}..")
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;
    use crate::faults::FaultBody;

    fn refused(text: &str) -> String {
        from_json::<FaultBody>(text.as_bytes(), "the body")
            .unwrap_err()
            .to_string()
    }

    #[test]
    fn what_does_not_fit_is_named_with_its_value_and_what_would_fit() {
        for (text, wanted) in [
            (
                r#"{"fault": {"delai": {"ms": 5}}}"#,
                "fault is \"delai\", it must be drop, delay, split,",
            ),
            (
                r#"{"fault": {"delay": {"mss": 5}}}"#,
                "fault.delay.mss is no key here, there is ms or jitter_ms",
            ),
            (
                r#"{"fault": {"delay": {"ms": "x"}}}"#,
                "fault.delay.ms is \"x\", it must be a whole number, 0 or more",
            ),
            (
                r#"{"fault": {"delay": {"ms": -1}}}"#,
                "fault.delay.ms is -1, it must be a whole number, 0 or more",
            ),
            (r#"{"fault": {"delay": {}}}"#, "fault.delay.ms is missing"),
            (
                r#"{"fault": "delay"}"#,
                "fault.delay is \"delay\", it must be an object with its keys",
            ),
            (
                r#"{"fault": {"drop": {}}}"#,
                "fault.drop is {}, it must be its name alone, without keys",
            ),
            (
                r#"{"fault": "drop", "scope": {"direction": "up"}}"#,
                "scope.direction is \"up\", it must be in, out or both",
            ),
            (
                r#"{"fault": "drop", "scop": {}}"#,
                "scop is no key here, there is fault, scope, times or for_ms",
            ),
            (
                r#"{"fault": "drop", "scope": {"port": 70000}}"#,
                "scope.port is 70000, it must be a whole number, 0 to 65535",
            ),
            (
                r#"{"fault": "drop", "scope": {"direction": 5}}"#,
                "scope.direction is 5, it must be in, out or both",
            ),
            ("{}", "fault is missing"),
            ("7", "the body is 7, it must be an object with its keys"),
            ("[1", "the body is no JSON: "),
            (
                r#"{"fault": "drop"} 5"#,
                "the body is no JSON: trailing characters",
            ),
        ] {
            let found = refused(text);
            assert!(found.starts_with(wanted), "{text}: {found}");
        }
    }

    #[test]
    fn a_long_value_is_cut() {
        let found = refused(&format!(r#"{{"fault": "{}"}}"#, "x".repeat(1000)));
        assert!(found.len() < 400, "{found}");
    }

    proptest! {
        #[test]
        fn whatever_comes_is_a_sentence(text in ".{0,60}", key in "[a-z_.{}:`]{0,9}") {
            let _read = from_json::<FaultBody>(text.as_bytes(), "the body");
            let text = format!(r#"{{"fault": {{{key:?}: {text:?}}}}}"#);
            if let Err(error) = from_json::<FaultBody>(text.as_bytes(), "the body") {
                prop_assert!(!error.to_string().is_empty());
            }
            let _said = of_query(&text, &key);
        }
    }
}
