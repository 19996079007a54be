//! A collision-free way from one joint set to another.

use std::fmt;

use kinematics::CapsuleError;
use kinematics::serial::{JointKind, JointValues, OutsideRange, SerialArm, SerialError};
use rand_distr::{Distribution, Uniform};
use rand_pcg::Pcg64Mcg;
use units::Millimeters;

use super::scene::Scene;
use super::shape::ArmShape;
use crate::sampling::{Sampling, Space, search};
use crate::wanted::{BrokenOff, Wanted};

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
    #[error("capsule {capsule} is on link {link}; links are 0 to {last}")]
    Link {
        /// Which capsule.
        capsule: usize,
        /// What was given.
        link: usize,
        /// The last one.
        last: usize,
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
    /// Joints of another arm.
    #[error("{end}: {source}")]
    Joints {
        /// `start` or `goal`.
        end: &'static str,
        /// How many.
        source: SerialError,
    },
    /// Start or goal beyond the joint ranges.
    #[error("{end}: {outside}")]
    Limits {
        /// `start` or `goal`.
        end: &'static str,
        /// The first joint that is.
        outside: OutsideRange,
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
    /// Nobody waited for the way any more.
    #[error(transparent)]
    BrokenOff(#[from] BrokenOff),
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
            CapsuleError::Link {
                capsule,
                link,
                last,
            } => ArmError::Link {
                capsule,
                link,
                last,
            },
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
    points: Vec<JointValues>,
    turned: f64,
    slid: f64,
}

impl ArmPath {
    fn new(arm: &SerialArm, points: Vec<JointValues>) -> ArmPath {
        let length = |kind: JointKind| -> f64 {
            let pairs = points.iter().zip(points.iter().skip(1));
            pairs
                .map(|(a, b)| {
                    let steps = a.as_slice().iter().zip(b.as_slice());
                    let of_kind = arm.joint_list().iter().zip(steps);
                    let of_kind = of_kind.filter(|(joint, _)| joint.kind == kind);
                    let squares = of_kind.map(|(_, (a, b))| (b - a) * (b - a));
                    squares.sum::<f64>().sqrt()
                })
                .sum()
        };
        ArmPath {
            turned: length(JointKind::Revolute).to_degrees(),
            slid: length(JointKind::Prismatic),
            points,
        }
    }

    /// The joint sets, start first.
    #[must_use]
    pub fn points(&self) -> &[JointValues] {
        &self.points
    }

    /// The sum of the ways in the space of the joints that turn, degrees.
    #[must_use]
    pub fn length_deg(&self) -> f64 {
        self.turned
    }

    /// The same of the joints that slide, millimeters.
    #[must_use]
    pub fn length_mm(&self) -> f64 {
        self.slid
    }
}

/// An arm and what it must not touch.
#[derive(Clone, Copy, Debug)]
pub struct Workplace<'a> {
    /// The arm.
    pub arm: &'a SerialArm,
    /// Its body.
    pub shape: &'a ArmShape,
    /// What stands around it, in its world.
    pub scene: &'a Scene,
    /// How far from that it stays wherever it is looked at, 1 to 1000 mm.
    pub margin: Millimeters,
}

impl Workplace<'_> {
    /// A way for the arm from `start` to `goal` by a probabilistic roadmap, its detours left out, as long as it is `wanted`.
    ///
    /// Everywhere on the way the joints are inside their ranges and the capsules touch nothing; at the
    /// joint sets it was looked at they are at least `margin` away. Connections are only looked at when
    /// a shortest path wants them (a lazy roadmap).
    ///
    /// The arm keeps 20 mm (or `margin`, if that is less) from itself: capsules on neighboring links
    /// are left out of that, and capsules that touch at home.
    ///
    /// # Errors
    /// Start or goal out of range or too near to an obstacle, a margin out of range, or no way found.
    pub fn transfer(
        &self,
        start: &JointValues,
        goal: &JointValues,
        sampling: &Sampling,
        wanted: Wanted<'_>,
    ) -> Result<ArmPath, ArmError> {
        let Workplace {
            arm,
            shape,
            scene,
            margin,
        } = *self;
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
            let outside = arm
                .check_ranges(joints)
                .map_err(|source| ArmError::Joints { end, source })?;
            if let Some(outside) = outside.into_iter().next() {
                return Err(ArmError::Limits { end, outside });
            }
            if let Some(touch) = space.touch(joints) {
                return Err(ArmError::Touches { end, touch });
            }
        }
        let found = search(&space, start.clone(), goal.clone(), sampling, wanted)?;
        let found = found.ok_or(ArmError::GaveUp {
            samples: sampling.most,
        })?;
        Ok(ArmPath::new(arm, space.shortened(&found.way, wanted)?))
    }
}

struct JointSpace<'a> {
    arm: &'a SerialArm,
    shape: &'a ArmShape,
    scene: &'a Scene,
    margin: f64,
}

impl JointSpace<'_> {
    fn touch(&self, joints: &JointValues) -> Option<Touch> {
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

    fn shortened(
        &self,
        points: &[JointValues],
        wanted: Wanted<'_>,
    ) -> Result<Vec<JointValues>, BrokenOff> {
        let mut kept = Vec::new();
        let mut rest = points;
        while let Some((here, ahead)) = rest.split_first() {
            kept.push(here.clone());
            let mut next = 0;
            for (index, to) in ahead.iter().enumerate().skip(1).rev() {
                wanted.check()?;
                if self.is_free(here, to) {
                    next = index;
                    break;
                }
            }
            rest = ahead.get(next..).unwrap_or_default();
        }
        Ok(kept)
    }
}

impl Space for JointSpace<'_> {
    type At = JointValues;

    const LAZY: bool = true;

    fn sample(&self, random: &mut Pcg64Mcg) -> JointValues {
        let mut part =
            || Uniform::new(0.0, 1.0).map_or(0.5, |unit: Uniform<f64>| unit.sample(random));
        self.arm.spread_over_ranges(|_| part())
    }

    /// Radians; the arm's whole span slid counts as one.
    fn distance(&self, a: &JointValues, b: &JointValues) -> f64 {
        let steps = a.as_slice().iter().zip(b.as_slice());
        let joints = self.arm.joint_list().iter().zip(steps);
        let squares = joints.map(|(joint, (a, b))| {
            let step = match joint.kind {
                JointKind::Revolute => b - a,
                JointKind::Prismatic => (b - a) / self.arm.span(),
            };
            step * step
        });
        squares.sum::<f64>().sqrt()
    }

    fn is_valid(&self, joints: &JointValues) -> bool {
        self.touch(joints).is_none()
    }

    /// Ends are known to be valid. The middle first, then the quarters and so on: what is in the
    /// way is found soon.
    fn is_free(&self, a: &JointValues, b: &JointValues) -> bool {
        let way = self.shape.way(self.arm, a, b);
        let margin = ArmShape::own_margin(self.margin);
        let mut parts = 1_u32;
        // Half a part each side of a joint set that keeps the margin.
        while way > 2.0 * margin * f64::from(parts) && parts < 1 << 20 {
            parts *= 2;
            let odd = (1..parts).step_by(2);
            let mut shares = odd.map(|part| f64::from(part) / f64::from(parts));
            if shares.any(|share| !self.is_valid(&a.toward(b, share))) {
                return false;
            }
        }
        true
    }
}
