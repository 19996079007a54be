//! What arm models there are, and what they are.

use api::arms::{ArmDescription, ArmJoint, ArmJointCoupling, ArmJointKind, ArmList, ArmSummary};
use kinematics::serial::{JointKind, SerialJoint};

use crate::arm::Arm;
use crate::convert::{shown, shown_pose};
use crate::dynamics::inertia_body;
use crate::refusal::Refusal;
use crate::shape;

/// The arm models that are known.
#[must_use]
pub fn models() -> ArmList {
    let arms = Arm::all().map(|arm| ArmSummary {
        model: arm.name().to_owned(),
        manufacturer: arm.serial.manufacturer().to_owned(),
        degrees_of_freedom: arm.serial.degrees_of_freedom(),
        solvers: arm.solvers(),
    });
    ArmList {
        arms: arms.collect(),
    }
}

/// All that is known of an arm model: Denavit-Hartenberg table, ranges, speeds, shape.
///
/// The table is in the standard convention, textbook (1.12), whatever the model's file has.
///
/// # Errors
/// There is no such model.
pub fn describe(model: &str) -> Result<ArmDescription, Refusal> {
    let arm = Arm::named(model)?;
    let joints = arm.serial.joint_list();
    Ok(ArmDescription {
        model: arm.name().to_owned(),
        manufacturer: arm.serial.manufacturer().to_owned(),
        degrees_of_freedom: joints.len(),
        solvers: arm.solvers(),
        task: arm.task(None),
        span_mm: shown(arm.serial.span()),
        base: shown_pose(&arm.serial.base()),
        flange: shown_pose(&arm.serial.flange()),
        joints: joints
            .iter()
            .map(|joint| joint_body(joint, joints))
            .collect(),
        home_deg_mm: arm.shown(&arm.serial.home()),
        capsules: shape::capsules(&arm),
    })
}

fn joint_body(joint: &SerialJoint, all: &[SerialJoint]) -> ArmJoint {
    let own = |value: f64| shown(joint.kind.shown(value));
    let couplings = joint.couplings.iter().filter_map(|(other, factor)| {
        let joint = all.get(*other)?.name.clone();
        Some(ArmJointCoupling {
            joint,
            factor: *factor,
        })
    });
    ArmJoint {
        name: joint.name.clone(),
        kind: match joint.kind {
            JointKind::Revolute => ArmJointKind::Revolute,
            JointKind::Prismatic => ArmJointKind::Prismatic,
        },
        a_mm: shown(joint.a),
        alpha_deg: shown(joint.alpha.to_degrees()),
        d_mm: shown(joint.d),
        theta_deg: shown(joint.theta.to_degrees()),
        sign: joint.sign,
        offset_deg_mm: own(joint.offset),
        couplings: couplings.collect(),
        min_deg_mm: own(joint.min),
        max_deg_mm: own(joint.max),
        max_speed_deg_mm_s: own(joint.max_speed),
        max_acceleration_deg_mm_s2: own(joint.max_acceleration),
        inertia: joint.inertia.as_ref().map(inertia_body),
    }
}
