//! What a run of `cellctl` leaves behind.

use std::process::ExitCode;

use serde::Serialize;

/// The meaning of the exit code.
#[derive(Clone, Copy, Debug, Eq, PartialEq)]
pub(crate) enum Exit {
    /// 0.
    Done,
    /// 1: the robot, or the server's checks, said no.
    Refused,
    /// 2: the command line makes no sense.
    Usage,
    /// 3: no answer, or none that tells.
    Link,
}

impl From<Exit> for ExitCode {
    fn from(exit: Exit) -> Self {
        match exit {
            Exit::Done => Self::SUCCESS,
            Exit::Refused => Self::from(1),
            Exit::Usage => Self::from(2),
            Exit::Link => Self::from(3),
        }
    }
}

/// Text for both streams, and the exit code.
#[derive(Debug)]
pub(crate) struct Report {
    pub(crate) stdout: String,
    pub(crate) stderr: String,
    pub(crate) exit: Exit,
}

impl Report {
    /// An answer for people.
    pub(crate) fn text(exit: Exit, text: &str) -> Self {
        Self {
            stdout: lines(text),
            stderr: String::new(),
            exit,
        }
    }

    /// What went wrong, for people.
    pub(crate) fn error(exit: Exit, text: &str) -> Self {
        Self {
            stdout: String::new(),
            stderr: lines(text),
            exit,
        }
    }

    /// One document for machines, whether it tells of success or of failure.
    pub(crate) fn json<T: Serialize>(exit: Exit, body: &T) -> Self {
        match serde_json::to_string_pretty(body) {
            Ok(text) => Self {
                stdout: text + "\n",
                stderr: String::new(),
                exit,
            },
            Err(error) => Self::error(
                Exit::Link,
                &format!("the answer cannot be written: {error}"),
            ),
        }
    }
}

/// `text` with one line end at its end, and nothing in it that moves a terminal's cursor: some of it was written by a
/// controller, or by whoever answers at the server's address.
fn lines(text: &str) -> String {
    let mut clean: String = text
        .trim_end()
        .chars()
        .map(|c| if c.is_control() && c != '\n' { ' ' } else { c })
        .collect();
    clean.push('\n');
    clean
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn words_from_outside_move_no_cursor() {
        assert_eq!(lines("a\u{1b}[2J\r\tb\n\n"), "a [2J  b\n");
    }
}
