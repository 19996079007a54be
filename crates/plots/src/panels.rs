//! Curves over a common axis, one panel for each quantity.

use plotters::style::text_anchor::HPos;

use crate::canvas::{Lettering, width, write};
use crate::error::all_finite;
use crate::figure::{Heading, Rect, as_number};
use crate::frame::{Axes, Frame, LEFT};
use crate::legend::{Entry, Sign, unique};
use crate::ticks::{extent, widened};
use crate::{Color, Drawing, PlotError};

/// A curve.
#[derive(Clone, Debug, PartialEq)]
pub struct Line {
    /// For the legend; lines of the same name have the same color.
    pub name: String,
    /// Its color.
    pub color: Color,
    /// How thick it is, in pixels: one that lies on another of the same values must be thinner to be seen.
    pub pixels: f64,
    /// Its points, in the units of the panel's labels.
    pub points: Vec<(f64, f64)>,
}

impl Line {
    /// A curve through `points`.
    #[must_use]
    pub fn new(name: impl Into<String>, color: Color, points: Vec<(f64, f64)>) -> Self {
        Self {
            name: name.into(),
            color,
            pixels: 1.8,
            points,
        }
    }

    /// The same curve, so thick.
    #[must_use]
    pub fn thick(self, pixels: f64) -> Self {
        Self { pixels, ..self }
    }
}

/// A limit: a horizontal line with its name at the right.
#[derive(Clone, Debug, PartialEq)]
pub struct Level {
    /// Beside the line.
    pub name: String,
    /// In the unit of the Y axis.
    pub value: f64,
    /// Its color.
    pub color: Color,
}

impl Level {
    /// A limit in the color of limits.
    #[must_use]
    pub fn limit(name: impl Into<String>, value: f64) -> Self {
        Self {
            name: name.into(),
            value,
            color: Color::LIMIT,
        }
    }
}

/// Something that happens at one place of the X axis: a vertical line with its name.
#[derive(Clone, Debug, PartialEq)]
pub struct Moment {
    /// Above the line.
    pub name: String,
    /// In the unit of the X axis.
    pub at: f64,
}

/// Curves with common axes.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Panel {
    /// Above the panel.
    pub title: String,
    /// The quantity of the X axis and its unit.
    pub x_label: String,
    /// The quantity of the Y axis and its unit.
    pub y_label: String,
    /// The curves.
    pub lines: Vec<Line>,
    /// Limits; the panel is as high as they need.
    pub levels: Vec<Level>,
    /// What happens when.
    pub moments: Vec<Moment>,
}

/// The width of all panels of a row.
const WIDTH: f64 = 860.0;
const GAP: f64 = 22.0;
const HIGH: f64 = 232.0;
/// For the panel's own title.
const ABOVE: f64 = 24.0;
/// For the names of moments, below the title.
const MOMENTS: f64 = 15.0;

/// Draws `all` in `columns` columns, row by row, with one legend for all.
///
/// # Errors
/// [`PlotError::Empty`] without a panel or for a panel without a point; [`PlotError::NotFinite`].
pub fn panels(
    title: &str,
    note: &str,
    all: &[Panel],
    columns: usize,
) -> Result<Drawing, PlotError> {
    if all.is_empty() {
        return Err(PlotError::Empty {
            what: title.to_owned(),
        });
    }
    let columns = columns.clamp(1, all.len());
    let entries = unique(all.iter().flat_map(|panel| &panel.lines).map(|line| Entry {
        sign: Sign::Line {
            color: line.color,
            pixels: line.pixels + 0.4,
        },
        name: line.name.clone(),
    }));
    // One curve has its name on its axis.
    let legend = if entries.len() > 1 {
        entries
    } else {
        Vec::new()
    };
    let rows = all.len().div_ceil(columns);
    let heading = Heading {
        title,
        note,
        legend: &legend,
    };
    let wide = (WIDTH - GAP * as_number(columns - 1)) / as_number(columns);
    // Alike for all, so that the same time is at the same place.
    let beside = all.iter().map(Panel::beside).fold(10.0, f64::max);
    heading.sheet((WIDTH, HIGH * as_number(rows)), |area, rest| {
        for (index, panel) in all.iter().enumerate() {
            let (row, column) = (as_number(index / columns), as_number(index % columns));
            let rect = Rect {
                left: rest.left + column * (wide + GAP),
                top: rest.top + row * HIGH,
                width: wide,
                height: HIGH - 6.0,
            };
            panel.draw(area, rect, beside)?;
        }
        Ok(())
    })
}

impl Panel {
    /// The room that the names of its levels take.
    fn beside(&self) -> f64 {
        let names = self.levels.iter().map(|level| &level.name);
        names
            .map(|name| width(name, Lettering::SMALL.pixels) + 8.0)
            .fold(10.0, f64::max)
    }

    fn draw(
        &self,
        area: &crate::canvas::Area<'_>,
        rect: Rect,
        beside: f64,
    ) -> Result<(), PlotError> {
        let points = || self.lines.iter().flat_map(|line| &line.points);
        all_finite(&self.title, points().flat_map(|&(x, y)| [x, y]))?;
        all_finite(&self.title, self.levels.iter().map(|level| level.value))?;
        all_finite(&self.title, self.moments.iter().map(|moment| moment.at))?;
        let empty = || PlotError::Empty {
            what: self.title.clone(),
        };
        let x = extent(points().map(|point| point.0)).ok_or_else(empty)?;
        let x = extent(
            [x.0, x.1]
                .into_iter()
                .chain(self.moments.iter().map(|moment| moment.at)),
        )
        .ok_or_else(empty)?;
        let x = if x.1 > x.0 { x } else { widened(x, 0.0) };
        let levels = self.levels.iter().map(|level| level.value);
        let y = extent(points().map(|point| point.1).chain(levels)).ok_or_else(empty)?;
        let y = widened(y, 0.06);
        write(
            area,
            &self.title,
            (rect.left + LEFT, rect.top + 13.0),
            Lettering::LABEL,
        )?;
        let named = self.moments.iter().any(|moment| !moment.name.is_empty());
        let above = if named { ABOVE + MOMENTS } else { ABOVE };
        let plot = Rect {
            top: rect.top + above,
            height: rect.height - above,
            width: rect.width - beside,
            ..rect
        };
        let axes = Axes {
            x,
            y,
            x_label: &self.x_label,
            y_label: &self.y_label,
        };
        let frame = Frame::new(area, plot, axes)?;
        if y.0 < 0.0 && y.1 > 0.0 {
            frame.line(&[(x.0, 0.0), (x.1, 0.0)], Color::FAINT, 1.0)?;
        }
        for level in &self.levels {
            frame.line(&[(x.0, level.value), (x.1, level.value)], level.color, 1.2)?;
            let lettering = Lettering::SMALL.color(level.color);
            frame.text(&level.name, (x.1, level.value), (6.0, 0.0), lettering)?;
        }
        for line in &self.lines {
            frame.line(&line.points, line.color, line.pixels)?;
        }
        for moment in &self.moments {
            frame.line(&[(moment.at, y.0), (moment.at, y.1)], Color::SOFT, 1.0)?;
            let right = moment.at > f64::midpoint(x.0, x.1);
            let (anchor, off) = if right {
                (HPos::Right, 0.0)
            } else {
                (HPos::Left, 0.0)
            };
            let lettering = Lettering::SMALL.anchored(anchor);
            frame.text(&moment.name, (moment.at, y.1), (off, -8.0), lettering)?;
        }
        Ok(())
    }
}
