//! Joints and tool in time.

use api::arms::{ArmDescription, ArmForwardResult, ArmJointKind};
use api::trajectory::{ToolPathFailure, TrajectoryPeaks, TrajectorySample};

use super::arm::{Letters, UNIT, arm_stick, place};
use super::short;
use crate::{
    Color, Drawing, Level, Line, Moment, Panel, PlotError, Skeleton, Stick, panels, skeleton,
};

/// A trajectory or a tool path, as far as a drawing needs it.
#[derive(Clone, Copy, Debug)]
pub struct TrajectoryLook<'a> {
    /// What it is, for the title.
    pub title: &'a str,
    /// Below the title.
    pub note: &'a str,
    /// The arm.
    pub arm: &'a ArmDescription,
    /// The joints along it.
    pub samples: &'a [TrajectorySample],
    /// What it asks of each joint, and what the joint can do.
    pub peaks: &'a [TrajectoryPeaks],
    /// When via points are passed.
    pub via_s: &'a [f64],
    /// The tool's path as it was wanted; may be empty.
    pub path_mm: &'a [[f64; 3]],
    /// Where the arm cannot follow it.
    pub failure: Option<&'a ToolPathFailure>,
}

/// Positions in their own units, with the ends of ranges that are near; velocities, accelerations and jerks as shares of
/// what each joint can do, so that one line is everyone's limit.
///
/// # Errors
/// [`PlotError::Empty`] without a sample; a value that cannot be drawn.
pub fn joints_in_time(look: &TrajectoryLook<'_>) -> Result<Drawing, PlotError> {
    let times: Vec<f64> = look.samples.iter().map(|sample| sample.time_s).collect();
    let positions = |joint: usize| {
        let samples = look.samples.iter();
        samples
            .filter_map(|sample| sample.position_deg_mm.get(joint).copied())
            .collect()
    };
    let mut all = position_panels(look.arm, &times, positions);
    all.extend(share_panel(
        look,
        "Velocity",
        &|sample| &sample.velocity_deg_mm_s,
        &|peak| Some(peak.max_velocity_deg_mm_s),
    ));
    all.extend(share_panel(
        look,
        "Acceleration",
        &|sample| &sample.acceleration_deg_mm_s2,
        &|peak| Some(peak.max_acceleration_deg_mm_s2),
    ));
    all.extend(share_panel(
        look,
        "Jerk",
        &|sample| &sample.jerk_deg_mm_s3,
        &|peak| peak.max_jerk_deg_mm_s3,
    ));
    for panel in &mut all {
        panel.moments = moments(look.via_s);
    }
    let columns = if all.len() > 1 { 2 } else { 1 };
    panels(look.title, look.note, &all, columns)
}

fn moments(via_s: &[f64]) -> Vec<Moment> {
    via_s
        .iter()
        .enumerate()
        .map(|(index, at)| Moment {
            name: if via_s.len() > 6 {
                String::new()
            } else {
                format!("via {}", index + 1)
            },
            at: *at,
        })
        .collect()
}

/// One panel for the joints that turn and one for those that slide, with the ends of their ranges if they are near.
pub(super) fn position_panels(
    arm: &ArmDescription,
    times: &[f64],
    values: impl Fn(usize) -> Vec<f64>,
) -> Vec<Panel> {
    let of_kind = |kind: ArmJointKind, unit: &str| {
        let mut panel = Panel {
            title: "Position".to_owned(),
            x_label: "time in s".to_owned(),
            y_label: format!("position in {unit}"),
            ..Panel::default()
        };
        let mut ranges = Vec::new();
        for (index, joint) in arm.joints.iter().enumerate() {
            if joint.kind != kind {
                continue;
            }
            let points: Vec<(f64, f64)> = times.iter().copied().zip(values(index)).collect();
            let color = Color::of(index);
            let (low, high) = crate::ticks::extent(points.iter().map(|point| point.1))?;
            panel.lines.push(Line::new(&*joint.name, color, points));
            // The end of a range is of interest to whoever comes near it.
            let near = (joint.max_deg_mm - joint.min_deg_mm) * 0.1;
            let ends = [
                ("min", joint.min_deg_mm, low - near <= joint.min_deg_mm),
                ("max", joint.max_deg_mm, high + near >= joint.max_deg_mm),
            ];
            ranges.extend(
                ends.into_iter()
                    .filter(|end| end.2)
                    .map(|(end, value, _)| Level {
                        name: format!("{} {end} {}", joint.name, short(value)),
                        value,
                        color,
                    }),
            );
        }
        let drawn = panel.lines.iter().flat_map(|line| &line.points);
        let levels = ranges.iter().map(|level| level.value);
        let (low, high) = crate::ticks::extent(drawn.map(|point| point.1).chain(levels))?;
        panel.levels = apart(ranges, (high - low) * 0.09);
        Some(panel)
    };
    let turning = of_kind(ArmJointKind::Revolute, "°");
    let sliding = of_kind(ArmJointKind::Prismatic, "mm");
    turning.into_iter().chain(sliding).collect()
}

/// Levels whose names would lie on each other are one line with both names.
fn apart(mut levels: Vec<Level>, least: f64) -> Vec<Level> {
    levels.sort_by(|a, b| a.value.total_cmp(&b.value));
    let mut kept: Vec<Level> = Vec::new();
    for level in levels {
        match kept.last_mut() {
            Some(last) if level.value - last.value < least => {
                // The line stays, the name moves to its neighbor.
                let name = std::mem::take(&mut last.name);
                let both = format!("{name}, {}", level.name);
                kept.push(Level {
                    name: both,
                    ..level
                });
            }
            _ => kept.push(level),
        }
    }
    kept
}

/// Shares of the joints' limits in percent; the limits are drawn where they are near.
fn share_panel(
    look: &TrajectoryLook<'_>,
    title: &str,
    values: &dyn Fn(&TrajectorySample) -> &Vec<f64>,
    limit: &dyn Fn(&TrajectoryPeaks) -> Option<f64>,
) -> Option<Panel> {
    let mut highest: f64 = 0.0;
    let mut lines = Vec::new();
    for (index, (joint, peak)) in look.arm.joints.iter().zip(look.peaks).enumerate() {
        let limit = limit(peak)?;
        let samples = look.samples.iter();
        let points: Vec<(f64, f64)> = samples
            .filter_map(|sample| {
                let value = values(sample).get(index)?;
                Some((sample.time_s, value / limit * 100.0))
            })
            .collect();
        if points.is_empty() {
            return None;
        }
        highest = points
            .iter()
            .fold(highest, |highest, point| highest.max(point.1.abs()));
        lines.push(Line::new(&*joint.name, Color::of(index), points));
    }
    let levels = if highest >= 40.0 {
        vec![Level::limit("limit", 100.0), Level::limit("limit", -100.0)]
    } else {
        Vec::new()
    };
    Some(Panel {
        title: format!("{title}, as a share of each joint's limit"),
        x_label: "time in s".to_owned(),
        y_label: format!("{} in %", title.to_lowercase()),
        lines,
        levels,
        moments: Vec::new(),
    })
}

/// Place and speed of the tool.
///
/// # Errors
/// [`PlotError::Empty`] without a sample; a value that cannot be drawn.
pub fn tool_in_time(look: &TrajectoryLook<'_>) -> Result<Drawing, PlotError> {
    let line = |name: &str, color: Color, value: &dyn Fn(&TrajectorySample) -> f64| {
        let samples = look.samples.iter();
        let points = samples.map(|sample| (sample.time_s, value(sample)));
        Line::new(name, color, points.collect())
    };
    let axis = |index: usize| {
        move |sample: &TrajectorySample| sample.tcp_mm.get(index).copied().unwrap_or_default()
    };
    let places = ["X", "Y", "Z"].iter().enumerate();
    let all = [
        Panel {
            title: "Place of the tool center point".to_owned(),
            x_label: "time in s".to_owned(),
            y_label: "place in mm".to_owned(),
            lines: places
                .map(|(index, name)| line(name, Color::of(index), &axis(index)))
                .collect(),
            levels: Vec::new(),
            moments: moments(look.via_s),
        },
        Panel {
            title: "Speed of the tool center point".to_owned(),
            x_label: "time in s".to_owned(),
            y_label: "speed in mm/s".to_owned(),
            lines: vec![line("", Color::INK, &|sample| sample.tcp_speed_mm_s)],
            levels: Vec::new(),
            moments: moments(look.via_s),
        },
    ];
    panels(look.title, look.note, &all, 1)
}

/// The way of the tool in space, with the arm at its start and at its end; where it was wanted and cannot go in vermilion.
///
/// # Errors
/// [`PlotError::Empty`] without a place; a value that cannot be drawn.
pub fn tool_in_space(
    look: &TrajectoryLook<'_>,
    start: Option<&ArmForwardResult>,
    end: Option<&ArmForwardResult>,
) -> Result<Drawing, PlotError> {
    let ends = [
        ("at the start", Color::FAINT, start, Letters::None),
        ("at the end", Color::MAIN, end, Letters::Written),
    ];
    let mut sticks: Vec<Stick> = ends
        .into_iter()
        .filter_map(|(name, color, at, letters)| Some(arm_stick(name, color, at?, letters)))
        .collect();
    let way = |name: &str, color: Color, points: Vec<[f64; 3]>| Stick {
        name: name.to_owned(),
        color,
        pixels: 2.4,
        points,
        letters: Vec::new(),
    };
    if look.failure.is_some() && !look.path_mm.is_empty() {
        sticks.push(way("path as wanted", Color::LIMIT, look.path_mm.to_vec()));
    }
    if !look.samples.is_empty() {
        let points = look.samples.iter().map(|sample| sample.tcp_mm).collect();
        sticks.push(way("way of the tool", Color::of(3), points));
    }
    if let Some(pose) = look.failure.and_then(|failure| failure.pose.as_ref()) {
        sticks.push(Stick {
            letters: vec!["no farther".to_owned()],
            ..way("", Color::LIMIT, vec![place(pose)])
        });
    }
    skeleton(&Skeleton {
        title: look.title.to_owned(),
        note: look.note.to_owned(),
        unit: UNIT.to_owned(),
        bodies: Vec::new(),
        sticks,
    })
}
