//! An arm in space, as the paper's figures 2 to 4 show it.

use api::PoseBody;
use api::arms::{ArmForwardResult, ArmOutside};

use super::{listed, pose_text, short};
use crate::figure::as_number;
use crate::{Body, Capsule, Color, Drawing, PlotError, Skeleton, Stick, skeleton};

/// The unit of all that is drawn in space.
pub(super) const UNIT: &str = "mm";

/// The arm at given joints: its shape, the frames of its table, and the tool, in space and in three projections.
///
/// `joints` are the displayed values that `answer` is of.
///
/// # Errors
/// A value that cannot be drawn.
pub fn posture(
    model: &str,
    joints: &[f64],
    answer: &ArmForwardResult,
) -> Result<Drawing, PlotError> {
    let mut note = format!("Tool at {}", pose_text(&answer.tcp));
    if let Some(configuration) = &answer.configuration {
        note.push_str("; configuration ");
        note.push_str(configuration);
    }
    if let Some(outside) = outside_text(&answer.outside) {
        note.push('\n');
        note.push_str(&outside);
    }
    let mut sticks = vec![arm_stick("arm", Color::MAIN, answer, Letters::Written)];
    sticks.extend(tool_axes(&answer.tcp, span(answer) * 0.12));
    skeleton(&Skeleton {
        title: format!("{model} at {}", listed(joints)),
        note,
        unit: UNIT.to_owned(),
        bodies: vec![arm_body("shape for collision checks", answer)],
        sticks,
    })
}

/// An arm with a name for the legend.
#[derive(Clone, Debug, PartialEq)]
pub struct Labeled {
    /// For the legend.
    pub name: String,
    /// Whether the arm can stand so.
    pub within_ranges: bool,
    /// Where it is.
    pub at: ArmForwardResult,
}

/// All joint sets that reach a pose, over each other: those inside the ranges in colors, the others in gray.
///
/// # Errors
/// [`PlotError::Empty`] without a joint set; a value that cannot be drawn.
pub fn branches(model: &str, note: &str, found: &[Labeled]) -> Result<Drawing, PlotError> {
    let inside = found.iter().filter(|branch| branch.within_ranges).count();
    let title = format!(
        "{model}: {} joint sets reach the pose, {inside} inside the ranges",
        found.len()
    );
    // The gray ones first, so that they lie below.
    let outside = found.iter().filter(|branch| !branch.within_ranges);
    let mut sticks: Vec<Stick> = outside
        .map(|branch| {
            arm_stick(
                "outside the ranges",
                Color::FAINT,
                &branch.at,
                Letters::None,
            )
        })
        .collect();
    let colored = found.iter().filter(|branch| branch.within_ranges);
    // Sets that differ in the wrist only lie on each other: each is thinner than the one below it.
    let thinner = 4.4 / as_number(inside.max(2) - 1);
    sticks.extend(colored.enumerate().map(|(index, branch)| Stick {
        pixels: 6.0 - thinner * as_number(index),
        ..arm_stick(&branch.name, Color::of(index), &branch.at, Letters::None)
    }));
    if let Some(first) = found.first() {
        sticks.extend(tool_axes(&first.at.tcp, span(&first.at) * 0.12));
    }
    skeleton(&Skeleton {
        title,
        note: note.to_owned(),
        unit: UNIT.to_owned(),
        bodies: Vec::new(),
        sticks,
    })
}

/// Whether the points of an arm have their names beside them.
#[derive(Clone, Copy, Debug, Eq, PartialEq)]
pub(super) enum Letters {
    Written,
    None,
}

/// The line through the frames of the table, or through the points that have names.
pub(super) fn arm_stick(
    name: &str,
    color: Color,
    at: &ArmForwardResult,
    letters: Letters,
) -> Stick {
    let mut points: Vec<(String, [f64; 3])> = if at.points.is_empty() {
        let frames = at.link_frames.iter().map(place);
        frames.map(|point| (String::new(), point)).collect()
    } else {
        let named = at.points.iter();
        named
            .map(|point| (point.name.clone(), point.at_mm))
            .collect()
    };
    // Frames that share their origin are one point.
    points.dedup_by(|later, earlier| near(later.1, earlier.1));
    if at.points.is_empty() {
        if let Some(first) = points.first_mut() {
            "base".clone_into(&mut first.0);
        }
        if let Some(last) = points.last_mut() {
            "tool".clone_into(&mut last.0);
        }
    }
    let (names, points): (Vec<String>, Vec<[f64; 3]>) = points.into_iter().unzip();
    Stick {
        name: name.to_owned(),
        color,
        pixels: 3.0,
        letters: match letters {
            Letters::Written => names,
            Letters::None => Vec::new(),
        },
        points,
    }
}

/// The arm's shape, as its collisions are checked.
pub(super) fn arm_body(name: &str, at: &ArmForwardResult) -> Body {
    Body {
        name: if at.capsules.is_empty() {
            String::new()
        } else {
            name.to_owned()
        },
        color: Color::BODY,
        capsules: at.capsules.iter().map(capsule).collect(),
    }
}

pub(super) fn capsule(placed: &api::arms::PlacedCapsule) -> Capsule {
    Capsule {
        from: placed.from_mm,
        to: placed.to_mm,
        radius: placed.radius_mm,
    }
}

/// X, Y and Z of the tool.
pub(super) fn tool_axes(tcp: &PoseBody, length: f64) -> [Stick; 3] {
    let origin = place(tcp);
    let axes = super::solid::axes(tcp);
    let names = [
        ("tool's X", Color::LIMIT),
        ("tool's Y", Color::START),
        ("tool's Z", Color::of(5)),
    ];
    let mut sticks = names.map(|(name, color)| Stick {
        name: name.to_owned(),
        color,
        pixels: 1.8,
        points: Vec::new(),
        letters: Vec::new(),
    });
    for (stick, axis) in sticks.iter_mut().zip(axes) {
        let mut end = origin;
        for (end, along) in end.iter_mut().zip(axis) {
            *end += along * length;
        }
        stick.points = vec![origin, end];
    }
    sticks
}

/// About how large the arm is.
pub(super) fn span(at: &ArmForwardResult) -> f64 {
    let points: Vec<[f64; 3]> = at.link_frames.iter().map(place).collect();
    points
        .windows(2)
        .map(|pair| match pair {
            [a, b] => distance(*a, *b),
            _ => 0.0,
        })
        .sum()
}

pub(super) fn place(pose: &PoseBody) -> [f64; 3] {
    [pose.x_mm, pose.y_mm, pose.z_mm]
}

fn near(a: [f64; 3], b: [f64; 3]) -> bool {
    distance(a, b) < 1e-6
}

fn distance(a: [f64; 3], b: [f64; 3]) -> f64 {
    let squares: f64 = a.iter().zip(b).map(|(a, b)| (a - b) * (a - b)).sum();
    squares.sqrt()
}

/// What is wrong with the joints, if anything.
pub(super) fn outside_text(outside: &[ArmOutside]) -> Option<String> {
    if outside.is_empty() {
        return None;
    }
    let joints: Vec<String> = outside
        .iter()
        .map(|joint| {
            format!(
                "{} is {}, its range {} to {}",
                joint.joint,
                short(joint.value_deg_mm),
                short(joint.min_deg_mm),
                short(joint.max_deg_mm)
            )
        })
        .collect();
    Some(format!("Outside its ranges: {}", joints.join("; ")))
}
