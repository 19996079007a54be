//! Everything wrong with a set-up, collected before anything is said.

use std::fmt;

use api::Violation;

/// Everything wrong with a set-up: each with its path in the file, the value and what is allowed.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub struct SetupErrors(Vec<Violation>);

impl SetupErrors {
    /// Each thing wrong, in the order of the file's sections.
    #[must_use]
    pub fn violations(&self) -> &[Violation] {
        &self.0
    }

    /// The violations themselves.
    pub(crate) fn into_violations(self) -> Vec<Violation> {
        self.0
    }
}

/// One a line.
impl fmt::Display for SetupErrors {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        for (index, violation) in self.0.iter().enumerate() {
            let end = if index == 0 { "" } else { "\n" };
            write!(f, "{end}{}: {}", violation.item, violation.message)?;
        }
        Ok(())
    }
}

/// The most faults that are told of: a file in the wrong unit has one in every line.
const MOST: usize = 100;

/// What is wrong so far.
#[derive(Debug, Default)]
pub(crate) struct Faults {
    found: Vec<Violation>,
    more: usize,
}

impl Faults {
    /// Adds what is wrong with an item.
    pub(crate) fn add(&mut self, item: impl Into<String>, message: impl Into<String>) {
        self.push(Violation {
            item: item.into(),
            message: message.into(),
            ..Violation::default()
        });
    }

    pub(crate) fn push(&mut self, violation: Violation) {
        if self.found.len() < MOST {
            self.found.push(violation);
        } else {
            self.more += 1;
        }
    }

    /// A number of a range, ends included. NaN is in no range.
    pub(crate) fn number(
        &mut self,
        item: impl Into<String>,
        value: f64,
        (min, max): (f64, f64),
    ) -> Option<f64> {
        if (min..=max).contains(&value) {
            return Some(value);
        }
        self.push(Violation {
            item: item.into(),
            message: format!("is {}; it must be from {min} to {max}", shown(value)),
            value: value.is_finite().then_some(value),
            min: Some(min),
            max: Some(max),
        });
        None
    }

    /// A list that is not longer than `max`.
    pub(crate) fn count(&mut self, item: &str, len: usize, max: usize) {
        if len > max {
            self.add(item, format!("has {len} entries; at most {max} are taken"));
        }
    }

    /// Whether nothing is wrong so far.
    pub(crate) fn is_empty(&self) -> bool {
        self.found.is_empty()
    }

    /// The faults, if there are any.
    pub(crate) fn into_errors(mut self) -> Option<SetupErrors> {
        if self.found.is_empty() {
            return None;
        }
        if self.more > 0 {
            let more = self.more;
            self.found.push(Violation {
                item: "…".to_owned(),
                message: format!("and {more} more"),
                ..Violation::default()
            });
        }
        Some(SetupErrors(self.found))
    }
}

/// A number from outside in a message: no row of three hundred digits.
fn shown(value: f64) -> String {
    if value.abs() < 1e15 {
        value.to_string()
    } else {
        format!("{value:e}")
    }
}
