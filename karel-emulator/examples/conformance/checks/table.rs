//! What was expected, what was seen, and whether that is the same.

use std::fmt::Display;

/// One observation.
#[derive(Debug)]
pub(crate) struct Row {
    /// Where the specification has it, such as `T2.4`.
    pub(crate) id: &'static str,
    /// What is looked at.
    pub(crate) what: String,
    pub(crate) expected: String,
    pub(crate) seen: String,
    pub(crate) holds: bool,
}

/// The observations of one driver.
#[derive(Debug, Default)]
pub(crate) struct Table {
    rows: Vec<Row>,
}

impl Table {
    /// What was seen must be what was expected.
    pub(crate) fn same<T: Display + PartialEq>(
        &mut self,
        id: &'static str,
        what: &str,
        expected: T,
        seen: T,
    ) {
        let holds = expected == seen;
        self.put(id, what, expected, seen, holds);
    }

    /// What was seen must hold; `expected` says what does.
    pub(crate) fn put(
        &mut self,
        id: &'static str,
        what: &str,
        expected: impl Display,
        seen: impl Display,
        holds: bool,
    ) {
        self.rows.push(Row {
            id,
            what: what.to_owned(),
            expected: shown(&expected.to_string()),
            seen: shown(&seen.to_string()),
            holds,
        });
    }

    pub(crate) fn rows(&self) -> &[Row] {
        &self.rows
    }

    /// The observations that do not hold.
    pub(crate) fn failed(&self) -> impl Iterator<Item = &Row> {
        self.rows.iter().filter(|row| !row.holds)
    }
}

/// As a table of a terminal: columns as wide as their longest text.
impl Display for Table {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let heads = ["", "observation", "expected", "seen"];
        let cells = |row: &Row| {
            [
                row.id.to_owned(),
                row.what.clone(),
                row.expected.clone(),
                row.seen.clone(),
            ]
        };
        let widths = |column: usize| {
            let longest = self
                .rows
                .iter()
                .filter_map(|row| cells(row).get(column).map(|cell| cell.chars().count()));
            let head = heads.get(column).map_or(0, |head| head.len());
            longest.chain([head]).max().unwrap_or(0)
        };
        let widths: Vec<usize> = (0..heads.len()).map(widths).collect();
        let line = |f: &mut std::fmt::Formatter<'_>, cells: &[String], verdict: &str| {
            for (cell, width) in cells.iter().zip(&widths) {
                write!(f, "{cell:width$}  ", width = *width)?;
            }
            writeln!(f, "{verdict}")
        };
        line(f, &heads.map(str::to_owned), "verdict")?;
        for row in &self.rows {
            let verdict = if row.holds { "ok" } else { "DIFFERS" };
            line(f, &cells(row), verdict)?;
        }
        Ok(())
    }
}

/// Short, and on one line.
fn shown(text: &str) -> String {
    const LONGEST: usize = 60;
    let one_line: String = text
        .chars()
        .map(|c| if c.is_control() { ' ' } else { c })
        .collect();
    if one_line.chars().count() <= LONGEST {
        return one_line;
    }
    let short: String = one_line.chars().take(LONGEST - 2).collect();
    format!("{short}..")
}
