//! Candidates become solutions if the forward kinematics agrees.
#![expect(
    clippy::inline_always,
    reason = "a function with AVX2 is made of what is inlined into it"
)]

use std::f64::consts::TAU;

use units::Degrees;

use crate::branches::{Branches, Solution};
use crate::configuration::{Configuration, Elbow, Flip, Front, turns_of};
use crate::forward::{Arm, Flange, Wrist};
use crate::joints::PendantJoints;
use crate::lanes::{
    Lane, Number, Select, Simd, SimdBase, SimdFloat, SimdMask, mask64x4, sum, transpose,
};
use crate::model::ArmModel;
use crate::pose::Pose;
use crate::posture::Posture;
use crate::singularity::Singularity;

/// How far the flange of a returned solution may be from the wanted pose: 1 nm, in millimeters
/// squared.
const MAX_POSITION_ERROR_SQUARED: f64 = 1e-6 * 1e-6;
/// The same for the rotation, 1e-9 rad: two unit quaternions are half the angle apart.
const MAX_ROTATION_ERROR_SQUARED: f64 = 5e-10 * 5e-10;

/// The arm postures that should reach a pose, a lane each: front up, front down, back up, back
/// down.
#[derive(Clone, Copy)]
pub(crate) struct Postures<S: Simd> {
    /// q1, q2, q3 of the chain.
    pub(crate) arm: [Lane<S>; 3],
    pub(crate) front: Lane<S>,
    pub(crate) elbow: Lane<S>,
}

/// q4, q5, q6 of the chain that go with them.
#[derive(Clone, Copy)]
pub(crate) struct Wrists<S: Simd> {
    pub(crate) wrist: [Lane<S>; 3],
    pub(crate) sin_q5: Lane<S>,
    /// Which lanes are branches of their own.
    pub(crate) wanted: mask64x4<S>,
}

/// Adds the postures whose joints, as they are returned, put the flange at `X_WF`.
#[inline(always)]
pub(crate) fn push_checked<S: Simd>(
    model: &ArmModel,
    X_WF: &Pose,
    postures: &Postures<S>,
    wrists: &[Wrists<S>; 2],
    branches: &mut Branches,
) {
    let g = &model.geometry;
    let [q1, q2, q3] = postures.arm;
    let [no_flip, flip] = wrists;
    // The same J1, J2 and J3 carry both wrists.
    let joints = shown(model, [q1, q2, q3], no_flip.wrist);
    let [c1, c2, c3, q4, q5, q6] = model.coupling.chain(&joints);
    let arm = Arm::of(g, c1, c2, c3);
    let reached = reaches(X_WF, &Flange::of(g, &arm, &Wrist::of(g, q4, q5, q6)));
    let flipped = shown(model, [q1, q2, q3], flip.wrist);
    let [.., q4, q5, q6] = model.coupling.chain(&flipped);
    let flip_reached = reaches(X_WF, &Flange::of(g, &arm, &Wrist::of(g, q4, q5, q6)));
    push(model, &joints, postures, no_flip, reached, branches);
    push(model, &flipped, postures, flip, flip_reached, branches);
}

/// The lanes that are wanted and `reached`, with all there is to know about them.
#[inline(always)]
fn push<S: Simd>(
    model: &ArmModel,
    joints: &[Lane<S>; 6],
    postures: &Postures<S>,
    wrists: &Wrists<S>,
    reached: mask64x4<S>,
    branches: &mut Branches,
) {
    let sin_q5 = unless_noise(wrists.sin_q5, Posture::SINGULAR_WRIST);
    let front = unless_noise(postures.front, Posture::SINGULAR_DISTANCE);
    let elbow = unless_noise(postures.elbow, Posture::SINGULAR_SINE);
    let flipped = (sin_q5 * model.no_flip_sign).simd_lt(0.0).to_bitmask();
    let back = front.simd_lt(0.0).to_bitmask();
    let down = elbow.simd_lt(0.0).to_bitmask();

    let [j1, j2, j3, j4, j5, j6] = *joints;
    let [m1, m2, m3, m4, m5, m6] = margins(model, joints);
    let shoulder = front.abs() / model.geometry.reach;
    let (wrist, elbow) = (sin_q5.abs(), elbow.abs());
    let lanes = transpose(&[
        j1, j2, j3, j4, j5, j6, m1, m2, m3, m4, m5, m6, wrist, shoulder, elbow,
    ]);
    let found = (wrists.wanted & reached).to_bitmask();
    for (lane, values) in lanes.iter().enumerate() {
        let is = |bits: u64| (bits >> lane) & 1 == 1;
        if !is(found) {
            continue;
        }
        let [j1, j2, j3, j4, j5, j6, m1, m2, m3, m4, m5, m6, ..] = *values;
        let [.., wrist, shoulder, elbow] = *values;
        let joints = PendantJoints::from_radians([j1, j2, j3, j4, j5, j6]);
        branches.push(Solution {
            joints,
            configuration: Configuration {
                flip: if is(flipped) {
                    Flip::Flip
                } else {
                    Flip::NoFlip
                },
                elbow: if is(down) { Elbow::Down } else { Elbow::Up },
                front: if is(back) { Front::Back } else { Front::Toward },
                turns: turns_of(&joints),
            },
            margins: [
                Degrees(m1),
                Degrees(m2),
                Degrees(m3),
                Degrees(m4),
                Degrees(m5),
                Degrees(m6),
            ],
            singularity: Singularity {
                wrist,
                shoulder,
                elbow,
            },
        });
    }
}

#[inline(always)]
fn unless_noise<S: Simd>(value: Lane<S>, noise: f64) -> Lane<S> {
    let zero = Lane::splat(value.simd, 0.0);
    value.abs().simd_lt(noise).select(zero, value)
}

/// Is the flange at `X_WF`? A NaN is nowhere.
#[inline(always)]
fn reaches<S: Simd>(X_WF: &Pose, flange: &Flange<Lane<S>>) -> mask64x4<S> {
    let isometry = X_WF.isometry();
    let (p, q) = (isometry.translation.vector, isometry.rotation.coords);
    let [x, y, z] = flange.position;
    let [w, i, j, k] = flange.rotation;
    let (x, y, z) = (x - p.x, y - p.y, z - p.z);
    let position = z.times_plus(z, sum((x, x), (y, y)));
    // A quaternion and its negative are the same rotation.
    let dot = k.scaled_plus(q.z, j.scaled_plus(q.y, i.scaled_plus(q.x, w * q.w)));
    let side = Lane::splat(dot.simd, 1.0).copysign(dot);
    let (w, i, j, k) = (
        side.scaled_plus(-q.w, w),
        side.scaled_plus(-q.x, i),
        side.scaled_plus(-q.y, j),
        side.scaled_plus(-q.z, k),
    );
    let rotation = sum((w, w), (i, i)) + sum((j, j), (k, k));
    position.simd_le(MAX_POSITION_ERROR_SQUARED) & rotation.simd_le(MAX_ROTATION_ERROR_SQUARED)
}

/// The pendant's joints: J1, J2, J3 on the turn nearest to the middle of their range, J4, J5, J6 on
/// the one nearest to zero.
#[inline(always)]
fn shown<S: Simd>(
    model: &ArmModel,
    [q1, q2, q3]: [Lane<S>; 3],
    [q4, q5, q6]: [Lane<S>; 3],
) -> [Lane<S>; 6] {
    let mut shown = model.coupling.pendant(&[q1, q2, q3, q4, q5, q6]);
    for (joint, middle) in shown.iter_mut().zip(model.shown_middles) {
        *joint = nearest_turn(*joint, middle);
    }
    shown
}

/// An angle, in radians, on the turn nearest to `middle`.
#[inline(always)]
pub(crate) fn nearest_turn<S: Simd>(angle: Lane<S>, middle: f64) -> Lane<S> {
    // Adding and subtracting it rounds to a whole number.
    const ROUND: f64 = 6_755_399_441_055_744.0;
    let turns = (angle - middle).mul_add(1.0 / TAU, ROUND) - ROUND;
    // The last term turns a negative zero into zero.
    turns.scaled_plus(-TAU, angle) + 0.0
}

/// The distances to the nearest limits, in degrees.
#[inline(always)]
fn margins<S: Simd>(model: &ArmModel, joints: &[Lane<S>; 6]) -> [Lane<S>; 6] {
    let mut margins = *joints;
    for (margin, limits) in margins.iter_mut().zip(&model.limits) {
        let degrees = *margin * (180.0 / std::f64::consts::PI);
        let (below, above) = (degrees - limits.min.0, -degrees + limits.max.0);
        *margin = below.simd_lt(above).select(below, above);
    }
    margins
}
