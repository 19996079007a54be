//! ZYZ Euler angles, textbook (1.11) and (1.24) to (1.33).

use nalgebra::{Matrix3, Rotation3};
use units::Radians;

use crate::pose::Pose;

/// Euler angles about the current Z, Y, Z axes: `R = Rz(phi) Ry(theta) Rz(psi)`.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[expect(missing_docs, reason = "the textbook's own letters, explained above")]
pub struct Zyz {
    pub phi: Radians,
    pub theta: Radians,
    pub psi: Radians,
}

/// Which of the two angle sets of one rotation: the sign of the root in (1.26).
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ZyzBranch {
    /// Theta from 0 to pi.
    Positive,
    /// Theta from -pi to 0.
    Negative,
}

/// What of the three angles a rotation determines.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum ZyzAngles {
    /// All three.
    Regular(Zyz),
    /// Theta is 0: only `phi + psi` is determined (1.31). Psi is given as 0 (remark 1.1).
    SumOnly(Zyz),
    /// Theta is pi: only `phi - psi` is determined (1.33). Psi is given as 0.
    DifferenceOnly(Zyz),
}

impl ZyzAngles {
    /// The angles, with psi 0 where it is free.
    #[must_use]
    pub fn angles(&self) -> Zyz {
        match self {
            ZyzAngles::Regular(zyz) | ZyzAngles::SumOnly(zyz) | ZyzAngles::DifferenceOnly(zyz) => {
                *zyz
            }
        }
    }
}

/// Below this sine of theta the other two angles are taken as one.
const SINGULAR: f64 = 1e-10;

impl Zyz {
    /// The rotation (1.11).
    #[must_use]
    pub fn rotation(&self) -> Rotation3<f64> {
        let (sf, cf) = self.phi.0.sin_cos();
        let (st, ct) = self.theta.0.sin_cos();
        let (ss, cs) = self.psi.0.sin_cos();
        Rotation3::from_matrix_unchecked(Matrix3::new(
            cf * ct * cs - sf * ss,
            -cf * ct * ss - sf * cs,
            cf * st,
            sf * ct * cs + cf * ss,
            -sf * ct * ss + cf * cs,
            sf * st,
            -st * cs,
            st * ss,
            ct,
        ))
    }
}

impl Pose {
    /// The rotation's ZYZ angles, (1.27) to (1.33), each in (-pi, pi].
    ///
    /// Theta is taken from sine and cosine together: the root of (1.26) loses half the digits near
    /// the singular cases, where our angles stay exact.
    #[must_use]
    pub fn zyz(&self, branch: ZyzBranch) -> ZyzAngles {
        angles_of(&self.rotation_matrix(), branch)
    }
}

/// The positive branch, with psi 0 where it is free.
pub(crate) fn zyz_of(rotation: &Matrix3<f64>) -> Zyz {
    angles_of(rotation, ZyzBranch::Positive).angles()
}

fn angles_of(r: &Matrix3<f64>, branch: ZyzBranch) -> ZyzAngles {
    let sine = r[(0, 2)].hypot(r[(1, 2)]);
    let zyz = |phi: f64, theta: f64, psi: f64| Zyz {
        phi: Radians(phi),
        theta: Radians(theta),
        psi: Radians(psi),
    };
    if sine < SINGULAR {
        return if r[(2, 2)] > 0.0 {
            ZyzAngles::SumOnly(zyz(r[(1, 0)].atan2(r[(0, 0)]), 0.0, 0.0))
        } else {
            let difference = (-r[(0, 1)]).atan2(-r[(0, 0)]);
            ZyzAngles::DifferenceOnly(zyz(difference, std::f64::consts::PI, 0.0))
        };
    }
    let sign = match branch {
        ZyzBranch::Positive => 1.0,
        ZyzBranch::Negative => -1.0,
    };
    let (sf, cf) = (sign * r[(1, 2)] / sine, sign * r[(0, 2)] / sine);
    // Psi from what is left after phi, so that their errors cancel near the singular cases.
    let psi = (cf * r[(1, 0)] - sf * r[(0, 0)]).atan2(cf * r[(1, 1)] - sf * r[(0, 1)]);
    let theta = (sign * sine).atan2(r[(2, 2)]);
    ZyzAngles::Regular(zyz(sf.atan2(cf), theta, psi))
}
