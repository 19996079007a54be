//! The closed form of the five-link arm: equations (1) to (4) of the paper.

use nalgebra::{Matrix3, Vector3};
use units::Degrees;

/// A joint at its limit is inside.
const AT_LIMIT_DEG: f64 = 1e-9;
/// Lengths below this part of the arm's are none.
const NOTHING: f64 = 1e-9;
/// How far E and F may be from l5 apart, as a part of l5.
const LENGTH_OFF: f64 = 1e-6;

/// The joints A to E, in degrees.
pub type FiveJoints = [Degrees; 5];

/// The ranges of A to E that the paper gives, in degrees.
pub const FIVE_LINK_RANGES: [(f64, f64); 5] = [
    (-60.0, 60.0),
    (-45.0, 135.0),
    (-135.0, 0.0),
    (-95.0, 95.0),
    (-95.0, 95.0),
];

/// The arm of the paper's figure 1: A turns about X, B, C and E about -Y, D about Z; links AB, BC,
/// CD, DE, EF hang along -Z at zero.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FiveLinkArm {
    l: [f64; 5],
}

/// Why the lengths, or the points, have no joint set.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
pub enum FiveLinkError {
    /// A length that no link has. l3 and l4 may be 0 singly: only their sum counts.
    #[error("l{number} is {value} mm; it must be above 0 and not above 100000")]
    Length {
        /// 1 to 5.
        number: usize,
        /// What was given.
        value: f64,
    },
    /// A coordinate or an angle that is not a number.
    #[error("{name} has the value {value}; it must be a number")]
    NotANumber {
        /// `E`, `F` or a joint.
        name: &'static str,
        /// What was given.
        value: f64,
    },
    /// E and F are not one link apart.
    #[error("E and F are {apart:.6} mm apart; the link EF is {l5:.6} mm long")]
    LinkLength {
        /// Their distance.
        apart: f64,
        /// The link's length.
        l5: f64,
    },
    /// E lies on the X axis, about which A turns: every A would do.
    #[error("E lies on the axis of A, which is not determined")]
    OnAxisA,
    /// (3), first line: A would be beyond its range.
    #[error("A would be {0:.3}; its range is -60 to 60 deg")]
    BeyondA(Degrees),
    /// (3), third line: c3* above 1: E is farther from B than the stretched arm.
    #[error("E is too far from B: cos C would be {0:.6}")]
    TooFar(f64),
    /// (3), third line: c3* below -1: nearer to B than the folded arm.
    #[error("E is too near to B: cos C would be {0:.6}")]
    TooNear(f64),
    /// (3), third line: c3* below cos 135: C would be beyond its range.
    #[error("C would be {0:.3}; its range is -135 to 0 deg")]
    BeyondC(Degrees),
    /// (3), last line: B would be beyond its range.
    #[error("B would be {0:.3}; its range is -45 to 135 deg")]
    BeyondB(Degrees),
    /// (4), last line: E would be beyond its range.
    #[error("E would be {0:.3}; its range is -95 to 95 deg")]
    BeyondE(Degrees),
}

/// The joint sets of E and F: at most two, the second with D half a turn away.
#[derive(Clone, Debug, PartialEq)]
pub enum FiveLinkSolutions {
    /// As a rule one.
    One(FiveJoints),
    /// (4), second line: within 10 degrees of sideways D may be on either side.
    Two([FiveJoints; 2]),
    /// EF is in line with DE: every D would do, and this one has D at 0.
    AnyD(FiveJoints),
}

impl FiveLinkArm {
    /// The arm with the links `l` in millimeters, AB to EF.
    ///
    /// # Errors
    /// A length that is not a positive number.
    pub fn try_new(l: [f64; 5]) -> Result<Self, FiveLinkError> {
        for (number, value) in (1..).zip(l) {
            if value.is_nan() || value <= 0.0 || value > 100_000.0 {
                return Err(FiveLinkError::Length { number, value });
            }
        }
        Ok(Self { l })
    }

    /// The points A to F in the fixed frame, in millimeters, (1) and (2). Ranges are not checked.
    ///
    /// # Errors
    /// A joint is not a number.
    pub fn points(&self, joints: &FiveJoints) -> Result<[Vector3<f64>; 6], FiveLinkError> {
        for (name, Degrees(value)) in ["A", "B", "C", "D", "E"].into_iter().zip(*joints) {
            if !value.is_finite() {
                return Err(FiveLinkError::NotANumber { name, value });
            }
        }
        let [l1, l2, l3, l4, l5] = self.l;
        let [(s1, c1), (s2, c2), _, (s4, c4), (s5, c5)] =
            joints.map(|joint| joint.0.to_radians().sin_cos());
        let [_, b, c, ..] = *joints;
        let (b2, b1) = (b.0 + c.0).to_radians().sin_cos();
        let p_B = Vector3::new(0.0, l1 * s1, -l1 * c1);
        let p_C = p_B + Vector3::new(s2, s1 * c2, -c1 * c2) * l2;
        let along = Vector3::new(b2, s1 * b1, -c1 * b1);
        let p_D = p_C + along * l3;
        let p_E = p_D + along * l4;
        let last = Vector3::new(
            c4 * s5 * b1 + c5 * b2,
            -(s5 * (s1 * c4 * b2 - c1 * s4) - s1 * c5 * b1),
            s5 * (c1 * c4 * b2 + s1 * s4) - c1 * c5 * b1,
        );
        Ok([Vector3::zeros(), p_B, p_C, p_D, p_E, p_E + last * l5])
    }

    /// The joints that put E and F at these points (millimeters, fixed frame), (3) and (4).
    ///
    /// # Errors
    /// Which line of (3) or (4) has no solution, and with what value.
    pub fn inverse(
        &self,
        p_E: &Vector3<f64>,
        p_F: &Vector3<f64>,
    ) -> Result<FiveLinkSolutions, FiveLinkError> {
        for (name, point) in [("E", p_E), ("F", p_F)] {
            if let Some(&value) = point.iter().find(|value| !value.is_finite()) {
                return Err(FiveLinkError::NotANumber { name, value });
            }
        }
        let [l1, l2, l3, l4, l5] = self.l;
        let span: f64 = self.l.iter().sum();
        let apart = (p_F - p_E).norm();
        if (apart - l5).abs() > LENGTH_OFF * l5 {
            return Err(FiveLinkError::LinkLength { apart, l5 });
        }
        if p_E.y.hypot(p_E.z) < NOTHING * span {
            return Err(FiveLinkError::OnAxisA);
        }
        // The first line of (3): A and A + 180 have the same tangent, and the range takes one.
        let alpha_a = if p_E.z == 0.0 {
            90_f64.copysign(p_E.y)
        } else {
            (-p_E.y / p_E.z).atan().to_degrees()
        };
        let a = inside(0, alpha_a).map_err(FiveLinkError::BeyondA)?;
        let (s1, c1) = a.0.to_radians().sin_cos();
        let l34 = l3 + l4;
        let drop = p_E.y * s1 - p_E.z * c1;
        let c3 = (p_E.norm_squared() + l1 * l1 - 2.0 * l1 * drop - l2 * l2 - l34 * l34)
            / (2.0 * l2 * l34);
        if c3 > 1.0 + NOTHING {
            return Err(FiveLinkError::TooFar(c3));
        }
        if c3 < -1.0 - NOTHING {
            return Err(FiveLinkError::TooNear(c3));
        }
        let c3 = c3.clamp(-1.0, 1.0);
        let s3 = -((1.0 - c3) * (1.0 + c3)).sqrt();
        let c = inside(2, s3.atan2(c3).to_degrees()).map_err(FiveLinkError::BeyondC)?;
        let alpha_b = (l34 * c3 + l2).atan2(l34 * s3) - (drop - l1).atan2(p_E.x);
        let b = inside(1, half_turn(alpha_b.to_degrees())).map_err(FiveLinkError::BeyondB)?;
        // F from C, in the frame of DE without D: turned by A and by B + C.
        let (b2, b1) = (b.0 + c.0).to_radians().sin_cos();
        let about_x = Matrix3::new(1.0, 0.0, 0.0, 0.0, c1, -s1, 0.0, s1, c1);
        let about_y = Matrix3::new(b1, 0.0, -b2, 0.0, 1.0, 0.0, b2, 0.0, b1);
        let along = about_x * about_y;
        let from_E = along.transpose() * (p_F - p_E) / apart;
        let (x, y, z) = (from_E.x, from_E.y, from_E.z);
        let set = |d: Degrees| -> Result<FiveJoints, FiveLinkError> {
            let (s4, c4) = d.0.to_radians().sin_cos();
            let (s5, c5) = (x * c4 + y * s4, -z);
            let e = inside(4, s5.atan2(c5).to_degrees()).map_err(FiveLinkError::BeyondE)?;
            Ok([a, b, c, d, e])
        };
        if x.hypot(y) < NOTHING {
            return set(Degrees(0.0)).map(FiveLinkSolutions::AnyD);
        }
        let d = if x == 0.0 {
            90_f64.copysign(y)
        } else {
            (y / x).atan().to_degrees()
        };
        let first = set(Degrees(d))?;
        // The second line of (4): beyond 85 degrees the other side is inside the range too.
        let other = d - 180_f64.copysign(d);
        if let Ok(other) = inside(3, other) {
            return Ok(FiveLinkSolutions::Two([first, set(other)?]));
        }
        Ok(FiveLinkSolutions::One(first))
    }
}

/// In (-180, 180].
fn half_turn(degrees: f64) -> f64 {
    degrees - 360.0 * ((degrees - 180.0) / 360.0).ceil()
}

/// The angle if it is inside the joint's range.
fn inside(joint: usize, degrees: f64) -> Result<Degrees, Degrees> {
    let (min, max) = FIVE_LINK_RANGES.get(joint).copied().unwrap_or((0.0, 0.0));
    if degrees >= min - AT_LIMIT_DEG && degrees <= max + AT_LIMIT_DEG {
        Ok(Degrees(degrees))
    } else {
        Err(Degrees(degrees))
    }
}
