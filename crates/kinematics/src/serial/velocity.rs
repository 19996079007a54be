//! Joint rates of a velocity of the flange: textbook 1.4.6.
#![expect(
    clippy::indexing_slicing,
    reason = "vectors and matrices of nalgebra, indexed within the shape they were made with"
)]

use nalgebra::{DMatrix, DVector, Vector3, Vector6};

use crate::serial::arm::SerialArm;
use crate::serial::error::SerialError;
use crate::serial::task::{Scaled, Task};
use crate::serial::values::JointValues;

/// Singular values below this part of the largest count as zero.
pub(crate) const RANK_TOLERANCE: f64 = 1e-9;
/// A velocity is compatible (1.91) if this part of it at most cannot be made.
const COMPATIBLE: f64 = 1e-9;
/// No velocity is larger, in millimeters or radians a second.
const MAX_VELOCITY: f64 = 1e6;

/// A velocity of the flange in the world.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Twist {
    /// Of the flange's origin, in millimeters a second.
    pub linear: Vector3<f64>,
    /// Angular, in radians a second.
    pub angular: Vector3<f64>,
}

impl Twist {
    pub(crate) fn vector(&self) -> Vector6<f64> {
        let (v, w) = (self.linear, self.angular);
        Vector6::new(v.x, v.y, v.z, w.x, w.y, w.z)
    }
}

/// Joint rates.
#[derive(Clone, Debug, PartialEq)]
pub struct Rates {
    /// Radians or millimeters a second, base first.
    pub rates: Vec<f64>,
    /// The largest share of a joint's highest speed that is asked for: above 1 the motion is too
    /// fast for the arm. Nothing was slowed down.
    pub load: f64,
    /// The rank of the task's Jacobian.
    pub rank: usize,
}

/// Why a velocity has no joint rates.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum VelocityError {
    /// The values are not the arm's.
    #[error(transparent)]
    Joints(#[from] SerialError),
    /// A component of the velocity is not a number, or beyond anything.
    #[error("{name} of the velocity is {value}; it must be a number from -{max} to {max}")]
    NotAVelocity {
        /// `linear` or `angular`.
        name: &'static str,
        /// What was given.
        value: f64,
        /// The largest magnitude.
        max: f64,
    },
    /// The null-space motion has the wrong number of joints, or is not finite.
    #[error("the null-space motion has {given} finite rates; the arm has {wanted} joints")]
    NullMotion {
        /// How many joints there are.
        wanted: usize,
        /// How many finite rates were given.
        given: usize,
    },
    /// (1.91) does not hold: part of the velocity cannot be made here, whatever the rates.
    #[error(
        "{missing_mm_s:.3} mm/s and {missing_rad_s:.5} rad/s of the velocity cannot be made here: \
         the Jacobian has rank {rank} of {wanted}"
    )]
    Incompatible {
        /// The rank.
        rank: usize,
        /// The rank a regular posture of an arm with enough joints has.
        wanted: usize,
        /// What is missing of the linear velocity.
        missing_mm_s: f64,
        /// What is missing of the angular velocity.
        missing_rad_s: f64,
    },
}

/// How well an arm moves at one posture.
#[derive(Clone, Debug, PartialEq)]
pub struct Dexterity {
    /// Singular values of the task's Jacobian with lengths as parts of the arm's span, largest
    /// first; as many as the smaller of the task's size and the joints.
    pub singular_values: Vec<f64>,
    /// How many of them are not zero.
    pub rank: usize,
    /// Their product, `sqrt(det(J J^T))` (Yoshikawa); of an arm with fewer joints than the task has
    /// numbers, `sqrt(det(J^T J))`.
    pub manipulability: f64,
    /// The largest divided by the smallest; infinite at a singularity.
    pub condition: f64,
    /// The task's motions that are lost here, as velocities in the world, of length 1 with lengths as
    /// parts of the span. An arm with fewer joints than the task asks for always has some.
    pub lost: Vec<Twist>,
    /// The joint motions that do not move the task, in radians and millimeters.
    pub free: Vec<Vec<f64>>,
}

impl SerialArm {
    /// Joint rates that move the flange with `twist`, as far as `task` asks.
    ///
    /// Fewer joints than the task has numbers: the rates if the velocity is compatible (1.91). As
    /// many: the inverse (1.92). More: `J+ chi + (1 - J+ J) rho` (1.93), with `null_motion` as rho
    /// in radians or millimeters a second; without it the smallest rates. The pseudo-inverse is
    /// taken from the singular values, so that it also serves at a singularity for the velocities
    /// that are left.
    ///
    /// # Errors
    /// What cannot be made of the velocity, with the rank.
    pub fn rates(
        &self,
        joints: &JointValues,
        twist: &Twist,
        task: Task,
        null_motion: Option<&[f64]>,
    ) -> Result<Rates, VelocityError> {
        self.check_count(joints.len())?;
        let parts = [("linear", twist.linear), ("angular", twist.angular)];
        for (name, vector) in parts {
            for &value in vector.iter() {
                if value.is_nan() || value.abs() > MAX_VELOCITY {
                    return Err(VelocityError::NotAVelocity {
                        name,
                        value,
                        max: MAX_VELOCITY,
                    });
                }
            }
        }
        let rho = self.null_motion(null_motion)?;
        let stance = self.stance(&self.chain(joints));
        let scaled = Scaled::of(self, &stance, task);
        let wanted = scaled.twist(&twist.vector());
        let inverse = PseudoInverse::of(&scaled.matrix);
        let mut rates = inverse.solve(&wanted);
        let missing = &wanted - &scaled.matrix * &rates;
        if missing.norm() > COMPATIBLE * wanted.norm().max(1e-12) {
            let (linear, angular) = (missing.rows(0, 3).norm(), missing.rows_range(3..).norm());
            return Err(VelocityError::Incompatible {
                rank: inverse.rank,
                wanted: task.size(),
                missing_mm_s: linear * self.span,
                missing_rad_s: angular,
            });
        }
        if let Some(rho) = rho {
            let rho = rho.component_div(&scaled.joint_units);
            rates += &rho - inverse.solve(&(&scaled.matrix * &rho));
        }
        let rates = rates.component_mul(&scaled.joint_units);
        let load = self
            .joints
            .iter()
            .zip(rates.iter())
            .map(|(joint, rate)| rate.abs() / joint.max_speed)
            .fold(0.0, f64::max);
        Ok(Rates {
            rates: rates.iter().copied().collect(),
            load,
            rank: inverse.rank,
        })
    }

    fn null_motion(&self, rho: Option<&[f64]>) -> Result<Option<DVector<f64>>, VelocityError> {
        let Some(rho) = rho else {
            return Ok(None);
        };
        let given = rho.iter().filter(|rate| rate.is_finite()).count();
        if given != self.joints.len() || rho.len() != given {
            return Err(VelocityError::NullMotion {
                wanted: self.joints.len(),
                given,
            });
        }
        Ok(Some(DVector::from_column_slice(rho)))
    }

    /// Rank, manipulability and what is lost at `joints`: a posture is singular (1.90) if the rank
    /// is below the smaller of the task's size and the joints.
    ///
    /// # Errors
    /// The values are another arm's.
    pub fn dexterity(&self, joints: &JointValues, task: Task) -> Result<Dexterity, SerialError> {
        self.check_count(joints.len())?;
        let stance = self.stance(&self.chain(joints));
        let scaled = Scaled::of(self, &stance, task);
        let (rows, columns) = scaled.matrix.shape();
        // A square matrix has all left and right singular vectors.
        let size = rows.max(columns);
        let mut square = DMatrix::zeros(size, size);
        square
            .view_mut((0, 0), (rows, columns))
            .copy_from(&scaled.matrix);
        let svd = square.svd(true, true);
        let count = rows.min(columns);
        let values: Vec<f64> = svd.singular_values.iter().copied().take(count).collect();
        let largest = values.first().copied().unwrap_or(0.0);
        let smallest = values.last().copied().unwrap_or(0.0);
        let is_zero = |value: f64| value <= RANK_TOLERANCE * largest;
        let rank = values.iter().filter(|value| !is_zero(**value)).count();
        let mut lost = Vec::new();
        let mut free = Vec::new();
        for (i, value) in svd.singular_values.iter().enumerate() {
            if !is_zero(*value) {
                continue;
            }
            if let Some(u) = &svd.u {
                let motion = scaled.selection.transpose() * u.view((0, i), (rows, 1));
                // The padding's own directions are no motion of the task.
                if u.view((0, i), (rows, 1)).norm() > 0.5 {
                    let part = |from| Vector3::from_fn(|k, _| motion[(from + k, 0)]);
                    lost.push(Twist {
                        // The selection divides lengths by the span; its transpose does it again.
                        linear: part(0) * (self.span * self.span),
                        angular: part(3),
                    });
                }
            }
            if let Some(v) = &svd.v_t {
                let motion = v.view((i, 0), (1, columns));
                if motion.norm() > 0.5 {
                    let units = scaled.joint_units.iter();
                    free.push(motion.iter().zip(units).map(|(m, unit)| m * unit).collect());
                }
            }
        }
        Ok(Dexterity {
            manipulability: values.iter().product(),
            condition: if rank < count {
                f64::INFINITY
            } else {
                largest / smallest
            },
            singular_values: values,
            rank,
            lost,
            free,
        })
    }
}

/// The pseudo-inverse by singular values.
pub(crate) struct PseudoInverse {
    u: DMatrix<f64>,
    v_t: DMatrix<f64>,
    values: DVector<f64>,
    pub(crate) rank: usize,
}

impl PseudoInverse {
    pub(crate) fn of(matrix: &DMatrix<f64>) -> Self {
        let (rows, columns) = matrix.shape();
        let svd = matrix.clone().svd(true, true);
        let values = svd.singular_values;
        let least = RANK_TOLERANCE * values.max();
        let rank = values.iter().filter(|value| **value > least).count();
        let none = |r: usize, c: usize| DMatrix::zeros(r, c);
        let count = values.len();
        Self {
            u: svd.u.unwrap_or_else(|| none(rows, count)),
            v_t: svd.v_t.unwrap_or_else(|| none(count, columns)),
            values,
            rank,
        }
    }

    /// The smallest least-squares solution.
    pub(crate) fn solve(&self, right: &DVector<f64>) -> DVector<f64> {
        let mut parts = self.u.tr_mul(right);
        for (i, part) in parts.iter_mut().enumerate() {
            *part = if i < self.rank {
                *part / self.values[i]
            } else {
                0.0
            };
        }
        self.v_t.tr_mul(&parts)
    }
}
