//! A collision-free way from one joint set to another.

use std::fmt;

use kinematics::{ArmModel, Axis, CapsuleError, JointsError, LimitViolations, PendantJoints};
use rand_distr::{Distribution, Uniform};
use rand_pcg::Pcg64Mcg;
use units::Millimeters;

use super::scene::Scene;
use super::shape::ArmShape;
use crate::sampling::{Sampling, Space, search};

/// Why there is no transfer. Capsules and obstacles count from 1.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum ArmError {
    /// An arm of no capsules, or of too many.
    #[error("{count} capsules; an arm has 1 to {most}")]
    Capsules {
        /// How many were given.
        count: usize,
        /// How many there may be.
        most: usize,
    },
    /// A number of a capsule that is out of range.
    #[error("capsule {capsule}: {item} is {value}; sizes are positive, coordinates within 100 m")]
    Capsule {
        /// Which capsule.
        capsule: usize,
        /// `from`, `to`, `radius`.
        item: &'static str,
        /// What was given.
        value: f64,
    },
    /// A capsule on a link that does not exist.
    #[error("capsule {capsule} is on link {link}; links are 0 to 6")]
    Link {
        /// Which capsule.
        capsule: usize,
        /// What was given.
        link: usize,
    },
    /// Too many obstacles.
    #[error("{count} obstacles; at most {most}")]
    Obstacles {
        /// How many were given.
        count: usize,
        /// How many there may be.
        most: usize,
    },
    /// A size or place of an obstacle that is out of range.
    #[error("obstacle {obstacle}: {item} is {value} mm; sizes are positive, all within 100 m")]
    Obstacle {
        /// Which obstacle.
        obstacle: usize,
        /// Which number.
        item: &'static str,
        /// What was given.
        value: f64,
    },
    /// A margin that is none.
    #[error("the margin is {value}; it must be from 1 to 1000 mm")]
    Margin {
        /// What was given.
        value: Millimeters,
    },
    /// Joints that are no joints.
    #[error("{end}: {source}")]
    NotFinite {
        /// `start` or `goal`.
        end: &'static str,
        /// Which joint.
        source: JointsError,
    },
    /// Start or goal beyond the joint limits.
    #[error("{end}: {violations}")]
    Limits {
        /// `start` or `goal`.
        end: &'static str,
        /// Which joints.
        violations: LimitViolations,
    },
    /// Start or goal in an obstacle, or nearer to it than the margin, or with two parts of the arm
    /// touching each other.
    #[error("{end}: {touch}")]
    Touches {
        /// `start` or `goal`.
        end: &'static str,
        /// What touches what.
        touch: Touch,
    },
    /// The samples were in vain, which does not prove that there is no way.
    #[error("no way found after {samples} samples")]
    GaveUp {
        /// How many were tried.
        samples: u32,
    },
}

impl From<CapsuleError> for ArmError {
    fn from(error: CapsuleError) -> ArmError {
        match error {
            CapsuleError::Number {
                capsule,
                item,
                value,
            } => ArmError::Capsule {
                capsule,
                item,
                value,
            },
            CapsuleError::Link { capsule, link, .. } => ArmError::Link { capsule, link },
            CapsuleError::Count { count, most } => ArmError::Capsules { count, most },
        }
    }
}

/// What a capsule of the arm is too near to. Both count from 1.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Touched {
    /// Something around the arm.
    Obstacle(usize),
    /// Another capsule of the arm.
    Capsule(usize),
}

impl fmt::Display for Touched {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Touched::Obstacle(index) => write!(f, "obstacle {index}"),
            Touched::Capsule(index) => write!(f, "capsule {index} of the arm itself"),
        }
    }
}

/// A capsule too near to an obstacle, or to another part of the arm.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
#[error("capsule {capsule} is {distance:.1} from {obstacle}; the margin is {margin}")]
pub struct Touch {
    /// Which capsule.
    pub capsule: usize,
    /// What is in its way.
    pub obstacle: Touched,
    /// Between the two; not positive if they overlap.
    pub distance: Millimeters,
    /// What is asked for.
    pub margin: Millimeters,
}

/// Joint sets to be gone through in straight lines of joint space, start and goal included.
#[derive(Clone, Debug, PartialEq)]
pub struct ArmPath {
    points: Vec<PendantJoints>,
}

impl ArmPath {
    /// The joint sets, start first.
    #[must_use]
    pub fn points(&self) -> &[PendantJoints] {
        &self.points
    }

    /// The sum of the ways in joint space, degrees.
    #[must_use]
    pub fn length_deg(&self) -> f64 {
        let pairs = self.points.iter().zip(self.points.iter().skip(1));
        pairs
            .map(|(a, b)| distance(&a.radians(), &b.radians()).to_degrees())
            .sum()
    }
}

/// A way for the arm from `start` to `goal` by a probabilistic roadmap, its detours left out.
///
/// Everywhere on the way the joints are inside their limits and the capsules touch nothing; at the
/// joint sets it was looked at they are at least `margin` away. Connections are only looked at when
/// a shortest path wants them (a lazy roadmap).
///
/// The arm keeps 20 mm (or `margin`, if that is less) from itself: capsules on neighboring links
/// are left out of that, and capsules that touch at home.
///
/// # Errors
/// Start or goal out of limits or too near to an obstacle, a margin out of range, or no way found.
pub fn transfer(
    arm: &ArmModel,
    shape: &ArmShape,
    scene: &Scene,
    start: &PendantJoints,
    goal: &PendantJoints,
    margin: Millimeters,
    sampling: &Sampling,
) -> Result<ArmPath, ArmError> {
    if !(1.0..=1000.0).contains(&margin.0) {
        return Err(ArmError::Margin { value: margin });
    }
    let space = JointSpace {
        arm,
        shape,
        scene,
        margin: margin.0,
    };
    for (end, joints) in [("start", start), ("goal", goal)] {
        let _ = PendantJoints::try_from_degrees(joints.degrees())
            .map_err(|source| ArmError::NotFinite { end, source })?;
        arm.check_limits(joints)
            .map_err(|violations| ArmError::Limits { end, violations })?;
        if let Some(touch) = space.touch(joints) {
            return Err(ArmError::Touches { end, touch });
        }
    }
    let found =
        search(&space, start.radians(), goal.radians(), sampling).ok_or(ArmError::GaveUp {
            samples: sampling.most,
        })?;
    let mut points = space.shortened(&found.way);
    // The ends exactly as they were given.
    if let [first, .., last] = points.as_mut_slice() {
        (*first, *last) = (*start, *goal);
    }
    Ok(ArmPath { points })
}

struct JointSpace<'a> {
    arm: &'a ArmModel,
    shape: &'a ArmShape,
    scene: &'a Scene,
    margin: f64,
}

fn distance(a: &[f64; 6], b: &[f64; 6]) -> f64 {
    let squares = a.iter().zip(b).map(|(a, b)| (b - a) * (b - a));
    squares.sum::<f64>().sqrt()
}

fn on_the_way(a: &[f64; 6], b: &[f64; 6], share: f64) -> [f64; 6] {
    let mut joints = *a;
    for (joint, to) in joints.iter_mut().zip(b) {
        *joint += share * (to - *joint);
    }
    joints
}

impl JointSpace<'_> {
    fn touch(&self, joints: &PendantJoints) -> Option<Touch> {
        let placed = self.shape.placed(self.arm, joints);
        let of_scene = (1..).zip(&placed).find_map(|(capsule, placed)| {
            let (obstacle, distance) = self.scene.touched(*placed, self.margin)?;
            Some(Touch {
                capsule,
                obstacle: Touched::Obstacle(obstacle),
                distance: Millimeters(distance),
                margin: Millimeters(self.margin),
            })
        });
        of_scene.or_else(|| {
            let own = self.shape.touches_itself(&placed, self.margin)?;
            Some(Touch {
                capsule: own.capsules.0,
                obstacle: Touched::Capsule(own.capsules.1),
                distance: Millimeters(own.distance),
                margin: Millimeters(own.margin),
            })
        })
    }

    fn shortened(&self, points: &[[f64; 6]]) -> Vec<PendantJoints> {
        let mut kept = Vec::new();
        let mut rest = points;
        while let Some((here, ahead)) = rest.split_first() {
            kept.push(PendantJoints::from_radians(*here));
            let farthest = (1..ahead.len())
                .rev()
                .find(|index| ahead.get(*index).is_some_and(|to| self.is_free(here, to)));
            rest = ahead.get(farthest.unwrap_or(0)..).unwrap_or_default();
        }
        kept
    }
}

impl Space<6> for JointSpace<'_> {
    const LAZY: bool = true;

    fn sample(&self, random: &mut Pcg64Mcg) -> [f64; 6] {
        Axis::ALL.map(|axis| {
            let limits = self.arm.limits(axis);
            let range = Uniform::new(limits.min.0, limits.max.0);
            range
                .map_or(limits.min.0, |range| range.sample(random))
                .to_radians()
        })
    }

    fn distance(&self, a: &[f64; 6], b: &[f64; 6]) -> f64 {
        distance(a, b)
    }

    fn is_valid(&self, joints: &[f64; 6]) -> bool {
        self.touch(&PendantJoints::from_radians(*joints)).is_none()
    }

    /// Ends are known to be valid. The middle first, then the quarters and so on: what is in the
    /// way is found soon.
    fn is_free(&self, a: &[f64; 6], b: &[f64; 6]) -> bool {
        let joints = PendantJoints::from_radians;
        let way = self.shape.way(self.arm, &joints(*a), &joints(*b));
        let margin = ArmShape::own_margin(self.margin);
        let mut parts = 1_u32;
        // Half a part each side of a joint set that keeps the margin.
        while way > 2.0 * margin * f64::from(parts) && parts < 1 << 20 {
            parts *= 2;
            let odd = (1..parts).step_by(2);
            let mut shares = odd.map(|part| f64::from(part) / f64::from(parts));
            if shares.any(|share| !self.is_valid(&on_the_way(a, b, share))) {
                return false;
            }
        }
        true
    }
}
