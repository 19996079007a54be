//! Inverse kinematics of any arm by damped least squares, inside the ranges.
#![expect(
    clippy::indexing_slicing,
    reason = "vectors and matrices of nalgebra, indexed within the shape they were made with"
)]

use nalgebra::{DMatrix, DVector, Matrix3, Vector3};

use crate::pose::Pose;
use crate::serial::arm::SerialArm;
use crate::serial::error::{OutsideRange, SerialError};
use crate::serial::task::{Scaled, Task};
use crate::serial::values::JointValues;

/// When a search ends.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct DlsOptions {
    /// As near as this is there, in millimeters.
    pub position_tolerance_mm: f64,
    /// As near as this is there, in radians.
    pub rotation_tolerance_rad: f64,
    /// Steps from each start.
    pub max_steps: usize,
    /// Starts: the given joints first, then points spread over the ranges.
    pub starts: usize,
}

impl Default for DlsOptions {
    fn default() -> Self {
        Self {
            position_tolerance_mm: 1e-6,
            rotation_tolerance_rad: 1e-9,
            max_steps: 200,
            starts: 20,
        }
    }
}

/// Joints that reach a pose, inside the ranges.
#[derive(Clone, Debug, PartialEq)]
pub struct DlsSolution {
    /// The joints.
    pub joints: JointValues,
    /// How far off the position is, in millimeters.
    pub position_error_mm: f64,
    /// How far off the rotation is, in radians, as far as the task asks for it.
    pub rotation_error_rad: f64,
    /// Steps of all starts.
    pub steps: usize,
    /// The start that led here, from 0.
    pub start: usize,
}

/// Why the search found nothing.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum DlsError {
    /// The start is not the arm's.
    #[error(transparent)]
    Joints(#[from] SerialError),
    /// The start is outside the ranges.
    #[error("the start is outside the ranges: {0}")]
    StartOutside(OutsideRange),
    /// An option that cannot be.
    #[error("{name} is {value}; it must be above 0")]
    Option {
        /// Which.
        name: &'static str,
        /// What was given.
        value: f64,
    },
    /// No start led there. `nearest` is how far the best one got.
    #[error(
        "not reached: {:.6} mm and {:.8} rad are left after {} steps{}", .nearest.position_error_mm,
        .nearest.rotation_error_rad, .nearest.steps, AtLimits(.at_limits)
    )]
    NotReached {
        /// The best of all starts.
        nearest: Box<DlsSolution>,
        /// The joints that are at a limit there.
        at_limits: Vec<String>,
    },
}

struct AtLimits<'a>(&'a [String]);

impl std::fmt::Display for AtLimits<'_> {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        if self.0.is_empty() {
            return Ok(());
        }
        write!(f, "; at a limit: {}", self.0.join(", "))
    }
}

/// What is left to a target.
struct Miss {
    position: Vector3<f64>,
    rotation: Vector3<f64>,
}

impl Miss {
    /// Without units.
    fn size(&self, span: f64) -> f64 {
        (self.position / span).norm_squared() + self.rotation.norm_squared()
    }
}

impl SerialArm {
    /// Joints inside the ranges with the flange at `X_WF`, as far as `task` asks, searched from
    /// `start`.
    ///
    /// Levenberg's method on the scaled Jacobian: a joint at its limit that would go beyond is held
    /// there for the step, so every iterate is inside the ranges. Local: from each start it finds
    /// one solution or a place where it can get no nearer.
    ///
    /// # Errors
    /// How far the best start got, and which joints are at a limit there.
    pub fn solve(
        &self,
        X_WF: &Pose,
        task: Task,
        start: &JointValues,
        options: &DlsOptions,
    ) -> Result<DlsSolution, DlsError> {
        self.check_count(start.len())?;
        if let Some(outside) = self.outside(start).into_iter().next() {
            return Err(DlsError::StartOutside(outside));
        }
        for (name, value) in [
            ("position_tolerance_mm", options.position_tolerance_mm),
            ("rotation_tolerance_rad", options.rotation_tolerance_rad),
            ("max_steps", as_number(options.max_steps)),
            ("starts", as_number(options.starts)),
        ] {
            if value.is_nan() || value <= 0.0 {
                return Err(DlsError::Option { name, value });
            }
        }
        let target = (X_WF.rotation_matrix(), X_WF.isometry().translation.vector);
        let mut best: Option<DlsSolution> = None;
        let mut steps = 0;
        for index in 0..options.starts {
            let from = if index == 0 {
                start.0.clone()
            } else {
                self.spread(index)
            };
            let mut found = self.search(&target, task, from, options);
            steps += found.steps;
            (found.steps, found.start) = (steps, index);
            if is_there(&found, options) {
                return Ok(found);
            }
            let size =
                |s: &DlsSolution| (s.position_error_mm / self.span).hypot(s.rotation_error_rad);
            if best.as_ref().is_none_or(|best| size(&found) < size(best)) {
                best = Some(found);
            }
        }
        let nearest = best.map(|nearest| DlsSolution { steps, ..nearest });
        let nearest = Box::new(nearest.unwrap_or_else(|| DlsSolution {
            joints: start.clone(),
            position_error_mm: f64::INFINITY,
            rotation_error_rad: f64::INFINITY,
            steps,
            start: 0,
        }));
        let pairs = self.joints.iter().zip(nearest.joints.as_slice());
        let at_limits = pairs
            .filter(|(joint, value)| **value <= joint.min || **value >= joint.max)
            .map(|(joint, _)| joint.name.clone())
            .collect();
        Err(DlsError::NotReached { nearest, at_limits })
    }

    fn search(
        &self,
        target: &(Matrix3<f64>, Vector3<f64>),
        task: Task,
        mut q: DVector<f64>,
        options: &DlsOptions,
    ) -> DlsSolution {
        let units = self.joint_units();
        let mut damping = 1e-4;
        let mut miss = self.miss(&q, target, task);
        let mut steps = 0;
        while steps < options.max_steps && !near(&miss, options) && damping < 1e8 {
            steps += 1;
            let stance = self.stance(&self.chain(&JointValues(q.clone())));
            let scaled = Scaled::of(self, &stance, task);
            let mut error = nalgebra::Vector6::zeros();
            error.fixed_rows_mut::<3>(0).copy_from(&miss.position);
            error.fixed_rows_mut::<3>(3).copy_from(&miss.rotation);
            let step = self.damped_step(&q, &scaled, &scaled.twist(&error), damping);
            let next = self.moved(&q, &step.component_mul(&units));
            let next_miss = self.miss(&next, target, task);
            if next_miss.size(self.span) < miss.size(self.span) {
                (q, miss) = (next, next_miss);
                damping = (damping * 0.2).max(1e-14);
            } else {
                damping *= 8.0;
            }
        }
        DlsSolution {
            joints: JointValues(q),
            position_error_mm: miss.position.norm(),
            rotation_error_rad: miss.rotation.norm(),
            steps,
            start: 0,
        }
    }

    /// The step of the joints that can make it: one at its limit that would go beyond is left out,
    /// and the others are asked again.
    fn damped_step(
        &self,
        q: &DVector<f64>,
        scaled: &Scaled,
        error: &DVector<f64>,
        damping: f64,
    ) -> DVector<f64> {
        let mut matrix = scaled.matrix.clone();
        let mut step = DVector::zeros(q.len());
        for _ in 0..=q.len() {
            let mut normal = matrix.tr_mul(&matrix);
            for i in 0..q.len() {
                normal[(i, i)] += damping;
            }
            let right = matrix.tr_mul(error);
            step = solve_symmetric(normal, &right);
            let mut held = false;
            for (i, joint) in self.joints.iter().enumerate() {
                let beyond =
                    (q[i] <= joint.min && step[i] < 0.0) || (q[i] >= joint.max && step[i] > 0.0);
                if beyond && matrix.column(i).norm_squared() > 0.0 {
                    matrix.column_mut(i).fill(0.0);
                    held = true;
                }
            }
            if !held {
                break;
            }
        }
        step
    }

    /// One step, no joint farther than half a radian, none beyond its range.
    fn moved(&self, q: &DVector<f64>, step: &DVector<f64>) -> DVector<f64> {
        let units = self.joint_units();
        let largest = step
            .iter()
            .zip(units.iter())
            .map(|(s, unit)| (s / unit).abs())
            .fold(0.0, f64::max);
        let scale = if largest > 0.5 { 0.5 / largest } else { 1.0 };
        let mut next = q + step * scale;
        for (value, joint) in next.iter_mut().zip(&self.joints) {
            *value = value.max(joint.min).min(joint.max);
        }
        next
    }

    fn miss(&self, q: &DVector<f64>, (r, p): &(Matrix3<f64>, Vector3<f64>), task: Task) -> Miss {
        let (rotation, position) = self.flange_at(&self.chain(&JointValues(q.clone())));
        Miss {
            position: p - position,
            rotation: task.rotation_error(&rotation, r),
        }
    }

    /// The `index`-th point of a sequence that fills the ranges evenly (the additive recurrence
    /// with the roots of x^(n+1) = x + 1); the same in every run.
    fn spread(&self, index: usize) -> DVector<f64> {
        let n = as_number(self.joints.len());
        let mut root = 1.5_f64;
        for _ in 0..30 {
            root = (1.0 + root).powf(1.0 / (n + 1.0));
        }
        let mut part = 1.0;
        let spread = self.spread_over_ranges(|_| {
            part /= root;
            (0.5 + part * as_number(index)).fract()
        });
        spread.0
    }
}

fn as_number(count: usize) -> f64 {
    u32::try_from(count).map_or(f64::MAX, f64::from)
}

fn near(miss: &Miss, options: &DlsOptions) -> bool {
    miss.position.norm() <= options.position_tolerance_mm
        && miss.rotation.norm() <= options.rotation_tolerance_rad
}

fn is_there(solution: &DlsSolution, options: &DlsOptions) -> bool {
    solution.position_error_mm <= options.position_tolerance_mm
        && solution.rotation_error_rad <= options.rotation_tolerance_rad
}

fn solve_symmetric(normal: DMatrix<f64>, right: &DVector<f64>) -> DVector<f64> {
    let n = right.len();
    normal
        .cholesky()
        .map_or_else(|| DVector::zeros(n), |cholesky| cholesky.solve(right))
}
