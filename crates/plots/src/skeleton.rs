//! Sticks in space: one picture in perspective, and the three projections.

use plotters::prelude::*;
use plotters::style::Color as _;
use plotters::style::text_anchor::HPos;

use crate::canvas::{Area, Lettering, at, broken, units, write};
use crate::error::all_finite;
use crate::figure::{Heading, Rect};
use crate::frame::{Axes, BELOW, Frame, LEFT};
use crate::legend::{Entry, Sign, unique};
use crate::ticks::{extent, multiples, number, step};
use crate::{Color, Drawing, PlotError};

/// A line in space.
#[derive(Clone, Debug, PartialEq)]
pub struct Stick {
    /// For the legend.
    pub name: String,
    /// Its color.
    pub color: Color,
    /// How thick, in pixels.
    pub pixels: f64,
    /// Its points.
    pub points: Vec<[f64; 3]>,
    /// A letter for each point, which then gets a dot, or none at all. An empty one is a dot without a letter.
    pub letters: Vec<String>,
}

/// A cylinder with round ends in space: it looks alike from everywhere.
#[derive(Clone, Debug, PartialEq)]
pub struct Capsule {
    /// One end of its axis.
    pub from: [f64; 3],
    /// The other.
    pub to: [f64; 3],
    /// Its radius.
    pub radius: f64,
}

/// Capsules of one color.
#[derive(Clone, Debug, PartialEq)]
pub struct Body {
    /// For the legend.
    pub name: String,
    /// Its color.
    pub color: Color,
    /// Its parts.
    pub capsules: Vec<Capsule>,
}

/// An arm and what is around it.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Skeleton {
    /// Above the drawing.
    pub title: String,
    /// Below the title.
    pub note: String,
    /// The unit of all coordinates: `mm`.
    pub unit: String,
    /// What is behind the sticks.
    pub bodies: Vec<Body>,
    /// What is drawn; what comes later lies on top.
    pub sticks: Vec<Stick>,
}

impl Skeleton {
    /// The places that have to be in the picture.
    fn places(&self) -> Vec<[f64; 3]> {
        let sticks = self.sticks.iter().flat_map(|stick| &stick.points).copied();
        let capsules = self.bodies.iter().flat_map(|body| &body.capsules);
        let corners = capsules.flat_map(|capsule| {
            [capsule.from, capsule.to].into_iter().flat_map(|end| {
                let moved = |by: f64| end.map(|value| value + by);
                [moved(capsule.radius), moved(-capsule.radius)]
            })
        });
        sticks.chain(corners).collect()
    }
}

const PANEL: f64 = 420.0;
const GAP: f64 = 20.0;
const ABOVE: f64 = 24.0;
/// Numbers along an edge of the cube, at least.
const TICKS: f64 = 2.2;

/// Draws the sticks in space, seen from the front right and above, and projected on the planes XZ, XY and YZ. All four
/// have the same scale.
///
/// # Errors
/// [`PlotError::Empty`] without a point, [`PlotError::NotFinite`], [`PlotError::Shape`] if a stick has letters, but not one
/// for each point.
pub fn skeleton(skeleton: &Skeleton) -> Result<Drawing, PlotError> {
    let title = &skeleton.title;
    for stick in &skeleton.sticks {
        if !stick.letters.is_empty() && stick.letters.len() != stick.points.len() {
            return Err(PlotError::Shape {
                what: format!("{title}: letters of {}", stick.name),
                given: stick.letters.len(),
                wanted: stick.points.len(),
            });
        }
    }
    let places = skeleton.places();
    all_finite(title, places.iter().flatten().copied())?;
    let cube = Cube::around(&places).ok_or_else(|| PlotError::Empty {
        what: title.clone(),
    })?;
    let bodies = skeleton.bodies.iter().map(|body| Entry {
        sign: Sign::Fill {
            color: body.color,
            opacity: 1.0,
        },
        name: body.name.clone(),
    });
    let sticks = skeleton.sticks.iter().map(|stick| Entry {
        sign: Sign::Line {
            color: stick.color,
            pixels: stick.pixels,
        },
        name: stick.name.clone(),
    });
    let legend = unique(bodies.chain(sticks));
    let heading = Heading {
        title,
        note: &skeleton.note,
        legend: &legend,
    };
    let size = (2.0 * PANEL + GAP, 2.0 * PANEL + GAP);
    heading.sheet(size, |area, rest| {
        let rect = |column: f64, row: f64| Rect {
            left: rest.left + column * (PANEL + GAP),
            top: rest.top + row * (PANEL + GAP),
            width: PANEL,
            height: PANEL,
        };
        in_space(area, rect(0.0, 0.0), skeleton, cube)?;
        for (rect, name, axes) in [
            (rect(1.0, 0.0), "XZ, seen against Y", (0, 2)),
            (rect(0.0, 1.0), "XY, seen from above", (0, 1)),
            (rect(1.0, 1.0), "YZ, seen from X", (1, 2)),
        ] {
            projection(area, rect, skeleton, cube, name, axes)?;
        }
        Ok(())
    })
}

/// The cube that all four pictures show.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Cube {
    low: [f64; 3],
    side: f64,
}

impl Cube {
    /// The base of an arm, the origin, is always in it.
    fn around(points: &[[f64; 3]]) -> Option<Self> {
        let _first = points.first()?;
        let range = |axis: usize| {
            let numbers = points.iter().filter_map(move |point| point.get(axis));
            extent(numbers.copied().chain([0.0])).unwrap_or((0.0, 0.0))
        };
        let ranges = [range(0), range(1), range(2)];
        let widest = ranges
            .iter()
            .map(|(low, high)| high - low)
            .fold(0.0, f64::max);
        let side = if widest > 0.0 { widest * 1.16 } else { 1.0 };
        Some(Self {
            low: ranges.map(|(low, high)| f64::midpoint(low, high) - side / 2.0),
            side,
        })
    }

    fn range(&self, axis: usize) -> (f64, f64) {
        let low = self.low.get(axis).copied().unwrap_or(0.0);
        (low, low + self.side)
    }
}

fn projection(
    area: &Area<'_>,
    rect: Rect,
    skeleton: &Skeleton,
    cube: Cube,
    name: &str,
    (across, up): (usize, usize),
) -> Result<(), PlotError> {
    let letter = |axis: usize| ["X", "Y", "Z"].get(axis).copied().unwrap_or_default();
    write(
        area,
        name,
        (rect.left + LEFT, rect.top + 13.0),
        Lettering::LABEL,
    )?;
    // The plot itself is a square.
    let side = (rect.width - LEFT - 8.0).min(rect.height - BELOW - ABOVE);
    let plot = Rect {
        top: rect.top + ABOVE,
        width: side + LEFT,
        height: side + BELOW,
        ..rect
    };
    let axes = Axes {
        x: cube.range(across),
        y: cube.range(up),
        x_label: &format!("{} in {}", letter(across), skeleton.unit),
        y_label: &format!("{} in {}", letter(up), skeleton.unit),
    };
    let frame = Frame::new(area, plot, axes)?;
    let flat = |point: &[f64; 3]| {
        let number = |axis: usize| point.get(axis).copied().unwrap_or_default();
        (number(across), number(up))
    };
    for body in &skeleton.bodies {
        for capsule in &body.capsules {
            let ends = [flat(&capsule.from), flat(&capsule.to)];
            frame.capsule(ends, capsule.radius, body.color)?;
        }
    }
    for stick in &skeleton.sticks {
        let points: Vec<(f64, f64)> = stick.points.iter().map(flat).collect();
        frame.line(&points, stick.color, stick.pixels)?;
        let up_is_less: Vec<(f64, f64)> = points.iter().map(|&(x, y)| (x, -y)).collect();
        for (index, (&point, letter)) in points.iter().zip(&stick.letters).enumerate() {
            frame.dot(point, stick.color, stick.pixels * 0.5 + 1.8)?;
            let off = beside(&up_is_less, index);
            frame.text(letter, point, off, lettering(off))?;
        }
    }
    Ok(())
}

/// A letter, or a word that begins or ends where its point is.
fn lettering((right, _): (f64, f64)) -> Lettering {
    let anchor = if right > 5.0 {
        HPos::Left
    } else if right < -5.0 {
        HPos::Right
    } else {
        HPos::Center
    };
    Lettering::SMALL.color(Color::INK).anchored(anchor)
}

/// Where the letter of a point stands, in pixels from it (down is more): on the side where its stick is not.
fn beside(places: &[(f64, f64)], index: usize) -> (f64, f64) {
    let Some(&(x, y)) = places.get(index) else {
        return (0.0, 0.0);
    };
    let neighbors = [index.checked_sub(1), index.checked_add(1)];
    let directions: Vec<(f64, f64)> = neighbors
        .into_iter()
        .flatten()
        .filter_map(|other| places.get(other))
        .filter_map(|&(nx, ny)| {
            let length = (nx - x).hypot(ny - y);
            (length > 1e-9).then(|| ((nx - x) / length, (ny - y) / length))
        })
        .collect();
    let (sx, sy) = directions
        .iter()
        .fold((0.0, 0.0), |sum, way| (sum.0 + way.0, sum.1 + way.1));
    let length = f64::hypot(sx, sy);
    let (dx, dy) = match directions.as_slice() {
        // Straight on: beside the stick, rather above than below.
        [(wx, wy), ..] if length < 0.3 => {
            if *wx > 0.0 || (*wx == 0.0 && *wy > 0.0) {
                (*wy, -wx)
            } else {
                (-wy, *wx)
            }
        }
        [] => (0.7, -0.7),
        _ => (-sx / length, -sy / length),
    };
    (dx * 11.0, dy * 12.0)
}

/// Where the eye is: turned from the X axis towards Y, and raised, in degrees.
const AZIMUTH: f64 = -55.0;
const ELEVATION: f64 = 24.0;

/// A place of the picture from above and aside, in lengths of the cube's side.
fn seen(point: [f64; 3]) -> (f64, f64) {
    let (sin_a, cos_a) = AZIMUTH.to_radians().sin_cos();
    let (sin_e, cos_e) = ELEVATION.to_radians().sin_cos();
    let [x, y, z] = point;
    (
        -sin_a * x + cos_a * y,
        cos_e * z - sin_e * (cos_a * x + sin_a * y),
    )
}

fn in_space(area: &Area<'_>, rect: Rect, skeleton: &Skeleton, cube: Cube) -> Result<(), PlotError> {
    // The corners of a cube of side 1 decide what fits.
    let corners = (0..8).map(|bits| {
        let bit = |which: i32| if bits & (1 << which) == 0 { 0.0 } else { 1.0 };
        seen([bit(0), bit(1), bit(2)])
    });
    let (left, right) = extent(corners.clone().map(|corner| corner.0)).unwrap_or((0.0, 1.0));
    let (down, up) = extent(corners.map(|corner| corner.1)).unwrap_or((0.0, 1.0));
    // Room for the numbers and names around the cube.
    let (room_x, room_y) = (rect.width - 90.0, rect.height - 60.0);
    let scale = (room_x / (right - left)).min(room_y / (up - down));
    let middle = (rect.left + rect.width / 2.0, rect.top + rect.height / 2.0);
    let share = |point: [f64; 3]| -> [f64; 3] {
        let mut share = [0.0; 3];
        for ((share, value), low) in share.iter_mut().zip(point).zip(cube.low) {
            *share = (value - low) / cube.side;
        }
        share
    };
    let place = |point: [f64; 3]| {
        let (x, y) = seen(share(point));
        (
            middle.0 + (x - f64::midpoint(left, right)) * scale,
            middle.1 - (y - f64::midpoint(down, up)) * scale,
        )
    };
    let line = |points: &[[f64; 3]], color: Color, pixels: f64| {
        let places = points.iter().map(|&point| {
            let (x, y) = place(point);
            at(x, y)
        });
        let style = color.0.stroke_width(units(pixels).unsigned_abs());
        area.draw(&PathElement::new(places.collect::<Vec<_>>(), style))
            .map_err(broken)
    };
    cage(cube, &line)?;
    numbers(area, cube, &skeleton.unit, &place)?;
    for body in &skeleton.bodies {
        for capsule in &body.capsules {
            let pixels = (2.0 * capsule.radius / cube.side * scale).max(1.0);
            line(&[capsule.from, capsule.to], body.color, pixels)?;
        }
    }
    for stick in &skeleton.sticks {
        // Its shadow on the floor shows where in X and Y it is.
        let floor: Vec<[f64; 3]> = stick
            .points
            .iter()
            .map(|&[x, y, _]| [x, y, cube.low[2]])
            .collect();
        line(&floor, Color::FAINT, (stick.pixels * 0.6).max(1.0))?;
    }
    for stick in &skeleton.sticks {
        line(&stick.points, stick.color, stick.pixels)?;
        let places: Vec<(f64, f64)> = stick.points.iter().map(|&point| place(point)).collect();
        for (index, (&(x, y), letter)) in places.iter().zip(&stick.letters).enumerate() {
            let size = stick.pixels * 0.5 + 1.8;
            area.draw(&Circle::new(at(x, y), units(size + 1.2), WHITE.filled()))
                .map_err(broken)?;
            area.draw(&Circle::new(at(x, y), units(size), stick.color.0.filled()))
                .map_err(broken)?;
            let off = beside(&places, index);
            write(area, letter, (x + off.0, y + off.1), lettering(off))?;
        }
    }
    write(
        area,
        "In space",
        (rect.left + LEFT, rect.top + 13.0),
        Lettering::LABEL,
    )
}

/// The three sides of the cube that are behind what is drawn, with a grid.
fn cage(
    cube: Cube,
    line: &impl Fn(&[[f64; 3]], Color, f64) -> Result<(), PlotError>,
) -> Result<(), PlotError> {
    let [x, y, z] = [cube.range(0), cube.range(1), cube.range(2)];
    let step = step(cube.side, TICKS);
    for at in multiples(x.0, x.1, step) {
        line(
            &[[at, y.0, z.0], [at, y.1, z.0], [at, y.1, z.1]],
            Color::GRID,
            1.0,
        )?;
    }
    for at in multiples(y.0, y.1, step) {
        line(
            &[[x.1, at, z.0], [x.0, at, z.0], [x.0, at, z.1]],
            Color::GRID,
            1.0,
        )?;
    }
    for at in multiples(z.0, z.1, step) {
        line(
            &[[x.0, y.0, at], [x.0, y.1, at], [x.1, y.1, at]],
            Color::GRID,
            1.0,
        )?;
    }
    for edge in [
        [[x.0, y.0, z.0], [x.1, y.0, z.0], [x.1, y.1, z.0]],
        [[x.0, y.0, z.0], [x.0, y.0, z.1], [x.0, y.1, z.1]],
        [[x.0, y.1, z.1], [x.1, y.1, z.1], [x.1, y.1, z.0]],
        [[x.0, y.0, z.0], [x.0, y.1, z.0], [x.1, y.1, z.0]],
    ] {
        line(&edge, Color::FAINT, 1.0)?;
    }
    line(&[[x.0, y.1, z.0], [x.0, y.1, z.1]], Color::FAINT, 1.0)
}

/// The numbers and names along the three edges in front.
fn numbers(
    area: &Area<'_>,
    cube: Cube,
    unit: &str,
    place: &impl Fn([f64; 3]) -> (f64, f64),
) -> Result<(), PlotError> {
    let [x, y, z] = [cube.range(0), cube.range(1), cube.range(2)];
    let step = step(cube.side, TICKS);
    let small = Lettering::SMALL;
    for value in multiples(x.0, x.1, step) {
        let (px, py) = place([value, y.0, z.0]);
        let lettering = small.anchored(HPos::Center);
        write(area, &number(value), (px - 4.0, py + 12.0), lettering)?;
    }
    for value in multiples(y.0, y.1, step) {
        let (px, py) = place([x.1, value, z.0]);
        write(area, &number(value), (px + 7.0, py + 6.0), small)?;
    }
    for value in multiples(z.0, z.1, step) {
        let (px, py) = place([x.0, y.0, value]);
        let lettering = small.anchored(HPos::Right);
        write(area, &number(value), (px - 7.0, py), lettering)?;
    }
    let middle = |range: (f64, f64)| f64::midpoint(range.0, range.1);
    let label = Lettering::LABEL;
    let (px, py) = place([middle(x), y.0, z.0]);
    let lettering = label.anchored(HPos::Center);
    write(
        area,
        &format!("X in {unit}"),
        (px - 14.0, py + 30.0),
        lettering,
    )?;
    let (px, py) = place([x.1, middle(y), z.0]);
    write(area, &format!("Y in {unit}"), (px + 22.0, py + 28.0), label)?;
    let (px, py) = place([x.0, y.0, z.1]);
    write(area, &format!("Z in {unit}"), (px - 26.0, py - 14.0), label)
}
