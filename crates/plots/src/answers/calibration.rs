//! The postures that a tool was computed out of.

use api::PoseBody;
use api::arms::{ArmCalibrationMethod, ArmCalibrationResult, ArmForwardResult};

use super::arm::{Letters, UNIT, arm_stick, place};
use super::short;
use crate::{Color, Drawing, PlotError, Skeleton, Stick, skeleton};

/// A taught posture.
#[derive(Clone, Debug, PartialEq)]
pub struct Taught {
    /// For the legend.
    pub name: String,
    /// How it was taught.
    pub by: TaughtBy,
}

/// How a posture was taught.
#[derive(Clone, Debug, PartialEq)]
pub enum TaughtBy {
    /// By joints: the arm with the tool that was found.
    Joints(ArmForwardResult),
    /// By the flange's pose in the arm's world.
    Flange(PoseBody),
}

/// The taught postures with the tool that was found: the tips meet at one place, and the more differently the flanges are
/// turned there, the better the tip is determined.
///
/// # Errors
/// [`PlotError::Empty`] without a posture; a value that cannot be drawn.
pub fn calibration(
    model: &str,
    answer: &ArmCalibrationResult,
    taught: &[Taught],
) -> Result<Drawing, PlotError> {
    let mut sticks: Vec<Stick> = taught
        .iter()
        .enumerate()
        .map(|(index, taught)| match &taught.by {
            TaughtBy::Joints(at) => arm_stick(&taught.name, Color::of(index), at, Letters::None),
            TaughtBy::Flange(flange) => Stick {
                name: taught.name.clone(),
                color: Color::of(index),
                pixels: 3.0,
                points: vec![place(flange), answer.place_mm],
                letters: Vec::new(),
            },
        })
        .collect();
    if !sticks.is_empty() {
        sticks.push(Stick {
            name: "the place".to_owned(),
            color: Color::INK,
            pixels: 3.0,
            points: vec![answer.place_mm],
            letters: vec!["place".to_owned()],
        });
    }
    let method = match answer.method {
        ArmCalibrationMethod::ThreePoint => "three-point method",
        ArmCalibrationMethod::SixPoint => "six-point method",
    };
    let [x, y, z] = place(&answer.tool).map(short);
    skeleton(&Skeleton {
        title: format!("{model}: a tool by the {method}"),
        note: format!(
            "Tip at X, Y, Z = {x}, {y}, {z} mm of the flange; the farthest tip is {} mm from the place",
            short(answer.worst_mm)
        ),
        unit: UNIT.to_owned(),
        bodies: Vec::new(),
        sticks,
    })
}
