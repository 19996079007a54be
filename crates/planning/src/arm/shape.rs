//! The arm as capsules.

use kinematics::{ArmModel, PendantJoints};
use nalgebra::{Isometry3, Point3, Rotation3, Translation3, UnitQuaternion, Vector3};
use units::{Millimeters, Radians};

use super::transfer::ArmError;

/// A cylinder with round ends, fixed to a link.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Capsule {
    /// The frame of the Denavit-Hartenberg table it moves with: 0 is the base, 6 the flange.
    pub link: usize,
    /// One end of its axis, in that frame, mm.
    pub from: [f64; 3],
    /// The other.
    pub to: [f64; 3],
    /// mm.
    pub radius: f64,
}

/// The capsules of an arm and its tool.
#[derive(Clone, Debug, PartialEq)]
pub struct ArmShape {
    capsules: Vec<Capsule>,
    /// For each joint, how far the capsules beyond it reach from its axis at most.
    reaches: [f64; 6],
}

const MAX_CAPSULES: usize = 64;
const MAX_MM: f64 = 1e5;

impl ArmShape {
    /// Capsules of an arm.
    ///
    /// # Errors
    /// Names the capsule and the number that is wrong.
    pub fn try_new(arm: &ArmModel, capsules: Vec<Capsule>) -> Result<ArmShape, ArmError> {
        if capsules.is_empty() || capsules.len() > MAX_CAPSULES {
            return Err(ArmError::Capsules {
                count: capsules.len(),
                most: MAX_CAPSULES,
            });
        }
        for (capsule, shape) in (1..).zip(&capsules) {
            let numbers = [
                ("from", shape.from),
                ("to", shape.to),
                ("radius", [shape.radius; 3]),
            ];
            for (item, values) in numbers {
                let wrong = |value: &f64| {
                    !value.is_finite()
                        || value.abs() > MAX_MM
                        || (item == "radius" && *value <= 0.0)
                };
                if let Some(&value) = values.iter().find(|value| wrong(value)) {
                    return Err(ArmError::Capsule {
                        capsule,
                        item,
                        value,
                    });
                }
            }
            if shape.link > 6 {
                let link = shape.link;
                return Err(ArmError::Link { capsule, link });
            }
        }
        let reaches = reaches(arm, &capsules);
        Ok(ArmShape { capsules, reaches })
    }

    /// The arm as its Denavit-Hartenberg table has it, in capsules of one radius: along each
    /// offset d and each length a that is longer than a millimeter.
    ///
    /// # Errors
    /// A radius that is none.
    pub fn skeleton(arm: &ArmModel, radius: Millimeters) -> Result<ArmShape, ArmError> {
        let mut capsules = Vec::new();
        for (index, row) in arm.dh().iter().enumerate() {
            let (d, a) = (row.d.0, row.a.0);
            let origin = [0.0; 3];
            if d.abs() > 1.0 {
                // Along the axis of the joint: fixed to the link before it.
                capsules.push(Capsule {
                    link: index,
                    from: origin,
                    to: [0.0, 0.0, d],
                    radius: radius.0,
                });
            }
            if a.abs() > 1.0 {
                // Back along the common normal, which is the x axis of the link's own frame.
                capsules.push(Capsule {
                    link: index + 1,
                    from: [-a, 0.0, 0.0],
                    to: origin,
                    radius: radius.0,
                });
            }
        }
        ArmShape::try_new(arm, capsules)
    }

    /// With more capsules, such as those of a tool.
    ///
    /// # Errors
    /// As [`Self::try_new`].
    pub fn with(&self, arm: &ArmModel, more: &[Capsule]) -> Result<ArmShape, ArmError> {
        let capsules = self.capsules.iter().chain(more).copied().collect();
        ArmShape::try_new(arm, capsules)
    }

    /// The capsules.
    #[must_use]
    pub fn capsules(&self) -> &[Capsule] {
        &self.capsules
    }

    /// The axes of the capsules in the world, mm, at these joints.
    pub(crate) fn placed(
        &self,
        arm: &ArmModel,
        joints: &PendantJoints,
        placed: &mut Vec<(Point3<f64>, Point3<f64>, f64)>,
    ) {
        placed.clear();
        let frames = frames(arm, joints);
        placed.extend(self.capsules.iter().filter_map(|capsule| {
            let frame = frames.get(capsule.link)?;
            Some((
                frame * Point3::from(capsule.from),
                frame * Point3::from(capsule.to),
                capsule.radius,
            ))
        }));
    }

    /// At most so far does any point of the arm move between two joint sets, mm.
    pub(crate) fn way(&self, arm: &ArmModel, a: &PendantJoints, b: &PendantJoints) -> f64 {
        let (a, b) = (arm.chain(a).radians(), arm.chain(b).radians());
        let ways = a.iter().zip(&b).zip(&self.reaches);
        ways.map(|((a, b), reach)| (b - a).abs() * reach).sum()
    }
}

/// The frames of the table, the base first.
fn frames(arm: &ArmModel, joints: &PendantJoints) -> [Isometry3<f64>; 7] {
    let angles = arm.chain(joints).radians();
    let mut frames = [Isometry3::identity(); 7];
    let mut frame = Isometry3::identity();
    for ((slot, row), angle) in frames.iter_mut().skip(1).zip(arm.dh()).zip(angles) {
        let (Radians(alpha), q) = (row.alpha, angle);
        let turn = UnitQuaternion::from_axis_angle(&Vector3::z_axis(), q);
        let shift = Translation3::from(turn * Vector3::new(row.a.0, 0.0, row.d.0));
        let twist = UnitQuaternion::from_rotation_matrix(&Rotation3::from_axis_angle(
            &Vector3::x_axis(),
            alpha,
        ));
        frame *= Isometry3::from_parts(shift, turn * twist);
        *slot = frame;
    }
    frames
}

/// Beyond a joint the arm reaches at most as far as the lengths up to a capsule, and the capsule
/// itself: for any posture.
fn reaches(arm: &ArmModel, capsules: &[Capsule]) -> [f64; 6] {
    let mut reaches = [0.0; 6];
    for (joint, reach) in reaches.iter_mut().enumerate() {
        // Joint k turns frame k + 1; its axis is that of frame k.
        for capsule in capsules.iter().filter(|capsule| capsule.link > joint) {
            let lengths = arm.dh().iter().take(capsule.link).skip(joint);
            let chain: f64 = lengths.map(|row| row.a.0.hypot(row.d.0)).sum();
            let norm = |p: [f64; 3]| Vector3::from(p).norm();
            let own = norm(capsule.from).max(norm(capsule.to)) + capsule.radius;
            *reach = f64::max(*reach, chain + own);
        }
    }
    reaches
}
