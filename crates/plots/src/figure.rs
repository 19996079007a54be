//! Title, note and legend above what is drawn.

use crate::canvas::{Area, Lettering, write};
use crate::legend::{self, Entry};
use crate::{Drawing, PlotError, canvas};

/// Around everything, in pixels.
pub(crate) const MARGIN: f64 = 16.0;

/// A rectangle of the sheet, in pixels from its left upper corner.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Rect {
    pub(crate) left: f64,
    pub(crate) top: f64,
    pub(crate) width: f64,
    pub(crate) height: f64,
}

/// What stands above a drawing.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Heading<'a> {
    pub(crate) title: &'a str,
    /// Lines of text below the title; may be empty.
    pub(crate) note: &'a str,
    pub(crate) legend: &'a [Entry],
}

impl Heading<'_> {
    /// A sheet with this heading, and `body` pixels of width and height below it.
    pub(crate) fn sheet(
        &self,
        body: (f64, f64),
        draw: impl FnOnce(&Area<'_>, Rect) -> Result<(), PlotError>,
    ) -> Result<Drawing, PlotError> {
        let (wide, high) = body;
        let notes: Vec<String> = self
            .note
            .lines()
            .flat_map(|line| wrapped(line, wide))
            .collect();
        let titles = wrapped_at(self.title, wide, Lettering::TITLE.pixels);
        let mut y = MARGIN + 8.0;
        let title_at = y;
        y += 24.0 * as_number(titles.len()) - 4.0;
        let notes_at = y;
        y += 18.0 * as_number(notes.len());
        let legend_at = y - 4.0;
        y += legend::height(self.legend, wide);
        let size = (whole(wide + 2.0 * MARGIN), whole(y + high + MARGIN));
        canvas::sheet(size, self.title, |area| {
            for (row, line) in titles.iter().enumerate() {
                let y = title_at + 24.0 * as_number(row);
                write(area, line, (MARGIN, y), Lettering::TITLE)?;
            }
            for (row, line) in notes.iter().enumerate() {
                let y = notes_at + 18.0 * as_number(row);
                write(area, line, (MARGIN, y), Lettering::NOTE)?;
            }
            legend::draw(area, self.legend, (MARGIN, legend_at), wide)?;
            let rest = Rect {
                left: MARGIN,
                top: y,
                width: wide,
                height: high,
            };
            draw(area, rest)
        })
    }
}

/// `line` in as many lines as it needs.
fn wrapped(line: &str, room: f64) -> Vec<String> {
    wrapped_at(line, room, Lettering::NOTE.pixels)
}

fn wrapped_at(line: &str, room: f64, pixels: f64) -> Vec<String> {
    let mut lines: Vec<String> = Vec::new();
    for word in line.split_whitespace() {
        match lines.last_mut() {
            Some(last) if canvas::width(last, pixels) + canvas::width(word, pixels) < room => {
                last.push(' ');
                last.push_str(word);
            }
            _ => lines.push(word.to_owned()),
        }
    }
    lines
}

#[expect(clippy::cast_precision_loss, reason = "a drawing has few lines")]
pub(crate) fn as_number(count: usize) -> f64 {
    count as f64
}

#[expect(
    clippy::cast_possible_truncation,
    clippy::cast_sign_loss,
    reason = "a drawing is some thousand pixels wide"
)]
fn whole(pixels: f64) -> u32 {
    pixels.ceil() as u32
}
