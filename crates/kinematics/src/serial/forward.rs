//! Forward kinematics of any chain.

use nalgebra::{DVector, Matrix3, Rotation3, UnitQuaternion, Vector3};

use crate::pose::Pose;
use crate::serial::arm::{JointKind, SerialArm};
use crate::serial::error::SerialError;
use crate::serial::values::JointValues;

/// A chain at one set of joint values, in the world; millimeters.
#[derive(Clone, Debug)]
pub(crate) struct Stance {
    /// Direction and a point of each joint's axis: z(i-1) and p(i-1).
    pub(crate) axes: Vec<(Vector3<f64>, Vector3<f64>)>,
    /// Frames 1 to n.
    pub(crate) frames: Vec<(Matrix3<f64>, Vector3<f64>)>,
    /// The flange.
    pub(crate) rotation: Matrix3<f64>,
    pub(crate) position: Vector3<f64>,
}

impl SerialArm {
    /// `X_WF`, the flange in the world, at `joints`; translation in millimeters.
    ///
    /// The product (1.22) of the textbook, (12) of the thesis, of any number of links. Ranges are
    /// not checked.
    ///
    /// # Errors
    /// The values are another arm's.
    pub fn forward(&self, joints: &JointValues) -> Result<Pose, SerialError> {
        self.check_count(joints.len())?;
        let (rotation, position) = self.flange_at(&self.chain(joints));
        Ok(pose_of(&rotation, position))
    }

    /// The frames 0 to n of the table and the flange, in the world: what a drawing needs.
    ///
    /// # Errors
    /// The values are another arm's.
    pub fn frames(&self, joints: &JointValues) -> Result<Vec<Pose>, SerialError> {
        self.check_count(joints.len())?;
        let stance = self.stance(&self.chain(joints));
        let mut frames = vec![self.base()];
        frames.extend(stance.frames.iter().map(|(r, p)| pose_of(r, *p)));
        frames.push(pose_of(&stance.rotation, stance.position));
        Ok(frames)
    }

    /// The flange at the chain's values `q`, without keeping what is between.
    pub(crate) fn flange_at(&self, q: &DVector<f64>) -> (Matrix3<f64>, Vector3<f64>) {
        let mut rotation = self.base.rotation.to_rotation_matrix().into_inner();
        let mut position = self.base.translation.vector;
        for ((joint, (link_r, link_p)), &q) in self.joints.iter().zip(&self.fixed).zip(q.iter()) {
            match joint.kind {
                JointKind::Revolute => turn_about_z(&mut rotation, q),
                JointKind::Prismatic => position += rotation.column(2) * q,
            }
            position += rotation * link_p;
            rotation *= link_r;
        }
        position += rotation * self.flange.translation.vector;
        rotation *= self.flange.rotation.to_rotation_matrix().matrix();
        (rotation, position)
    }

    /// All of the chain at its values `q`.
    pub(crate) fn stance(&self, q: &DVector<f64>) -> Stance {
        let n = self.joints.len();
        let (mut axes, mut frames) = (Vec::with_capacity(n), Vec::with_capacity(n));
        let mut rotation = self.base.rotation.to_rotation_matrix().into_inner();
        let mut position = self.base.translation.vector;
        for ((joint, (link_r, link_p)), &q) in self.joints.iter().zip(&self.fixed).zip(q.iter()) {
            axes.push((rotation.column(2).into_owned(), position));
            match joint.kind {
                JointKind::Revolute => turn_about_z(&mut rotation, q),
                JointKind::Prismatic => position += rotation.column(2) * q,
            }
            position += rotation * link_p;
            rotation *= link_r;
            frames.push((rotation, position));
        }
        position += rotation * self.flange.translation.vector;
        rotation *= self.flange.rotation.to_rotation_matrix().matrix();
        Stance {
            axes,
            frames,
            rotation,
            position,
        }
    }
}

/// `rotation * Rz(angle)`: the first two columns turn.
fn turn_about_z(rotation: &mut Matrix3<f64>, angle: f64) {
    let (s, c) = angle.sin_cos();
    let (x, y) = (
        rotation.column(0).into_owned(),
        rotation.column(1).into_owned(),
    );
    rotation.set_column(0, &(x * c + y * s));
    rotation.set_column(1, &(y * c - x * s));
}

pub(crate) fn pose_of(rotation: &Matrix3<f64>, position: Vector3<f64>) -> Pose {
    let rotation = Rotation3::from_matrix_unchecked(*rotation);
    Pose::from_parts(position, UnitQuaternion::from_rotation_matrix(&rotation))
}
