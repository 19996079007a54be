//! Forward and inverse kinematics of many poses: four poses go side by side, a lane each.
//!
//! The formulas are those of `inverse.rs`. Solutions are not put through the forward kinematics
//! again; a pose at a singularity, where that matters, is solved by the checked way instead.
#![expect(
    clippy::inline_always,
    reason = "a function with AVX2 is made of what is inlined into it"
)]

use std::f64::consts::{PI, TAU};

use crate::geometry::Geometry;
use crate::joints::{Axis, PendantJoints};
use crate::lanes::Lanes;
use crate::model::ArmModel;
use crate::pose::Pose;
use crate::trigonometry::atan2;

const LANES: usize = 4;
type Lane = Lanes<LANES>;
type Turn = (Lane, Lane);

/// Nearer to a singularity than this (sines, parts of the reach) a pose is solved by itself.
const NEARLY_SINGULAR: f64 = 1e-6;

/// Up to eight joint sets of four poses.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Group {
    /// Displayed joints in radians: set, joint, pose.
    joints: [[Lane; 6]; 8],
    reached: [[bool; LANES]; 8],
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
        sets.filter(move |(_, reached)| reached.get(lane) == Some(&true))
            .map(move |(joints, _)| {
                let of = |joint: &Lane| joint.0.get(lane).copied().unwrap_or(f64::NAN);
                let [j1, j2, j3, j4, j5, j6] = joints;
                PendantJoints::from_radians([of(j1), of(j2), of(j3), of(j4), of(j5), of(j6)])
            })
    }

    /// How many there are.
    #[must_use]
    pub fn len(&self) -> usize {
        let reached = self.group.reached.iter();
        reached
            .filter(|set| set.get(self.lane) == Some(&true))
            .count()
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
            joints: [[Lanes::all(0.0); 6]; 8],
            reached: [[false; LANES]; 8],
        }
    }

    /// How many sets reach each pose, and how many of them are inside the limits.
    #[inline(always)]
    pub(crate) fn count(&self, limits: &[(f64, f64); 6]) -> [(u8, u8); LANES] {
        let mut counts = [(0, 0); LANES];
        for (joints, reached) in self.joints.iter().zip(&self.reached) {
            let mut inside = *reached;
            for (joint, (min, max)) in joints.iter().zip(limits) {
                for (inside, value) in inside.iter_mut().zip(joint.0) {
                    *inside &= value >= *min && value <= *max;
                }
            }
            for ((count, reached), inside) in counts.iter_mut().zip(reached).zip(inside) {
                count.0 += u8::from(*reached);
                count.1 += u8::from(inside);
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
            let solution = solutions.next();
            if let Some(reached) = reached.get_mut(lane) {
                *reached = solution.is_some();
            }
            let Some(solution) = solution else { continue };
            let values = solution.joints.radians();
            for ((joint, value), middle) in joints.iter_mut().zip(values).zip(middles) {
                if let Some(cell) = joint.0.get_mut(lane) {
                    *cell = value - TAU * ((value - middle) / TAU).round();
                }
            }
        }
    }
}

/// Solves up to four poses; lanes beyond them hold the last one again.
#[multiversion::multiversion(targets("x86_64+avx2+fma"))]
pub(crate) fn solve_group(model: &ArmModel, poses: &[Pose], group: &mut Group) {
    let g = &model.geometry;
    let middles = middles(model);
    let (p, r) = load(poses);
    let [r0, r1, r2] = r;
    let [x, y, z] = p;
    let (x, y, z) = (x - r2[0] * g.d6, y - r2[1] * g.d6, z - r2[2] * g.d6);
    let lateral = -g.s1 * g.lateral;
    let across = (x * x + y * y).sqrt();
    let square = (across - lateral.abs()) * (across + lateral.abs());
    let front = square.map(|s| if s > 0.0 { s } else { 0.0 }).sqrt();
    let scale = (across * across).recip();
    let close = NEARLY_SINGULAR * g.reach;
    let mut alone = (square - close * close).test(|s| s < 0.0);
    let v = (z - g.d1) * g.s1;
    let (longest, shortest) = (g.a2 + g.forearm, (g.a2 - g.forearm).abs());
    let mut set = group.joints.iter_mut().zip(group.reached.iter_mut());
    for side in [1.0, -1.0] {
        let front = front * side;
        let q1 = (
            (y * front - x * lateral) * scale,
            (x * front + y * lateral) * scale,
        );
        let first = atan2(q1.0, q1.1);
        let u = front - g.a1;
        let distance = (u * u + v * v).sqrt();
        let per_distance = distance.recip();
        let area = ((distance * -1.0 + longest) * (distance + longest))
            * ((distance - shortest) * (distance + shortest));
        // Nearly stretched or folded.
        let least = NEARLY_SINGULAR * g.a2 * g.forearm;
        let nearly = area.test(|area| area.abs() < least * least);
        or(&mut alone, nearly);
        let reaches = area.test(|area| area > 0.0);
        let sine = area.map(|a| if a > 0.0 { a } else { 0.0 }).sqrt() * (0.5 / (g.a2 * g.forearm));
        let (dx, dy) = (u * per_distance, v * per_distance);
        let along =
            (distance * distance + (g.a2 - g.forearm) * longest) * per_distance * (0.5 / g.a2);
        let across_arm = sine * per_distance * (g.s1 * g.forearm);
        for bend in [1.0, -1.0] {
            let off = across_arm * bend;
            let q2 = (dy * along + dx * off, dx * along - dy * off);
            let (fx, fy) = (u - q2.1 * g.a2, v - q2.0 * g.a2);
            let (fx, fy) = (fx * (1.0 / g.forearm), fy * (1.0 / g.forearm));
            let q23 = (
                fy * g.forearm_cos - fx * g.forearm_sin,
                fx * g.forearm_cos + fy * g.forearm_sin,
            );
            let (second, both) = (atan2(q2.0, q2.1), atan2(q23.0, q23.1));
            let seen = |column: [Lane; 3]| seen(g, q1, q23, column);
            let (c0, c1, c2) = (seen(r0), seen(r1), seen(r2));
            let [wx, wy, wz] = c2;
            let sine5 = (wx * wx + wy * wy).sqrt();
            or(&mut alone, sine5.test(|s| s < NEARLY_SINGULAR));
            let scale = sine5.recip() * (model.no_flip_sign * g.s5);
            let (s4, c4) = (wy * scale, wx * scale);
            let t = -g.s4 * g.s5;
            let q4 = atan2(s4, c4);
            let q5 = atan2((c4 * wx + s4 * wy) * g.s5, wz * t);
            let q6 = atan2((c4 * c0[1] - s4 * c0[0]) * t, (c4 * c1[1] - s4 * c1[0]) * t);
            let arm = [first, second, both - second];
            for wrist in [[q4, q5, q6], [q4 + PI, -q5, q6 + PI]] {
                let [a, b, c] = arm;
                let [d, e, f] = wrist;
                let shown = model.coupling.pendant(&[a, b, c, d, e, f]);
                let Some((joints, reached)) = set.next() else {
                    return;
                };
                for ((joint, value), middle) in joints.iter_mut().zip(shown).zip(middles) {
                    const ROUND: f64 = 6_755_399_441_055_744.0;
                    let turns = (value - middle) * (1.0 / TAU) + ROUND - ROUND;
                    *joint = value - turns * TAU;
                }
                *reached = reaches;
            }
        }
    }
    if alone != [false; LANES] {
        for (lane, (pose, alone)) in poses.iter().zip(alone).enumerate() {
            if alone {
                group.solve_alone(model, pose, lane, &middles);
            }
        }
    }
}

#[inline(always)]
fn or(these: &mut [bool; LANES], those: [bool; LANES]) {
    for (this, that) in these.iter_mut().zip(those) {
        *this |= that;
    }
}

/// A column of the flange's rotation, seen from the forearm; as in `inverse.rs`.
#[inline(always)]
fn seen(g: &Geometry, (s1, c1): Turn, (s23, c23): Turn, [x, y, z]: [Lane; 3]) -> [Lane; 3] {
    let z = z * g.s1;
    let (along, across) = (c1 * x + s1 * y, s1 * x - c1 * y);
    [
        c23 * along + s23 * z,
        across * (g.s1 * g.s3),
        (s23 * along - c23 * z) * g.s3,
    ]
}

/// Positions, and the columns of the rotations.
#[inline(always)]
fn load(poses: &[Pose]) -> ([Lane; 3], [[Lane; 3]; 3]) {
    let mut p = [Lanes::all(0.0); 3];
    let mut q = [Lanes::all(0.0); 4];
    for lane in 0..LANES {
        let Some(pose) = poses.get(lane).or(poses.last()) else {
            break;
        };
        let isometry = pose.isometry();
        for (to, from) in p.iter_mut().zip(isometry.translation.vector.iter()) {
            if let Some(cell) = to.0.get_mut(lane) {
                *cell = *from;
            }
        }
        for (to, from) in q.iter_mut().zip(isometry.rotation.coords.iter()) {
            if let Some(cell) = to.0.get_mut(lane) {
                *cell = *from;
            }
        }
    }
    let [i, j, k, w] = q;
    let one_minus = |a: Lane| a.map(|a| 1.0 - a);
    let (i2, j2, k2) = (i + i, j + j, k + k);
    let columns = [
        [
            one_minus(j * j2 + k * k2),
            i * j2 + k * w * 2.0,
            i * k2 - j * w * 2.0,
        ],
        [
            i * j2 - k * w * 2.0,
            one_minus(i * i2 + k * k2),
            j * k2 + i * w * 2.0,
        ],
        [
            i * k2 + j * w * 2.0,
            j * k2 - i * w * 2.0,
            one_minus(i * i2 + j * j2),
        ],
    ];
    (p, columns)
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
