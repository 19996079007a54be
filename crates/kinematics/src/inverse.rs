//! Closed-form inverse kinematics: every branch of an ortho-parallel arm with a spherical wrist.

use std::f64::consts::TAU;

use nalgebra::{Matrix3, Vector3};
use units::Millimeters;

use crate::branches::{Branches, Solution};
use crate::configuration::turns_of;
use crate::forward::{Posture, Turned, arm_rotation, flange_of};
use crate::geometry::Geometry;
use crate::ik_error::{IkError, ReachBound};
use crate::joints::{Axis, ChainJoints, PendantJoints};
use crate::model::ArmModel;
use crate::pose::Pose;

/// A wrist center this far out of reach, in millimeters, is pulled onto the stretched arm: half of what a solution may
/// be off.
const REACH_ROUNDING: f64 = 5e-7;
/// How far the pose of a returned solution may be from the wanted one: 1 nm, and 1e-9 in the rotation matrix.
const MAX_POSITION_ERROR: f64 = 1e-6;
const MAX_ROTATION_ERROR: f64 = 1e-9;

/// Every branch that reaches `X_WF`. Joints that a singularity leaves free stay near `reference`.
pub(crate) fn branches(
    model: &ArmModel,
    X_WF: &Pose,
    reference: &PendantJoints,
) -> Result<Branches, IkError> {
    let g = &model.geometry;
    let R_WF = X_WF.rotation_matrix();
    let p_WF = X_WF.isometry().translation.vector;
    let p_WC = p_WF - g.d6 * R_WF.column(2);
    let near = model.chain(reference).radians();

    let mut branches = Branches::new();
    let mut miss: Option<Miss> = None;
    for base in bases(g, &p_WC, near)? {
        let Some(base) = base else { continue };
        match elbows(g, &base, p_WC.z, near) {
            Ok(elbows) => {
                for elbow in elbows.into_iter().flatten() {
                    push_wrists(model, &mut branches, &p_WF, &R_WF, &base, &elbow, near);
                }
            }
            Err(this) => miss = Some(miss.map_or(this, |other| other.smaller(this))),
        }
    }
    match miss {
        Some(Miss { excess, bound }) if branches.is_empty() => Err(IkError::OutOfReach {
            excess: Millimeters(excess),
            bound,
        }),
        _ => Ok(branches),
    }
}

/// By how much a wrist center is out of reach.
#[derive(Clone, Copy)]
struct Miss {
    excess: f64,
    bound: ReachBound,
}

impl Miss {
    fn smaller(self, other: Miss) -> Miss {
        if other.excess < self.excess {
            other
        } else {
            self
        }
    }
}

/// q1, with the signed distance of the wrist center in front of axis 1.
struct Base {
    q1: (f64, f64),
    front: f64,
}

/// Front and back.
fn bases(g: &Geometry, p_WC: &Vector3<f64>, near: [f64; 6]) -> Result<[Option<Base>; 2], IkError> {
    let lateral = -g.s1 * g.lateral;
    let across = p_WC.x.hypot(p_WC.y);
    let short = lateral.abs() - across;
    if short > REACH_ROUNDING {
        let excess = Millimeters(short);
        return Err(IkError::OutOfReach {
            excess,
            bound: ReachBound::TooNearToAxis1,
        });
    }
    // Not the difference of squares, which loses half the digits.
    let front = ((across - lateral.abs()) * (across + lateral.abs()))
        .max(0.0)
        .sqrt();
    if across < Posture::SINGULAR_DISTANCE {
        // Every q1 will do.
        return Ok([
            Some(Base {
                q1: near[0].sin_cos(),
                front: 0.0,
            }),
            None,
        ]);
    }
    let side = |front: f64| {
        let norm = front.hypot(lateral);
        let sine = (p_WC.y * front - p_WC.x * lateral) / (across * norm);
        let cosine = (p_WC.x * front + p_WC.y * lateral) / (across * norm);
        Some(Base {
            q1: (sine, cosine),
            front,
        })
    };
    if front < Posture::SINGULAR_DISTANCE {
        return Ok([side(front), None]);
    }
    Ok([side(front), side(-front)])
}

/// q2 and q2 + q3, with the sine between upper arm and forearm, positive with the elbow up.
struct Elbowed {
    q2: (f64, f64),
    q23: (f64, f64),
    bend: f64,
}

/// Elbow up and down: the two circles about shoulder and wrist center meet in two points, in one, or in none.
fn elbows(g: &Geometry, base: &Base, z: f64, near: [f64; 6]) -> Result<[Option<Elbowed>; 2], Miss> {
    let (u, v) = (base.front - g.a1, g.s1 * (z - g.d1));
    let distance = u.hypot(v);
    let (longest, shortest) = (g.a2 + g.forearm, (g.a2 - g.forearm).abs());
    if distance > longest + REACH_ROUNDING {
        return Err(Miss {
            excess: distance - longest,
            bound: ReachBound::TooFar,
        });
    }
    if distance < shortest - REACH_ROUNDING {
        return Err(Miss {
            excess: shortest - distance,
            bound: ReachBound::TooNear,
        });
    }
    // Direction from the shoulder to the wrist center; free if they coincide.
    let (direction_sin, direction_cos) = if distance > 0.0 {
        (v / distance, u / distance)
    } else {
        near[1].sin_cos()
    };
    // Twice the area of the triangle, by Heron: exact near the stretched and the folded arm, where the law of cosines
    // alone loses half the digits.
    let area = ((longest - distance) * (longest + distance))
        * ((distance - shortest) * (distance + shortest));
    let sine_between = area.max(0.0).sqrt() / (2.0 * g.a2 * g.forearm);
    let at_shoulder = |side: f64| {
        if distance == 0.0 {
            return (0.0, 1.0);
        }
        let sine = side * g.forearm * sine_between / distance;
        let cosine = (distance * distance + (g.a2 - g.forearm) * longest) / (2.0 * g.a2 * distance);
        let norm = sine.hypot(cosine);
        (sine / norm, cosine / norm)
    };
    let elbow = |side: f64| {
        let (sine, cosine) = at_shoulder(side);
        let q2 = (
            direction_sin * cosine + direction_cos * sine,
            direction_cos * cosine - direction_sin * sine,
        );
        // What is left for the forearm, turned back by its own direction.
        let (x, y) = (u - g.a2 * q2.1, v - g.a2 * q2.0);
        let length = x.hypot(y);
        let (sf, cf) = (y / length, x / length);
        let q23 = (
            sf * g.forearm_cos - cf * g.forearm_sin,
            cf * g.forearm_cos + sf * g.forearm_sin,
        );
        Some(Elbowed {
            q2,
            q23,
            bend: g.s1 * side * sine_between,
        })
    };
    if sine_between < Posture::SINGULAR_SINE {
        return Ok([elbow(0.0), None]);
    }
    // Up is on the left of the line from shoulder to wrist center when frame 1's second axis points up.
    Ok([elbow(g.s1), elbow(-g.s1)])
}

/// The wrist's two solutions, or the one nearest to `near` if axes 4 and 6 are in line.
fn push_wrists(
    model: &ArmModel,
    branches: &mut Branches,
    p_WF: &Vector3<f64>,
    R_WF: &Matrix3<f64>,
    base: &Base,
    elbow: &Elbowed,
    near: [f64; 6],
) {
    let g = &model.geometry;
    let turned = Turned {
        q1: base.q1,
        q2: elbow.q2,
        q23: elbow.q23,
        q4: (0.0, 1.0),
        q5: (0.0, 1.0),
        q6: (0.0, 1.0),
    };
    let R_3F = arm_rotation(g, &turned).transpose() * R_WF;
    let sine = R_3F[(0, 2)].hypot(R_3F[(1, 2)]);
    let q1 = angle(base.q1);
    let q2 = angle(elbow.q2);
    let q3 = angle(elbow.q23) - q2;
    let mut push = |q4: (f64, f64)| {
        let (q5, q6) = rest_of_wrist(g, &R_3F, q4);
        let chain = ChainJoints::from_radians([q1, q2, q3, angle(q4), angle(q5), angle(q6)]);
        let posture = Posture::from_parts(q5.0, base.front, elbow.bend);
        if let Some(solution) = checked(model, &chain, &posture, p_WF, R_WF) {
            branches.push(solution);
        }
    };
    if sine < Posture::SINGULAR_WRIST {
        push(shared(g, &R_3F, near));
        return;
    }
    let side = model.no_flip_sign * g.s5 / sine;
    let q4 = (R_3F[(1, 2)] * side, R_3F[(0, 2)] * side);
    push(q4);
    push((-q4.0, -q4.1));
}

/// q5 and q6 at a given q4: what is left of the wrist's rotation, so that an error of q4 is made good by q6.
fn rest_of_wrist(
    g: &Geometry,
    R_3F: &Matrix3<f64>,
    (s4, c4): (f64, f64),
) -> ((f64, f64), (f64, f64)) {
    let t = -g.s4 * g.s5;
    let m = R_3F;
    let q5 = (g.s5 * (m[(0, 2)] * c4 + m[(1, 2)] * s4), t * m[(2, 2)]);
    let q6 = (
        t * (c4 * m[(1, 0)] - s4 * m[(0, 0)]),
        t * (c4 * m[(1, 1)] - s4 * m[(0, 1)]),
    );
    (q5, q6)
}

/// With axes 4 and 6 in line only their sum, or difference, is determined: the way there is shared out evenly.
fn shared(g: &Geometry, R_3F: &Matrix3<f64>, near: [f64; 6]) -> (f64, f64) {
    let [_, _, _, q4, _, q6] = near;
    let (_, at_q4) = rest_of_wrist(g, R_3F, q4.sin_cos());
    let way = angle(at_q4) - q6;
    let way = way - TAU * (way / TAU).round();
    // q6 counts with the direction in which axis 6 points along axis 4.
    let along = R_3F[(2, 2)].signum();
    (q4 + along * way / 2.0).sin_cos()
}

fn angle((sine, cosine): (f64, f64)) -> f64 {
    sine.atan2(cosine)
}

/// The solution on the turns it is shown with, if the forward kinematics agrees.
fn checked(
    model: &ArmModel,
    chain: &ChainJoints,
    posture: &Posture,
    p_WF: &Vector3<f64>,
    R_WF: &Matrix3<f64>,
) -> Option<Solution> {
    let joints = model.on_shown_turns(&model.pendant(chain));
    let (p, R) = flange_of(&model.geometry, &Turned::of(&model.chain(&joints)));
    // Negated, so that NaN fails.
    if !((p - p_WF).norm() <= MAX_POSITION_ERROR && (R - R_WF).amax() <= MAX_ROTATION_ERROR) {
        return None;
    }
    Some(Solution {
        joints,
        configuration: model.configuration_of(posture, turns_of(&joints)),
        margins: model.margins(&joints),
        singularity: posture.singularity(&model.geometry),
    })
}

impl ArmModel {
    /// J1, J2, J3 on the turn nearest to the middle of their range, J4, J5, J6 on the one nearest to zero.
    fn on_shown_turns(&self, joints: &PendantJoints) -> PendantJoints {
        let shown = Axis::ALL.map(|axis| {
            let limits = self.limits(axis);
            let middle = match axis {
                Axis::J1 | Axis::J2 | Axis::J3 => {
                    f64::midpoint(limits.min.0, limits.max.0).to_radians()
                }
                Axis::J4 | Axis::J5 | Axis::J6 => 0.0,
            };
            let value = axis.of(&joints.radians());
            value - TAU * ((value - middle) / TAU).round()
        });
        PendantJoints::from_radians(shown)
    }
}
