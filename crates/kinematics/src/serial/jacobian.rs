//! Geometric and analytic Jacobians.

use nalgebra::{Matrix3, Matrix6xX};

use crate::serial::arm::{JointKind, SerialArm};
use crate::serial::error::SerialError;
use crate::serial::forward::Stance;
use crate::serial::values::JointValues;
use crate::wpr::angles_of;
use crate::zyz::{Zyz, zyz_of};

/// 6 x n: velocity of the flange's origin in the world (millimeters) above its angular velocity in
/// the world (radians), for each radian or millimeter of each displayed joint value.
pub type Jacobian = Matrix6xX<f64>;

/// The three angles an orientation is written with.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Angles {
    /// phi, theta, psi: `R = Rz(phi) Ry(theta) Rz(psi)`, textbook (1.11).
    Zyz,
    /// w, p, r: `R = Rz(r) Ry(p) Rx(w)`.
    Wpr,
}

/// Where the three angles have no rates.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum RepresentationSingular {
    /// The joint values are another arm's.
    #[error(transparent)]
    Joints(#[from] SerialError),
    /// Theta is 0 or 180 degrees.
    #[error("theta is {theta_deg} deg: at 0 and 180 only phi + psi or phi - psi has a rate")]
    Zyz {
        /// Theta, in degrees.
        theta_deg: f64,
    },
    /// P is 90 or -90 degrees.
    #[error("P is {p_deg} deg: at 90 and -90 only W - R or W + R has a rate")]
    Wpr {
        /// P, in degrees.
        p_deg: f64,
    },
}

/// Below this sine of theta, or cosine of P, the rates of the angles would be a million times those
/// of the flange.
const SINGULAR: f64 = 1e-6;

impl SerialArm {
    /// The geometric Jacobian at `joints`: textbook (1.78), its columns (1.79) for prismatic and
    /// (1.80) for revolute joints, times the display's signs and couplings.
    ///
    /// # Errors
    /// The values are another arm's.
    pub fn jacobian(&self, joints: &JointValues) -> Result<Jacobian, SerialError> {
        self.check_count(joints.len())?;
        Ok(self.jacobian_of(&self.stance(&self.chain(joints))))
    }

    pub(crate) fn jacobian_of(&self, stance: &Stance) -> Jacobian {
        let n = self.joints.len();
        let mut chain = Jacobian::zeros(n);
        for (i, (joint, (z, p))) in self.joints.iter().zip(&stance.axes).enumerate() {
            match joint.kind {
                JointKind::Revolute => {
                    let v = z.cross(&(stance.position - p));
                    chain.fixed_view_mut::<3, 1>(0, i).copy_from(&v);
                    chain.fixed_view_mut::<3, 1>(3, i).copy_from(z);
                }
                JointKind::Prismatic => chain.fixed_view_mut::<3, 1>(0, i).copy_from(z),
            }
        }
        chain * &self.coupling
    }

    /// The analytic Jacobian: as [`Self::jacobian`], but the lower rows are the rates of the three
    /// angles. Textbook (1.84) to (1.89), with the erratum of (1.87).
    ///
    /// # Errors
    /// The values are another arm's, or the angles have no rates here.
    pub fn analytic_jacobian(
        &self,
        joints: &JointValues,
        angles: Angles,
    ) -> Result<Jacobian, RepresentationSingular> {
        self.check_count(joints.len())?;
        let stance = self.stance(&self.chain(joints));
        let mut jacobian = self.jacobian_of(&stance);
        let inverse = rates_from_angular_velocity(&stance.rotation, angles)?;
        let lower = inverse * jacobian.fixed_rows::<3>(3);
        jacobian.fixed_rows_mut::<3>(3).copy_from(&lower);
        Ok(jacobian)
    }
}

/// H^-1 of (1.88): the angles' rates from the angular velocity in the world.
pub(crate) fn rates_from_angular_velocity(
    rotation: &Matrix3<f64>,
    angles: Angles,
) -> Result<Matrix3<f64>, RepresentationSingular> {
    match angles {
        Angles::Zyz => {
            let Zyz { phi, theta, .. } = zyz_of(rotation);
            let ((sf, cf), (st, ct)) = (phi.0.sin_cos(), theta.0.sin_cos());
            if st.abs() < SINGULAR {
                return Err(RepresentationSingular::Zyz {
                    theta_deg: theta.0.to_degrees(),
                });
            }
            // omega = z phi' + Rz(phi) y theta' + Rz(phi) Ry(theta) z psi', solved for the rates.
            Ok(Matrix3::new(
                -cf * ct / st,
                -sf * ct / st,
                1.0,
                -sf,
                cf,
                0.0,
                cf / st,
                sf / st,
                0.0,
            ))
        }
        Angles::Wpr => {
            let [_, p, r] = angles_of(rotation);
            let ((sp, cp), (sr, cr)) = (p.0.to_radians().sin_cos(), r.0.to_radians().sin_cos());
            if cp.abs() < SINGULAR {
                return Err(RepresentationSingular::Wpr { p_deg: p.0 });
            }
            // omega = Rz(r) Ry(p) x w' + Rz(r) y p' + z r'.
            Ok(Matrix3::new(
                cr / cp,
                sr / cp,
                0.0,
                -sr,
                cr,
                0.0,
                cr * sp / cp,
                sr * sp / cp,
                1.0,
            ))
        }
    }
}
