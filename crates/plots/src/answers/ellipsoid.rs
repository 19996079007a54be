//! Which velocities the tool can have.

use std::f64::consts::TAU;

use api::arms::{ArmDescription, ArmForwardResult, ArmJacobianResult};
use nalgebra::{DMatrix, Vector3};

use super::arm::{Letters, UNIT, arm_body, arm_stick, place, span};
use super::{listed, short};
use crate::{Color, Drawing, PlotError, Skeleton, Stick, skeleton};

/// The arm with the ellipsoid of the tool's velocities: where its joints' rates, each as a share of the joint's highest
/// speed, have the length 1. It is flat where a direction is lost.
///
/// # Errors
/// [`PlotError::Shape`] if the Jacobian has not a column for each joint of the model; a value that cannot be drawn.
pub fn velocities(
    arm: &ArmDescription,
    joints: &[f64],
    at: &ArmForwardResult,
    jacobian: &ArmJacobianResult,
) -> Result<Drawing, PlotError> {
    let columns = arm.joints.len();
    let mut entries = Vec::new();
    for row in jacobian.geometric.iter().take(3) {
        if row.len() != columns {
            return Err(PlotError::Shape {
                what: "a row of the Jacobian".to_owned(),
                given: row.len(),
                wanted: columns,
            });
        }
        let speeds = arm.joints.iter().map(|joint| joint.max_speed_deg_mm_s);
        entries.extend(row.iter().zip(speeds).map(|(entry, speed)| entry * speed));
    }
    if entries.len() != 3 * columns {
        return Err(PlotError::Shape {
            what: "the linear part of the Jacobian".to_owned(),
            given: entries.len(),
            wanted: 3 * columns,
        });
    }
    crate::error::all_finite("the Jacobian", entries.iter().copied())?;
    // The image of the unit sphere: its half axes are the left singular vectors times the singular values.
    let svd = DMatrix::from_row_slice(3, columns, &entries).svd(true, false);
    let mut half_axes: Vec<(Vector3<f64>, f64)> = Vec::new();
    if let Some(u) = &svd.u {
        let lengths = svd.singular_values.iter().copied();
        half_axes.extend(
            u.column_iter()
                .zip(lengths)
                .map(|(way, length)| (Vector3::from_iterator(way.iter().copied()), length)),
        );
    }
    half_axes.resize(3, (Vector3::zeros(), 0.0));
    let longest = half_axes.iter().map(|axis| axis.1).fold(0.0, f64::max);
    let per_speed = if longest > 0.0 {
        span(at) * 0.22 / longest
    } else {
        0.0
    };
    let scaled: Vec<Vector3<f64>> = half_axes
        .iter()
        .map(|(way, length)| way * *length * per_speed)
        .collect();
    let mut sticks = vec![arm_stick("arm", Color::MAIN, at, Letters::Written)];
    let middle = Vector3::from(place(&at.tcp));
    for (a, b) in [(0, 1), (0, 2), (1, 2)] {
        let (Some(a), Some(b)) = (scaled.get(a), scaled.get(b)) else {
            continue;
        };
        let points = (0..=72).map(|n| {
            let (sin, cos) = (f64::from(n) / 72.0 * TAU).sin_cos();
            (middle + a * cos + b * sin).into()
        });
        sticks.push(Stick {
            name: "velocities of the tool".to_owned(),
            color: Color::of(3),
            pixels: 1.4,
            points: points.collect(),
            letters: Vec::new(),
        });
    }
    let lengths: Vec<f64> = half_axes.iter().map(|axis| axis.1.round()).collect();
    skeleton(&Skeleton {
        title: format!(
            "{} at {}: velocities of the tool",
            arm.model,
            listed(joints)
        ),
        note: format!(
            "Half axes {} mm/s: what the tool can do while the joints' rates, as shares of their highest speeds, have the length 1\n\
             Rank {} of {}, manipulability {}",
            listed(&lengths),
            jacobian.rank,
            jacobian.full_rank,
            short(jacobian.manipulability),
        ),
        unit: UNIT.to_owned(),
        bodies: vec![arm_body("shape for collision checks", at)],
        sticks,
    })
}
