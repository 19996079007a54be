//! Checked rigid transforms.

use std::ops::Mul;

use nalgebra::{Isometry3, Matrix3, Translation3, UnitQuaternion, Vector3};
use units::{Degrees, Millimeters, Radians};

use crate::wpr::{Xyzwpr, angles_of, rotation_of};

/// The longest coordinate a pose may have: a kilometer, far beyond any arm and any rail.
const MAX_COORDINATE: Millimeters = Millimeters(1e6);
/// The largest angle a pose may be written with; sine and cosine are exact far beyond it.
const MAX_ANGLE: Degrees = Degrees(36_000.0);
/// How far the length of a rotation's quaternion may be from 1.
const MAX_NORM_ERROR: f64 = 1e-6;

/// Why a pose was refused.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
pub enum PoseError {
    /// A coordinate is NaN, infinite or too long.
    #[error("{name} is {value}; it must be a number from -{max} to {max}", max = MAX_COORDINATE)]
    Coordinate {
        /// `x`, `y` or `z`.
        name: &'static str,
        /// What was given.
        value: Millimeters,
    },
    /// An angle is NaN, infinite or too large.
    #[error("{name} is {value}; it must be a number from -{max} to {max}", max = MAX_ANGLE)]
    Angle {
        /// `w`, `p` or `r`.
        name: &'static str,
        /// What was given.
        value: Degrees,
    },
    /// A quaternion that is not of length 1.
    #[error("the rotation's quaternion has the length {norm}; it must be 1")]
    Rotation {
        /// Its length.
        norm: f64,
    },
}

/// A rigid transform, checked: finite, with a unit rotation; translation in millimeters.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Pose(Isometry3<f64>);

impl Pose {
    /// A pose from what the pendant shows.
    ///
    /// # Errors
    /// Names the item that is not finite, or larger than a kilometer or a hundred turns.
    pub fn try_from_xyzwpr(pose: &Xyzwpr) -> Result<Pose, PoseError> {
        for (name, value) in [("x", pose.x), ("y", pose.y), ("z", pose.z)] {
            check_coordinate(name, value)?;
        }
        for (name, value) in [("w", pose.w), ("p", pose.p), ("r", pose.r)] {
            if !value.is_finite() || value.abs() > MAX_ANGLE {
                return Err(PoseError::Angle { name, value });
            }
        }
        let rotation = rotation_of([pose.w, pose.p, pose.r]);
        Ok(Pose::from_parts(
            Vector3::new(pose.x.0, pose.y.0, pose.z.0),
            UnitQuaternion::from_rotation_matrix(&rotation),
        ))
    }

    /// A pose from a transform of nalgebra, translation in millimeters.
    ///
    /// # Errors
    /// The translation is not finite or longer than a kilometer, or the rotation is not of length
    /// 1.
    pub fn try_from_isometry(isometry: Isometry3<f64>) -> Result<Pose, PoseError> {
        let p = isometry.translation.vector;
        for (name, value) in [("x", p.x), ("y", p.y), ("z", p.z)] {
            check_coordinate(name, Millimeters(value))?;
        }
        let norm = isometry.rotation.quaternion().norm();
        if !norm.is_finite() || (norm - 1.0).abs() > MAX_NORM_ERROR {
            return Err(PoseError::Rotation { norm });
        }
        Ok(Pose::from_parts(
            p,
            UnitQuaternion::new_normalize(isometry.rotation.into_inner()),
        ))
    }

    /// For values that are finite and of unit length by construction.
    pub(crate) fn from_parts(translation: Vector3<f64>, rotation: UnitQuaternion<f64>) -> Pose {
        Pose(Isometry3::from_parts(
            Translation3::from(translation),
            rotation,
        ))
    }

    /// No translation, no rotation.
    #[must_use]
    pub fn identity() -> Pose {
        Pose(Isometry3::identity())
    }

    /// As the pendant shows it; W, P, R in (-180, 180], and R = 0 where P is ±90.
    #[must_use]
    pub fn xyzwpr(&self) -> Xyzwpr {
        let p = self.0.translation.vector;
        Xyzwpr::new(
            [p.x, p.y, p.z].map(Millimeters),
            angles_of(&self.rotation_matrix()),
        )
    }

    /// The transform itself, translation in millimeters.
    #[must_use]
    pub fn isometry(&self) -> &Isometry3<f64> {
        &self.0
    }

    /// The transform back: `X_BA` of `X_AB`.
    #[must_use]
    pub fn inverse(&self) -> Pose {
        Pose(self.0.inverse())
    }

    /// How far the origins are apart, and the angle of the one rotation that takes one pose to the
    /// other.
    #[must_use]
    pub fn distance_to(&self, other: &Pose) -> (Millimeters, Radians) {
        let apart = self.0.translation.vector - other.0.translation.vector;
        let between = self.0.rotation.rotation_to(&other.0.rotation);
        // The usual 2 acos(w) loses half the digits at small angles.
        let angle = 2.0 * between.imag().norm().atan2(between.w.abs());
        (Millimeters(apart.norm()), Radians(angle))
    }

    pub(crate) fn rotation_matrix(&self) -> Matrix3<f64> {
        self.0.rotation.to_rotation_matrix().into_inner()
    }
}

fn check_coordinate(name: &'static str, value: Millimeters) -> Result<(), PoseError> {
    if !value.is_finite() || value.abs() > MAX_COORDINATE {
        return Err(PoseError::Coordinate { name, value });
    }
    Ok(())
}

/// `X_AC = X_AB * X_BC`
impl Mul for Pose {
    type Output = Pose;
    fn mul(self, other: Pose) -> Pose {
        let mut product = self.0 * other.0;
        // Long chains of products keep their unit length.
        product.rotation.renormalize_fast();
        Pose(product)
    }
}

impl TryFrom<&Xyzwpr> for Pose {
    type Error = PoseError;
    fn try_from(pose: &Xyzwpr) -> Result<Pose, PoseError> {
        Pose::try_from_xyzwpr(pose)
    }
}
