//! A disc among polygons.

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
            name: "cell that is not free".to_owned(),
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

/// Edges that follow each other as one line: a walk of thousands of steps is drawn, and simplified, as one.
fn chained(edges: &[[[f64; 2]; 2]]) -> Vec<Vec<Point>> {
    let mut lines: Vec<Vec<Point>> = Vec::new();
    for &[[ax, ay], [bx, by]] in edges {
        match lines.last_mut() {
            Some(line) if line.last() == Some(&(ax, ay)) => line.push((bx, by)),
            _ => lines.push(vec![(ax, ay), (bx, by)]),
        }
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
}
