//! The wheels of a mecanum base along a route.

use super::short;
use crate::{Color, Drawing, Level, Line, Panel, PlotError, panels};

/// One moment of a drive.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct DriveSample {
    /// From the start, in seconds.
    pub time_s: f64,
    /// The base in the world: x and y in mm, heading in degrees.
    pub x_mm: f64,
    /// See `x_mm`.
    pub y_mm: f64,
    /// See `x_mm`.
    pub heading_deg: f64,
    /// The base's speed.
    pub speed_mm_s: f64,
    /// How fast it turns.
    pub turn_deg_s: f64,
    /// The wheels in the order of the thesis: front left, front right, rear left, rear right.
    pub wheels_rad_s: [f64; 4],
}

/// A drive along a route.
#[derive(Clone, Debug, PartialEq)]
pub struct Drive {
    /// The drive, in the order of time.
    pub samples: Vec<DriveSample>,
    /// The highest speed of a wheel.
    pub max_wheel_speed_rad_s: f64,
}

/// Wheel speeds with their limit, the base's speed, and its turning, over time.
///
/// # Errors
/// [`PlotError::Empty`] without a sample; a value that cannot be drawn.
pub fn wheels(title: &str, drive: &Drive) -> Result<Drawing, PlotError> {
    let line = |name: &str, color: Color, value: &dyn Fn(&DriveSample) -> f64| {
        let samples = drive.samples.iter();
        let points = samples.map(|sample| (sample.time_s, value(sample)));
        Line::new(name, color, points.collect())
    };
    let names = ["front left", "front right", "rear left", "rear right"];
    let limit = drive.max_wheel_speed_rad_s;
    let speeds = Panel {
        title: "Speed of the wheels".to_owned(),
        x_label: "time in s".to_owned(),
        y_label: "speed in rad/s".to_owned(),
        lines: names
            .iter()
            .enumerate()
            .map(|(index, name)| {
                // Straight on, two and two wheels turn alike: the rear ones lie thin on the front ones.
                let pixels = if index < 2 { 4.6 } else { 1.6 };
                line(name, Color::of(index), &|sample| {
                    sample.wheels_rad_s.get(index).copied().unwrap_or_default()
                })
                .thick(pixels)
            })
            .collect(),
        levels: vec![
            Level::limit(format!("limit {}", short(limit)), limit),
            Level::limit(format!("limit {}", short(-limit)), -limit),
        ],
        ..Panel::default()
    };
    let of_base = |title: &str, y_label: &str, value: &dyn Fn(&DriveSample) -> f64| Panel {
        title: title.to_owned(),
        x_label: "time in s".to_owned(),
        y_label: y_label.to_owned(),
        lines: vec![line("", Color::INK, value)],
        ..Panel::default()
    };
    let all = [
        speeds,
        of_base("Speed of the base", "speed in mm/s", &|sample| {
            sample.speed_mm_s
        }),
        of_base("Turning of the base", "turning in °/s", &|sample| {
            sample.turn_deg_s
        }),
    ];
    let end = drive.samples.last().map_or(0.0, |sample| sample.time_s);
    panels(title, &format!("{} s", short(end)), &all, 1)
}
