//! What a link weighs, and how its mass is spread.

use nalgebra::{Matrix3, Vector3};

use crate::pose::Pose;

/// No link of an arm is heavier, and no payload.
const MAX_MASS_KG: f64 = 1e6;
/// No center of mass is farther from its frame: the longest link.
const MAX_CENTER_M: f64 = 100.0;
const MAX_INERTIA_KG_M2: f64 = 1e9;
/// Two numbers of a file that differ by less than this part of the largest are the same.
const SAME: f64 = 1e-9;

/// Why a mass, a center of mass or an inertia was refused.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum InertiaError {
    /// The mass is not above 0.
    #[error("mass_kg is {value}; it must be above 0 and not above {max}")]
    Mass {
        /// What was given.
        value: f64,
        /// The highest legal value.
        max: f64,
    },
    /// A coordinate of the center of mass is no number, or far from any link.
    #[error("center_of_mass_m has {value} for {axis}; it must be a number from -{max} to {max}")]
    Center {
        /// `x`, `y` or `z`.
        axis: &'static str,
        /// What was given.
        value: f64,
        /// The largest magnitude that is taken.
        max: f64,
    },
    /// An entry of the inertia is no number, or beyond any link's.
    #[error("inertia_kg_m2 has {value} for {entry}; it must be a number from -{max} to {max}")]
    Entry {
        /// `xx` to `zz`.
        entry: &'static str,
        /// What was given.
        value: f64,
        /// The largest magnitude that is taken.
        max: f64,
    },
    /// The matrix is not symmetric.
    #[error(
        "inertia_kg_m2 has {above} for {entry} and {below} across the diagonal; they must be the same"
    )]
    NotSymmetric {
        /// `xy`, `xz` or `yz`.
        entry: &'static str,
        /// The value above the diagonal.
        above: f64,
        /// The value below it.
        below: f64,
    },
    /// About some axis the inertia is 0 or below.
    #[error("inertia_kg_m2 has the principal moment {smallest}; each must be above 0")]
    NotPositive {
        /// The smallest principal moment.
        smallest: f64,
    },
    /// No distribution of mass has it.
    #[error(
        "inertia_kg_m2 has the principal moment {largest}; it must not be above the sum of the other two, {others}"
    )]
    Triangle {
        /// The largest principal moment.
        largest: f64,
        /// The sum of the other two.
        others: f64,
    },
}

/// The mass of a body, its center and its inertia, in a frame of the body: kilograms, meters,
/// kg m^2 about the center of mass along the frame's axes.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LinkInertia {
    mass_kg: f64,
    center_of_mass_m: Vector3<f64>,
    inertia_kg_m2: Matrix3<f64>,
}

impl LinkInertia {
    /// Of a body: `inertia_kg_m2` is the matrix, with the products of inertia as they stand in it
    /// (`-integral x y dm`).
    ///
    /// # Errors
    /// The mass is not positive, or the inertia not symmetric, not positive definite, or against
    /// the triangle inequality of the principal moments; with value and limit.
    pub fn try_new(
        mass_kg: f64,
        center_of_mass_m: [f64; 3],
        inertia_kg_m2: [[f64; 3]; 3],
    ) -> Result<Self, InertiaError> {
        let point = Self::point(mass_kg, center_of_mass_m)?;
        let [[xx, xy, xz], [yx, yy, yz], [zx, zy, zz]] = inertia_kg_m2;
        for (entry, value) in [
            ("xx", xx),
            ("xy", xy),
            ("xz", xz),
            ("yx", yx),
            ("yy", yy),
            ("yz", yz),
            ("zx", zx),
            ("zy", zy),
            ("zz", zz),
        ] {
            // NaN is in no range.
            if !(-MAX_INERTIA_KG_M2..=MAX_INERTIA_KG_M2).contains(&value) {
                let max = MAX_INERTIA_KG_M2;
                return Err(InertiaError::Entry { entry, value, max });
            }
        }
        let matrix = Matrix3::new(xx, xy, xz, xy, yy, yz, xz, yz, zz);
        let close = SAME * matrix.amax();
        for (entry, above, below) in [("xy", xy, yx), ("xz", xz, zx), ("yz", yz, zy)] {
            if (above - below).abs() > close {
                return Err(InertiaError::NotSymmetric {
                    entry,
                    above,
                    below,
                });
            }
        }
        let moments = matrix.symmetric_eigenvalues();
        let (smallest, largest) = (moments.min(), moments.max());
        if smallest <= 0.0 {
            return Err(InertiaError::NotPositive { smallest });
        }
        let others = moments.sum() - largest;
        if largest > others + close {
            return Err(InertiaError::Triangle { largest, others });
        }
        Ok(Self {
            inertia_kg_m2: matrix,
            ..point
        })
    }

    /// Of a body so small that only its mass counts, such as a payload of which no more is known.
    ///
    /// # Errors
    /// As [`Self::try_new`].
    pub fn point(mass_kg: f64, center_of_mass_m: [f64; 3]) -> Result<Self, InertiaError> {
        if !(mass_kg > 0.0 && mass_kg <= MAX_MASS_KG) {
            return Err(InertiaError::Mass {
                value: mass_kg,
                max: MAX_MASS_KG,
            });
        }
        for (axis, value) in ["x", "y", "z"].into_iter().zip(center_of_mass_m) {
            if !(-MAX_CENTER_M..=MAX_CENTER_M).contains(&value) {
                let max = MAX_CENTER_M;
                return Err(InertiaError::Center { axis, value, max });
            }
        }
        Ok(Self {
            mass_kg,
            center_of_mass_m: center_of_mass_m.into(),
            inertia_kg_m2: Matrix3::zeros(),
        })
    }

    /// The mass in kilograms.
    #[must_use]
    pub fn mass_kg(&self) -> f64 {
        self.mass_kg
    }

    /// The center of mass in the frame, in meters.
    #[must_use]
    pub fn center_of_mass_m(&self) -> Vector3<f64> {
        self.center_of_mass_m
    }

    /// The inertia about the center of mass along the frame's axes.
    #[must_use]
    pub fn inertia_kg_m2(&self) -> Matrix3<f64> {
        self.inertia_kg_m2
    }

    /// The same body seen from another of its frames, in which this one is at `X_AB` (millimeters).
    #[must_use]
    pub fn seen_from(&self, X_AB: &Pose) -> Self {
        let turn = X_AB.isometry().rotation.to_rotation_matrix();
        let shift = X_AB.isometry().translation.vector / 1000.0;
        Self {
            mass_kg: self.mass_kg,
            center_of_mass_m: turn * self.center_of_mass_m + shift,
            inertia_kg_m2: turn.matrix() * self.inertia_kg_m2 * turn.matrix().transpose(),
        }
    }
}
