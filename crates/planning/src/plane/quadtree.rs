//! Approximate cell decomposition.

use super::Point;
use super::floor::{Floor, PlaneError, within};
use super::graph::shortest;
use super::polygon::between;
use super::route::Route;
use super::sketch::{Sketch, SketchedCell};
use crate::wanted::Wanted;

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Color {
    /// The robot can stand anywhere in it.
    White,
    /// Partly, or not known.
    Gray,
    /// Nowhere, or too small to be looked into.
    Black,
}

#[derive(Clone, Copy, Debug)]
struct Cell {
    middle: Point,
    half: [f64; 2],
    color: Color,
    /// The first of four.
    children: Option<usize>,
}

/// A path through gray cells is worth looking into if it is not this much longer than a white one.
const GRAY_COSTS: f64 = 2.0;
const MAX_CELLS: usize = 400_000;

/// A path by approximate (quadtree) cell decomposition, its detours left out.
///
/// As the textbook has it: the shortest way through white and gray cells is looked for; the gray
/// cells on it are divided, until a way is all white. Cells smaller than `resolution` (mm) count as
/// black.
///
/// # Errors
/// Start or goal where the robot cannot stand, a resolution below 0.1 mm, or no path at this
/// resolution.
pub fn quadtree(
    floor: &Floor,
    start: Point,
    goal: Point,
    resolution: f64,
) -> Result<Route, PlaneError> {
    Ok(quadtree_sketched(floor, start, goal, resolution, Wanted::ALWAYS)?.0)
}

/// As [`quadtree`], with the cells as far as they were divided, as long as the path is `wanted`.
///
/// # Errors
/// As [`quadtree`]; [`PlaneError::BrokenOff`].
pub fn quadtree_sketched(
    floor: &Floor,
    start: Point,
    goal: Point,
    resolution: f64,
    wanted: Wanted<'_>,
) -> Result<(Route, Sketch), PlaneError> {
    let resolution = within("resolution", resolution, 0.1, 1e5)?;
    floor.check("start", start)?;
    floor.check("goal", goal)?;
    let method = "approximate cell decomposition";
    let mut tree = Tree::new(floor, resolution);
    loop {
        wanted.check()?;
        let (first, last) = (tree.leaf(start), tree.leaf(goal));
        let way = tree
            .way(first, last, goal)
            .ok_or(PlaneError::NoPath { method, resolution })?;
        let gray: Vec<usize> = way
            .iter()
            .copied()
            .filter(|index| tree.is(*index, Color::Gray))
            .collect();
        if gray.is_empty() {
            let mut points = vec![start];
            for (from, to) in way.iter().zip(way.iter().skip(1)) {
                points.extend(tree.door(*from, *to));
            }
            points.push(goal);
            let route = Route::new(points).shortened(floor, wanted)?;
            return Ok((route, tree.sketched()));
        }
        for index in gray {
            tree.divide(index);
        }
        if tree.cells.len() > MAX_CELLS {
            return Err(PlaneError::GaveUp {
                method,
                effort: u32::try_from(MAX_CELLS).unwrap_or(u32::MAX),
                unit: "cells",
            });
        }
    }
}

struct Tree<'a> {
    floor: &'a Floor,
    resolution: f64,
    cells: Vec<Cell>,
}

impl<'a> Tree<'a> {
    fn new(floor: &'a Floor, resolution: f64) -> Tree<'a> {
        let ([x0, y0], [x1, y1]) = (floor.min(), floor.max());
        let half = [0.5 * (x1 - x0), 0.5 * (y1 - y0)];
        let mut tree = Tree {
            floor,
            resolution,
            cells: Vec::new(),
        };
        let root = tree.cell([x0 + half[0], y0 + half[1]], half);
        tree.cells.push(root);
        tree
    }

    /// A clearance changes by no more than the way: that of the middle tells about the whole cell.
    fn cell(&self, middle: Point, half: [f64; 2]) -> Cell {
        let clearance = self.floor.clearance(middle);
        let reach = half[0].hypot(half[1]);
        let color = if clearance >= reach {
            Color::White
        } else if clearance <= -reach || 2.0 * half[0].max(half[1]) < self.resolution {
            Color::Black
        } else {
            Color::Gray
        };
        Cell {
            middle,
            half,
            color,
            children: None,
        }
    }

    fn sketched(&self) -> Sketch {
        let leaves = self.cells.iter().filter(|cell| cell.children.is_none());
        let cells = leaves.map(|cell| {
            let ([x, y], [w, h]) = (cell.middle, cell.half);
            SketchedCell {
                corners: [
                    [x - w, y - h],
                    [x + w, y - h],
                    [x + w, y + h],
                    [x - w, y + h],
                ],
                free: cell.color == Color::White,
            }
        });
        Sketch {
            cells: cells.collect(),
            edges: Vec::new(),
        }
    }

    fn is(&self, index: usize, color: Color) -> bool {
        self.cells
            .get(index)
            .is_some_and(|cell| cell.color == color)
    }

    fn divide(&mut self, index: usize) {
        let first = self.cells.len();
        let Some(cell) = self.cells.get_mut(index) else {
            return;
        };
        cell.children = Some(first);
        let ([x, y], [w, h]) = (cell.middle, cell.half.map(|half| 0.5 * half));
        for middle in [
            [x - w, y - h],
            [x + w, y - h],
            [x - w, y + h],
            [x + w, y + h],
        ] {
            let child = self.cell(middle, [w, h]);
            self.cells.push(child);
        }
    }

    fn leaf(&self, [x, y]: Point) -> usize {
        let mut at = 0;
        while let Some(cell) = self.cells.get(at)
            && let Some(first) = cell.children
        {
            let [mx, my] = cell.middle;
            at = first + usize::from(x > mx) + 2 * usize::from(y > my);
        }
        at
    }

    fn way(&self, first: usize, last: usize, goal: Point) -> Option<Vec<usize>> {
        if self.is(first, Color::Black) || self.is(last, Color::Black) {
            return None;
        }
        let middle = |index: usize| self.cells.get(index).map_or(goal, |cell| cell.middle);
        shortest(
            self.cells.len(),
            first,
            last,
            |node, around| {
                let Some(cell) = self.cells.get(node) else {
                    return;
                };
                let here = around.len();
                self.beside(cell, 0, around);
                for (next, cost) in around.iter_mut().skip(here) {
                    *cost = between(cell.middle, middle(*next));
                    if self.is(*next, Color::Gray) {
                        *cost *= GRAY_COSTS;
                    }
                }
                around.retain(|(next, _)| *next != node);
            },
            |node| between(middle(node), middle(last)),
        )
    }

    /// The leaves that share a piece of a side with `cell`.
    fn beside(&self, cell: &Cell, at: usize, found: &mut Vec<(usize, f64)>) {
        let Some(other) = self.cells.get(at) else {
            return;
        };
        let (x, y) = (gap(cell, other, 0), gap(cell, other, 1));
        if x > 1e-9 || y > 1e-9 {
            return;
        }
        if let Some(first) = other.children {
            for child in first..first + 4 {
                self.beside(cell, child, found);
            }
        } else if other.color != Color::Black && x.min(y) < -1e-9 {
            // Touching in one direction, overlapping in the other; not only at a corner.
            found.push((at, 0.0));
        }
    }

    /// The middle of the common side.
    fn door(&self, from: usize, to: usize) -> Option<Point> {
        let (a, b) = (self.cells.get(from)?, self.cells.get(to)?);
        let middle = |(am, ah): (f64, f64), (bm, bh): (f64, f64)| {
            0.5 * ((am - ah).max(bm - bh) + (am + ah).min(bm + bh))
        };
        let [ax, ay] = a.middle;
        let [bx, by] = b.middle;
        Some([
            middle((ax, a.half[0]), (bx, b.half[0])),
            middle((ay, a.half[1]), (by, b.half[1])),
        ])
    }
}

/// How far two cells are apart along x (0) or y (1); negative if they overlap.
fn gap(a: &Cell, b: &Cell, axis: usize) -> f64 {
    let of = |values: &[f64; 2]| if axis == 0 { values[0] } else { values[1] };
    (of(&a.middle) - of(&b.middle)).abs() - of(&a.half) - of(&b.half)
}
