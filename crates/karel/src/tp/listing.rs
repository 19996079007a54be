//! The sections of a listing: `/PROG`, `/ATTR`, `/APPL`, `/MN`, `/POS`, `/END`.

use std::{collections::BTreeMap, sync::Arc};

use super::{Instruction, Operand, Taught, instruction::Line, position, resolve, scan::Scanner};
use crate::{
    diagnostic::Reports,
    span::{Source, Span, latin1},
};

/// A TP program: its name, and its instructions with the lines that the pendant shows.
#[derive(Debug)]
pub(crate) struct Listing {
    pub(crate) name: String,
    pub(crate) instructions: Vec<Instruction>,
    /// Taught positions.
    pub(crate) positions: BTreeMap<i32, Arc<Taught>>,
}

/// Lines of a program; more are refused.
const MOST_LINES: usize = 10_000;

/// Reads a listing. `None` if there is no program in it; else the result is meaningful only if no
/// error was reported.
pub(crate) fn parse(source: &Source, reports: &mut Reports) -> Option<Listing> {
    if !crate::parser::is_source_text(&source.bytes, 0, reports) {
        return None;
    }
    let first = source.bytes.trim_ascii_start();
    if !first
        .get(..5)
        .is_some_and(|word| word.eq_ignore_ascii_case(b"/PROG"))
    {
        let start = source.bytes.len() - first.len();
        let message = "expected /PROG: this is no listing of a TP program";
        reports.error_with_help(
            Span::new(start, start + 1),
            message,
            "a controller's backup has other `.ls` files, too, such as its alarms",
        );
        return None;
    }
    let mut sections = Sections::default();
    let mut start = 0;
    for line in source.bytes.split_inclusive(|byte| *byte == b'\n') {
        sections.line(line, start, reports);
        start += line.len();
    }
    sections.close_line(reports);
    let Sections {
        name,
        lines,
        place,
        pos,
        ..
    } = sections;
    let Some(name) = name else {
        let message = "expected /PROG and the program's name";
        reports.error(Span::new(0, 1), message);
        return None;
    };
    if place != Place::End {
        let end = source.bytes.len();
        reports.error(Span::new(end.saturating_sub(1), end), "/END is missing");
    }
    let taught = match pos {
        Some((from, to)) => {
            let bytes = source.bytes.get(from..to).unwrap_or_default();
            position::positions(bytes, from, reports)
        }
        None => BTreeMap::new(),
    };
    Some(Listing {
        name,
        instructions: resolve::resolve(lines, taught.clone(), reports),
        positions: taught,
    })
}

#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
enum Place {
    #[default]
    Before,
    Header,
    Main,
    Positions,
    End,
}

#[derive(Debug, Default)]
struct Sections {
    place: Place,
    name: Option<String>,
    lines: Vec<(Line, Span)>,
    /// A line of `/MN` that may go on in the next one, and where it starts.
    open: Option<(Vec<u8>, usize)>,
    /// What the SELECT before compares.
    selects: Option<Operand>,
    /// Where the positions are.
    pos: Option<(usize, usize)>,
}

impl Sections {
    fn line(&mut self, line: &[u8], start: usize, reports: &mut Reports) {
        let text = line.trim_ascii();
        if text.is_empty() || self.place == Place::End {
            return;
        }
        let span = Span::new(start, start + line.trim_ascii_end().len());
        if text.first() == Some(&b'/') && text.get(1) != Some(&b'/') {
            self.close_line(reports);
            return self.section(text, start, span, reports);
        }
        match self.place {
            Place::Before => reports.error(span, "expected /PROG"),
            Place::Header | Place::Positions | Place::End => {}
            Place::Main => self.main_line(line, start, reports),
        }
    }

    /// An instruction without `;` goes on in a line that has no number, as those of a `C` do.
    fn main_line(&mut self, line: &[u8], start: usize, reports: &mut Reports) {
        if let Some((open, at)) = &mut self.open
            && !open.trim_ascii_end().ends_with(b";")
            && line.trim_ascii_start().starts_with(b":")
        {
            // Blank lines between them count, so that places in the file stay what they are.
            open.resize(start - *at, b' ');
            let mut more = line.to_vec();
            if let Some(colon) = more.iter_mut().find(|byte| **byte == b':') {
                *colon = b' ';
            }
            open.extend(more);
            return;
        }
        self.close_line(reports);
        self.open = Some((line.to_vec(), start));
    }

    fn close_line(&mut self, reports: &mut Reports) {
        if let Some((line, start)) = self.open.take()
            && !reports.is_full()
        {
            let span = Span::new(start, start + line.trim_ascii_end().len());
            self.instruction(&line, start, span, reports);
        }
    }

    fn section(&mut self, text: &[u8], start: usize, span: Span, reports: &mut Reports) {
        let text = latin1(text);
        let mut words = text.split_whitespace();
        let section = words.next().unwrap_or_default().to_ascii_uppercase();
        if let Some((_, end)) = &mut self.pos
            && self.place == Place::Positions
        {
            *end = start;
        }
        self.place = match section.as_str() {
            "/PROG" if self.name.is_none() => {
                match words.next().map(str::to_ascii_uppercase) {
                    Some(name) if is_name(&name) => self.name = Some(name),
                    Some(_) | None => {
                        reports.error(span, "expected the program's name behind /PROG");
                    }
                }
                Place::Header
            }
            // One listing of the field repeats /APPL.
            "/ATTR" | "/APPL" | "/CMND" | "/EXTEND" | "/POSITION" => Place::Header,
            "/MN" => Place::Main,
            "/POS" => {
                let from = span.end();
                self.pos = Some((from, from));
                Place::Positions
            }
            "/END" => Place::End,
            other => {
                reports.error(span, format!("the section {other} is not known"));
                self.place
            }
        };
    }

    /// `  12:L PR[1] 100mm/sec FINE ;`: the number counts for nothing, the pendant counts itself.
    fn instruction(&mut self, line: &[u8], start: usize, span: Span, reports: &mut Reports) {
        if self.lines.len() >= MOST_LINES {
            reports.error(span, format!("more than {MOST_LINES} lines"));
            return;
        }
        // The controller prints an empty line so.
        if line.trim_ascii() == b";" {
            self.lines.push((Line::Done(Instruction::Nothing), span));
            return;
        }
        let Some(colon) = line.iter().position(|byte| *byte == b':') else {
            return reports.error(span, "expected a line number and `:`");
        };
        let number = line.get(..colon).unwrap_or_default().trim_ascii();
        if !number.iter().all(u8::is_ascii_digit) {
            return reports.error(span, "expected a line number and `:`");
        }
        let rest = line.get(colon + 1..).unwrap_or_default().trim_ascii_end();
        let rest = rest.strip_suffix(b";").unwrap_or(rest);
        let mut scanner = Scanner::new(rest, start + colon + 1, reports);
        let parsed = if scanner.at_end() {
            Ok(Line::Done(Instruction::Nothing))
        } else {
            scanner.line(&mut self.selects)
        };
        let parsed = parsed.unwrap_or(Line::Done(Instruction::Nothing));
        self.lines.push((parsed, span));
    }
}

fn is_name(name: &str) -> bool {
    let part = |c: char| c.is_ascii_alphanumeric() || matches!(c, '_' | '-');
    !name.starts_with(|c: char| c.is_ascii_digit())
        && (1..=36).contains(&name.len())
        && name.chars().all(part)
}
