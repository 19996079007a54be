//! Closed-form inverse kinematics: every branch of an ortho-parallel arm with a spherical wrist.
//!
//! The wrist center is where the flange's axis, followed back by d6, ends. Axis 1 turns the arm's
//! plane towards it, or away from it; in the plane upper arm and forearm reach it with the elbow on
//! either side; the wrist makes up for the rotation in two ways. The first two choices are the four
//! lanes: front up, front down, back up, back down.
#![expect(
    clippy::inline_always,
    reason = "a function with AVX2 is made of what is inlined into it, and a call a lane would undo the point of lanes"
)]

use std::f64::consts::{PI, TAU};

use nalgebra::{Matrix3, Vector3};
use units::Millimeters;

use crate::branches::Branches;
use crate::checked::{Postures, Wrists, both, push_checked};
use crate::geometry::Geometry;
use crate::ik_error::{IkError, ReachBound};
use crate::joints::{Axis, PendantJoints};
use crate::lanes::Lanes;
use crate::model::ArmModel;
use crate::pose::Pose;
use crate::posture::Posture;
use crate::trigonometry::atan2;

/// A wrist center this far beyond a bound, in millimeters, is taken as on it: half of what a
/// solution may be off.
const REACH_ROUNDING: f64 = 5e-7;

/// Sine and cosine of an angle, a lane each.
type Turn = (Lanes<4>, Lanes<4>);

/// Puts every branch that reaches `X_WF` into `branches`, which is empty. Joints that a singularity
/// leaves free stay near `reference`.
#[multiversion::multiversion(targets("x86_64+avx2+fma"))]
pub(crate) fn collect(
    model: &ArmModel,
    X_WF: &Pose,
    reference: &PendantJoints,
    branches: &mut Branches,
) -> Result<(), IkError> {
    let g = &model.geometry;
    let R_WF = X_WF.rotation_matrix();
    let p_WC = X_WF.isometry().translation.vector - g.d6 * R_WF.column(2);
    let near = model.chain(reference).radians();
    let [free_q1, free_q2, ..] = near;

    let base = Base::of(g, &p_WC, free_q1)?;
    let elbow = Elbow::of(g, &base, p_WC.z, free_q2);
    let wrist = Wrist::of(model, &base, &elbow, &R_WF, near);

    let (q1, q2, q23) = (angle(base.q1), angle(elbow.q2), angle(elbow.q23));
    let (q4, q5, q6) = (angle(wrist.q4), angle(wrist.q5), angle(wrist.q6));
    let wanted = both(base.wanted, elbow.wanted);
    let (sin_q5, _) = wrist.q5;
    let no_flip = Wrists {
        wrist: [q4, q5, q6],
        sin_q5,
        wanted,
    };
    let flip = Wrists {
        wrist: [q4 + PI, -q5, q6 + PI],
        sin_q5: -sin_q5,
        wanted: both(wanted, wrist.has_flip),
    };
    let postures = Postures {
        arm: [q1, q2, q23 - q2],
        front: base.front,
        elbow: elbow.bend,
    };
    push_checked(model, X_WF, &postures, &[no_flip, flip], branches);
    if branches.is_empty() {
        Err(out_of_reach(g, &base, p_WC.z))
    } else {
        Ok(())
    }
}

#[inline(always)]
fn angle((sine, cosine): Turn) -> Lanes<4> {
    atan2(sine, cosine)
}

/// q1, and how far the wrist center is in front of axis 1.
struct Base {
    q1: Turn,
    front: Lanes<4>,
    wanted: [bool; 4],
}

impl Base {
    /// Front, then back.
    #[inline(always)]
    fn of(g: &Geometry, p_WC: &Vector3<f64>, free_q1: f64) -> Result<Self, IkError> {
        // The plane of the arm passes axis 1 at this distance.
        let lateral = -g.s1 * g.lateral;
        let across = (p_WC.x * p_WC.x + p_WC.y * p_WC.y).sqrt();
        if lateral.abs() - across > REACH_ROUNDING {
            let excess = Millimeters(lateral.abs() - across);
            return Err(IkError::OutOfReach {
                excess,
                bound: ReachBound::TooNearToAxis1,
            });
        }
        let by_side = |front: f64, back: f64| Lanes([front, front, back, back]);
        if across < Posture::SINGULAR_DISTANCE {
            // Every q1 will do.
            let (sine, cosine) = free_q1.sin_cos();
            return Ok(Self {
                q1: (Lanes::all(sine), Lanes::all(cosine)),
                front: Lanes::all(0.0),
                wanted: [true, true, false, false],
            });
        }
        // Not the difference of the squares, which loses half the digits.
        let front = ((across - lateral.abs()) * (across + lateral.abs()))
            .max(0.0)
            .sqrt();
        let scale = 1.0 / (across * (front * front + lateral * lateral).sqrt());
        let (x, y) = (p_WC.x * scale, p_WC.y * scale);
        Ok(Self {
            q1: (
                by_side(y * front - x * lateral, -y * front - x * lateral),
                by_side(x * front + y * lateral, -x * front + y * lateral),
            ),
            front: by_side(front, -front),
            wanted: if front < Posture::SINGULAR_DISTANCE {
                [true, true, false, false]
            } else {
                [true; 4]
            },
        })
    }
}

/// q2 and q2 + q3, and the sine between upper arm and forearm, positive with the elbow up.
struct Elbow {
    q2: Turn,
    q23: Turn,
    bend: Lanes<4>,
    wanted: [bool; 4],
}

impl Elbow {
    /// Up and down on either side: the circles about shoulder and wrist center meet in two points.
    #[inline(always)]
    fn of(g: &Geometry, base: &Base, z: f64, free_q2: f64) -> Self {
        let (u, v) = (base.front - g.a1, Lanes::all(g.s1 * (z - g.d1)));
        let distance = (u * u + v * v).sqrt();
        let per_distance = distance.recip();
        let (longest, shortest) = (g.a2 + g.forearm, (g.a2 - g.forearm).abs());
        // Twice the area of the triangle, by Heron: exact near the stretched and the folded arm,
        // where the law of cosines loses half the digits. Beyond reach the arm is stretched, and
        // the check at the end will see.
        let area = ((distance * -1.0 + longest) * (distance + longest))
            * ((distance - shortest) * (distance + shortest));
        let sine = area.map(|area| if area > 0.0 { area } else { 0.0 }).sqrt()
            * (0.5 / (g.a2 * g.forearm));
        // Up is on the left of the line from shoulder to wrist center if frame 1's second axis
        // points up.
        let bend = sine * Lanes([1.0, -1.0, 1.0, -1.0]);
        let mut direction = (v * per_distance, u * per_distance);
        let mut shoulder = (
            bend * per_distance * (g.s1 * g.forearm),
            (distance * distance + (g.a2 - g.forearm) * longest) * per_distance * (0.5 / g.a2),
        );
        let folded = distance.test(|distance| distance == 0.0);
        if folded != [false; 4] {
            // The arm is folded onto its shoulder, and every q2 will do.
            let (s2, c2) = free_q2.sin_cos();
            direction.0 = direction.0.replaced(folded, Lanes::all(s2));
            direction.1 = direction.1.replaced(folded, Lanes::all(c2));
            shoulder.0 = shoulder.0.replaced(folded, Lanes::all(0.0));
            shoulder.1 = shoulder.1.replaced(folded, Lanes::all(1.0));
        }
        let q2 = (
            direction.0 * shoulder.1 + direction.1 * shoulder.0,
            direction.1 * shoulder.1 - direction.0 * shoulder.0,
        );
        // The way left for the forearm, turned back by the forearm's own direction.
        let (x, y) = (u - q2.1 * g.a2, v - q2.0 * g.a2);
        let per_length = (x * x + y * y).sqrt().recip();
        let (cosine, sine_of_way) = (x * per_length, y * per_length);
        let q23 = (
            sine_of_way * g.forearm_cos - cosine * g.forearm_sin,
            cosine * g.forearm_cos + sine_of_way * g.forearm_sin,
        );
        let [front_two, _, back_two, _] = sine.test(|sine| sine >= Posture::SINGULAR_SINE);
        // Stretched or folded, up and down are one.
        let wanted = [true, front_two, true, back_two];
        Self {
            q2,
            q23,
            bend,
            wanted,
        }
    }
}

/// q4, q5 and q6 without flip.
struct Wrist {
    q4: Turn,
    q5: Turn,
    q6: Turn,
    has_flip: [bool; 4],
}

impl Wrist {
    #[inline(always)]
    fn of(
        model: &ArmModel,
        base: &Base,
        elbow: &Elbow,
        R_WF: &Matrix3<f64>,
        near: [f64; 6],
    ) -> Self {
        let g = &model.geometry;
        let ((s1, c1), (s23, c23)) = (base.q1, elbow.q23);
        // A column of the flange's rotation, seen from the forearm.
        let seen = |column: usize| {
            let axis = R_WF.column(column);
            let (x, y, z) = (axis.x, axis.y, g.s1 * axis.z);
            let (along, across) = (c1 * x + s1 * y, s1 * x - c1 * y);
            [
                c23 * along + s23 * z,
                across * (g.s1 * g.s3),
                (s23 * along - c23 * z) * g.s3,
            ]
        };
        let rotation = [seen(0), seen(1), seen(2)];
        let [_, _, [x, y, _]] = rotation;
        let sine = (x * x + y * y).sqrt();
        let scale = sine.recip() * (model.no_flip_sign * g.s5);
        let mut q4 = (y * scale, x * scale);
        let in_line = sine.test(|sine| sine < Posture::SINGULAR_WRIST);
        if in_line != [false; 4] {
            let shared = share(model, &rotation, near);
            q4 = (
                q4.0.replaced(in_line, shared.0),
                q4.1.replaced(in_line, shared.1),
            );
        }
        let (q5, q6) = rest_of_wrist(g, &rotation, q4);
        Self {
            q4,
            q5,
            q6,
            has_flip: sine.test(|sine| sine >= Posture::SINGULAR_WRIST),
        }
    }
}

/// q5 and q6 at a given q4: what is left of the wrist's rotation, so that an error of q4 is made
/// good by q6.
#[inline(always)]
fn rest_of_wrist(g: &Geometry, columns: &[[Lanes<4>; 3]; 3], (s4, c4): Turn) -> (Turn, Turn) {
    let [[x1, y1, _], [x2, y2, _], [x3, y3, z3]] = *columns;
    let t = -g.s4 * g.s5;
    (
        ((c4 * x3 + s4 * y3) * g.s5, z3 * t),
        ((c4 * y1 - s4 * x1) * t, (c4 * y2 - s4 * x2) * t),
    )
}

/// q4 with axes 4 and 6 in line: only their sum, or difference, is determined, and the way from
/// `near` is shared out evenly, as far as J4's limits allow.
#[cold]
fn share(model: &ArmModel, columns: &[[Lanes<4>; 3]; 3], near: [f64; 6]) -> Turn {
    let [.., q4, _, q6] = near;
    let (sine, cosine) = q4.sin_cos();
    let at_q4 = (Lanes::all(sine), Lanes::all(cosine));
    let (_, rest) = rest_of_wrist(&model.geometry, columns, at_q4);
    let way = angle(rest) - q6;
    let [_, _, [.., along]] = *columns;
    let limits = model.limits(Axis::J4);
    let (a, b) = (model.coupling.q4(limits.min), model.coupling.q4(limits.max));
    let (low, high) = (a.min(b), a.max(b));
    // q6 counts in the direction in which axis 6 points along axis 4.
    let turned = way.zip(along, |way, along| {
        let half = (way - TAU * (way / TAU).round()) / 2.0;
        (q4 + along.signum() * half).clamp(low, high)
    });
    (turned.map(f64::sin), turned.map(f64::cos))
}

/// By how much the wrist center is out of reach, on the better side.
#[cold]
fn out_of_reach(g: &Geometry, base: &Base, z: f64) -> IkError {
    let (longest, shortest) = (g.a2 + g.forearm, (g.a2 - g.forearm).abs());
    let miss = |front: f64| {
        let distance = (front - g.a1).hypot(z - g.d1);
        if distance > f64::midpoint(longest, shortest) {
            (distance - longest, ReachBound::TooFar)
        } else {
            (shortest - distance, ReachBound::TooNear)
        }
    };
    let [front, _, back, _] = base.front.0;
    let (front, back) = (miss(front), miss(back));
    let (excess, bound) = if back.0 < front.0 { back } else { front };
    IkError::OutOfReach {
        excess: Millimeters(excess),
        bound,
    }
}
