//! Forward and inverse kinematics of many poses: four poses go side by side, a lane each.
//!
//! The formulas are those of `inverse.rs`. Solutions are not put through the forward kinematics
//! again; a pose at a singularity, where that matters, is solved by the checked way instead.
#![expect(
    clippy::inline_always,
    reason = "a function with AVX2 is made of what is inlined into it"
)]

use std::f64::consts::{PI, TAU};

use crate::checked::nearest_turn;
use crate::inverse::{last, seen};
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
        let mut group = Group::none();
        let mut index = 0;
        for poses in poses.chunks(LANES) {
            solve_group(self, poses, &mut group);
            for lane in 0..poses.len() {
                each(
                    index,
                    &JointSets {
                        group: &group,
                        lane,
                    },
                );
                index += 1;
            }
        }
    }
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

/// Solves up to four poses; lanes beyond them hold the last one again.
fn solve_group(model: &ArmModel, poses: &[Pose], group: &mut Group) {
    dispatch!(model.level, simd => solve_group_with(simd, model, poses, group));
}

#[inline(always)]
pub(crate) fn solve_group_with<S: Simd>(
    simd: S,
    model: &ArmModel,
    poses: &[Pose],
    group: &mut Group,
) {
    let g = &model.geometry;
    let middles = middles(model);
    let one = Lane::splat(simd, 1.0);
    let zero = Lane::splat(simd, 0.0);
    let ([x, y, z], [r0, r1, r2]) = load(simd, poses);
    let [x, y, z] = [
        r2[0].scaled_plus(-g.d6, x),
        r2[1].scaled_plus(-g.d6, y),
        r2[2].scaled_plus(-g.d6, z),
    ];
    let lateral = -g.s1 * g.lateral;
    let across = sum((x, x), (y, y)).sqrt();
    let square = (across - lateral.abs()) * (across + lateral.abs());
    let front = square.simd_gt(0.0).select(square, zero).sqrt();
    let scale = one / (across * across);
    let close = NEARLY_SINGULAR * g.reach;
    let mut alone = square.simd_lt(close * close);
    let v = (z - g.d1) * g.s1;
    let (longest, shortest) = (g.a2 + g.forearm, g.a2 - g.forearm);
    let mut set = group.joints.iter_mut().zip(group.reached.iter_mut());
    for side in [1.0, -1.0] {
        let front = front * side;
        let q1 = (
            x.scaled_plus(-lateral, y * front) * scale,
            y.scaled_plus(lateral, x * front) * scale,
        );
        let [first] = angles([q1]);
        let u = front - g.a1;
        let square = sum((u, u), (v, v));
        let per_square = one / square;
        let area = (-square + longest * longest) * (square - shortest * shortest);
        // Nearly stretched or folded.
        let least = NEARLY_SINGULAR * g.a2 * g.forearm;
        alone |= area.abs().simd_lt(least * least);
        let reaches = area.simd_gt(0.0);
        let twice_height = reaches.select(area, zero).sqrt();
        let along = (square + shortest * longest) * per_square * (0.5 / g.a2);
        let across_arm = twice_height * per_square * (g.s1 * 0.5 / g.a2);
        for bend in [1.0, -1.0] {
            let off = across_arm * bend;
            let q2 = (sum((v, along), (u, off)), difference((u, along), (v, off)));
            let (fx, fy) = (
                q2.1.scaled_plus(-g.a2, u) * (1.0 / g.forearm),
                q2.0.scaled_plus(-g.a2, v) * (1.0 / g.forearm),
            );
            let q23 = (
                fx.scaled_plus(-g.forearm_sin, fy * g.forearm_cos),
                fy.scaled_plus(g.forearm_sin, fx * g.forearm_cos),
            );
            let [second, both] = angles([q2, q23]);
            let columns = [
                seen(g, q1, q23, r0),
                seen(g, q1, q23, r1),
                seen(g, q1, q23, r2),
            ];
            let [_, _, [wx, wy, wz]] = columns;
            let sine5 = sum((wx, wx), (wy, wy)).sqrt();
            alone |= sine5.simd_lt(NEARLY_SINGULAR);
            // Only directions count, so nothing is made of length 1.
            let turned = model.no_flip_sign * g.s5;
            let q4 = (wy * turned, wx * turned);
            let q6 = last(g, &columns, q4);
            let q5 = (sine5 * model.no_flip_sign, wz * (-g.s4 * g.s5));
            let [q4, q5, q6] = angles([q4, q5, q6]);
            let third = both - second;
            for [q4, q5, q6] in [[q4, q5, q6], [q4 + PI, -q5, q6 + PI]] {
                let shown = model.coupling.pendant(&[first, second, third, q4, q5, q6]);
                let Some((joints, reached)) = set.next() else {
                    return;
                };
                for ((joint, value), middle) in joints.iter_mut().zip(shown).zip(middles) {
                    *joint = nearest_turn(value, middle).into();
                }
                *reached = reaches.to_bitmask();
            }
        }
    }
    if alone.any_true() {
        let alone = alone.to_bitmask();
        for (lane, pose) in poses.iter().enumerate() {
            if (alone >> lane) & 1 == 1 {
                group.solve_alone(model, pose, lane, &middles);
            }
        }
    }
}

/// Positions, and the columns of the rotations.
#[inline(always)]
fn load<S: Simd>(simd: S, poses: &[Pose]) -> ([Lane<S>; 3], [[Lane<S>; 3]; 3]) {
    let mut p = [[0.0; LANES]; 3];
    let mut q = [[0.0; LANES]; 4];
    for lane in 0..LANES {
        let Some(pose) = poses.get(lane).or(poses.last()) else {
            break;
        };
        let isometry = pose.isometry();
        for (to, from) in p.iter_mut().zip(isometry.translation.vector.iter()) {
            if let Some(cell) = to.get_mut(lane) {
                *cell = *from;
            }
        }
        for (to, from) in q.iter_mut().zip(isometry.rotation.coords.iter()) {
            if let Some(cell) = to.get_mut(lane) {
                *cell = *from;
            }
        }
    }
    let [x, y, z] = p;
    let [i, j, k, w] = q;
    let (x, y, z) = (
        Lane::simd_from(simd, x),
        Lane::simd_from(simd, y),
        Lane::simd_from(simd, z),
    );
    let (i, j) = (Lane::simd_from(simd, i), Lane::simd_from(simd, j));
    let (k, w) = (Lane::simd_from(simd, k), Lane::simd_from(simd, w));
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
