//! Joint rates, as the arm shows them.

use api::arms::{ArmForwardResult, ArmRatesResult, ArmTwist};

use super::arm::{Letters, UNIT, arm_stick, place};
use super::short;
use crate::{Color, Drawing, PlotError, Skeleton, Stick, skeleton};

/// The arm `now` and `later`: `after_s` seconds on at these rates, with the way that the asked velocity would have taken
/// the tool. What a null-space motion moves is seen too: the arm, not the tool.
///
/// # Errors
/// A value that cannot be drawn.
pub fn rates(
    model: &str,
    answer: &ArmRatesResult,
    velocity: &ArmTwist,
    after_s: f64,
    (now, later): (&ArmForwardResult, &ArmForwardResult),
) -> Result<Drawing, PlotError> {
    let start = place(&now.tcp);
    let mut end = start;
    for (end, speed) in end.iter_mut().zip(velocity.linear_mm_s) {
        *end += speed * after_s;
    }
    let after = short(after_s);
    skeleton(&Skeleton {
        title: format!("{model}: the arm now, and {after} s later at its joints' rates"),
        note: format!("{} % of what the joints can do", short(answer.load * 100.0)),
        unit: UNIT.to_owned(),
        bodies: Vec::new(),
        sticks: vec![
            arm_stick("now", Color::FAINT, now, Letters::None),
            arm_stick("later", Color::MAIN, later, Letters::Written),
            Stick {
                name: "the tool's velocity".to_owned(),
                color: Color::LIMIT,
                pixels: 2.4,
                points: vec![start, end],
                letters: Vec::new(),
            },
        ],
    })
}
