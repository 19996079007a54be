//! Paths of an arm against the zones of the cell: the samples between two points, not only the points.

use api::setup::ZoneKind;
use kinematics::PendantJoints;
use nalgebra::Point3;
use thiserror::Error;
use units::Millimeters;

use super::geometry::Capsule;
use super::model::{Arm, Setup, Zone};

/// No joint turns farther than this between two samples of a path in joint space, in degrees. At full reach that is
/// 35 mm at the tip, less than the thickness of what moves.
const STEP_DEG: f64 = 1.0;

/// A path that enters a keep-out zone.
#[derive(Clone, Debug, Error, PartialEq)]
#[error(
    "the arm enters `{zone}` by {depth:.1} at x {:.1}, y {:.1}, z {:.1} mm", .point.x, .point.y, .point.z
)]
pub(crate) struct KeepOutViolation {
    /// The zone's id.
    pub(crate) zone: String,
    /// The sample where it is deepest, from 0.
    pub(crate) at: usize,
    /// The point on the arm's skeleton there, in the cell frame, in millimeters.
    pub(crate) point: Point3<f64>,
    /// How deep a part of the arm is inside; its thickness counts.
    pub(crate) depth: Millimeters,
}

/// How close a path comes to a zone.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Closest {
    pub(crate) zone: String,
    pub(crate) at: usize,
    pub(crate) point: Point3<f64>,
    /// Negative inside, by the depth.
    pub(crate) gap: Millimeters,
}

impl Closest {
    /// Where it is, for a person.
    pub(crate) fn spot(&self) -> String {
        let Point3 { coords } = self.point;
        format!("x {:.1}, y {:.1}, z {:.1} mm", coords.x, coords.y, coords.z)
    }
}

impl Setup {
    /// Whether no part of the arm enters a keep-out zone at any of the samples.
    ///
    /// The samples are all that is looked at: they must be as close together as [`joint_path`] makes them.
    ///
    /// # Errors
    /// The zone that is entered most deeply, where, and by how much.
    pub(crate) fn check_path(
        &self,
        arm: &Arm,
        samples: &[PendantJoints],
    ) -> Result<(), KeepOutViolation> {
        let zones = self.zones_of(&arm.id, ZoneKind::KeepOut);
        match closest(&bodies(arm, samples), zones) {
            Some(Closest {
                zone,
                at,
                point,
                gap,
            }) if gap.0 < 0.0 => Err(KeepOutViolation {
                zone,
                at,
                point,
                depth: -gap,
            }),
            Some(_) | None => Ok(()),
        }
    }
}

impl Setup {
    /// The hand-over zones that any part of an arm is in.
    pub(crate) fn handover_zones_of(&self, arm: &str, joints_deg: [f64; 6]) -> Vec<String> {
        let Some(arm) = self.arm(arm) else {
            return Vec::new();
        };
        let body = arm.capsules(&PendantJoints::from_degrees(joints_deg));
        self.zones_of(&arm.id, ZoneKind::Handover)
            .filter(|zone| body.iter().any(|part| zone.bounds.gap(part).0 <= 0.0))
            .map(|zone| zone.id.clone())
            .collect()
    }
}

/// The arm's body at each sample of a path.
pub(crate) fn bodies(arm: &Arm, samples: &[PendantJoints]) -> Vec<[Capsule; 5]> {
    samples.iter().map(|joints| arm.capsules(joints)).collect()
}

/// The zone that the arm comes closest to; `None` where there is no zone.
pub(crate) fn closest<'a>(
    bodies: &[[Capsule; 5]],
    zones: impl Iterator<Item = &'a Zone>,
) -> Option<Closest> {
    let zones: Vec<_> = zones.collect();
    let mut best: Option<Closest> = None;
    if zones.is_empty() {
        return best;
    }
    for (at, body) in bodies.iter().enumerate() {
        for capsule in body {
            for zone in &zones {
                let bound = best.as_ref().map_or(f64::INFINITY, |best| best.gap.0);
                if zone.bounds.gap_at_least(capsule) >= bound {
                    continue;
                }
                let (gap, point) = zone.bounds.gap(capsule);
                if gap < bound {
                    best = Some(Closest {
                        zone: zone.id.clone(),
                        at,
                        point,
                        gap: Millimeters(gap),
                    });
                }
            }
        }
    }
    best
}

/// How far inside its work areas the arm's tool center point stays, at the sample where it is least; `None` where the
/// arm has no work area. A tip inside several is as far inside as in the best of them.
pub(crate) fn least_inside<'a>(
    bodies: &[[Capsule; 5]],
    zones: impl Iterator<Item = &'a Zone>,
) -> Option<Closest> {
    let zones: Vec<_> = zones.collect();
    let inside = bodies.iter().enumerate().filter_map(|(at, [.., tool])| {
        let point = tool.to;
        zones
            .iter()
            .map(|zone| Closest {
                zone: zone.id.clone(),
                at,
                point,
                gap: Millimeters(-zone.bounds.distance(&point)),
            })
            .max_by(|a, b| a.gap.0.total_cmp(&b.gap.0))
    });
    inside.min_by(|a, b| a.gap.0.total_cmp(&b.gap.0))
}

/// The samples of a motion in joint space, both ends included: all joints start and stop together, as a controller
/// moves them.
pub(crate) fn joint_path(from: &PendantJoints, to: &PendantJoints) -> Vec<PendantJoints> {
    let (from, to) = (from.degrees(), to.degrees());
    let farthest = from.iter().zip(to).map(|(a, b)| (b - a).abs());
    let steps = (farthest.fold(0.0, f64::max) / STEP_DEG).ceil().max(1.0);
    let mut samples = Vec::new();
    let mut step = 0.0;
    while step <= steps {
        let share = step / steps;
        let mut degrees = from;
        for (value, end) in degrees.iter_mut().zip(to) {
            *value += (end - *value) * share;
        }
        samples.push(PendantJoints::from_degrees(degrees));
        step += 1.0;
    }
    samples
}
