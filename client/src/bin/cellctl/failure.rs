//! What can go wrong, in words and as an exit code.

use std::error::Error;
use std::fmt::Write;

use api::{Outcome, Problem, ProblemCode, Violation};
use client::ClientError;
use serde::Serialize;

use crate::report::{Exit, Report};

/// Why a subcommand was not carried out.
#[derive(Debug, thiserror::Error)]
pub(crate) enum Failure {
    /// The server could not be asked, or said no.
    #[error(transparent)]
    Client(#[from] ClientError),
    /// The command line leaves open which robot or cell is meant.
    #[error("{why}; say which one")]
    Which { why: String, all: Vec<String> },
    /// The command line asks for what cannot be.
    #[error("{0}")]
    Usage(String),
    /// A question about an arm or a route that has no answer.
    #[error(transparent)]
    Refusal(#[from] robotics::Refusal),
    /// What was asked for cannot be drawn.
    #[error("the drawing: {0}")]
    Plot(#[from] plots::PlotError),
    /// A number that no job of the cell has.
    #[error("the cell has no job number {number}")]
    NoJob { number: u64 },
    /// A relative move without a place to count from.
    #[error(
        "the server knows no accepted target to count from: none yet, or a motion in doubt since"
    )]
    NoAcceptedTarget,
    /// Control of the cell ended while it was to be kept.
    #[error("control of the cell was lost: {0}")]
    ControlLost(String),
    /// The arm did not come to rest in the time allowed.
    #[error("still not at rest after {seconds} s: {last}")]
    NotStill { seconds: f64, last: String },
}

/// A failure other than a problem, for machines.
#[derive(Debug, Serialize)]
struct Document {
    title: String,
    detail: String,
    outcome: Outcome,
    #[serde(skip_serializing_if = "Vec::is_empty")]
    violations: Vec<Violation>,
    #[serde(skip_serializing_if = "Option::is_none")]
    status: Option<u16>,
    #[serde(skip_serializing_if = "Option::is_none")]
    request_id: Option<String>,
}

impl Failure {
    /// The failure for people, or for machines.
    pub(crate) fn report(&self, json: bool) -> Report {
        let exit = self.exit();
        if !json {
            return Report::error(exit, &self.text());
        }
        match self {
            Self::Client(ClientError::Problem(problem)) => Report::json(exit, problem),
            Self::Client(error) => {
                Report::json(exit, &self.document(error.status(), error.request_id()))
            }
            Self::Which { .. }
            | Self::Usage(_)
            | Self::Refusal(_)
            | Self::Plot(_)
            | Self::NoJob { .. }
            | Self::NoAcceptedTarget
            | Self::ControlLost(_)
            | Self::NotStill { .. } => Report::json(exit, &self.document(None, None)),
        }
    }

    fn exit(&self) -> Exit {
        match self {
            Self::Client(error) => exit_of(error),
            Self::Which { .. } | Self::Usage(_) => Exit::Usage,
            Self::NoJob { .. }
            | Self::NoAcceptedTarget
            | Self::ControlLost(_)
            | Self::Refusal(_)
            | Self::Plot(_) => Exit::Refused,
            Self::NotStill { .. } => Exit::Link,
        }
    }

    fn outcome(&self) -> Outcome {
        match self {
            Self::Client(error) => error.outcome(),
            Self::Which { .. } | Self::Usage(_) | Self::NoJob { .. } | Self::NoAcceptedTarget => {
                Outcome::NotSent
            }
            Self::ControlLost(_) | Self::NotStill { .. } | Self::Refusal(_) | Self::Plot(_) => {
                Outcome::None
            }
        }
    }

    fn document(&self, status: Option<u16>, request_id: Option<&str>) -> Document {
        let title = match self.exit() {
            Exit::Refused => "Refused",
            Exit::Usage => "Usage",
            Exit::Link | Exit::Done => "Link",
        };
        Document {
            title: title.to_owned(),
            detail: self.sentence(),
            outcome: self.outcome(),
            violations: self.violations(),
            status,
            request_id: request_id.map(str::to_owned),
        }
    }

    /// What is wrong with which item, for machines.
    fn violations(&self) -> Vec<Violation> {
        match self {
            Self::Refusal(refusal) if !refusal.path.is_empty() => vec![Violation {
                item: refusal.path.clone(),
                message: refusal.detail.clone(),
                value: refusal.value,
                min: refusal.min,
                max: refusal.max,
            }],
            Self::Refusal(_)
            | Self::Client(_)
            | Self::Which { .. }
            | Self::Usage(_)
            | Self::Plot(_)
            | Self::NoJob { .. }
            | Self::NoAcceptedTarget
            | Self::ControlLost(_)
            | Self::NotStill { .. } => Vec::new(),
        }
    }

    /// The failure and its first cause; the layers of the transport between them tell nothing more.
    fn sentence(&self) -> String {
        let causes = std::iter::successors(self.source(), |&error| error.source());
        match causes.last() {
            Some(cause) => with_cause(self.to_string(), &cause.to_string()),
            None => self.to_string(),
        }
    }

    fn text(&self) -> String {
        let mut text = match self {
            Self::Client(ClientError::Problem(problem)) => problem_text(problem),
            Self::Client(ClientError::Unreachable { .. }) => {
                format!(
                    "{}\nHint: is it running there? --server and --emulator name other addresses",
                    self.sentence()
                )
            }
            Self::Client(_)
            | Self::Usage(_)
            | Self::Refusal(_)
            | Self::Plot(_)
            | Self::ControlLost(_)
            | Self::NotStill { .. } => self.sentence(),
            Self::Which { all, .. } => list(&self.sentence(), all),
            Self::NoJob { .. } => format!("{}\nHint: {JOBS}", self.sentence()),
            Self::NoAcceptedTarget => {
                format!(
                    "{}\nHint: move to an absolute pose, or home, first",
                    self.sentence()
                )
            }
        };
        match self.outcome() {
            Outcome::Unknown => text.push_str(
                "\nThe outcome is UNKNOWN: the robot may have moved, or may be moving. \
                 Look at it before sending anything else.",
            ),
            Outcome::NotSent | Outcome::Rejected | Outcome::None => {}
        }
        if let Self::Client(error) = self
            && let Some(id) = error.request_id()
        {
            let _ = write!(text, "\nRequest {id}");
        }
        format!("cellctl: {text}")
    }
}

/// 4xx is a refusal, anything else a matter of the link; where the outcome is unknown nobody can speak of a refusal.
fn exit_of(error: &ClientError) -> Exit {
    let refused = match error {
        ClientError::Problem(_) | ClientError::Refused { .. } | ClientError::Invalid { .. } => {
            error
                .status()
                .is_some_and(|status| (400..500).contains(&status))
        }
        ClientError::BaseUrl { .. } | ClientError::RequestId { .. } | ClientError::Token => {
            return Exit::Usage;
        }
        ClientError::Unreachable { .. }
        | ClientError::Timeout { .. }
        | ClientError::Interrupted { .. }
        | ClientError::Protocol { .. } => false,
    };
    if refused && error.outcome() != Outcome::Unknown {
        Exit::Refused
    } else {
        Exit::Link
    }
}

fn problem_text(problem: &Problem) -> String {
    let mut text = format!("{}: {}", problem.title, problem.detail);
    for violation in &problem.violations {
        let line = violation_text(violation, &problem.detail);
        // An item alone, which the sentence names, tells nothing more.
        if !(line == violation.item && problem.detail.contains(&line)) {
            let _ = write!(text, "\n  {line}");
        }
    }
    if let Some(words) = &problem.controller_text
        && !problem.detail.contains(words.as_str())
    {
        let _ = write!(text, "\nThe controller said: {words}");
    }
    if let Some(motion) = problem.motion {
        let _ = write!(text, "\nMotion {motion}");
    }
    if let Some(hint) = problem.hint.as_deref().or_else(|| hint_for(problem)) {
        let _ = write!(text, "\nHint: {hint}");
    }
    text
}

const JOBS: &str = "`cellctl job list` shows the jobs";

/// What to do next at a command line, where the server, which does not know of one, has no hint.
fn hint_for(problem: &Problem) -> Option<&'static str> {
    let detail = &problem.detail;
    let item = problem.violations.first().map(|first| first.item.as_str());
    match (problem.code, item) {
        (ProblemCode::Validation, Some("speed_mm_s")) if detail.contains("`speed_percent`") => {
            Some("say how fast with --percent, for example --percent 20")
        }
        (ProblemCode::Validation, Some("speed_percent")) if detail.contains("mm/s") => {
            Some("say how fast with --speed, for example --speed 200")
        }
        (ProblemCode::Validation, Some(item)) if item.ends_with(".load_id") => {
            Some("`cellctl loads` shows where every load is")
        }
        (ProblemCode::NotFound, _) => [
            (" job ", JOBS),
            (" load ", "`cellctl loads` shows the loads"),
            (" motion ", "`cellctl motions` shows the last ones"),
            ("intervention", "`cellctl interventions` shows what is open"),
            (
                "mobile robot",
                "`cellctl mobile-robot` shows those there are",
            ),
            (
                " robot ",
                "`cellctl cells` shows the cells and their robots",
            ),
            (" cell ", "`cellctl cells` shows the cells and their robots"),
        ]
        .into_iter()
        .find(|(what, _)| detail.contains(what))
        .map(|(_, hint)| hint),
        _ => None,
    }
}

/// A sentence and what caused it, unless it says that already.
pub(crate) fn with_cause(sentence: String, cause: &str) -> String {
    if sentence.contains(cause) {
        sentence
    } else {
        format!("{sentence}: {cause}")
    }
}

/// One thing wrong with its value and limits; its message, too, unless the `detail` above it says the same.
fn violation_text(violation: &Violation, detail: &str) -> String {
    let Violation {
        item,
        message,
        value,
        min,
        max,
    } = violation;
    let mut text = item.clone();
    if let Some(value) = value {
        let _ = write!(text, " = {value}");
    }
    match (min, max) {
        (Some(min), Some(max)) => {
            let _ = write!(text, " (limits {min} to {max})");
        }
        (Some(min), None) => {
            let _ = write!(text, " (at least {min})");
        }
        (None, Some(max)) => {
            let _ = write!(text, " (at most {max})");
        }
        (None, None) => {}
    }
    if !detail.contains(message) {
        let _ = write!(text, ": {message}");
    }
    text
}

fn list(sentence: &str, items: &[String]) -> String {
    items.iter().fold(sentence.to_owned(), |text, item| {
        format!("{text}\n  {item}")
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    fn problem(code: ProblemCode, item: Option<&str>, detail: &str) -> Problem {
        let violations = item.map(|item| Violation {
            item: item.to_owned(),
            message: detail.to_owned(),
            ..Violation::default()
        });
        let violations: Vec<_> = violations.into_iter().collect();
        serde_json::from_value(serde_json::json!({
            "type": "about:blank",
            "title": code.title(),
            "status": code.status(),
            "detail": detail,
            "code": code,
            "outcome": "NOT_SENT",
            "retryable": false,
            "request_id": "r",
            "violations": violations,
        }))
        .unwrap()
    }

    #[test]
    fn who_cannot_know_what_to_do_next_is_told() {
        let percent = "speed_mm_s: this controller takes the speed in percent: `speed_percent`";
        for (code, item, detail, hint) in [
            (
                ProblemCode::NotFound,
                None,
                "cell `line` has no job 7",
                "cellctl job list",
            ),
            (
                ProblemCode::NotFound,
                None,
                "there is no robot `r9` in cell `line`",
                "cellctl cells",
            ),
            (
                ProblemCode::NotFound,
                None,
                "there is no mobile robot `mr9` in the set-up of cell `line`",
                "cellctl mobile-robot",
            ),
            (
                ProblemCode::Validation,
                Some("speed_mm_s"),
                percent,
                "--percent",
            ),
            (
                ProblemCode::Validation,
                Some("params.items[0].load_id"),
                "load-1 is at rack/d",
                "cellctl loads",
            ),
        ] {
            let text = problem_text(&problem(code, item, detail));
            assert!(text.contains("\nHint: ") && text.contains(hint), "{text}");
        }
        let other = problem(ProblemCode::Validation, Some("reason"), "reason: is empty");
        assert_eq!(
            problem_text(&other),
            "The request does not fit: reason: is empty"
        );
    }

    #[test]
    fn a_cause_is_said_once() {
        let said = with_cause(
            "reading x: (code: 14) no file".to_owned(),
            "(code: 14) no file",
        );
        assert_eq!(said, "reading x: (code: 14) no file");
        assert_eq!(with_cause("reading x".to_owned(), "why"), "reading x: why");
    }
}
