//! Forward and inverse kinematics of many poses: four poses go side by side, a lane each.
//!
//! The formulas are those of `inverse.rs`. Solutions are not put through the forward kinematics
//! again; a pose at a singularity, where that matters, is solved by the checked way instead.
#![expect(
    clippy::inline_always,
    reason = "a function with AVX2 is made of what is inlined into it"
)]

use std::f64::consts::{PI, TAU};

use nalgebra::Isometry3;

use crate::checked::nearest_turn;
use crate::joints::{Axis, PendantJoints};
use crate::lanes::{
    LANES, Lane, Number, Select, Simd, SimdBase, SimdFloat, SimdFrom, SimdMask, difference,
    dispatch, mask64x4, sum,
};
use crate::model::ArmModel;
use crate::pose::Pose;
use crate::trigonometry::angles;

/// Nearer to a singularity than this (sines, parts of the reach) a pose is solved by itself.
const NEARLY_SINGULAR: f64 = 1e-6;

/// Groups that are solved before they are given away.
const GROUPS: usize = 4;

/// Up to eight joint sets of four poses.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Group {
    /// Displayed joints in radians: set, joint, pose.
    joints: [[[f64; LANES]; 6]; 8],
    /// A bit for each pose.
    reached: [u64; 8],
}

/// The joint sets that reach one pose of a batch; see [`ArmModel::inverse_batch`].
#[derive(Clone, Copy, Debug)]
pub struct JointSets<'a> {
    group: &'a Group,
    lane: usize,
}

impl JointSets<'_> {
    /// The joint sets: front before back, elbow up before down, no flip before flip; J1 to J6 each
    /// on the turn nearest to the middle of its range.
    pub fn iter(&self) -> impl Iterator<Item = PendantJoints> {
        let lane = self.lane;
        let sets = self.group.joints.iter().zip(&self.group.reached);
        sets.filter(move |(_, reached)| (**reached >> lane) & 1 == 1)
            .map(move |(joints, _)| {
                let of = |joint: &[f64; LANES]| joint.get(lane).copied().unwrap_or(f64::NAN);
                let [j1, j2, j3, j4, j5, j6] = joints;
                PendantJoints::from_radians([of(j1), of(j2), of(j3), of(j4), of(j5), of(j6)])
            })
    }

    /// How many there are.
    #[must_use]
    pub fn len(&self) -> usize {
        let reached = self.group.reached.iter();
        reached.filter(|set| (**set >> self.lane) & 1 == 1).count()
    }

    /// Is the pose out of reach?
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }
}

impl ArmModel {
    /// Every joint set of each of `poses`, given to `each` with the pose's index, in order.
    ///
    /// For maps and searches over many poses: a tenth of the time of [`Self::inverse_all`] and
    /// more. Limits are not checked. The joint sets are exact to 1 nm as those of `inverse_all`, by
    /// the way they are computed and not by a check of each.
    pub fn inverse_batch(&self, poses: &[Pose], mut each: impl FnMut(usize, &JointSets<'_>)) {
        let display = Display::of(self);
        let mut groups = [Group::none(); GROUPS];
        let mut index = 0;
        for poses in poses.chunks(LANES * GROUPS) {
            solve_groups(self, &display, poses, &mut groups);
            for (group, poses) in groups.iter().zip(poses.chunks(LANES)) {
                for lane in 0..poses.len() {
                    each(index, &JointSets { group, lane });
                    index += 1;
                }
            }
        }
    }
}

/// Solves as many groups of poses as there are. Not generic, so that it is compiled here, whoever calls.
fn solve_groups(model: &ArmModel, display: &Display, poses: &[Pose], groups: &mut [Group]) {
    dispatch!(model.level, simd => {
        for (poses, group) in poses.chunks(LANES).zip(&mut *groups) {
            solve_group_with(simd, model, display, poses, group);
        }
    });
}

impl Group {
    pub(crate) fn none() -> Self {
        Self {
            joints: [[[0.0; LANES]; 6]; 8],
            reached: [0; 8],
        }
    }

    /// How many sets reach each pose, and how many of them are inside the limits.
    #[inline(always)]
    pub(crate) fn count<S: Simd>(&self, simd: S, limits: &[(f64, f64); 6]) -> [(u8, u8); LANES] {
        let mut counts = [(0, 0); LANES];
        for (joints, reached) in self.joints.iter().zip(&self.reached) {
            let mut inside = mask64x4::splat(simd, true);
            for (joint, (min, max)) in joints.iter().zip(limits) {
                let joint = Lane::simd_from(simd, *joint);
                inside = inside & joint.simd_ge(*min) & joint.simd_le(*max);
            }
            let inside = inside.to_bitmask() & reached;
            for (lane, count) in counts.iter_mut().enumerate() {
                count.0 += u8::from((reached >> lane) & 1 == 1);
                count.1 += u8::from((inside >> lane) & 1 == 1);
            }
        }
        counts
    }

    /// The checked solutions of one pose, in its lane.
    #[cold]
    fn solve_alone(&mut self, model: &ArmModel, pose: &Pose, lane: usize, middles: &[f64; 6]) {
        let found = model.inverse_all(pose);
        let mut solutions = found.iter().flatten();
        for (joints, reached) in self.joints.iter_mut().zip(&mut self.reached) {
            *reached &= !(1 << lane);
            let Some(solution) = solutions.next() else {
                continue;
            };
            *reached |= 1 << lane;
            let values = solution.joints.radians();
            for ((joint, value), middle) in joints.iter_mut().zip(values).zip(middles) {
                if let Some(cell) = joint.get_mut(lane) {
                    *cell = value - TAU * ((value - middle) / TAU).round();
                }
            }
        }
    }
}

/// How the chain's angles are shown, `J = q * sign + offset`, and the middles of the joints' ranges, in radians.
pub(crate) struct Display {
    signs: [f64; 6],
    offsets: [f64; 6],
    /// What of J2, as it is shown, adds to J3.
    j2_in_j3: f64,
    middles: [f64; 6],
    /// The forearm's direction at q2 + q3 = 0.
    forearm_phase: f64,
    /// Of q5 without flip.
    no_flip_sign: f64,
}

impl Display {
    /// [`crate::coupling::Coupling::pendant`], multiplied out: the signs are 1 or -1.
    pub(crate) fn of(model: &ArmModel) -> Self {
        let coupling = &model.coupling;
        let mut offsets = coupling.offsets;
        for (offset, sign) in offsets.iter_mut().zip(coupling.signs) {
            *offset *= -sign;
        }
        Self {
            signs: coupling.signs,
            offsets,
            j2_in_j3: -coupling.j2_in_q3 * Axis::J3.of(&coupling.signs),
            middles: middles(model),
            forearm_phase: model.geometry.forearm_sin.atan2(model.geometry.forearm_cos),
            no_flip_sign: model.no_flip_sign,
        }
    }

    /// J1, which both elbows share.
    #[inline(always)]
    fn first<S: Simd>(&self, q1: Lane<S>) -> Lane<S> {
        let ([sign, ..], [offset, ..]) = (self.signs, self.offsets);
        nearest_turn(
            q1.scaled_plus(sign, q1.like(offset)),
            Axis::J1.of(&self.middles),
        )
    }

    /// The joints of both wrists, without flip and with it. `q5` is above zero.
    #[inline(always)]
    fn shown<S: Simd>(
        &self,
        j1: Lane<S>,
        [q2, q3]: [Lane<S>; 2],
        [q4, q5, q6]: [Lane<S>; 3],
    ) -> [[Lane<S>; 6]; 2] {
        let [_, s2, s3, s4, s5, s6] = self.signs;
        let [_, o2, o3, o4, o5, o6] = self.offsets;
        let [_, m2, m3, m4, m5, m6] = self.middles;
        let s5 = self.no_flip_sign * s5;
        let j2 = q2.scaled_plus(s2, q2.like(o2));
        let j3 = j2.scaled_plus(self.j2_in_j3, q3.scaled_plus(s3, q3.like(o3)));
        let (j2, j3) = (nearest_turn(j2, m2), nearest_turn(j3, m3));
        let j4 = nearest_turn(q4.scaled_plus(s4, q4.like(o4)), m4);
        let j5 = nearest_turn(q5.scaled_plus(s5, q5.like(o5)), m5);
        let flip5 = nearest_turn(q5.scaled_plus(-s5, q5.like(o5)), m5);
        let j6 = nearest_turn(q6.scaled_plus(s6, q6.like(o6)), m6);
        let flip = [j1, j2, j3, half_turned(j4, m4), flip5, half_turned(j6, m6)];
        [[j1, j2, j3, j4, j5, j6], flip]
    }
}

/// Solves up to four poses; lanes beyond them hold the last one again.
///
/// What the four postures of an arm have in common is computed once. In the plane of the arm, seen along the way to the
/// wrist center, both elbows lie alike on either side: the upper arm is at the angle `alpha` from that way, the forearm at
/// `beta` on the other side of it. So three angles make the four of q2 and q2 + q3.
#[inline(always)]
pub(crate) fn solve_group_with<S: Simd>(
    simd: S,
    model: &ArmModel,
    display: &Display,
    poses: &[Pose],
    group: &mut Group,
) {
    let g = &model.geometry;
    let one = Lane::splat(simd, 1.0);
    let zero = Lane::splat(simd, 0.0);
    let ([x, y, z], [r0, r1, r2]) = load(simd, poses);
    let [x, y, z] = [
        r2[0].scaled_plus(-g.d6, x),
        r2[1].scaled_plus(-g.d6, y),
        r2[2].scaled_plus(-g.d6, z),
    ];
    // All twists are a quarter turn one way or the other: their signs go where they cost least.
    let turned = model.no_flip_sign * g.s5;
    let last = -g.s4 * g.s5;
    let columns = [
        signed(r0, last, g.s1),
        signed(r1, last, g.s1),
        signed(r2, turned, g.s1),
    ];
    let [r0, r1, r2] = columns;
    let upright = g.s3 * last * turned;
    let lateral = -g.s1 * g.lateral;
    let across = sum((x, x), (y, y)).sqrt();
    let square = (across - lateral.abs()) * (across + lateral.abs());
    let front = square.simd_gt(0.0).select(square, zero).sqrt();
    let scale = one / (across * across);
    let close = NEARLY_SINGULAR * g.reach;
    let mut alone = square.simd_lt(close * close);
    let v = (z - g.d1) * g.s1;
    let (longest, shortest) = (g.a2 + g.forearm, g.a2 - g.forearm);
    let mut sets = group.joints.iter_mut().zip(group.reached.iter_mut());
    for side in [1.0, -1.0] {
        let front = front * side;
        let (sin1, cos1) = (
            x.scaled_plus(-lateral, y * front) * scale,
            y.scaled_plus(lateral, x * front) * scale,
        );
        let u = front - g.a1;
        let square = sum((u, u), (v, v));
        let per_square = one / square;
        let area = (-square + longest * longest) * (square - shortest * shortest);
        // Nearly stretched or folded.
        let least = NEARLY_SINGULAR * g.a2 * g.forearm;
        alone |= area.abs().simd_lt(least * least);
        let reaches = area.simd_gt(0.0);
        let twice_height = reaches.select(area, zero).sqrt();
        // Parts of the way to the wrist center: the elbow's foot on it, and what is left of it.
        let foot = (square + shortest * longest) * per_square * 0.5;
        let rest = (square - shortest * longest) * per_square * 0.5;
        let height = twice_height * per_square * (g.s1 * 0.5);
        let [first, gamma] = angles([(sin1, cos1), (v, u)]);
        let [alpha, beta] = angles([(height, foot), (height, rest)]);
        let reached = reaches.to_bitmask();
        let j1 = display.first(first);
        // The forearm's direction, turned back by its own phase.
        let (pu, pv) = (
            u.scaled_plus(g.forearm_cos, v * g.forearm_sin),
            v.scaled_plus(g.forearm_cos, -u * g.forearm_sin),
        );
        let (ahead, beside) = (rest * (1.0 / g.forearm), height * (1.0 / g.forearm));
        // The rotation in the plane of the arm: along it, across it, and up.
        let (sin_across, cos_across) = (sin1 * (g.s1 * g.s3), cos1 * (g.s1 * g.s3));
        let (along, across) = ((sin1, cos1), (sin_across, cos_across));
        let (along0, y0) = in_plane(along, across, r0);
        let (along1, y1) = in_plane(along, across, r1);
        let (along2, wy) = in_plane(along, across, r2);
        for bend in [1.0, -1.0] {
            let second = alpha.scaled_plus(bend, gamma);
            let third = (alpha + beta).scaled_plus(-bend, one * -display.forearm_phase);
            let beside = beside * bend;
            let c23 = sum((pu, ahead), (pv, beside));
            let s23 = difference((pv, ahead), (pu, beside));
            let x0 = sum((c23, along0), (s23, r0[2]));
            let x1 = sum((c23, along1), (s23, r1[2]));
            let wx = sum((c23, along2), (s23, r2[2]));
            let wz = difference((s23, along2), (c23, r2[2]));
            let sine5 = sum((wx, wx), (wy, wy)).sqrt();
            alone |= sine5.simd_lt(NEARLY_SINGULAR);
            // Only directions count, so nothing is made of length 1.
            let q6 = (
                difference((wx, y0), (wy, x0)),
                difference((wx, y1), (wy, x1)),
            );
            let [q4, q5, q6] = angles([(wy, wx), (sine5, wz * upright), q6]);
            for values in display.shown(j1, [second, third], [q4, q5, q6]) {
                let Some((joints, is_reached)) = sets.next() else {
                    return;
                };
                for (joint, value) in joints.iter_mut().zip(values) {
                    *joint = value.into();
                }
                *is_reached = reached;
            }
        }
    }
    if alone.any_true() {
        let alone = alone.to_bitmask();
        for (lane, pose) in poses.iter().enumerate() {
            if (alone >> lane) & 1 == 1 {
                group.solve_alone(model, pose, lane, &display.middles);
            }
        }
    }
}

/// A column of a rotation, turned over by `sign`, its upright part by `upright` besides.
#[inline(always)]
fn signed<S: Simd>([x, y, z]: [Lane<S>; 3], sign: f64, upright: f64) -> [Lane<S>; 3] {
    [x * sign, y * sign, z * (sign * upright)]
}

/// The parts of a column along the arm's plane and across it.
#[inline(always)]
fn in_plane<S: Simd>(
    (s1, c1): (Lane<S>, Lane<S>),
    (s_across, c_across): (Lane<S>, Lane<S>),
    [x, y, _]: [Lane<S>; 3],
) -> (Lane<S>, Lane<S>) {
    (
        sum((c1, x), (s1, y)),
        difference((s_across, x), (c_across, y)),
    )
}

/// The same number of four poses.
#[inline(always)]
fn of_each<S: Simd>(
    simd: S,
    [a, b, c, d]: [&Isometry3<f64>; LANES],
    of: impl Fn(&Isometry3<f64>) -> f64,
) -> Lane<S> {
    Lane::simd_from(simd, [of(a), of(b), of(c), of(d)])
}

/// Half a turn on from an angle within half a turn of `middle`, and within it again.
#[inline(always)]
fn half_turned<S: Simd>(angle: Lane<S>, middle: f64) -> Lane<S> {
    let half = Lane::splat(angle.simd, PI);
    angle + angle.simd_gt(middle).select(-half, half)
}

/// Positions, and the columns of the rotations.
#[inline(always)]
fn load<S: Simd>(simd: S, poses: &[Pose]) -> ([Lane<S>; 3], [[Lane<S>; 3]; 3]) {
    let at = |lane: usize| poses.get(lane).or(poses.last());
    let (Some(a), Some(b), Some(c), Some(d)) = (at(0), at(1), at(2), at(3)) else {
        let none = Lane::splat(simd, f64::NAN);
        return ([none; 3], [[none; 3]; 3]);
    };
    let all = [a.isometry(), b.isometry(), c.isometry(), d.isometry()];
    let x = of_each(simd, all, |pose| pose.translation.vector.x);
    let y = of_each(simd, all, |pose| pose.translation.vector.y);
    let z = of_each(simd, all, |pose| pose.translation.vector.z);
    let i = of_each(simd, all, |pose| pose.rotation.coords.x);
    let j = of_each(simd, all, |pose| pose.rotation.coords.y);
    let k = of_each(simd, all, |pose| pose.rotation.coords.z);
    let w = of_each(simd, all, |pose| pose.rotation.coords.w);
    let (i2, j2, k2) = (i + i, j + j, k + k);
    let columns = [
        [
            -sum((j, j2), (k, k2)) + 1.0,
            sum((i, j2), (w, k2)),
            difference((i, k2), (w, j2)),
        ],
        [
            difference((i, j2), (w, k2)),
            -sum((i, i2), (k, k2)) + 1.0,
            sum((j, k2), (w, i2)),
        ],
        [
            sum((i, k2), (w, j2)),
            difference((j, k2), (w, i2)),
            -sum((i, i2), (j, j2)) + 1.0,
        ],
    ];
    ([x, y, z], columns)
}

/// The middles of the joints' ranges, in radians.
fn middles(model: &ArmModel) -> [f64; 6] {
    let [a, b, c, d, e, f] = Axis::ALL;
    let middle = |axis| {
        let limits = model.limits(axis);
        f64::midpoint(limits.min.0, limits.max.0).to_radians()
    };
    [
        middle(a),
        middle(b),
        middle(c),
        middle(d),
        middle(e),
        middle(f),
    ]
}
