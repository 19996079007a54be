//! The paper: a `plotters` area whose unit is finer than a pixel, and text on it.
//!
//! `plotters` rounds every place to a whole unit of its backend. The backend is [`FINE`] times as large as the drawing,
//! so a curve is smooth; the SVG's `viewBox` brings it back to size.

use plotters::coord::Shift;
use plotters::prelude::*;
use plotters::style::Color as _;
use plotters::style::text_anchor::{HPos, Pos, VPos};

use crate::drawing::Drawing;
use crate::{Color, PlotError};

/// Units of the backend in a pixel.
pub(crate) const FINE: i32 = 8;

pub(crate) type Area<'a> = DrawingArea<SVGBackend<'a>, Shift>;

/// A size in pixels as units of the backend.
#[expect(
    clippy::cast_possible_truncation,
    reason = "a drawing is some thousand pixels wide; a cast of more saturates"
)]
pub(crate) fn units(pixels: f64) -> i32 {
    (pixels * f64::from(FINE)).round() as i32
}

/// A place in pixels.
pub(crate) fn at(x: f64, y: f64) -> (i32, i32) {
    (units(x), units(y))
}

/// A failure of the drawing library.
#[expect(clippy::needless_pass_by_value, reason = "the form that map_err takes")]
pub(crate) fn broken<E: std::error::Error + Send + Sync>(
    error: DrawingAreaErrorKind<E>,
) -> PlotError {
    PlotError::Draw(error.to_string())
}

/// Draws on a white sheet of `width` x `height` pixels. `title` is what a screen reader says of it.
pub(crate) fn sheet(
    (width, height): (u32, u32),
    title: &str,
    draw: impl FnOnce(&Area<'_>) -> Result<(), PlotError>,
) -> Result<Drawing, PlotError> {
    let fine = FINE.unsigned_abs();
    let (wide, high) = (width * fine, height * fine);
    let mut svg = String::new();
    {
        let root = SVGBackend::with_string(&mut svg, (wide, high)).into_drawing_area();
        root.fill(&WHITE).map_err(broken)?;
        draw(&root)?;
        root.present().map_err(broken)?;
    }
    let begin = svg.find('>').map_or(0, |end| end + 1);
    // What is said is what holds without it: a third of a large drawing.
    let body = svg.get(begin..).unwrap_or_default();
    let body = body
        .replace(" opacity=\"1\"", "")
        .replace(" stroke=\"none\"", "");
    Ok(Drawing::new(format!(
        "<svg width=\"{width}\" height=\"{height}\" viewBox=\"0 0 {wide} {high}\" \
         xmlns=\"http://www.w3.org/2000/svg\" role=\"img\" \
         stroke-linejoin=\"round\" stroke-linecap=\"round\">\n<title>{}</title>{}\n",
        escaped(title),
        body.trim_end(),
    )))
}

fn escaped(text: &str) -> String {
    text.replace('&', "&amp;")
        .replace('<', "&lt;")
        .replace('>', "&gt;")
}

/// A size and color of text, placed by its left end, middle or right end.
#[derive(Clone, Copy)]
pub(crate) struct Lettering {
    pub(crate) pixels: f64,
    pub(crate) color: Color,
    pub(crate) anchor: HPos,
}

impl Lettering {
    pub(crate) const TITLE: Self = Self::new(17.0, Color::INK, HPos::Left);
    pub(crate) const NOTE: Self = Self::new(12.5, Color::SOFT, HPos::Left);
    pub(crate) const LABEL: Self = Self::new(12.5, Color::INK, HPos::Left);
    pub(crate) const SMALL: Self = Self::new(11.5, Color::SOFT, HPos::Left);

    const fn new(pixels: f64, color: Color, anchor: HPos) -> Self {
        Self {
            pixels,
            color,
            anchor,
        }
    }

    pub(crate) const fn color(self, color: Color) -> Self {
        Self { color, ..self }
    }

    pub(crate) const fn anchored(self, anchor: HPos) -> Self {
        Self { anchor, ..self }
    }

    pub(crate) fn style(self) -> TextStyle<'static> {
        TextStyle {
            font: (FAMILY, f64::from(units(self.pixels))).into_font(),
            color: self.color.0.to_backend_color(),
            pos: Pos::new(self.anchor, VPos::Center),
        }
    }
}

/// The font, and what a viewer without it takes.
const FAMILY: &str = "DejaVu Sans, Verdana, sans-serif";

/// Writes `text` with its middle line at `place`, in pixels.
pub(crate) fn write(
    area: &Area<'_>,
    text: &str,
    (x, y): (f64, f64),
    lettering: Lettering,
) -> Result<(), PlotError> {
    area.draw(&Text::new(text.to_owned(), at(x, y), lettering.style()))
        .map_err(broken)
}

/// About how wide `text` is in pixels: enough to leave room for it.
pub(crate) fn width(text: &str, pixels: f64) -> f64 {
    let ems: f64 = text
        .chars()
        .map(|letter| match letter {
            'i' | 'j' | 'l' | 'I' | '.' | ',' | ':' | ';' | '\'' | '|' | ' ' | '(' | ')' | '/'
            | 't' | 'f' | 'r' => 0.36,
            'm' | 'w' | 'M' | 'W' | '%' => 0.92,
            _ => 0.63,
        })
        .sum();
    ems * pixels
}
