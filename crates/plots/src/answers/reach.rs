//! Where an arm reaches.

use api::arms::{ReachGrid, ReachPlane, ReachResult};

use super::{listed, short};
use crate::{Drawing, HeatMap, Item, Look, PlotError, heat_map};

/// How many joint sets inside the ranges reach each point of a grid.
///
/// # Errors
/// [`PlotError::Shape`] if there is not one count for each point of the grid; a value that cannot be drawn.
pub fn reach(model: &str, grid: &ReachGrid, answer: &ReachResult) -> Result<Drawing, PlotError> {
    let columns = answer.u_mm.len();
    let wanted = columns * answer.v_mm.len();
    if answer.inside.len() != wanted {
        return Err(PlotError::Shape {
            what: "the counts of a reachability grid".to_owned(),
            given: answer.inside.len(),
            wanted,
        });
    }
    let rows = answer.inside.chunks(columns.max(1));
    let counts = rows.map(|row| row.iter().copied().map(u32::from).collect());
    let (plane, u, v, across) = match grid.plane {
        ReachPlane::Xy => ("XY", "X", "Y", "Z"),
        ReachPlane::Xz => ("XZ", "X", "Z", "Y"),
        ReachPlane::Yz => ("YZ", "Y", "Z", "X"),
    };
    let base_is_seen = |edges: &[f64]| match edges {
        [first, .., last] => *first <= 0.0 && 0.0 <= *last,
        [] | [_] => false,
    };
    let mut items = Vec::new();
    if base_is_seen(&answer.u_mm) && base_is_seen(&answer.v_mm) {
        items.push(Item::Dot {
            name: "base".to_owned(),
            at: (0.0, 0.0),
            text: String::new(),
            look: Look::Fault,
        });
    }
    heat_map(&HeatMap {
        title: format!(
            "Reach of {model} in {plane} at {across} = {} mm",
            short(grid.across_mm)
        ),
        note: format!(
            "Joint sets inside the ranges, the tool at W, P, R = {}°; {} of {wanted} poses are reached",
            listed(&[grid.w_deg, grid.p_deg, grid.r_deg]),
            answer.reachable,
        ),
        x_label: format!("{u} in mm"),
        y_label: format!("{v} in mm"),
        counted: "joint sets".to_owned(),
        x: answer.u_mm.clone(),
        y: answer.v_mm.clone(),
        counts: counts.collect(),
        items,
    })
}
