//! The textbook's geometric inverse kinematics of its arm of table 1.1: (1.34) to (1.57).

use nalgebra::Matrix3;
use units::{Degrees, Millimeters, Radians};

use crate::configuration::{Elbow, Flip, Front};
use crate::pose::Pose;
use crate::singularity::SingularityKind;
use crate::zyz::{ZyzAngles, ZyzBranch};

/// A cosine this far beyond 1 is rounding.
const ROUNDING: f64 = 1e-12;
/// The wrist center is nearer to axis 1 than this part of the reach: theta 1 is not determined.
const ON_AXIS: f64 = 1e-9;

/// The arm of table 1.1.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TextbookArm {
    d1: f64,
    a2: f64,
    d4: f64,
    d6: f64,
}

/// Which of the eight solutions.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct TextbookBranch {
    /// Toward: (1.36). Back: (1.37).
    pub front: Front,
    /// The sign of the sine in (1.46): `Down` is positive, `Up` negative.
    pub elbow: Elbow,
    /// The sign of the root in (1.55): `NoFlip` is positive.
    pub flip: Flip,
}

/// theta 1 to theta 6.
#[derive(Clone, Debug, PartialEq)]
pub struct TextbookSolution {
    /// The angles, in (-180, 180].
    pub joints: [Degrees; 6],
    /// Where a family of angles reaches the pose: at the shoulder theta 1, at the wrist theta 6
    /// was taken as 0 (remark 1.1).
    pub singular: Vec<SingularityKind>,
}

/// Why there is none.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
pub enum TextbookError {
    /// A length that no arm has.
    #[error("{name} is {value}; it must be {wanted}")]
    Length {
        /// `d1`, `a2`, `d4` or `d6`.
        name: &'static str,
        /// What was given.
        value: Millimeters,
        /// What it must be.
        wanted: &'static str,
    },
    /// (1.44) gives a cosine beyond 1: the wrist center is too far.
    #[error("the wrist center is {0:.3} farther than the stretched arm")]
    TooFar(Millimeters),
    /// (1.44) gives a cosine below -1: the wrist center is too near.
    #[error("the wrist center is {0:.3} nearer than the folded arm")]
    TooNear(Millimeters),
}

impl TextbookArm {
    /// The arm with these lengths.
    ///
    /// # Errors
    /// a2 or d4 is not above 0, or one of the four is not a number up to 100 m.
    pub fn try_new(
        d1: Millimeters,
        a2: Millimeters,
        d4: Millimeters,
        d6: Millimeters,
    ) -> Result<Self, TextbookError> {
        for (name, value) in [("d1", d1), ("d6", d6)] {
            if !value.is_finite() || value.0.abs() > 100_000.0 {
                let wanted = "a number from -100000 to 100000 mm";
                return Err(TextbookError::Length {
                    name,
                    value,
                    wanted,
                });
            }
        }
        for (name, value) in [("a2", a2), ("d4", d4)] {
            if value.0.is_nan() || value.0 <= 0.0 || value.0 > 100_000.0 {
                let wanted = "above 0 and not above 100000 mm";
                return Err(TextbookError::Length {
                    name,
                    value,
                    wanted,
                });
            }
        }
        Ok(Self {
            d1: d1.0,
            a2: a2.0,
            d4: d4.0,
            d6: d6.0,
        })
    }

    /// The angles of one branch that put the flange at `X_WF`.
    ///
    /// (1.35) to (1.53), and (1.54) with its angles named rightly: q4 = phi, q5 = theta, q6 = psi.
    ///
    /// # Errors
    /// How far the wrist center is out of reach.
    pub fn inverse(
        &self,
        X_WF: &Pose,
        branch: TextbookBranch,
    ) -> Result<TextbookSolution, TextbookError> {
        let Self { d1, a2, d4, d6 } = *self;
        let R = X_WF.rotation_matrix();
        let p = X_WF.isometry().translation.vector - d6 * R.column(2);
        let mut singular = Vec::new();
        let side = match branch.front {
            Front::Toward => 1.0,
            Front::Back => -1.0,
        };
        let across = p.x.hypot(p.y);
        let theta1 = if across < ON_AXIS * (a2 + d4) {
            singular.push(SingularityKind::Shoulder);
            0.0
        } else {
            (side * p.y).atan2(side * p.x)
        };
        // (1.39), (1.40); behind axis 1 the way to the wrist center is negative.
        let (b, c) = (p.z - d1, side * across);
        let (squares, product) = (a2 * a2 + d4 * d4, 2.0 * a2 * d4);
        let cosine = (b * b + c * c - squares) / product;
        let distance = b.hypot(c);
        if cosine > 1.0 + ROUNDING {
            return Err(TextbookError::TooFar(Millimeters(distance - a2 - d4)));
        }
        if cosine < -1.0 - ROUNDING {
            return Err(TextbookError::TooNear(Millimeters(
                (a2 - d4).abs() - distance,
            )));
        }
        // (1.46) by Heron, exact near the stretched and the folded arm.
        let square = (a2 + d4 - distance)
            * (a2 + d4 + distance)
            * (distance - (a2 - d4).abs())
            * (distance + (a2 - d4).abs());
        let magnitude = square.max(0.0).sqrt() / product;
        if magnitude < 1e-7 {
            singular.push(SingularityKind::Elbow);
        }
        let sine = match branch.elbow {
            Elbow::Down => magnitude,
            Elbow::Up => -magnitude,
        };
        let theta3 = sine.atan2(cosine);
        let theta2 = b.atan2(c) - (d4 * sine).atan2(a2 + d4 * cosine);
        // R03 of (1.16) to (1.18): theta 3 is counted from a right angle.
        let (s1, c1) = theta1.sin_cos();
        let (s, c) = (theta2 + theta3 + std::f64::consts::FRAC_PI_2).sin_cos();
        let R03 = Matrix3::new(c1 * c, s1, c1 * s, s1 * c, -c1, s1 * s, s, 0.0, -c);
        let wrist = crate::serial::forward::pose_of(&(R03.transpose() * R), nalgebra::zero());
        let angles = wrist.zyz(match branch.flip {
            Flip::NoFlip => ZyzBranch::Positive,
            Flip::Flip => ZyzBranch::Negative,
        });
        if !matches!(angles, ZyzAngles::Regular(_)) {
            singular.push(SingularityKind::Wrist);
        }
        let zyz = angles.angles();
        let joints = [
            Radians(theta1),
            Radians(theta2),
            Radians(theta3),
            zyz.phi,
            zyz.theta,
            zyz.psi,
        ];
        let shown = |angle: Radians| {
            let degrees = angle.0.to_degrees();
            Degrees(degrees - 360.0 * ((degrees - 180.0) / 360.0).ceil())
        };
        Ok(TextbookSolution {
            joints: joints.map(shown),
            singular,
        })
    }
}
