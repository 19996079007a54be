//! A motion by a velocity vector, as the paper's figures 3 and 4 show it.

use api::arms::{ArmDescription, ArmForwardResult, ArmMotionEnd, ArmVelocityMotionResult};

use super::arm::{Letters, UNIT, arm_stick};
use super::short;
use super::trajectory::position_panels;
use crate::{Color, Drawing, Moment, PlotError, Skeleton, Stick, panels, skeleton};

/// The arm at the start and at the end, and the tool's way between them.
///
/// # Errors
/// A value that cannot be drawn.
pub fn velocity_motion(
    model: &str,
    answer: &ArmVelocityMotionResult,
    start: &ArmForwardResult,
    end: &ArmForwardResult,
) -> Result<Drawing, PlotError> {
    let way = Stick {
        name: "way of the tool".to_owned(),
        color: Color::of(3),
        pixels: 2.4,
        points: answer.samples.iter().map(|sample| sample.tcp_mm).collect(),
        letters: Vec::new(),
    };
    skeleton(&Skeleton {
        title: title(model, answer),
        note: note(answer),
        unit: UNIT.to_owned(),
        bodies: Vec::new(),
        sticks: vec![
            arm_stick("at the start", Color::FAINT, start, Letters::None),
            arm_stick("at the end", Color::MAIN, end, Letters::Written),
            way,
        ],
    })
}

/// The joints during the motion.
///
/// # Errors
/// [`PlotError::Empty`] if nothing moved; a value that cannot be drawn.
pub fn velocity_motion_joints(
    arm: &ArmDescription,
    answer: &ArmVelocityMotionResult,
) -> Result<Drawing, PlotError> {
    let times: Vec<f64> = answer.samples.iter().map(|sample| sample.time_s).collect();
    let values = |joint: usize| {
        let samples = answer.samples.iter();
        samples
            .filter_map(|sample| sample.joints_deg_mm.get(joint).copied())
            .collect()
    };
    let mut all = position_panels(arm, &times, values);
    if answer.end != ArmMotionEnd::Completed {
        for panel in &mut all {
            panel.moments.push(Moment {
                name: "stopped".to_owned(),
                at: answer.moved_s,
            });
        }
    }
    panels(&title(&arm.model, answer), &note(answer), &all, 1)
}

fn title(model: &str, answer: &ArmVelocityMotionResult) -> String {
    let end = match answer.end {
        ArmMotionEnd::Completed => "all of its time",
        ArmMotionEnd::Limit => "until a joint's range ended",
        ArmMotionEnd::TooFast => "until a joint would have been too fast",
        ArmMotionEnd::Singular => "until a singular posture",
    };
    format!(
        "{model}: motion by a velocity vector, {} s, {end}",
        short(answer.moved_s)
    )
}

fn note(answer: &ArmVelocityMotionResult) -> String {
    answer.detail.clone().unwrap_or_default()
}
