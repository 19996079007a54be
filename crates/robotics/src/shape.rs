//! The arm's shape: the capsules of its model file, or capsules along the lengths of its table.

use api::arms::{ArmCapsule, PlacedCapsule};
use kinematics::Pose;
use kinematics::serial::JointKind;
use nalgebra::{Point3, Rotation3, Vector3};

use crate::arm::Arm;
use crate::convert::shown;

/// ASSUMPTION: the arm's thickness as a part of its lengths; 90 mm of an M-20iA, whose forearm is about so thick.
const THICKNESS: f64 = 0.0424;
/// Lengths below this have no capsule.
const LEAST_MM: f64 = 1.0;

/// Of the model's file; where it has none, along each offset d, with the link before the joint, and along each length a, with the joint's own. A prismatic
/// joint's is as long as its stroke, and moves.
pub(crate) fn capsules(arm: &Arm) -> Vec<ArmCapsule> {
    let own = arm.serial.capsules();
    if !own.is_empty() {
        let bodies = own.iter().map(|capsule| ArmCapsule {
            link: capsule.link,
            from_mm: capsule.from,
            to_mm: capsule.to,
            radius_mm: capsule.radius,
        });
        return bodies.collect();
    }
    let radius_mm = (arm.serial.span() * THICKNESS).round();
    let mut capsules = Vec::new();
    let mut push = |link: usize, from: Vector3<f64>, to: Vector3<f64>| {
        if (to - from).norm() > LEAST_MM {
            let list = |v: Vector3<f64>| [v.x, v.y, v.z].map(shown);
            capsules.push(ArmCapsule {
                link,
                from_mm: list(from),
                to_mm: list(to),
                radius_mm,
            });
        }
    };
    let mut links = 0;
    for (link, joint) in arm.serial.joint_list().iter().enumerate() {
        // The common normal is the x axis of the link's own frame; before it, the joint's axis.
        let elbow = Vector3::new(-joint.a, 0.0, 0.0);
        match joint.kind {
            JointKind::Revolute => push(link, Vector3::zeros(), Vector3::new(0.0, 0.0, joint.d)),
            JointKind::Prismatic => {
                let back = Rotation3::from_axis_angle(&Vector3::x_axis(), -joint.alpha);
                let stroke = Vector3::new(0.0, 0.0, joint.min - joint.max);
                push(link + 1, elbow, elbow + back * stroke);
            }
        }
        push(link + 1, elbow, Vector3::zeros());
        links = link + 1;
    }
    let flange = arm.serial.flange().isometry().translation.vector;
    push(links, Vector3::zeros(), flange);
    capsules
}

/// The capsules where the frames of the links are.
pub(crate) fn placed(capsules: &[ArmCapsule], frames: &[Pose]) -> Vec<PlacedCapsule> {
    capsules
        .iter()
        .filter_map(|capsule| {
            let frame = frames.get(capsule.link)?.isometry();
            let at = |p: [f64; 3]| {
                let p = frame * Point3::from(p);
                [p.x, p.y, p.z].map(shown)
            };
            Some(PlacedCapsule {
                from_mm: at(capsule.from_mm),
                to_mm: at(capsule.to_mm),
                radius_mm: capsule.radius_mm,
            })
        })
        .collect()
}
