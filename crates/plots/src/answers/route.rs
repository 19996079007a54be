//! A disc among polygons.

use std::collections::BTreeMap;

use api::paths::{PlanRouteResult, RouteMethod};

use super::short;
use crate::{Drawing, Item, Look, Map, PlotError, map};

type Point = (f64, f64);

/// The floor, what stands on it, what was looked at, and the route.
///
/// # Errors
/// A value that cannot be drawn.
pub fn route(answer: &PlanRouteResult) -> Result<Drawing, PlotError> {
    let method = match answer.method {
        RouteMethod::Trapezoidal => "trapezoidal cell decomposition",
        RouteMethod::Quadtree => "approximate cell decomposition",
        RouteMethod::PotentialField => "potential field",
        RouteMethod::Roadmap => "probabilistic roadmap",
    };
    let graph = match answer.method {
        RouteMethod::PotentialField => "walked on the way",
        RouteMethod::Trapezoidal | RouteMethod::Quadtree | RouteMethod::Roadmap => "roadmap",
    };
    let mut items = Vec::new();
    let outlines = |free: bool| {
        let cells = answer.cells.iter().filter(move |cell| cell.free == free);
        cells.map(|cell| polygon(&cell.corners_mm))
    };
    for points in outlines(false) {
        items.push(Item::Region {
            name: "cell not wholly free".to_owned(),
            points,
            look: Look::Closed,
        });
    }
    for points in outlines(true) {
        items.push(Item::Region {
            name: "free cell".to_owned(),
            points,
            look: Look::Cell,
        });
    }
    for obstacle in &answer.obstacles {
        items.push(Item::Region {
            name: "obstacle".to_owned(),
            points: polygon(&obstacle.corners_mm),
            look: Look::Obstacle,
        });
    }
    let ([x0, y0], [x1, y1]) = (answer.floor.min_mm, answer.floor.max_mm);
    items.push(Item::Region {
        name: "edge of the floor".to_owned(),
        points: vec![(x0, y0), (x1, y0), (x1, y1), (x0, y1)],
        look: Look::Bounds,
    });
    if !answer.graph_mm.is_empty() {
        let lines = chained(&answer.graph_mm);
        items.push(Item::Lines {
            name: graph.to_owned(),
            lines,
            look: Look::Graph,
        });
    }
    items.push(Item::Lines {
        name: "route".to_owned(),
        lines: vec![polygon(&answer.points_mm)],
        look: Look::Path,
    });
    let ends = [
        (answer.points_mm.first(), "start", Look::Start),
        (answer.points_mm.last(), "goal", Look::Goal),
    ];
    for (place, name, look) in ends {
        let Some(&[x, y]) = place else { continue };
        if answer.radius_mm > 0.0 {
            items.push(Item::Ring {
                name: String::new(),
                center: (x, y),
                radius: answer.radius_mm,
                look,
            });
        }
        items.push(Item::Dot {
            name: name.to_owned(),
            at: (x, y),
            text: String::new(),
            look,
        });
    }
    map(&Map {
        title: format!(
            "A disc of {} mm radius among obstacles: {method}",
            short(answer.radius_mm)
        ),
        note: format!(
            "{} mm in {} straight pieces, {} mm clear at the narrowest place",
            short(answer.length_mm),
            answer.points_mm.len().saturating_sub(1),
            short(answer.clearance_mm),
        ),
        x_label: "X in mm".to_owned(),
        y_label: "Y in mm".to_owned(),
        items,
    })
}

fn polygon(corners: &[[f64; 2]]) -> Vec<Point> {
    corners.iter().map(|&[x, y]| (x, y)).collect()
}

/// The edges as few long lines, each edge once: a walk is one line then, and a roadmap of thousands of edges a small file.
fn chained(edges: &[[[f64; 2]; 2]]) -> Vec<Vec<Point>> {
    let key = |[x, y]: [f64; 2]| (x.to_bits(), y.to_bits());
    // Edges by the places they begin or end at, the first last, so that it is taken first.
    let mut at: BTreeMap<(u64, u64), Vec<usize>> = BTreeMap::new();
    for (index, edge) in edges.iter().enumerate().rev() {
        for &end in edge {
            at.entry(key(end)).or_default().push(index);
        }
    }
    let mut open = vec![true; edges.len()];
    let mut lines: Vec<Vec<Point>> = Vec::new();
    for (first, &[from, _]) in edges.iter().enumerate() {
        if open.get(first) != Some(&true) {
            continue;
        }
        let mut here = from;
        let mut line = vec![(here[0], here[1])];
        while let Some(index) = at.get_mut(&key(here)).and_then(Vec::pop) {
            let (Some(is_open), Some(&[a, b])) = (open.get_mut(index), edges.get(index)) else {
                continue;
            };
            if !std::mem::replace(is_open, false) {
                continue;
            }
            here = if key(a) == key(here) { b } else { a };
            line.push((here[0], here[1]));
        }
        lines.push(line);
    }
    lines
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn edges_that_follow_each_other_are_one_line() {
        let edges = [
            [[0.0, 0.0], [1.0, 0.0]],
            [[1.0, 0.0], [1.0, 1.0]],
            [[5.0, 5.0], [6.0, 6.0]],
        ];
        let lines = chained(&edges);
        assert_eq!(lines.len(), 2);
        assert_eq!(lines[0], [(0.0, 0.0), (1.0, 0.0), (1.0, 1.0)]);
    }

    #[test]
    fn each_edge_of_a_net_is_drawn_once() {
        // All edges between seven places on a circle, some of them the other way around.
        let places: Vec<[f64; 2]> = (0..7)
            .map(|n| {
                let (sin, cos) = f64::from(n).sin_cos();
                [cos, sin]
            })
            .collect();
        let mut edges = Vec::new();
        for (n, &a) in places.iter().enumerate() {
            for &b in &places[..n] {
                edges.push(if edges.len() % 3 == 0 { [b, a] } else { [a, b] });
            }
        }
        let lines = chained(&edges);
        assert!(lines.len() <= 4, "{}", lines.len());
        let ordered = |(a, b): (Point, Point)| if a < b { (a, b) } else { (b, a) };
        let mut drawn: Vec<_> = lines
            .iter()
            .flat_map(|line| line.windows(2).map(|pair| ordered((pair[0], pair[1]))))
            .collect();
        let mut wanted: Vec<_> = edges
            .iter()
            .map(|&[a, b]| ordered(((a[0], a[1]), (b[0], b[1]))))
            .collect();
        drawn.sort_by(|a, b| a.partial_cmp(b).unwrap());
        wanted.sort_by(|a, b| a.partial_cmp(b).unwrap());
        assert_eq!(drawn, wanted);
    }
}
