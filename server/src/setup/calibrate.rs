//! Tool calibration by the four-point method.
//!
//! The tip of the tool is held at one fixed point in several postures. With the flange at rotation `R_i` and position
//! `t_i` in the arm's world, the tip is at `R_i p + t_i`, the same for all: `p`, the tool center point in the flange
//! frame, is what makes the tips agree best. With the means taken off, `(R_i - mean R) p = -(t_i - mean t)` is a linear
//! least-squares problem for `p` alone; the fixed point need not be known.

use kinematics::Pose;
use nalgebra::{Matrix3, Vector3};
use thiserror::Error;

/// The fewest postures.
pub(crate) const MIN_POINTS: usize = 4;
/// The most postures.
pub(crate) const MAX_POINTS: usize = 100;
/// The largest distance of a tip from their mean that is taken where nobody says otherwise, in millimeters.
pub(crate) const MAX_RESIDUAL_MM: f64 = 1.0;
/// The least root mean square by which the rotations must move a tool of length 1, in its least favorable direction:
/// flanges turned by 10 degrees to either side and to front and back give 0.12.
const LEAST_SPREAD: f64 = 0.08;

/// A tool center point, and how well it is known.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Calibration {
    /// In the flange frame, in millimeters.
    pub(crate) tip: Vector3<f64>,
    /// The distances of the postures' tips from their mean, in millimeters.
    pub(crate) residuals: Vec<f64>,
    pub(crate) rms: f64,
    pub(crate) max: f64,
    /// Three times the standard error of the tip in its worst direction, in millimeters.
    pub(crate) uncertainty: f64,
}

/// Why postures give no tool.
#[derive(Clone, Debug, Error, PartialEq)]
pub(crate) enum CalibrationError {
    #[error("there are {count} postures; it takes {MIN_POINTS} to {MAX_POINTS}")]
    Count { count: usize },
    #[error(
        "postures {first} and {second} turn the flange alike: {angle_deg:.2} degrees apart; 5 are needed"
    )]
    Alike {
        first: usize,
        second: usize,
        angle_deg: f64,
    },
    #[error(
        "the flange was turned about one direction only, so the tip is not determined along ({:.2}, {:.2}, {:.2}) of \
         the flange frame: the spread there is {spread:.3}; at least {LEAST_SPREAD} is needed. Tilt it to another side",
        .direction.x, .direction.y, .direction.z
    )]
    Degenerate {
        direction: Vector3<f64>,
        spread: f64,
    },
    #[error(
        "the tips do not agree: posture {worst} is {distance:.3} mm from their mean; at most {limit} mm is taken"
    )]
    Residual {
        worst: usize,
        distance: f64,
        limit: f64,
    },
}

/// The least angle between any two postures' flanges, in degrees.
const LEAST_ANGLE_DEG: f64 = 5.0;

/// The tool center point that fits the flange poses best.
///
/// # Errors
/// Too few postures, postures that do not determine the tip, or tips farther apart than `max_residual_mm`.
pub(crate) fn four_point(
    flanges: &[Pose],
    max_residual_mm: f64,
) -> Result<Calibration, CalibrationError> {
    let count = flanges.len();
    if !(MIN_POINTS..=MAX_POINTS).contains(&count) {
        return Err(CalibrationError::Count { count });
    }
    for (first, a) in flanges.iter().enumerate() {
        for (second, b) in flanges.iter().enumerate().skip(first + 1) {
            let angle_deg = a.distance_to(b).1.0.to_degrees();
            if angle_deg < LEAST_ANGLE_DEG {
                return Err(CalibrationError::Alike {
                    first,
                    second,
                    angle_deg,
                });
            }
        }
    }
    let rotations: Vec<Matrix3<f64>> = flanges
        .iter()
        .map(|flange| flange.isometry().rotation.to_rotation_matrix().into_inner())
        .collect();
    let positions: Vec<Vector3<f64>> = flanges
        .iter()
        .map(|flange| flange.isometry().translation.vector)
        .collect();
    let n = f64::from(u32::try_from(count).unwrap_or(u32::MAX));
    let mean_rotation = rotations.iter().sum::<Matrix3<f64>>() / n;
    let mean_position = positions.iter().sum::<Vector3<f64>>() / n;

    // The normal equations are well conditioned: the spread below bounds their condition number.
    let mut normal = Matrix3::zeros();
    let mut right = Vector3::zeros();
    for (rotation, position) in rotations.iter().zip(&positions) {
        let turn = rotation - mean_rotation;
        normal += turn.transpose() * turn;
        right -= turn.transpose() * (position - mean_position);
    }
    let eigen = normal.symmetric_eigen();
    let weakest = eigen.eigenvalues.imin();
    let least = eigen.eigenvalues.min().max(0.0);
    let spread = (least / n).sqrt();
    if spread < LEAST_SPREAD {
        return Err(CalibrationError::Degenerate {
            direction: eigen.eigenvectors.column(weakest).into_owned(),
            spread,
        });
    }
    let basis = eigen.eigenvectors;
    let along = (basis.transpose() * right).component_div(&eigen.eigenvalues);
    let tip = basis * along;

    let mean_tip = mean_rotation * tip + mean_position;
    let residuals: Vec<f64> = rotations
        .iter()
        .zip(&positions)
        .map(|(rotation, position)| (rotation * tip + position - mean_tip).norm())
        .collect();
    let squares: f64 = residuals.iter().map(|distance| distance * distance).sum();
    let (mut worst, mut max) = (0, 0.0);
    for (index, distance) in residuals.iter().enumerate() {
        if *distance > max {
            (worst, max) = (index, *distance);
        }
    }
    if max > max_residual_mm {
        return Err(CalibrationError::Residual {
            worst,
            distance: max,
            limit: max_residual_mm,
        });
    }
    // 3 n equations, 6 unknowns: the tip and the fixed point.
    let variance = squares / (3.0 * n - 6.0);
    Ok(Calibration {
        tip,
        residuals,
        rms: (squares / n).sqrt(),
        max,
        uncertainty: 3.0 * (variance / least).sqrt(),
    })
}
