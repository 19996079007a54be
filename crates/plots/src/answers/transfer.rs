//! An arm among obstacles.

use api::arms::{ArmObstacle, ArmTransferResult, PlacedCapsule};

use super::arm::{UNIT, capsule};
use super::short;
use super::solid::wires;
use crate::{Body, Color, Drawing, PlotError, Skeleton, Stick, skeleton};

/// The obstacles, the arm's shape at the start and at the goal, and the flange's way.
///
/// # Errors
/// A value that cannot be drawn.
pub fn transfer(
    model: &str,
    obstacles: &[ArmObstacle],
    answer: &ArmTransferResult,
) -> Result<Drawing, PlotError> {
    let body = |name: &str, color: Color, capsules: Option<&Vec<PlacedCapsule>>| Body {
        name: name.to_owned(),
        color,
        capsules: capsules.into_iter().flatten().map(capsule).collect(),
    };
    let bodies = vec![
        body("arm at the goal", Color::GOAL_BODY, answer.capsules.last()),
        body(
            "arm at the start",
            Color::START_BODY,
            answer.capsules.first(),
        ),
    ];
    let mut sticks: Vec<Stick> = obstacles
        .iter()
        .flat_map(|obstacle| {
            let name = match obstacle {
                ArmObstacle::Box { .. } | ArmObstacle::Cylinder { .. } => "obstacle",
                ArmObstacle::KeepOut { .. } => "keep-out zone",
            };
            let color = match obstacle {
                ArmObstacle::Box { .. } | ArmObstacle::Cylinder { .. } => Color::INK,
                ArmObstacle::KeepOut { .. } => Color::LIMIT,
            };
            wires(obstacle).into_iter().map(move |points| Stick {
                name: name.to_owned(),
                color,
                pixels: 1.4,
                points,
                letters: Vec::new(),
            })
        })
        .collect();
    sticks.push(Stick {
        name: "way of the flange".to_owned(),
        color: Color::MAIN,
        pixels: 2.6,
        points: answer.flange_mm.clone(),
        letters: Vec::new(),
    });
    let pieces = answer.points_deg_mm.len().saturating_sub(1);
    let slid = answer
        .length_mm
        .map(|length| format!(" and {} mm", short(length)));
    let slid = slid.unwrap_or_default();
    skeleton(&Skeleton {
        title: format!("{model}: a way that touches nothing"),
        note: format!(
            "{pieces} straight {} of joint space, {}°{slid} together",
            if pieces == 1 { "piece" } else { "pieces" },
            short(answer.length_deg)
        ),
        unit: UNIT.to_owned(),
        bodies,
        sticks,
    })
}
