//! Things in a plane, seen from above, with equal axes.

use crate::canvas::Lettering;
use crate::error::all_finite;
use crate::figure::{Heading, Rect};
use crate::frame::{Axes, BELOW, Frame, LEFT};
use crate::legend::{Entry, Sign, unique};
use crate::ticks::{extent, widened};
use crate::{Color, Drawing, PlotError};

/// How a part of a map looks.
#[derive(Clone, Copy, Debug, Eq, PartialEq)]
pub enum Look {
    /// What may not be touched: filled.
    Obstacle,
    /// What is closed because of something else: lightly filled.
    Closed,
    /// A part of the free space: a thin outline.
    Cell,
    /// What was looked at and is of no more interest: thin lines.
    Graph,
    /// The outer edge of all: an outline.
    Bounds,
    /// What the drawing is about: a thick line.
    Path,
    /// A second line beside it.
    Second,
    /// Where it begins.
    Start,
    /// Where it ends.
    Goal,
    /// Where it went wrong.
    Fault,
    /// Beside the point.
    Note,
}

impl Look {
    fn fill(self) -> Option<(Color, f64)> {
        match self {
            Self::Obstacle => Some((Color::SOFT, 0.75)),
            Self::Closed => Some((Color::LIMIT, 0.16)),
            Self::Cell
            | Self::Graph
            | Self::Bounds
            | Self::Path
            | Self::Second
            | Self::Start
            | Self::Goal
            | Self::Fault
            | Self::Note => None,
        }
    }

    fn stroke(self) -> (Color, f64) {
        match self {
            Self::Obstacle => (Color::INK, 1.0),
            Self::Closed => (Color::CLOSED, 0.8),
            Self::Cell => (Color::FAINT, 0.7),
            Self::Graph => (Color::FAINT, 0.8),
            Self::Bounds => (Color::INK, 1.6),
            Self::Path => (Color::MAIN, 3.0),
            Self::Second => (Color::of(3), 2.0),
            Self::Start => (Color::START, 1.8),
            Self::Goal => (Color::GOAL, 1.8),
            Self::Fault => (Color::LIMIT, 2.2),
            Self::Note => (Color::SOFT, 1.2),
        }
    }
}

/// A part of a map; the name goes into the legend, where an equal name stands once, an empty one not at all.
#[derive(Clone, Debug, PartialEq)]
pub enum Item {
    /// A polygon, closed by itself.
    Region {
        /// For the legend.
        name: String,
        /// Its corners.
        points: Vec<(f64, f64)>,
        /// How it looks.
        look: Look,
    },
    /// Several lines, each through its own points.
    Lines {
        /// For the legend.
        name: String,
        /// The points of each line.
        lines: Vec<Vec<(f64, f64)>>,
        /// How they look.
        look: Look,
    },
    /// A circle.
    Ring {
        /// For the legend.
        name: String,
        /// Its middle.
        center: (f64, f64),
        /// In the unit of the axes.
        radius: f64,
        /// How it looks.
        look: Look,
    },
    /// A dot, with a text beside it that may be empty.
    Dot {
        /// For the legend.
        name: String,
        /// Its place.
        at: (f64, f64),
        /// Beside it.
        text: String,
        /// How it looks.
        look: Look,
    },
}

impl Item {
    fn name(&self) -> &str {
        match self {
            Self::Region { name, .. }
            | Self::Lines { name, .. }
            | Self::Ring { name, .. }
            | Self::Dot { name, .. } => name,
        }
    }

    /// The places that have to be on the map.
    fn places(&self) -> Vec<(f64, f64)> {
        match self {
            Self::Region { points, .. } => points.clone(),
            Self::Lines { lines, .. } => lines.iter().flatten().copied().collect(),
            Self::Ring { center, radius, .. } => vec![
                (center.0 - radius, center.1 - radius),
                (center.0 + radius, center.1 + radius),
            ],
            Self::Dot { at, .. } => vec![*at],
        }
    }

    pub(crate) fn entry(&self) -> Entry {
        let sign = match self {
            Self::Region { look, .. } => match look.fill() {
                Some((color, opacity)) => Sign::Fill { color, opacity },
                None => line_sign(*look),
            },
            Self::Lines { look, .. } => line_sign(*look),
            Self::Ring { look, .. } => Sign::Ring {
                color: look.stroke().0,
            },
            Self::Dot { look, .. } => Sign::Dot {
                color: look.stroke().0,
            },
        };
        Entry {
            sign,
            name: self.name().to_owned(),
        }
    }

    pub(crate) fn draw(&self, frame: &Frame<'_>) -> Result<(), PlotError> {
        match self {
            Self::Region { points, look, .. } => {
                frame.area(points, look.fill(), Some(look.stroke()))
            }
            Self::Lines { lines, look, .. } => {
                let (color, pixels) = look.stroke();
                lines
                    .iter()
                    .try_for_each(|line| frame.line(line, color, pixels))
            }
            Self::Ring {
                center,
                radius,
                look,
                ..
            } => frame.ring(*center, *radius, look.stroke().0),
            Self::Dot { at, text, look, .. } => {
                let color = look.stroke().0;
                frame.dot(*at, color, 5.0)?;
                if text.is_empty() {
                    return Ok(());
                }
                frame.text(text, *at, (9.0, -9.0), Lettering::SMALL.color(color))
            }
        }
    }
}

fn line_sign(look: Look) -> Sign {
    let (color, pixels) = look.stroke();
    Sign::Line { color, pixels }
}

/// A map.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Map {
    /// Above the map.
    pub title: String,
    /// Below the title.
    pub note: String,
    /// The quantity of the X axis and its unit.
    pub x_label: String,
    /// The quantity of the Y axis and its unit.
    pub y_label: String,
    /// What is on it; what comes later lies on top.
    pub items: Vec<Item>,
}

/// The largest plot, in pixels.
const LARGEST: (f64, f64) = (790.0, 620.0);
/// The least width of a sheet: the title needs room.
const NARROWEST: f64 = 460.0;

/// Draws a map: a unit is equally long on both axes.
///
/// # Errors
/// [`PlotError::Empty`] without a place, [`PlotError::NotFinite`].
pub fn map(map: &Map) -> Result<Drawing, PlotError> {
    let places: Vec<(f64, f64)> = map.items.iter().flat_map(Item::places).collect();
    all_finite(&map.title, places.iter().flat_map(|&(x, y)| [x, y]))?;
    let empty = || PlotError::Empty {
        what: map.title.clone(),
    };
    let x = extent(places.iter().map(|place| place.0)).ok_or_else(empty)?;
    let y = extent(places.iter().map(|place| place.1)).ok_or_else(empty)?;
    let legend = unique(map.items.iter().map(Item::entry));
    let heading = Heading {
        title: &map.title,
        note: &map.note,
        legend: &legend,
    };
    let view = View::of(widened(x, 0.03), widened(y, 0.03));
    view.sheet(&heading, (&map.x_label, &map.y_label), |frame| {
        map.items.iter().try_for_each(|item| item.draw(frame))
    })
}

/// The part of the plane that is shown, and how large.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct View {
    x: (f64, f64),
    y: (f64, f64),
    plot: (f64, f64),
}

impl View {
    /// As large as there is room, with one scale for both axes. What is too narrow to read shows more of its surroundings.
    pub(crate) fn of(x: (f64, f64), y: (f64, f64)) -> Self {
        let (wide, high) = (x.1 - x.0, y.1 - y.0);
        let scale = (LARGEST.0 / wide).min(LARGEST.1 / high);
        let plot = (
            (wide * scale).max(NARROWEST - LEFT),
            (high * scale).max(140.0),
        );
        let grown = |range: (f64, f64), pixels: f64| {
            let more = (pixels / scale - (range.1 - range.0)).max(0.0) / 2.0;
            (range.0 - more, range.1 + more)
        };
        Self {
            x: grown(x, plot.0),
            y: grown(y, plot.1),
            plot,
        }
    }

    pub(crate) fn sheet(
        &self,
        heading: &Heading<'_>,
        (x_label, y_label): (&str, &str),
        draw: impl FnOnce(&Frame<'_>) -> Result<(), PlotError>,
    ) -> Result<Drawing, PlotError> {
        let body = (self.plot.0 + LEFT + 14.0, self.plot.1 + BELOW + 12.0);
        heading.sheet(body, |area, rest| {
            let rect = Rect {
                top: rest.top + 12.0,
                width: rest.width - 14.0,
                height: rest.height - 12.0,
                ..rest
            };
            let axes = Axes {
                x: self.x,
                y: self.y,
                x_label,
                y_label,
            };
            draw(&Frame::new(area, rect, axes)?)
        })
    }
}
