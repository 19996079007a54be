//! Inverse kinematics of any arm of six revolute joints with a spherical wrist: thesis section
//! 2.2.2, any twists and offsets.
//!
//! The first three joints carry the wrist center: q3 out of the quartic (15) in tan(q3 / 2), or out
//! of the equation of degree two that is left where a1 or sin(alpha1) is 0. The last three turn the
//! flange, (17) and (18). Every solution is put through the forward kinematics before it is
//! returned.
#![expect(
    clippy::indexing_slicing,
    reason = "vectors and matrices of nalgebra, indexed within the shape they were made with"
)]

use std::f64::consts::{PI, TAU};

use nalgebra::{DVector, Matrix3, Vector3};

use crate::pose::Pose;
use crate::serial::arm::{JointKind, SerialArm};
use crate::serial::error::{OutsideRange, SerialError};
use crate::serial::polynomial::{Root, real_roots};
use crate::serial::values::JointValues;
use crate::singularity::SingularityKind;

/// Sines and lengths (parts of the arm's span) below this are zero.
const NOTHING: f64 = 1e-9;
/// A flange this far off, as part of the span, and in radians, is no solution.
const OFF: f64 = 1e-9;
/// Below this sine of the angle between axes 4 and 6 they are in one line.
const IN_LINE: f64 = 1e-9;
/// Two solutions closer than this, in radians, are one.
const SAME: f64 = 1e-6;

/// One joint set that reaches a pose.
#[derive(Clone, Debug, PartialEq)]
pub struct WristSolution {
    /// The joints, revolute ones on the turn nearest to the middle of their range.
    pub joints: JointValues,
    /// Joints beyond their range; none if the arm can stand so.
    pub outside: Vec<OutsideRange>,
    /// The singularities this posture is at: there a family of joint sets reaches the pose, and
    /// this is the one near the reference.
    pub singular: Vec<SingularityKind>,
}

/// Why there is none.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum WristError {
    /// The reference is not the arm's.
    #[error(transparent)]
    Joints(#[from] SerialError),
    /// This way of solving needs six revolute joints whose last three axes meet in a point.
    #[error("{arm} has no spherical wrist: {reason}")]
    NotCovered {
        /// The arm.
        arm: String,
        /// What is different.
        reason: String,
    },
    /// No posture of the first three joints brings the wrist center there.
    #[error(
        "out of reach: the wrist center at ({x:.3}, {y:.3}, {z:.3}) mm from the base has no posture"
    )]
    WristCenterOutOfReach {
        /// In the base's frame.
        x: f64,
        /// In the base's frame.
        y: f64,
        /// In the base's frame.
        z: f64,
    },
    /// The wrist center is reached, but the wrist cannot turn so far.
    #[error(
        "out of reach: the wrist center is reached in {postures} postures, but the wrist, whose \
         twists are not right angles, cannot turn the flange so"
    )]
    RotationOutOfReach {
        /// How many.
        postures: usize,
    },
}

/// The numbers of a 6R arm with a spherical wrist, in the thesis's letters; lengths as parts of the
/// span.
struct Arm6 {
    a: [f64; 3],
    d: [f64; 4],
    sin: [f64; 5],
    cos: [f64; 5],
    /// Of the wrist center in the frame behind joint 6.
    center: Vector3<f64>,
    /// Undoes the twist of row 6.
    untwist: Matrix3<f64>,
}

/// Do the last three axes of the six meet in a point?
pub(crate) fn expect_spherical_wrist(arm: &SerialArm) -> Result<(), WristError> {
    let _ = Arm6::of(arm)?;
    Ok(())
}

/// A posture of the first three joints.
struct Posture3 {
    q: [f64; 3],
    singular: Vec<SingularityKind>,
}

impl SerialArm {
    /// Every joint set that puts the flange at `X_WF`, inside the ranges or not; up to eight. Where
    /// a singularity leaves joints free they stay near `reference`: at a singular wrist J4 and J6
    /// share their way.
    ///
    /// # Errors
    /// The arm is not of this kind, or what is out of reach.
    pub fn inverse_spherical(
        &self,
        X_WF: &Pose,
        reference: &JointValues,
    ) -> Result<Vec<WristSolution>, WristError> {
        self.check_count(reference.len())?;
        let arm = Arm6::of(self)?;
        let near = self.chain(reference);
        // The pose between the base and the frame behind joint 6.
        let X_0n = self.base.inverse() * X_WF.isometry() * self.flange.inverse();
        let R = X_0n.rotation.to_rotation_matrix().into_inner();
        let p = X_0n.translation.vector / self.span;
        let center = p + R * arm.center;
        let postures = arm.first_three(&center, &near);
        let reaching = postures.len();
        let mut solutions: Vec<WristSolution> = Vec::new();
        let mut any_center = false;
        for posture in postures {
            if !arm.reaches(&posture.q, &center) {
                continue;
            }
            any_center = true;
            let R36 = arm.rotation_03(&posture.q).transpose() * R * arm.untwist;
            for (wrist, in_line) in arm.wrist(&R36, &near) {
                let [q1, q2, q3] = posture.q;
                let [q4, q5, q6] = wrist;
                let q = DVector::from_column_slice(&[q1, q2, q3, q4, q5, q6]);
                let mut singular = posture.singular.clone();
                if in_line {
                    singular.push(SingularityKind::Wrist);
                }
                let solution = self.shown_solution(&q, singular);
                if self.is_at(&solution.joints, X_WF) && !is_among(&solutions, &solution) {
                    solutions.push(solution);
                }
            }
        }
        if !solutions.is_empty() {
            return Ok(solutions);
        }
        if any_center {
            return Err(WristError::RotationOutOfReach { postures: reaching });
        }
        let [x, y, z] = (center * self.span).into();
        Err(WristError::WristCenterOutOfReach { x, y, z })
    }

    /// Displayed joints of the chain's, on the turns nearest to the middles of their ranges.
    fn shown_solution(&self, q: &DVector<f64>, singular: Vec<SingularityKind>) -> WristSolution {
        let mut shown = DVector::zeros(q.len());
        for (i, joint) in self.joints.iter().enumerate() {
            // Couplings are with joints before.
            let coupled: f64 = joint
                .couplings
                .iter()
                .map(|(other, factor)| factor * shown[*other])
                .sum();
            let value = (q[i] - self.offsets[i] - coupled) * joint.sign;
            let middle = f64::midpoint(joint.min, joint.max);
            shown[i] = value - TAU * ((value - middle) / TAU).round();
        }
        let joints = JointValues(shown);
        WristSolution {
            outside: self.outside(&joints),
            joints,
            singular,
        }
    }

    fn is_at(&self, joints: &JointValues, X_WF: &Pose) -> bool {
        let (rotation, position) = self.flange_at(&self.chain(joints));
        let apart = (position - X_WF.isometry().translation.vector).norm();
        let turned = (rotation - X_WF.rotation_matrix()).amax();
        apart <= OFF * self.span && turned <= OFF
    }
}

fn is_among(solutions: &[WristSolution], candidate: &WristSolution) -> bool {
    solutions.iter().any(|solution| {
        let pairs = solution.joints.0.iter().zip(candidate.joints.0.iter());
        pairs
            .map(|(a, b)| (a - b - TAU * ((a - b) / TAU).round()).abs())
            .all(|apart| apart < SAME)
    })
}

impl Arm6 {
    fn of(arm: &SerialArm) -> Result<Self, WristError> {
        let refused = |reason: String| WristError::NotCovered {
            arm: arm.name.clone(),
            reason,
        };
        let [j1, j2, j3, j4, j5, j6] = arm.joints.as_slice() else {
            return Err(refused(format!("{} joints, not 6", arm.joints.len())));
        };
        if let Some(joint) = arm.joints.iter().find(|j| j.kind != JointKind::Revolute) {
            return Err(refused(format!("{} slides", joint.name)));
        }
        let span = arm.span;
        for (joint, key, value) in [(j4, "a_mm", j4.a), (j5, "a_mm", j5.a), (j5, "d_mm", j5.d)] {
            if value.abs() > NOTHING * span {
                return Err(refused(format!("{}: {key} is {value}, not 0", joint.name)));
            }
        }
        for joint in [j4, j5] {
            if joint.alpha.sin().abs() < NOTHING {
                let alpha = joint.alpha.to_degrees();
                return Err(refused(format!("{}: alpha_deg is {alpha}", joint.name)));
            }
        }
        if j1.a.abs() < NOTHING * span && j1.alpha.sin().abs() < NOTHING {
            return Err(refused("J1 and J2 turn about one line".to_owned()));
        }
        let rows = [j1, j2, j3, j4, j5];
        let twist = rows.map(|joint| exact(joint.alpha.sin_cos()));
        let (s6, c6) = exact(j6.alpha.sin_cos());
        let untwist = Matrix3::new(1.0, 0.0, 0.0, 0.0, c6, s6, 0.0, -s6, c6);
        Ok(Self {
            a: [j1.a, j2.a, j3.a].map(|a| a / span),
            d: [j1.d, j2.d, j3.d, j4.d].map(|d| d / span),
            sin: twist.map(|(sine, _)| sine),
            cos: twist.map(|(_, cosine)| cosine),
            center: untwist * Vector3::new(-j6.a, 0.0, -j6.d) / span,
            untwist,
        })
    }

    /// The wrist center in frame 1 but for q2, as a function of q3: `h = hc cos q3 + hs sin q3 +
    /// h1`.
    fn in_frame_1(&self) -> [Vector3<f64>; 3] {
        let ([_, a2, a3], [_, d2, d3, d4]) = (self.a, self.d);
        let ([_, s2, s3, ..], [_, c2, c3, ..]) = (self.sin, self.cos);
        // In frame 2 the center is Rz(q3) v.
        let v = Vector3::new(a3, -d4 * s3, d3 + d4 * c3);
        let twisted = |x: f64, y: f64| Vector3::new(x, c2 * y, s2 * y);
        [
            twisted(v.x, v.y),
            twisted(-v.y, v.x),
            Vector3::new(a2, -s2 * v.z, d2 + c2 * v.z),
        ]
    }

    fn first_three(&self, center: &Vector3<f64>, near: &DVector<f64>) -> Vec<Posture3> {
        let h = self.in_frame_1();
        let (q3s, double) = self.q3(center, &h);
        let mut postures = Vec::new();
        for (q3, is_double) in q3s.into_iter().zip(double) {
            let (sine, cosine) = q3.sin_cos();
            let [hc, hs, h1] = h;
            let h = hc * cosine + hs * sine + h1;
            let mut singular = Vec::new();
            if is_double {
                singular.push(SingularityKind::Elbow);
            }
            for (gx, gy) in self.in_plane(center, &h) {
                let mut singular = singular.clone();
                // (gx, gy) is (hx, hy) turned by q2.
                let q2 = if h.x.hypot(h.y) < NOTHING {
                    singular.push(SingularityKind::Elbow);
                    near[1]
                } else {
                    gy.atan2(gx) - h.y.atan2(h.x)
                };
                let [a1, _, _] = self.a;
                let ([s1, ..], [c1, ..]) = (self.sin, self.cos);
                let (kx, ky) = (a1 + gx, c1 * gy - s1 * h.z);
                let q1 = if kx.hypot(ky) < NOTHING {
                    singular.push(SingularityKind::Shoulder);
                    near[0]
                } else {
                    center.y.atan2(center.x) - ky.atan2(kx)
                };
                singular.dedup();
                postures.push(Posture3 {
                    q: [q1, q2, q3],
                    singular,
                });
            }
        }
        postures
    }

    /// Where the wrist center can be in frame 1: from the two equations that q1 does not change,
    /// its distance from the base and its height.
    fn in_plane(&self, p: &Vector3<f64>, h: &Vector3<f64>) -> Vec<(f64, f64)> {
        let ([a1, ..], [d1, ..]) = (self.a, self.d);
        let ([s1, ..], [c1, ..]) = (self.sin, self.cos);
        let z = p.z - d1;
        let across = h.x * h.x + h.y * h.y;
        let square = p.x * p.x + p.y * p.y + z * z;
        // sqrt of what is left; a little below 0 is the touching case.
        let root = |left: f64| (left > -1e-7 * across.max(NOTHING)).then(|| left.max(0.0).sqrt());
        if a1.abs() < NOTHING {
            let gy = (z - c1 * h.z) / s1;
            let gx = root(across - gy * gy);
            return gx.map_or(Vec::new(), |gx| both_signs(gx, |gx| (gx, gy)));
        }
        let gx = (square - a1 * a1 - h.norm_squared()) / (2.0 * a1);
        if s1.abs() < NOTHING {
            let gy = root(across - gx * gx);
            return gy.map_or(Vec::new(), |gy| both_signs(gy, |gy| (gx, gy)));
        }
        vec![(gx, (z - c1 * h.z) / s1)]
    }

    /// The candidates for q3, and which of them are double roots.
    fn q3(&self, p: &Vector3<f64>, [hc, hs, h1]: &[Vector3<f64>; 3]) -> (Vec<f64>, Vec<bool>) {
        let ([a1, ..], [d1, ..]) = (self.a, self.d);
        let ([s1, ..], [c1, ..]) = (self.sin, self.cos);
        let z = p.z - d1;
        // |h|^2 = C cos q3 + D sin q3 + ..: the squares of hc and hs add to a constant.
        let (C, D) = (2.0 * hc.dot(h1), 2.0 * hs.dot(h1));
        let constant = hc.norm_squared() + h1.norm_squared();
        let E = constant - a1 * a1 - p.x * p.x - p.y * p.y - z * z;
        let (H, I, J) = (hc.z, hs.z, h1.z - z * c1);
        if a1.abs() < NOTHING {
            return circle(C, D, E);
        }
        if s1.abs() < NOTHING {
            // The height alone: c1 (H cos + I sin + h1) = z.
            return circle(H, I, h1.z - z / c1);
        }
        // (15) is s1^2 (C c + D s + E)^2 + 4 a1^2 (H c + I s + J)^2 = 4 a1^2 s1^2 (x^2 + y^2) with
        // tan(q3 / 2). The half angle is counted from where its leading coefficient is largest, so
        // that q3 = 180 is no exception.
        let side = 4.0 * a1 * a1 * s1 * s1 * (p.x * p.x + p.y * p.y);
        let at = |q3: f64| {
            let (s, c) = q3.sin_cos();
            let (first, second) = (C * c + D * s + E, H * c + I * s + J);
            s1 * s1 * first * first + 4.0 * a1 * a1 * second * second - side
        };
        let from = (0..8).map(|k| f64::from(k) * PI / 4.0 + 0.1).fold(
            (0.0, -1.0),
            |best: (f64, f64), q3| {
                let size = at(q3 + PI).abs();
                if size > best.1 { (q3, size) } else { best }
            },
        );
        let shift = from.0;
        let (s, c) = shift.sin_cos();
        let (C, D) = (C * c + D * s, D * c - C * s);
        let (H, I) = (H * c + I * s, I * c - H * s);
        let (a, b) = (4.0 * a1 * a1, s1 * s1);
        let R = a * (J - H) * (J - H) + b * (E - C) * (E - C) - side;
        let S = 4.0 * (a * I * (J - H) + b * D * (E - C));
        let T =
            2.0 * (a * (J * J - H * H + 2.0 * I * I) + b * (E * E - C * C + 2.0 * D * D) - side);
        let U = 4.0 * (a * I * (J + H) + b * D * (E + C));
        let V = a * (J + H) * (J + H) + b * (E + C) * (E + C) - side;
        let roots = real_roots(&[V, U, T, S, R]);
        let q3: Vec<f64> = roots
            .iter()
            .map(|root| shift + 2.0 * root.at.atan())
            .collect();
        // Rounding may take a double root apart.
        let is_double = |(index, root): (usize, &Root)| {
            let twin = |other: Option<&f64>| {
                let here = q3.get(index);
                here.zip(other).is_some_and(|(a, b)| (a - b).abs() < SAME)
            };
            let before = index.checked_sub(1).and_then(|index| q3.get(index));
            root.double || twin(before) || twin(q3.get(index + 1))
        };
        let double = roots.iter().enumerate().map(is_double).collect();
        (q3, double)
    }

    fn reaches(&self, q: &[f64; 3], center: &Vector3<f64>) -> bool {
        let ([a1, a2, a3], [d1, d2, d3, d4]) = (self.a, self.d);
        let rows = [(a1, d1), (a2, d2), (a3, d3)];
        let mut position = Vector3::zeros();
        let mut rotation = Matrix3::identity();
        for (((q, (a, d)), s), c) in q.iter().zip(rows).zip(self.sin).zip(self.cos) {
            let (sq, cq) = q.sin_cos();
            position += rotation * Vector3::new(a * cq, a * sq, d);
            rotation *= link_rotation((sq, cq), (s, c));
        }
        position += rotation.column(2) * d4;
        (position - center).norm() <= OFF
    }

    fn rotation_03(&self, q: &[f64; 3]) -> Matrix3<f64> {
        let twists = self.sin.into_iter().zip(self.cos);
        q.iter()
            .zip(twists)
            .fold(Matrix3::identity(), |rotation, (q, twist)| {
                rotation * link_rotation(q.sin_cos(), twist)
            })
    }

    /// q4, q5, q6 of the rotation that is left, and whether axes 4 and 6 are in one line.
    fn wrist(&self, r: &Matrix3<f64>, near: &DVector<f64>) -> Vec<([f64; 3], bool)> {
        let ([.., s4, s5], [.., c4, c5]) = (self.sin, self.cos);
        let (xi, eta, zeta) = (r[(0, 2)], r[(1, 2)], r[(2, 2)]);
        let rest = |q4: f64, q5: f64| {
            let first = link_rotation(q4.sin_cos(), (s4, c4));
            let left = (first * link_rotation(q5.sin_cos(), (s5, c5))).transpose() * r;
            left[(1, 0)].atan2(left[(0, 0)])
        };
        // The third component of (18) gives cos q5.
        let cosine = (c4 * c5 - zeta) / (s4 * s5);
        if xi.hypot(eta) < IN_LINE {
            // J4 and J6 turn the flange alike: each makes half of the way from the reference.
            let q5 = if cosine > 0.0 { 0.0 } else { PI };
            let along = zeta.signum();
            let way = rest(near[3], q5) - near[5];
            let half = 0.5 * (way - TAU * (way / TAU).round());
            let q4 = near[3] + along * half;
            return vec![([q4, q5, rest(q4, q5)], true)];
        }
        // The component across: what (xi, eta) has besides it is sin q5.
        let mut wrists = Vec::new();
        let clamped = cosine.clamp(-1.0, 1.0);
        if (cosine - clamped).abs() > 1e-9 {
            return wrists;
        }
        let y = -c4 * s5 * clamped - s4 * c5;
        // With right angles y is 0 and the sine is exact; else from both equations.
        let square = (xi * xi + eta * eta - y * y) / (s5 * s5);
        let sine = square.max(0.0).sqrt();
        for sine in [sine, -sine] {
            let q5 = sine.atan2(clamped);
            let q4 = eta.atan2(xi) - y.atan2(s5 * sine);
            wrists.push(([q4, q5, rest(q4, q5)], false));
        }
        wrists
    }
}

/// `Rz(q) Rx(alpha)`.
fn link_rotation((sq, cq): (f64, f64), (s, c): (f64, f64)) -> Matrix3<f64> {
    Matrix3::new(cq, -c * sq, s * sq, sq, c * cq, -s * cq, 0.0, s, c)
}

fn exact((s, c): (f64, f64)) -> (f64, f64) {
    let round = |v: f64| if v.abs() < 1e-15 { 0.0 } else { v };
    (round(s), round(c))
}

/// `C cos q + D sin q + E = 0`, and which roots are double. Nothing if every q solves it: then q3
/// does not move the wrist center, and the table is degenerate.
fn circle(C: f64, D: f64, E: f64) -> (Vec<f64>, Vec<bool>) {
    let radius = C.hypot(D);
    if radius < NOTHING * NOTHING {
        return (Vec::new(), Vec::new());
    }
    let (ratio, middle) = (-E / radius, D.atan2(C));
    if ratio.abs() > 1.0 + 1e-12 {
        return (Vec::new(), Vec::new());
    }
    // Near the ends the arc cosine loses half the digits; the square root of the product does not.
    let half = ((1.0 - ratio) * (1.0 + ratio)).max(0.0).sqrt().atan2(ratio);
    if half < 1e-7 || PI - half < 1e-7 {
        let at = if half < 1.0 { middle } else { middle + PI };
        return (vec![at], vec![true]);
    }
    (vec![middle + half, middle - half], vec![false, false])
}

fn both_signs(value: f64, f: impl Fn(f64) -> (f64, f64)) -> Vec<(f64, f64)> {
    if value < NOTHING {
        vec![f(0.0)]
    } else {
        vec![f(value), f(-value)]
    }
}
