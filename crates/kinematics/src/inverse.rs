//! Closed-form inverse kinematics: every branch of an ortho-parallel arm with a spherical wrist.
//!
//! The wrist center is where the flange's axis, followed back by d6, ends. Axis 1 turns the arm's
//! plane towards it, or away from it; in the plane upper arm and forearm reach it with the elbow on
//! either side; the wrist makes up for the rotation in two ways. The first two choices are the four
//! lanes: front up, front down, back up, back down.
#![expect(
    clippy::inline_always,
    reason = "a function with AVX2 is made of what is inlined into it"
)]

use std::f64::consts::{PI, TAU};

use nalgebra::{Matrix3, Vector3};
use units::Millimeters;

use crate::branches::Branches;
use crate::checked::{Postures, Wrists, push_checked};
use crate::geometry::Geometry;
use crate::ik_error::{IkError, ReachBound};
use crate::joints::{Axis, PendantJoints};
use crate::lanes::{
    LANES, Lane, Number, Select, Simd, SimdBase, SimdFloat, SimdFrom, SimdMask, difference,
    dispatch, for_one, mask64x4, sum, transpose,
};
use crate::model::ArmModel;
use crate::pose::Pose;
use crate::posture::Posture;
use crate::trigonometry::{Turn, angles};

/// A wrist center this far beyond a bound, in millimeters, is taken as on it: half of what a
/// solution may be off.
const REACH_ROUNDING: f64 = 5e-7;

/// Puts every branch that reaches `X_WF` into `branches`, which is empty. Joints that a singularity
/// leaves free stay near `reference`.
pub(crate) fn collect(
    model: &ArmModel,
    X_WF: &Pose,
    reference: &PendantJoints,
    branches: &mut Branches,
) -> Result<(), IkError> {
    dispatch!(for_one(model.level), simd => collect_with(simd, model, X_WF, reference, branches))
}

#[inline(always)]
fn collect_with<S: Simd>(
    simd: S,
    model: &ArmModel,
    X_WF: &Pose,
    reference: &PendantJoints,
    branches: &mut Branches,
) -> Result<(), IkError> {
    let g = &model.geometry;
    let R_WF = X_WF.rotation_matrix();
    let p_WC = X_WF.isometry().translation.vector - g.d6 * R_WF.column(2);

    let base = Base::of(simd, model, &p_WC, reference)?;
    let elbow = Elbow::of(model, &base, p_WC.z, reference);
    let wrist = Wrist::of(model, &base, &elbow, &R_WF, reference);

    let [q1, q2, q23] = angles([base.q1, elbow.q2, elbow.q23]);
    let [q4, q5, q6] = angles([wrist.q4, wrist.q5, wrist.q6]);
    let wanted = base.wanted & elbow.wanted;
    let (sin_q5, _) = wrist.q5;
    let no_flip = Wrists {
        wrist: [q4, q5, q6],
        sin_q5,
        wanted,
    };
    let flip = Wrists {
        wrist: [q4 + PI, -q5, q6 + PI],
        sin_q5: -sin_q5,
        wanted: wanted & wrist.has_flip,
    };
    let postures = Postures {
        arm: [q1, q2, q23 - q2],
        front: base.front,
        elbow: elbow.bend,
    };
    push_checked(model, X_WF, &postures, &[no_flip, flip], branches);
    if branches.is_empty() {
        Err(out_of_reach(g, base.front.into(), p_WC.z))
    } else {
        Ok(())
    }
}

/// q1, and how far the wrist center is in front of axis 1.
struct Base<S: Simd> {
    q1: Turn<S>,
    front: Lane<S>,
    wanted: mask64x4<S>,
}

impl<S: Simd> Base<S> {
    /// Front, then back.
    #[inline(always)]
    fn of(
        simd: S,
        model: &ArmModel,
        p_WC: &Vector3<f64>,
        reference: &PendantJoints,
    ) -> Result<Self, IkError> {
        let g = &model.geometry;
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
        let by_side = |front: f64, back: f64| Lane::simd_from(simd, [front, front, back, back]);
        let front_only = || by_side(1.0, 0.0).simd_gt(0.0);
        if across < Posture::SINGULAR_DISTANCE {
            // Every q1 will do.
            let [free_q1, ..] = model.chain(reference).radians();
            let (sine, cosine) = free_q1.sin_cos();
            return Ok(Self {
                q1: (Lane::splat(simd, sine), Lane::splat(simd, cosine)),
                front: Lane::splat(simd, 0.0),
                wanted: front_only(),
            });
        }
        let (front, longer) = if lateral == 0.0 {
            (across, across)
        } else {
            // Not the difference of the squares, which loses half the digits.
            let square = (across - lateral.abs()) * (across + lateral.abs());
            // Within rounding of the nearest it can be, the way is not longer than the offset.
            (square.max(0.0).sqrt(), across.max(lateral.abs()))
        };
        let scale = 1.0 / (across * longer);
        let (x, y) = (p_WC.x * scale, p_WC.y * scale);
        Ok(Self {
            q1: (
                by_side(y * front - x * lateral, -y * front - x * lateral),
                by_side(x * front + y * lateral, -x * front + y * lateral),
            ),
            front: by_side(front, -front),
            wanted: if front < Posture::SINGULAR_DISTANCE {
                front_only()
            } else {
                mask64x4::splat(simd, true)
            },
        })
    }
}

/// q2 and q2 + q3, and the sine between upper arm and forearm, positive with the elbow up.
struct Elbow<S: Simd> {
    q2: Turn<S>,
    q23: Turn<S>,
    bend: Lane<S>,
    wanted: mask64x4<S>,
}

impl<S: Simd> Elbow<S> {
    /// Up and down on either side: the circles about shoulder and wrist center meet in two points.
    #[inline(always)]
    fn of(model: &ArmModel, base: &Base<S>, z: f64, reference: &PendantJoints) -> Self {
        let g = &model.geometry;
        let simd = base.front.simd;
        let (u, v) = (base.front - g.a1, Lane::splat(simd, g.s1 * (z - g.d1)));
        let square = sum((u, u), (v, v));
        let per_square = Lane::splat(simd, 1.0) / square;
        let (longest, shortest) = (g.a2 + g.forearm, g.a2 - g.forearm);
        // Twice the area of the triangle, by Heron. Beyond reach the arm is stretched, and the
        // check at the end will see.
        let area = (-square + longest * longest) * (square - shortest * shortest);
        let area = area.simd_gt(0.0).select(area, Lane::splat(simd, 0.0));
        let sine = area.sqrt() * (0.5 / (g.a2 * g.forearm));
        // Up is on the left of the line from shoulder to wrist center if frame 1's second axis
        // points up.
        let up_and_down = Lane::simd_from(simd, [1.0, -1.0, 1.0, -1.0]);
        let bend = sine * up_and_down;
        // The upper arm along and across the way to the wrist center, by the way's length.
        let along = (square + shortest * longest) * per_square * (0.5 / g.a2);
        let beside = bend * per_square * (g.s1 * g.forearm);
        let mut q2 = (
            sum((v, along), (u, beside)),
            difference((u, along), (v, beside)),
        );
        let folded = square.simd_eq(0.0);
        if folded.any_true() {
            // The arm is folded onto its shoulder, and every q2 will do.
            let [_, free_q2, ..] = model.chain(reference).radians();
            let (s2, c2) = free_q2.sin_cos();
            q2.0 = folded.select(Lane::splat(simd, s2), q2.0);
            q2.1 = folded.select(Lane::splat(simd, c2), q2.1);
        }
        // The way left for the forearm, turned back by the forearm's own direction. Its length is
        // the forearm's but for rounding, which one step of Newton's takes out.
        let (x, y) = (
            q2.1.scaled_plus(-g.a2, u) * (1.0 / g.forearm),
            q2.0.scaled_plus(-g.a2, v) * (1.0 / g.forearm),
        );
        let per_length = sum((x, x), (y, y)) * -0.5 + 1.5;
        let (cosine, sine_of_way) = (x * per_length, y * per_length);
        let q23 = (
            cosine.scaled_plus(-g.forearm_sin, sine_of_way * g.forearm_cos),
            sine_of_way.scaled_plus(g.forearm_sin, cosine * g.forearm_cos),
        );
        // Stretched or folded, up and down are one.
        let bent = sine.simd_ge(Posture::SINGULAR_SINE);
        Self {
            q2,
            q23,
            bend,
            wanted: bent | up_and_down.simd_gt(0.0),
        }
    }
}

/// q4, q5 and q6 without flip.
struct Wrist<S: Simd> {
    q4: Turn<S>,
    q5: Turn<S>,
    q6: Turn<S>,
    has_flip: mask64x4<S>,
}

impl<S: Simd> Wrist<S> {
    #[inline(always)]
    fn of(
        model: &ArmModel,
        base: &Base<S>,
        elbow: &Elbow<S>,
        R_WF: &Matrix3<f64>,
        reference: &PendantJoints,
    ) -> Self {
        let g = &model.geometry;
        let simd = base.front.simd;
        let columns = [
            seen(g, base.q1, elbow.q23, column(simd, R_WF, 0)),
            seen(g, base.q1, elbow.q23, column(simd, R_WF, 1)),
            seen(g, base.q1, elbow.q23, column(simd, R_WF, 2)),
        ];
        let [_, _, [x, y, along]] = columns;
        let sine = sum((x, x), (y, y)).sqrt();
        // Only directions count, so nothing is made of length 1.
        let side = model.no_flip_sign * g.s5;
        let q4 = (y * side, x * side);
        let wrist = Self {
            q4,
            q5: (sine * model.no_flip_sign, along * (-g.s4 * g.s5)),
            q6: last(g, &columns, q4),
            has_flip: sine.simd_ge(Posture::SINGULAR_WRIST),
        };
        if wrist.has_flip.all_true() {
            wrist
        } else {
            wrist.in_line(model, &columns, reference)
        }
    }

    /// The lanes with axes 4 and 6 in line get a q4 near the reference's.
    #[inline(always)]
    fn in_line(
        self,
        model: &ArmModel,
        columns: &[[Lane<S>; 3]; 3],
        reference: &PendantJoints,
    ) -> Self {
        let g = &model.geometry;
        let [first, second, [x, y, along]] = *columns;
        let lanes = transpose(&[first[0], first[1], second[0], second[1], along]);
        let (mut sines, mut cosines) = self.q4;
        for ((columns, sine), cosine) in lanes.iter().zip(sines.iter_mut()).zip(cosines.iter_mut())
        {
            (*sine, *cosine) = share(model, columns, reference);
        }
        let separate = self.has_flip;
        let q5 = sum((cosines, x), (sines, y)) * g.s5;
        let q6 = last(g, columns, (sines, cosines));
        Self {
            q4: (
                separate.select(self.q4.0, sines),
                separate.select(self.q4.1, cosines),
            ),
            q5: (separate.select(self.q5.0, q5), self.q5.1),
            q6: (
                separate.select(self.q6.0, q6.0),
                separate.select(self.q6.1, q6.1),
            ),
            has_flip: separate,
        }
    }
}

#[inline(always)]
fn column<S: Simd>(simd: S, R: &Matrix3<f64>, column: usize) -> [Lane<S>; 3] {
    let axis = R.column(column);
    [
        Lane::splat(simd, axis.x),
        Lane::splat(simd, axis.y),
        Lane::splat(simd, axis.z),
    ]
}

/// A column of the flange's rotation, seen from the forearm.
#[inline(always)]
pub(crate) fn seen<S: Simd>(
    g: &Geometry,
    (s1, c1): Turn<S>,
    (s23, c23): Turn<S>,
    [x, y, z]: [Lane<S>; 3],
) -> [Lane<S>; 3] {
    let z = z * g.s1;
    let (along, across) = (sum((c1, x), (s1, y)), difference((s1, x), (c1, y)));
    [
        sum((c23, along), (s23, z)),
        across * (g.s1 * g.s3),
        difference((s23, along), (c23, z)) * g.s3,
    ]
}

/// q6 at a given q4, of whatever length: what is left of the wrist's rotation, so that an error of
/// q4 is made good by q6.
#[inline(always)]
pub(crate) fn last<S: Simd>(
    g: &Geometry,
    &[[x1, y1, _], [x2, y2, _], _]: &[[Lane<S>; 3]; 3],
    (s4, c4): Turn<S>,
) -> Turn<S> {
    let t = -g.s4 * g.s5;
    (
        difference((c4, y1), (s4, x1)) * t,
        difference((c4, y2), (s4, x2)) * t,
    )
}

/// q4 with axes 4 and 6 in line: only their sum, or difference, is determined, and the way from
/// `reference` is shared out evenly, as far as J4's limits allow. `columns` are x and y of the
/// first two columns of the rotation, and z of the third.
#[cold]
fn share(
    model: &ArmModel,
    &[x1, y1, x2, y2, along]: &[f64; 5],
    reference: &PendantJoints,
) -> (f64, f64) {
    let g = &model.geometry;
    let [.., q4, _, q6] = model.chain(reference).radians();
    let (s4, c4) = q4.sin_cos();
    let t = -g.s4 * g.s5;
    let rest = ((c4 * y1 - s4 * x1) * t).atan2((c4 * y2 - s4 * x2) * t);
    let way = rest - q6;
    let limits = model.limits(Axis::J4);
    let (a, b) = (model.coupling.q4(limits.min), model.coupling.q4(limits.max));
    let (low, high) = (a.min(b), a.max(b));
    // q6 counts in the direction in which axis 6 points along axis 4.
    let half = (way - TAU * (way / TAU).round()) / 2.0;
    (q4 + along.signum() * half).clamp(low, high).sin_cos()
}

/// By how much the wrist center is out of reach, on the better side.
#[cold]
fn out_of_reach(g: &Geometry, fronts: [f64; LANES], z: f64) -> IkError {
    let (longest, shortest) = (g.a2 + g.forearm, (g.a2 - g.forearm).abs());
    let miss = |front: f64| {
        let distance = (front - g.a1).hypot(z - g.d1);
        if distance > f64::midpoint(longest, shortest) {
            (distance - longest, ReachBound::TooFar)
        } else {
            (shortest - distance, ReachBound::TooNear)
        }
    };
    let [front, _, back, _] = fronts;
    let (front, back) = (miss(front), miss(back));
    let (excess, bound) = if back.0 < front.0 { back } else { front };
    IkError::OutOfReach {
        excess: Millimeters(excess),
        bound,
    }
}
