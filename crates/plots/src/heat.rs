//! Counts over the cells of a plane.

use std::collections::BTreeSet;

use crate::error::all_finite;
use crate::figure::Heading;
use crate::legend::{Entry, Sign, unique};
use crate::map::{Item, View};
use crate::palette::scale;
use crate::ticks::extent;
use crate::{Color, Drawing, PlotError};

/// A count for each cell of a rectangular grid.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct HeatMap {
    /// Above the map.
    pub title: String,
    /// Below the title.
    pub note: String,
    /// The quantity of the X axis and its unit.
    pub x_label: String,
    /// The quantity of the Y axis and its unit.
    pub y_label: String,
    /// What is counted, for the legend: `branches`.
    pub counted: String,
    /// The middles of the columns, rising, equally far from each other.
    pub x: Vec<f64>,
    /// The middles of the rows, rising, equally far from each other.
    pub y: Vec<f64>,
    /// For each row, for each of its columns.
    pub counts: Vec<Vec<u32>>,
    /// What is drawn on the cells.
    pub items: Vec<Item>,
}

/// Draws a map of counts: none is white, and the more the lighter from violet to yellow.
///
/// # Errors
/// [`PlotError::Empty`] without a cell, [`PlotError::NotFinite`], [`PlotError::Shape`] if there is not one count for each cell.
pub fn heat_map(map: &HeatMap) -> Result<Drawing, PlotError> {
    all_finite(&map.title, map.x.iter().chain(&map.y).copied())?;
    let shape = |what: &str, given: usize, wanted: usize| PlotError::Shape {
        what: format!("{}: {what}", map.title),
        given,
        wanted,
    };
    if map.counts.len() != map.y.len() {
        return Err(shape("rows", map.counts.len(), map.y.len()));
    }
    if let Some(row) = map.counts.iter().find(|row| row.len() != map.x.len()) {
        return Err(shape("a row", row.len(), map.x.len()));
    }
    let (x, y) = (edges(&map.x), edges(&map.y));
    let empty = || PlotError::Empty {
        what: map.title.clone(),
    };
    let across = extent(x.iter().copied()).ok_or_else(empty)?;
    let up = extent(y.iter().copied()).ok_or_else(empty)?;
    let seen: BTreeSet<u32> = map.counts.iter().flatten().copied().collect();
    let most = seen.last().copied().unwrap_or(0);
    let entries = swatches(&seen).into_iter().map(|count| Entry {
        sign: Sign::Fill {
            color: color(count, most),
            opacity: 1.0,
        },
        name: if count == 0 {
            format!("0 {}", map.counted)
        } else {
            count.to_string()
        },
    });
    let legend = unique(entries.chain(map.items.iter().map(Item::entry)));
    let heading = Heading {
        title: &map.title,
        note: &map.note,
        legend: &legend,
    };
    let view = View::of(across, up);
    view.sheet(&heading, (&map.x_label, &map.y_label), |frame| {
        for (row, pair) in map.counts.iter().zip(y.windows(2)) {
            let &[low, above] = pair else { continue };
            // Under the next row's edge, so that nothing shines through between the two.
            let high = above + (above - low) * 0.08;
            for (from, to, count) in runs(row) {
                let (Some(&left), Some(&right)) = (x.get(from), x.get(to)) else {
                    continue;
                };
                if count > 0 {
                    frame.rectangle([(left, low), (right, high)], color(count, most))?;
                }
            }
        }
        map.items.iter().try_for_each(|item| item.draw(frame))
    })
}

/// The edges of the cells around `middles`.
fn edges(middles: &[f64]) -> Vec<f64> {
    let step = match middles {
        [first, second, ..] => second - first,
        _ => 1.0,
    };
    let mut edges: Vec<f64> = middles.iter().map(|middle| middle - step / 2.0).collect();
    edges.extend(middles.last().map(|last| last + step / 2.0));
    edges
}

/// Neighbors of the same count: from which cell, to before which, and the count.
fn runs(row: &[u32]) -> Vec<(usize, usize, u32)> {
    let mut runs: Vec<(usize, usize, u32)> = Vec::new();
    for (index, &count) in row.iter().enumerate() {
        match runs.last_mut() {
            Some((_, to, same)) if *same == count => *to = index + 1,
            _ => runs.push((index, index + 1, count)),
        }
    }
    runs
}

/// The counts that the legend shows: all there are, or nine of them.
fn swatches(seen: &BTreeSet<u32>) -> Vec<u32> {
    if seen.len() <= 12 {
        return seen.iter().copied().collect();
    }
    let all: Vec<u32> = seen.iter().copied().collect();
    let every = all.len().div_ceil(9);
    let mut some: Vec<u32> = all.iter().copied().step_by(every).collect();
    some.extend(all.last());
    some.dedup();
    some
}

fn color(count: u32, most: u32) -> Color {
    if count == 0 {
        return Color::PAPER;
    }
    if most <= 1 {
        return scale(0.35);
    }
    scale(f64::from(count - 1) / f64::from(most - 1))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn neighbors_of_the_same_count_are_one_rectangle() {
        assert_eq!(runs(&[0, 0, 2, 2, 2, 1]), [(0, 2, 0), (2, 5, 2), (5, 6, 1)]);
        assert_eq!(runs(&[]), []);
    }

    #[test]
    fn a_cell_reaches_half_a_step_to_each_side() {
        assert_eq!(edges(&[0.0, 10.0, 20.0]), [-5.0, 5.0, 15.0, 25.0]);
        assert_eq!(edges(&[3.0]), [2.5, 3.5]);
    }

    #[test]
    fn a_long_legend_is_shortened_but_keeps_both_ends() {
        let seen: BTreeSet<u32> = (1..=100).collect();
        let some = swatches(&seen);
        assert!(some.len() <= 11, "{some:?}");
        assert_eq!((some[0], some[some.len() - 1]), (1, 100));
    }
}
