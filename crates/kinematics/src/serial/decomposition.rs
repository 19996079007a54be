//! Singularities of arms with a spherical wrist, taken apart: textbook 1.4.5.

use nalgebra::{Matrix3, Vector3};

use crate::serial::arm::SerialArm;
use crate::serial::spherical::{WristError, expect_spherical_wrist};
use crate::serial::values::JointValues;
use crate::serial::velocity::RANK_TOLERANCE;

/// The Jacobian of an arm of six joints whose last three axes meet in a point, seen at that point:
/// the wrist does not move it, so the upper right block is zero and `det J = det J11 * det J22`.
///
/// The determinant is that of the flange's Jacobian: another point of the same body adds multiples
/// of the lower rows to the upper ones.
#[derive(Clone, Debug, PartialEq)]
pub struct SingularityDecomposition {
    /// J11: the wrist center's velocity for the first three joints, millimeters for each radian of
    /// the displayed values.
    pub arm: Matrix3<f64>,
    /// J22: the flange's angular velocity for the last three.
    pub wrist: Matrix3<f64>,
    /// Of J11: below 3 the arm is singular (elbow or shoulder).
    pub arm_rank: usize,
    /// Of J22: below 3 the wrist is, axes 4 and 6 being in one line.
    pub wrist_rank: usize,
}

impl SingularityDecomposition {
    /// `det J11`, cubic millimeters.
    #[must_use]
    pub fn arm_determinant(&self) -> f64 {
        self.arm.determinant()
    }

    /// `det J22`.
    #[must_use]
    pub fn wrist_determinant(&self) -> f64 {
        self.wrist.determinant()
    }

    /// `det J`, cubic millimeters.
    #[must_use]
    pub fn determinant(&self) -> f64 {
        self.arm_determinant() * self.wrist_determinant()
    }

    /// Has the Jacobian lost rank?
    #[must_use]
    pub fn is_singular(&self) -> bool {
        self.arm_rank < 3 || self.wrist_rank < 3
    }
}

impl SerialArm {
    /// What of the arm is singular at `joints`: its first three joints, its wrist, or both.
    ///
    /// # Errors
    /// The values are another arm's, or the arm has no spherical wrist.
    pub fn singularity_decomposition(
        &self,
        joints: &JointValues,
    ) -> Result<SingularityDecomposition, WristError> {
        self.check_count(joints.len())?;
        expect_spherical_wrist(self)?;
        let stance = self.stance(&self.chain(joints));
        // The fourth frame stands where the three axes meet.
        let center = stance
            .frames
            .get(3)
            .map_or_else(Vector3::zeros, |(_, position)| *position);
        let jacobian = self.jacobian_of(&stance);
        let lower = jacobian.fixed_rows::<3>(3);
        let to_center = (center - stance.position).cross_matrix();
        // v + omega x r = v - r x omega
        let upper = jacobian.fixed_rows::<3>(0) - to_center * lower;
        let arm: Matrix3<f64> = upper.fixed_columns::<3>(0).into_owned();
        let wrist: Matrix3<f64> = lower.fixed_columns::<3>(3).into_owned();
        Ok(SingularityDecomposition {
            arm_rank: (arm / self.span()).rank(RANK_TOLERANCE),
            wrist_rank: wrist.rank(RANK_TOLERANCE),
            arm,
            wrist,
        })
    }
}
