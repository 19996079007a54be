//! Messages about a source, with the place they are about.

use std::{fmt, sync::Arc};

use crate::span::{Source, Span, latin1};

/// How bad a [`Diagnostic`] is.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Severity {
    /// The program cannot be loaded.
    Error,
    /// The program can be loaded, but something is probably not meant.
    Warning,
}

/// A message about a place of a source. `Display` renders it with the source line and a caret.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Diagnostic {
    /// How bad it is.
    pub severity: Severity,
    /// What is wrong, one sentence without a full stop.
    pub message: String,
    /// What can be done about it.
    pub help: Option<String>,
    /// The file's name as it was given.
    pub file: Arc<str>,
    /// Line from 1.
    pub line: u32,
    /// Column from 1, in bytes.
    pub column: u32,
    /// The source line, tabs as single blanks; a window of it if it is long.
    pub source_line: String,
    /// Where the carets start in `source_line`, and how many there are.
    pub carets: (usize, usize),
}

impl fmt::Display for Diagnostic {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let severity = match self.severity {
            Severity::Error => "error",
            Severity::Warning => "warning",
        };
        let number = self.line.to_string();
        let margin = " ".repeat(number.len());
        let (start, length) = self.carets;
        writeln!(f, "{severity}: {}", self.message)?;
        writeln!(f, "{margin}--> {}:{}:{}", self.file, self.line, self.column)?;
        writeln!(f, "{margin} |")?;
        writeln!(f, "{number} | {}", self.source_line)?;
        write!(f, "{margin} | {}{}", " ".repeat(start), "^".repeat(length))?;
        if let Some(help) = &self.help {
            write!(f, "\n{margin} = help: {help}")?;
        }
        Ok(())
    }
}

impl std::error::Error for Diagnostic {}

/// Renders several diagnostics, one blank line between them.
#[must_use]
pub fn render(diagnostics: &[Diagnostic]) -> String {
    let texts: Vec<String> = diagnostics.iter().map(Diagnostic::to_string).collect();
    texts.join("\n\n")
}

/// More messages than this help nobody.
const MAX_REPORTS: usize = 50;

/// Longest part of a source line that is shown.
const WINDOW: usize = 120;

#[derive(Debug)]
struct Report {
    severity: Severity,
    span: Span,
    message: String,
    help: Option<String>,
}

/// Collects what the lexer, the parser and the checker have to say.
#[derive(Debug, Default)]
pub(crate) struct Reports {
    list: Vec<Report>,
    errors: usize,
}

impl Reports {
    pub(crate) fn error(&mut self, span: Span, message: impl Into<String>) {
        self.push(Severity::Error, span, message.into(), None);
    }

    pub(crate) fn error_with_help(
        &mut self,
        span: Span,
        message: impl Into<String>,
        help: impl Into<String>,
    ) {
        self.push(Severity::Error, span, message.into(), Some(help.into()));
    }

    /// Adds help to the newest report.
    pub(crate) fn help(&mut self, help: &str) {
        if let Some(last) = self.list.last_mut() {
            last.help = Some(help.to_owned());
        }
    }

    pub(crate) fn warning(&mut self, span: Span, message: impl Into<String>) {
        self.push(Severity::Warning, span, message.into(), None);
    }

    fn push(&mut self, severity: Severity, span: Span, message: String, help: Option<String>) {
        let repeated = self
            .list
            .last()
            .is_some_and(|last| last.span == span && last.message == message);
        if repeated {
            return;
        }
        if self.list.len() >= MAX_REPORTS {
            // An error behind many warnings is still one: it takes the place of one of them.
            let is_warning = |report: &Report| report.severity == Severity::Warning;
            let place = self.list.iter().rposition(is_warning);
            let (Severity::Error, Some(place)) = (severity, place) else {
                return;
            };
            let _warning = self.list.remove(place);
        }
        self.errors += usize::from(severity == Severity::Error);
        self.list.push(Report {
            severity,
            span,
            message,
            help,
        });
    }

    pub(crate) fn has_errors(&self) -> bool {
        self.errors > 0
    }

    /// No more errors are recorded; a parser may stop.
    pub(crate) fn is_full(&self) -> bool {
        self.errors >= MAX_REPORTS
    }

    /// The diagnostics in the order of the source.
    pub(crate) fn into_diagnostics(mut self, source: &Source) -> Vec<Diagnostic> {
        self.list.sort_by_key(|report| report.span.start);
        self.list
            .into_iter()
            .map(|report| diagnostic(report, source))
            .collect()
    }
}

fn diagnostic(report: Report, source: &Source) -> Diagnostic {
    let (file, line, column) = source.position(report.span.start);
    let bytes = source.line_bytes(report.span.start);
    let start = (column as usize - 1).min(bytes.len());
    let on_line = report.span.end().saturating_sub(report.span.start());
    let length = on_line.min(bytes.len() - start).max(1);
    let window_start = if bytes.len() > WINDOW {
        start.saturating_sub(WINDOW / 2)
    } else {
        0
    };
    let window_end = bytes.len().min(window_start + WINDOW);
    let shown = latin1(bytes.get(window_start..window_end).unwrap_or_default());
    let room = (window_end - start).max(1);
    Diagnostic {
        severity: report.severity,
        message: report.message,
        help: report.help,
        file,
        line,
        column,
        source_line: shown.replace(|c: char| c.is_control(), " "),
        carets: (start - window_start, length.min(room)),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn render_one(text: &str, span: Span) -> String {
        let mut reports = Reports::default();
        reports.error_with_help(span, "`b` is not declared", "declare it in a VAR section");
        let source = Source::new(text.as_bytes(), "t.kl");
        render(&reports.into_diagnostics(&source))
    }

    #[test]
    fn a_diagnostic_shows_the_line_and_a_caret_run() {
        let expected = "error: `b` is not declared\n --> t.kl:2:6\n  |\n2 |  a = bcd\n  |      ^^^\n  = help: \
                        declare it in a VAR section";
        assert_eq!(render_one("x\n\ta = bcd\r\n", Span::new(7, 10)), expected);
    }

    #[test]
    fn a_long_line_is_shown_through_a_window() {
        let text = format!("{}b{}", " ".repeat(1000), "x".repeat(1000));
        let shown = render_one(&text, Span::new(1000, 1001));
        assert!(shown.lines().all(|line| line.len() < 140), "{shown}");
        assert!(shown.contains('^'));
    }

    #[test]
    fn a_span_at_the_end_of_the_file_still_has_a_caret() {
        assert!(render_one("abc", Span::new(3, 3)).contains('^'));
        assert!(render_one("", Span::new(0, 0)).contains('^'));
    }
}
