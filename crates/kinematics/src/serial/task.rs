//! What of the flange's motion matters, and how it is made comparable.
#![expect(
    clippy::indexing_slicing,
    reason = "vectors and matrices of nalgebra, indexed within the shape they were made with"
)]

use nalgebra::{DMatrix, DVector, Matrix3, Vector3, Vector6};

use crate::serial::arm::{JointKind, SerialArm};
use crate::serial::forward::Stance;

/// What of the flange's motion is asked for. Arms with fewer than six joints cannot do all of it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Task {
    /// Position and rotation: six numbers.
    Pose,
    /// Position and the direction of the flange's Z axis, turning about it is free: five numbers.
    PositionAndAxis,
    /// Position and the rotation about the world's Z: four numbers, a SCARA's.
    PositionAndHeading,
    /// The position only: three numbers.
    Position,
}

impl Task {
    /// The most that `joints` joints can do in general: 6 or more the pose, 5 position and axis,
    /// fewer the position. For four joints of a SCARA, ask for [`Task::PositionAndHeading`].
    #[must_use]
    pub fn for_joints(joints: usize) -> Task {
        match joints {
            0..=4 => Task::Position,
            5 => Task::PositionAndAxis,
            _ => Task::Pose,
        }
    }

    /// How many numbers it has.
    #[must_use]
    pub fn size(self) -> usize {
        match self {
            Task::Pose => 6,
            Task::PositionAndAxis => 5,
            Task::PositionAndHeading => 4,
            Task::Position => 3,
        }
    }

    /// The rows of the task for a flange that is turned by `rotation`, lengths divided by `span`:
    /// size x 6.
    fn selection(self, rotation: &Matrix3<f64>, span: f64) -> DMatrix<f64> {
        let mut rows = DMatrix::zeros(self.size(), 6);
        for i in 0..3 {
            rows[(i, i)] = 1.0 / span;
        }
        match self {
            Task::Pose => (3..6).for_each(|i| rows[(i, i)] = 1.0),
            // Turns about the flange's own X and Y move its Z.
            Task::PositionAndAxis => {
                for (row, column) in [(3, 0), (4, 1)] {
                    for i in 0..3 {
                        rows[(row, 3 + i)] = rotation[(i, column)];
                    }
                }
            }
            Task::PositionAndHeading => rows[(3, 5)] = 1.0,
            Task::Position => {}
        }
        rows
    }

    /// The rotation vector in the world that is still to be made, as far as the task asks for it.
    pub(crate) fn rotation_error(self, now: &Matrix3<f64>, wanted: &Matrix3<f64>) -> Vector3<f64> {
        match self {
            Task::Pose => rotation_vector(&(wanted * now.transpose())),
            Task::PositionAndAxis => {
                let (from, to) = (now.column(2), wanted.column(2));
                let axis = from.cross(&to);
                let (sine, cosine) = (axis.norm(), from.dot(&to));
                if sine > 1e-12 {
                    axis * (sine.atan2(cosine) / sine)
                } else if cosine > 0.0 {
                    Vector3::zeros()
                } else {
                    // Half a turn, about any axis across.
                    now.column(0) * std::f64::consts::PI
                }
            }
            Task::PositionAndHeading => {
                let turn = wanted * now.transpose();
                let angle = (turn[(1, 0)] - turn[(0, 1)]).atan2(turn[(0, 0)] + turn[(1, 1)]);
                Vector3::new(0.0, 0.0, angle)
            }
            Task::Position => Vector3::zeros(),
        }
    }
}

/// The axis times the angle of a rotation, angle from 0 to pi.
pub(crate) fn rotation_vector(r: &Matrix3<f64>) -> Vector3<f64> {
    let twice = Vector3::new(
        r[(2, 1)] - r[(1, 2)],
        r[(0, 2)] - r[(2, 0)],
        r[(1, 0)] - r[(0, 1)],
    );
    let (sine, cosine) = (0.5 * twice.norm(), 0.5 * (r.trace() - 1.0));
    if sine > 1e-8 {
        return twice * (0.5 * sine.atan2(cosine) / sine);
    }
    if cosine > 0.0 {
        return twice * 0.5;
    }
    // Near half a turn the axis is the longest column of R + 1.
    let columns = r + Matrix3::identity();
    let longest = (0..3).map(|i| columns.column(i).into_owned()).fold(
        Vector3::zeros(),
        |best: Vector3<f64>, column| {
            if column.norm_squared() > best.norm_squared() {
                column
            } else {
                best
            }
        },
    );
    longest.normalize() * sine.atan2(cosine)
}

/// The Jacobian of a task without units: lengths are parts of the arm's span, so that one singular
/// value can be held against another.
#[derive(Clone, Debug)]
pub(crate) struct Scaled {
    /// size x n.
    pub(crate) matrix: DMatrix<f64>,
    /// size x 6: from a twist in the world.
    pub(crate) selection: DMatrix<f64>,
    /// Displayed joint rates are the scaled ones times these.
    pub(crate) joint_units: DVector<f64>,
}

impl Scaled {
    pub(crate) fn of(arm: &SerialArm, stance: &Stance, task: Task) -> Scaled {
        let selection = task.selection(&stance.rotation, arm.span);
        let joint_units = arm.joint_units();
        let mut matrix = &selection * arm.jacobian_of(stance);
        for (mut column, unit) in matrix.column_iter_mut().zip(joint_units.iter()) {
            column *= *unit;
        }
        Scaled {
            matrix,
            selection,
            joint_units,
        }
    }

    pub(crate) fn twist(&self, twist: &Vector6<f64>) -> DVector<f64> {
        &self.selection * twist
    }
}

impl SerialArm {
    /// One scaled unit of each joint: a radian, or the arm's span.
    pub(crate) fn joint_units(&self) -> DVector<f64> {
        let unit = |kind| match kind {
            JointKind::Revolute => 1.0,
            JointKind::Prismatic => self.span,
        };
        DVector::from_iterator(
            self.joints.len(),
            self.joints.iter().map(|joint| unit(joint.kind)),
        )
    }
}
