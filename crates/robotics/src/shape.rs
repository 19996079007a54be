//! The arm's shape: the capsules of its model file, or capsules along the lengths of its table.

use api::arms::{ArmCapsule, PlacedCapsule};
use kinematics::Pose;
use nalgebra::Point3;
use planning::arm::{Capsule, skeleton};
use units::Millimeters;

use crate::arm::Arm;
use crate::convert::shown;

/// ASSUMPTION: the arm's thickness as a part of its lengths; 90 mm of an M-20iA, whose forearm is about so thick.
const THICKNESS: f64 = 0.0424;

/// Of the model's file; where it has none, along the lengths of its table.
pub(crate) fn capsules(arm: &Arm) -> Vec<ArmCapsule> {
    let own = arm.serial.capsules();
    if !own.is_empty() {
        return own
            .iter()
            .map(|capsule| body(capsule, |value| value))
            .collect();
    }
    let radius = Millimeters((arm.serial.span() * THICKNESS).round());
    let along = skeleton(arm.serial, radius);
    along.iter().map(|capsule| body(capsule, shown)).collect()
}

fn body(capsule: &Capsule, shown: fn(f64) -> f64) -> ArmCapsule {
    ArmCapsule {
        link: capsule.link,
        from_mm: capsule.from.map(shown),
        to_mm: capsule.to.map(shown),
        radius_mm: capsule.radius,
    }
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
