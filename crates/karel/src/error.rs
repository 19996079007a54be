//! The error that ends a task.

use std::{fmt, sync::Arc};

use crate::status::Status;

/// One entry of a call stack, innermost first.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct CallSite {
    /// Program that owns the routine, upper case.
    pub program: Arc<str>,
    /// Routine, upper case; the program's name for its main body.
    pub routine: Arc<str>,
    /// Physical source line, comments counted, from 1.
    pub line: u32,
}

/// A run-time error: the status, where it happened, and the call stack at that moment.
///
/// `Display` writes one line as on the pendant: `INTP-311 (PROG, 204) Uninitialized data is used`.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct RuntimeError {
    /// Facility and number.
    pub status: Status,
    /// What happened, without the place.
    pub message: String,
    /// Program of the routine that failed, upper case.
    pub program: Arc<str>,
    /// Physical source line, comments counted, from 1.
    pub line: u32,
    /// The call stack, innermost first; its first entry is the place of the error.
    pub calls: Vec<CallSite>,
}

impl fmt::Display for RuntimeError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(
            f,
            "{} ({}, {}) {}",
            self.status, self.program, self.line, self.message
        )
    }
}

impl std::error::Error for RuntimeError {}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_text_is_the_pendants() {
        let error = RuntimeError {
            status: Status::INTP_UNINIT,
            message: "Uninitialized data is used".to_owned(),
            program: "MAPPDK_SERVER".into(),
            line: 204,
            calls: Vec::new(),
        };
        assert_eq!(
            error.to_string(),
            "INTP-311 (MAPPDK_SERVER, 204) Uninitialized data is used"
        );
    }
}
