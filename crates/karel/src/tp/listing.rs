//! The sections of a listing: `/PROG`, `/ATTR`, `/APPL`, `/MN`, `/POS`, `/END`.

use std::{collections::BTreeMap, sync::Arc};

use super::{
    Branch, Instruction, MotionTarget, Taught, instruction::Line, position, scan::Scanner,
};
use crate::{
    diagnostic::Reports,
    parser::Reported,
    span::{Source, Span, latin1},
};

/// A TP program: its name, and its instructions with the lines that the pendant shows.
#[derive(Debug)]
pub(crate) struct Listing {
    pub(crate) name: String,
    pub(crate) instructions: Vec<Instruction>,
}

/// Lines of a program; more are refused.
const MOST_LINES: usize = 10_000;

/// Reads a listing. `None` if there is no program in it; else the result is meaningful only if no
/// error was reported.
pub(crate) fn parse(source: &Source, reports: &mut Reports) -> Option<Listing> {
    if !crate::parser::is_source_text(&source.bytes, 0, reports) {
        return None;
    }
    let mut sections = Sections::default();
    let mut start = 0;
    for line in source.bytes.split_inclusive(|byte| *byte == b'\n') {
        sections.line(line, start, reports);
        start += line.len();
    }
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
        instructions: resolve(lines, &taught, reports),
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
    /// Where the positions are.
    pos: Option<(usize, usize)>,
}

impl Sections {
    fn line(&mut self, line: &[u8], start: usize, reports: &mut Reports) {
        let text = line.trim_ascii();
        if text.is_empty() || self.place == Place::End || reports.is_full() {
            return;
        }
        let span = Span::new(start, start + line.trim_ascii_end().len());
        if text.first() == Some(&b'/') && text.get(1) != Some(&b'/') {
            return self.section(text, start, span, reports);
        }
        match self.place {
            Place::Before => reports.error(span, "expected /PROG"),
            Place::Header | Place::Positions | Place::End => {}
            Place::Main => self.instruction(line, start, span, reports),
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
            scanner.line()
        };
        let parsed = parsed.unwrap_or_else(|Reported| Line::Done(Instruction::Nothing));
        self.lines.push((parsed, span));
    }
}

fn is_name(name: &str) -> bool {
    let part = |c: char| c.is_ascii_alphanumeric() || matches!(c, '_' | '-');
    name.starts_with(|c: char| c.is_ascii_alphabetic())
        && name.len() <= 36
        && name.chars().all(part)
}

/// Labels become instructions, positions their values.
fn resolve(
    lines: Vec<(Line, Span)>,
    taught: &BTreeMap<i32, Arc<Taught>>,
    reports: &mut Reports,
) -> Vec<Instruction> {
    let mut labels = BTreeMap::new();
    for (at, (line, span)) in (0_u32..).zip(&lines) {
        if let Line::Label(label) = line
            && labels.insert(*label, at).is_some()
        {
            reports.error(*span, format!("LBL[{label}] is there twice"));
        }
    }
    let target = |label: i32, span: Span, reports: &mut Reports| {
        labels.get(&label).copied().unwrap_or_else(|| {
            reports.error(span, format!("there is no LBL[{label}]"));
            0
        })
    };
    let resolved = lines.into_iter().map(|(line, span)| match line {
        Line::Label(_) => Instruction::Nothing,
        Line::Jump(label) => Instruction::Jump(target(label, span, reports)),
        Line::IfJump(condition, label) => Instruction::If {
            condition,
            then: Branch::Jump(target(label, span, reports)),
        },
        Line::Done(instruction) => instruction,
        Line::Move(motion, None) => Instruction::Move(motion),
        Line::Move(mut motion, Some(number)) => match taught.get(&number) {
            Some(position) => {
                motion.target = MotionTarget::Taught(position.clone());
                Instruction::Move(motion)
            }
            None => {
                reports.error(span, format!("there is no P[{number}] in the section /POS"));
                Instruction::Nothing
            }
        },
    });
    resolved.collect()
}
