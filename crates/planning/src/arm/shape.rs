//! The arm as capsules.

use kinematics::Capsule;
use kinematics::serial::{JointKind, JointValues, SerialArm, SerialJoint};
use nalgebra::{Point3, Rotation3, Vector3};
use units::Millimeters;

use super::transfer::ArmError;

/// Ends of the axis in the world, and the radius, mm.
pub(crate) type Placed = (Point3<f64>, Point3<f64>, f64);

/// The capsules of an arm and its tool.
#[derive(Clone, Debug, PartialEq)]
pub struct ArmShape {
    capsules: Vec<Capsule>,
    /// Pairs of capsules that could touch each other.
    pairs: Vec<(usize, usize)>,
    /// For each joint, how far a point of the capsules beyond it moves at most for each radian or millimeter of it.
    reaches: Vec<f64>,
}

/// The arm keeps this far from itself, mm, or the margin to obstacles if that is less.
const OWN_MARGIN: f64 = 20.0;

/// Two capsules too near to each other.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Own {
    /// From 1.
    pub(crate) capsules: (usize, usize),
    pub(crate) distance: f64,
    pub(crate) margin: f64,
}

impl ArmShape {
    /// Capsules of an arm.
    ///
    /// # Errors
    /// Names the capsule and the number that is wrong.
    pub fn try_new(arm: &SerialArm, capsules: Vec<Capsule>) -> Result<ArmShape, ArmError> {
        if capsules.is_empty() {
            return Err(ArmError::Capsules {
                count: 0,
                most: Capsule::MOST,
            });
        }
        Capsule::check(&capsules, arm.degrees_of_freedom())?;
        let reaches = reaches(arm, &capsules);
        let mut shape = ArmShape {
            pairs: separate_links(&capsules),
            capsules,
            reaches,
        };
        // What touches at home was built so.
        let home = shape.placed(arm, &arm.home());
        let apart = |pair: &(usize, usize)| gap(&home, *pair).is_some_and(|gap| gap >= OWN_MARGIN);
        shape.pairs.retain(apart);
        Ok(shape)
    }

    /// The capsules of the arm's model file.
    ///
    /// # Errors
    /// The model file has none.
    pub fn of_model(arm: &SerialArm) -> Result<ArmShape, ArmError> {
        ArmShape::try_new(arm, arm.capsules().to_vec())
    }

    /// The arm as its table has it, in capsules of one radius: [`skeleton`].
    ///
    /// # Errors
    /// A radius that is none.
    pub fn skeleton(arm: &SerialArm, radius: Millimeters) -> Result<ArmShape, ArmError> {
        ArmShape::try_new(arm, skeleton(arm, radius))
    }

    /// With more capsules, such as those of a tool.
    ///
    /// # Errors
    /// As [`Self::try_new`].
    pub fn with(&self, arm: &SerialArm, more: &[Capsule]) -> Result<ArmShape, ArmError> {
        let capsules = self.capsules.iter().chain(more).copied().collect();
        ArmShape::try_new(arm, capsules)
    }

    /// The capsules.
    #[must_use]
    pub fn capsules(&self) -> &[Capsule] {
        &self.capsules
    }

    /// The axes of the capsules in the world, mm, at these joints.
    pub(crate) fn placed(&self, arm: &SerialArm, joints: &JointValues) -> Vec<Placed> {
        // Joints of another arm were refused before.
        let frames = arm.frames(joints).unwrap_or_default();
        let placed = |capsule: &Capsule| {
            let frame = frames.get(capsule.link)?.isometry();
            Some((
                frame * Point3::from(capsule.from),
                frame * Point3::from(capsule.to),
                capsule.radius,
            ))
        };
        self.capsules.iter().filter_map(placed).collect()
    }

    /// How far the arm must keep from itself at the joint sets that are looked at.
    ///
    /// Between two of them a capsule moves against another one no farther than [`Self::way`], which
    /// counts all joints; only those between their links turn the one against the other.
    pub(crate) fn own_margin(margin: f64) -> f64 {
        margin.min(OWN_MARGIN)
    }

    /// The first two capsules that come nearer to each other than the arm's own margin.
    pub(crate) fn touches_itself(&self, placed: &[Placed], margin: f64) -> Option<Own> {
        let margin = Self::own_margin(margin);
        self.pairs.iter().find_map(|&(first, second)| {
            let distance = gap(placed, (first, second))?;
            (distance < margin).then_some(Own {
                capsules: (first + 1, second + 1),
                distance,
                margin,
            })
        })
    }

    /// At most so far does any point of the arm move between two joint sets, mm.
    pub(crate) fn way(&self, arm: &SerialArm, a: &JointValues, b: &JointValues) -> f64 {
        let chain = |joints| arm.chain_values(joints).unwrap_or_default();
        let (a, b) = (chain(a), chain(b));
        let ways = a.iter().zip(&b).zip(&self.reaches);
        ways.map(|((a, b), reach)| (b - a).abs() * reach).sum()
    }
}

/// Capsules of one radius along the lengths of an arm's table, where these are longer than a millimeter: along each offset d,
/// with the link before the joint, along each length a, with the joint's own, and to the flange. A prismatic joint's is as
/// long as its stroke, and moves.
#[must_use]
pub fn skeleton(arm: &SerialArm, radius: Millimeters) -> Vec<Capsule> {
    let mut capsules = Vec::new();
    let mut push = |link: usize, from: Vector3<f64>, to: Vector3<f64>| {
        if (to - from).norm() > 1.0 {
            capsules.push(Capsule {
                link,
                from: from.into(),
                to: to.into(),
                radius: radius.0,
            });
        }
    };
    let mut links = 0;
    for (link, joint) in arm.joint_list().iter().enumerate() {
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
    let flange = arm.flange().isometry().translation.vector;
    push(links, Vector3::zeros(), flange);
    capsules
}

/// Pairs of capsules on links that are not neighbors. A link without capsules, like the middle of a
/// wrist, has no length: the links on either side of it are neighbors.
fn separate_links(capsules: &[Capsule]) -> Vec<(usize, usize)> {
    let mut links: Vec<usize> = capsules.iter().map(|capsule| capsule.link).collect();
    links.sort_unstable();
    links.dedup();
    let place = |link: usize| links.binary_search(&link).unwrap_or_default();
    let mut pairs = Vec::new();
    for (first, a) in capsules.iter().enumerate() {
        for (second, b) in capsules.iter().enumerate().skip(first + 1) {
            if place(a.link).abs_diff(place(b.link)) > 1 {
                pairs.push((first, second));
            }
        }
    }
    pairs
}

/// Between the surfaces of two capsules, mm; negative if they overlap.
fn gap(placed: &[Placed], (first, second): (usize, usize)) -> Option<f64> {
    let (a, b) = (placed.get(first)?, placed.get(second)?);
    Some(between_segments((&a.0, &a.1), (&b.0, &b.1)) - a.2 - b.2)
}

/// The distance of two segments: the nearest points of their lines, kept on the segments.
fn between_segments(
    (a, b): (&Point3<f64>, &Point3<f64>),
    (c, d): (&Point3<f64>, &Point3<f64>),
) -> f64 {
    let (u, v, w) = (b - a, d - c, a - c);
    let (uu, uv, vv) = (u.norm_squared(), u.dot(&v), v.norm_squared());
    let (uw, vw) = (u.dot(&w), v.dot(&w));
    let share = |part: f64, whole: f64| {
        if whole > 0.0 {
            (part / whole).clamp(0.0, 1.0)
        } else {
            0.0
        }
    };
    let area = uu * vv - uv * uv;
    // Parallel: any point of the first will do to begin with.
    let s = if area > 1e-12 * uu * vv {
        share(uv * vw - vv * uw, area)
    } else {
        0.0
    };
    let t = share(uv * s + vw, vv);
    let s = share(uv * t - uw, uu);
    (w + u * s - v * t).norm()
}

/// Beyond a joint that turns the arm reaches at most as far as the lengths up to a capsule, and the capsule itself: for
/// any posture. What slides moves as far as it slides.
fn reaches(arm: &SerialArm, capsules: &[Capsule]) -> Vec<f64> {
    let joints = arm.joint_list();
    let reach = |(joint, turning): (usize, &SerialJoint)| {
        // Joint k turns frame k + 1; its axis is that of frame k.
        let moved = capsules.iter().filter(|capsule| capsule.link > joint);
        let reaches = moved.map(|capsule| match turning.kind {
            JointKind::Prismatic => 1.0,
            JointKind::Revolute => {
                let between = joints.iter().take(capsule.link).skip(joint);
                let chain: f64 = between.map(|joint| joint.a.hypot(farthest(joint))).sum();
                let norm = |p: [f64; 3]| Vector3::from(p).norm();
                chain + norm(capsule.from).max(norm(capsule.to)) + capsule.radius
            }
        });
        reaches.fold(0.0, f64::max)
    };
    joints.iter().enumerate().map(reach).collect()
}

/// Along its axis, at most: of a joint that slides, wherever it is.
fn farthest(joint: &SerialJoint) -> f64 {
    match joint.kind {
        JointKind::Revolute => joint.d.abs(),
        JointKind::Prismatic => {
            let stroke = joint.min.abs().max(joint.max.abs());
            joint.d.abs() + joint.offset.abs() + stroke
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn distances_of_segments_by_hand() {
        let p = |x: f64, y: f64, z: f64| Point3::new(x, y, z);
        let o = p(0.0, 0.0, 0.0);
        for (one, other, wanted) in [
            // Crossing lines, 3 apart: the nearest points are the middles.
            (
                [p(-1.0, 0.0, 0.0), p(1.0, 0.0, 0.0)],
                [p(0.0, -1.0, 3.0), p(0.0, 1.0, 3.0)],
                3.0,
            ),
            // Parallel, side by side and shifted: 3, 4, 5.
            (
                [o, p(2.0, 0.0, 0.0)],
                [p(1.0, 2.0, 0.0), p(3.0, 2.0, 0.0)],
                2.0,
            ),
            (
                [o, p(2.0, 0.0, 0.0)],
                [p(5.0, 4.0, 0.0), p(9.0, 4.0, 0.0)],
                5.0,
            ),
            // In one line, and end to end.
            (
                [o, p(2.0, 0.0, 0.0)],
                [p(6.0, 0.0, 0.0), p(3.0, 0.0, 0.0)],
                1.0,
            ),
            // The end of one before the middle of the other.
            (
                [o, p(0.0, 0.0, 4.0)],
                [p(1.0, 0.0, 2.0), p(9.0, 3.0, 2.0)],
                1.0,
            ),
            // Points: 2, 3, 6 make 7.
            ([o, o], [p(2.0, 3.0, 6.0), p(2.0, 3.0, 6.0)], 7.0),
            ([o, o], [p(-5.0, 2.0, 0.0), p(5.0, 2.0, 0.0)], 2.0),
            // They cross.
            (
                [p(-1.0, -1.0, 0.0), p(1.0, 1.0, 0.0)],
                [p(-1.0, 1.0, 0.0), p(1.0, -1.0, 0.0)],
                0.0,
            ),
        ] {
            let [a, b] = &one;
            let [c, d] = &other;
            for found in [
                between_segments((a, b), (c, d)),
                between_segments((d, c), (a, b)),
            ] {
                assert!((found - wanted).abs() < 1e-12, "{one:?} {other:?}: {found}");
            }
        }
    }
}
