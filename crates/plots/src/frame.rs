//! Axes with a grid, labels and units.

use plotters::coord::types::RangedCoordf64;
use plotters::element::Drawable;
use plotters::prelude::*;
use plotters::style::Color as _;
use plotters::style::text_anchor::{HPos, Pos, VPos};

use crate::canvas::{Area, Lettering, broken, units};
use crate::figure::Rect;
use crate::simplify::simplified;
use crate::ticks::number;
use crate::{Color, PlotError};

/// Room for the labels of the Y axis, in pixels.
pub(crate) const LEFT: f64 = 66.0;
/// Room for the labels of the X axis.
pub(crate) const BELOW: f64 = 42.0;

/// What the axes show.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Axes<'a> {
    pub(crate) x: (f64, f64),
    pub(crate) y: (f64, f64),
    pub(crate) x_label: &'a str,
    pub(crate) y_label: &'a str,
}

/// A place with axes, where data are drawn in their own units.
pub(crate) struct Frame<'a> {
    chart: ChartContext<'a, SVGBackend<'a>, Cartesian2d<RangedCoordf64, RangedCoordf64>>,
    /// Data units in a pixel.
    pixel: (f64, f64),
}

type Place = (f64, f64);

impl<'a> Frame<'a> {
    /// Draws the axes: the plot itself is [`LEFT`] and [`BELOW`] smaller than `rect`.
    pub(crate) fn new(area: &Area<'a>, rect: Rect, axes: Axes<'_>) -> Result<Self, PlotError> {
        let within = area.clone().shrink(
            (units(rect.left), units(rect.top)),
            (units(rect.width), units(rect.height)),
        );
        let mut chart = ChartBuilder::on(&within)
            .x_label_area_size(units(BELOW))
            .y_label_area_size(units(LEFT))
            .build_cartesian_2d(axes.x.0..axes.x.1, axes.y.0..axes.y.1)
            .map_err(broken)?;
        let plot = (rect.width - LEFT, rect.height - BELOW);
        let fine = |pixels: f64| units(pixels).unsigned_abs();
        let short = |value: &f64| number(*value);
        let small = Lettering::SMALL.style();
        let beside = small.clone().pos(Pos::new(HPos::Right, VPos::Center));
        chart
            .configure_mesh()
            .max_light_lines(0)
            .bold_line_style(Color::GRID.0.stroke_width(fine(1.0)))
            .axis_style(Color::SOFT.0.stroke_width(fine(1.0)))
            .set_all_tick_mark_size(units(4.0))
            .x_labels(labels(plot.0, 48.0))
            .y_labels(labels(plot.1, 26.0))
            .x_label_formatter(&short)
            .y_label_formatter(&short)
            .x_label_style(small)
            .y_label_style(beside)
            .axis_desc_style(Lettering::LABEL.style())
            .x_desc(axes.x_label)
            .y_desc(axes.y_label)
            .draw()
            .map_err(broken)?;
        let pixel = (
            (axes.x.1 - axes.x.0) / plot.0.max(1.0),
            (axes.y.1 - axes.y.0) / plot.1.max(1.0),
        );
        Ok(Self { chart, pixel })
    }

    /// A line through `points`.
    pub(crate) fn line(
        &self,
        points: &[Place],
        color: Color,
        pixels: f64,
    ) -> Result<(), PlotError> {
        // Nobody sees a tenth of a pixel.
        let on_paper: Vec<Place> = points
            .iter()
            .map(|(x, y)| (x / self.pixel.0, y / self.pixel.1))
            .collect();
        let few: Vec<Place> = simplified(&on_paper, 0.1)
            .into_iter()
            .map(|(x, y)| (x * self.pixel.0, y * self.pixel.1))
            .collect();
        let style = color.0.stroke_width(units(pixels).unsigned_abs());
        self.draw(&PathElement::new(few, style))
    }

    /// A filled polygon with an outline.
    pub(crate) fn area(
        &self,
        points: &[Place],
        fill: Option<(Color, f64)>,
        outline: Option<(Color, f64)>,
    ) -> Result<(), PlotError> {
        if let Some((color, opacity)) = fill {
            let style = color.0.mix(opacity).filled();
            self.draw(&Polygon::new(points.to_vec(), style))?;
        }
        if let (Some((color, pixels)), Some(&first)) = (outline, points.first()) {
            let mut closed = points.to_vec();
            closed.push(first);
            let style = color.0.stroke_width(units(pixels).unsigned_abs());
            self.draw(&PathElement::new(closed, style))?;
        }
        Ok(())
    }

    /// A line with round ends as thick as twice `radius`, in data units; the axes are equal.
    pub(crate) fn capsule(
        &self,
        ends: [Place; 2],
        radius: f64,
        color: Color,
    ) -> Result<(), PlotError> {
        let pixels = (2.0 * radius / self.pixel.0).max(1.0);
        let style = color.0.stroke_width(units(pixels).unsigned_abs());
        self.draw(&PathElement::new(ends.to_vec(), style))
    }

    /// A rectangle without an outline.
    pub(crate) fn rectangle(&self, corners: [Place; 2], color: Color) -> Result<(), PlotError> {
        self.draw(&Rectangle::new(corners, color.0.filled()))
    }

    /// A dot with a white rim, so that it stands out from what it lies on.
    pub(crate) fn dot(&self, at: Place, color: Color, pixels: f64) -> Result<(), PlotError> {
        self.draw(&Circle::new(at, units(pixels + 1.2), WHITE.filled()))?;
        self.draw(&Circle::new(at, units(pixels), color.0.filled()))
    }

    /// A circle of `radius` in data units (of X; the axes of a map are equal).
    pub(crate) fn ring(&self, at: Place, radius: f64, color: Color) -> Result<(), PlotError> {
        let style = color.0.stroke_width(units(1.5).unsigned_abs());
        self.draw(&Circle::new(at, units(radius / self.pixel.0), style))
    }

    /// `text` beside a place of the data, `off` by so many pixels.
    pub(crate) fn text(
        &self,
        text: &str,
        at: Place,
        off: (f64, f64),
        lettering: Lettering,
    ) -> Result<(), PlotError> {
        let off = (units(off.0), units(off.1));
        let label = Text::new(text.to_owned(), off, lettering.style());
        self.draw(&(EmptyElement::at(at) + label))
    }

    fn draw<E>(&self, element: &E) -> Result<(), PlotError>
    where
        for<'b> &'b E: plotters::element::PointCollection<'b, Place>,
        E: Drawable<SVGBackend<'a>>,
    {
        self.chart.plotting_area().draw(element).map_err(broken)
    }
}

/// How many labels fit beside `room` pixels if each takes `each`.
#[expect(
    clippy::cast_possible_truncation,
    clippy::cast_sign_loss,
    reason = "a few"
)]
fn labels(room: f64, each: f64) -> usize {
    ((room / each).round() as usize).max(2)
}
