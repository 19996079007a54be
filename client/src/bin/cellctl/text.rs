//! Poses, joints and tables for people.

use std::fmt::{self, Write};

use api::{JointMargin, JointsBody, Motion, PoseBody};
use serde::Serialize;

/// A number to the thousandth, which is what goes over the wire. Zero has no sign.
pub(crate) fn thousandths(value: f64) -> String {
    let text = format!("{value:.3}");
    match text.strip_prefix('-') {
        Some("0.000") => "0.000".to_owned(),
        Some(_) | None => text,
    }
}

/// A pose in a sentence.
pub(crate) fn pose(pose: &PoseBody) -> String {
    let [x, y, z, w, p, r] = <[f64; 6]>::from(*pose).map(thousandths);
    format!("X {x}  Y {y}  Z {z} mm  W {w}  P {p}  R {r} deg")
}

/// Joint values in a sentence.
pub(crate) fn joints(joints: JointsBody) -> String {
    let [j1, j2, j3, j4, j5, j6] = <[f64; 6]>::from(joints).map(thousandths);
    format!("J1 {j1}  J2 {j2}  J3 {j3}  J4 {j4}  J5 {j5}  J6 {j6} deg")
}

/// A motion's speed, in the unit it was given in.
pub(crate) fn speed(motion: &Motion) -> String {
    match (motion.speed_mm_s, motion.speed_percent) {
        (Some(speed), _) => format!("{speed} mm/s"),
        (None, Some(percent)) => format!("{percent} %"),
        (None, None) => String::new(),
    }
}

/// An enum of the API by its name in JSON.
pub(crate) fn word<T: Serialize>(value: T) -> String {
    match serde_json::to_value(value) {
        Ok(serde_json::Value::String(word)) => word,
        Ok(other) => other.to_string(),
        Err(_) => "?".to_owned(),
    }
}

/// Facts, one a line, with their names in a column of their own.
pub(crate) fn facts(facts: &[(&str, String)]) -> String {
    let width = facts.iter().map(|(name, _)| name.len()).max().unwrap_or(0);
    facts.iter().fold(String::new(), |mut text, (name, fact)| {
        let _ = writeln!(text, "  {name:<width$}  {fact}");
        text
    })
}

/// Each joint with its limits and how far inside them it is.
pub(crate) fn margins(margins: &[JointMargin]) -> Table {
    let mut table = Table::new(&["joint", ">value", ">min", ">max", ">margin", ""]);
    for joint in margins {
        table.row([
            joint.joint.clone(),
            thousandths(joint.value_deg),
            thousandths(joint.min_deg),
            thousandths(joint.max_deg),
            thousandths(joint.margin_deg),
            if joint.margin_deg < 0.0 {
                "outside"
            } else {
                ""
            }
            .to_owned(),
        ]);
    }
    table
}

/// An aligned table. A heading that begins with `>` aligns its column to the right.
#[derive(Debug)]
pub(crate) struct Table {
    headings: Vec<String>,
    rows: Vec<Vec<String>>,
}

impl Table {
    pub(crate) fn new(headings: &[&str]) -> Self {
        Self::with_headings(headings.iter().map(|&heading| heading.to_owned()))
    }

    /// For as many columns as there are joints.
    pub(crate) fn with_headings(headings: impl IntoIterator<Item = String>) -> Self {
        Self {
            headings: headings.into_iter().collect(),
            rows: Vec::new(),
        }
    }

    pub(crate) fn row(&mut self, cells: impl IntoIterator<Item = String>) {
        self.rows.push(cells.into_iter().collect());
    }
}

impl fmt::Display for Table {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let titles: Vec<String> = self
            .headings
            .iter()
            .map(|heading| heading.trim_start_matches('>').to_owned())
            .collect();
        let lines: Vec<&Vec<String>> = std::iter::once(&titles).chain(&self.rows).collect();
        let widths: Vec<usize> = (0..titles.len())
            .map(|column| {
                let cells = lines.iter().filter_map(|line| line.get(column));
                cells.map(|cell| cell.chars().count()).max().unwrap_or(0)
            })
            .collect();
        for line in lines {
            let mut text = String::new();
            for ((cell, &width), heading) in line.iter().zip(&widths).zip(&self.headings) {
                if heading.starts_with('>') {
                    let _ = write!(text, "  {cell:>width$}");
                } else {
                    let _ = write!(text, "  {cell:<width$}");
                }
            }
            writeln!(f, "{}", text.trim_end())?;
        }
        Ok(())
    }
}

/// A time for people: to the second, in UTC.
pub(crate) fn whole_seconds(at: jiff::Timestamp) -> String {
    at.strftime("%F %T UTC").to_string()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_table_is_aligned() {
        let mut table = Table::new(&["name", ">value"]);
        table.row(["J1".to_owned(), "-180.000".to_owned()]);
        table.row(["elbow°".to_owned(), "0.500".to_owned()]);
        assert_eq!(
            table.to_string(),
            "  name       value\n  J1      -180.000\n  elbow°     0.500\n"
        );
    }

    #[test]
    fn zero_has_no_sign() {
        assert_eq!(thousandths(-0.000_4), "0.000");
        assert_eq!(thousandths(-0.000_6), "-0.001");
    }

    #[test]
    fn a_word_is_the_one_of_the_api() {
        assert_eq!(word(api::MotionState::InDoubt), "in_doubt");
    }
}
