//! What the colors of a drawing mean: a strip above the drawing, never on it.

use plotters::prelude::*;
use plotters::style::Color as _;

use crate::canvas::{Area, Lettering, at, broken, units, width, write};
use crate::{Color, PlotError};

/// The sign beside a name.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Sign {
    Line { color: Color, pixels: f64 },
    Fill { color: Color, opacity: f64 },
    Ring { color: Color },
    Dot { color: Color },
}

/// A name and its sign.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Entry {
    pub(crate) sign: Sign,
    pub(crate) name: String,
}

/// Between the middle lines of two rows.
const ROW: f64 = 20.0;
const SIGN: f64 = 22.0;
const GAP: f64 = 18.0;

/// Each name once, in the order of the first.
pub(crate) fn unique(entries: impl IntoIterator<Item = Entry>) -> Vec<Entry> {
    let mut seen: Vec<Entry> = Vec::new();
    for entry in entries {
        if !entry.name.is_empty() && !seen.iter().any(|other| other.name == entry.name) {
            seen.push(entry);
        }
    }
    seen
}

/// Where each entry stands: its left end, and its row.
fn places(entries: &[Entry], room: f64) -> Vec<(f64, f64)> {
    let (mut x, mut row) = (0.0, 0.0);
    entries
        .iter()
        .map(|entry| {
            let wide = SIGN + 6.0 + width(&entry.name, Lettering::LABEL.pixels);
            if x > 0.0 && x + wide > room {
                x = 0.0;
                row += 1.0;
            }
            let place = (x, row);
            x += wide + GAP;
            place
        })
        .collect()
}

/// How high the strip is if it may be `room` wide.
pub(crate) fn height(entries: &[Entry], room: f64) -> f64 {
    places(entries, room)
        .last()
        .map_or(0.0, |(_, row)| (row + 1.0) * ROW)
}

/// Draws the strip with its left upper corner at `(left, top)`.
pub(crate) fn draw(
    area: &Area<'_>,
    entries: &[Entry],
    (left, top): (f64, f64),
    room: f64,
) -> Result<(), PlotError> {
    for (entry, (x, row)) in entries.iter().zip(places(entries, room)) {
        let (x, y) = (left + x, top + (row + 0.5) * ROW);
        let middle = x + SIGN / 2.0;
        match entry.sign {
            Sign::Line { color, pixels } => {
                let style = color.0.stroke_width(units(pixels).unsigned_abs());
                area.draw(&PathElement::new(vec![at(x, y), at(x + SIGN, y)], style))
            }
            Sign::Fill { color, opacity } => {
                let corners = [at(x + 3.0, y - 6.0), at(x + SIGN - 3.0, y + 6.0)];
                area.draw(&Rectangle::new(corners, color.0.mix(opacity).filled()))
                    .and_then(|()| {
                        let line = Color::FAINT.0.stroke_width(units(0.8).unsigned_abs());
                        area.draw(&Rectangle::new(corners, line))
                    })
            }
            Sign::Ring { color } => area.draw(&Circle::new(
                at(middle, y),
                units(6.0),
                color.0.stroke_width(units(1.5).unsigned_abs()),
            )),
            Sign::Dot { color } => {
                area.draw(&Circle::new(at(middle, y), units(5.0), color.0.filled()))
            }
        }
        .map_err(broken)?;
        write(area, &entry.name, (x + SIGN + 6.0, y), Lettering::LABEL)?;
    }
    Ok(())
}
